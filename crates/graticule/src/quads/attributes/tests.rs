use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use graticule_fixtures::{Fixture, QuadFixture, cylinder_patch, grid, quad_grid};

use super::*;
use crate::geometry::TriangleTree;
use crate::mesh::{CornerAttribute, NO_VALUE, RepairOptions, repair};
use crate::watch::Watch;

fn soup(fixture: &Fixture) -> PolygonSoup {
    PolygonSoup {
        positions: fixture.positions.clone(),
        polygons: fixture.triangles.iter().map(|t| &t[..]).collect(),
        ..PolygonSoup::default()
    }
}

/// One value for each corner, by its triangle's middle and its own position.
fn per_corner<T>(soup: &PolygonSoup, value: impl Fn(DVec3, DVec3) -> T) -> CornerAttribute<T> {
    let mut values = Vec::new();
    for polygon in soup.polygons.iter() {
        let at = |vertex: u32| soup.positions[vertex as usize];
        let middle = polygon.iter().map(|&v| at(v)).sum::<DVec3>() / polygon.len() as f64;
        values.extend(polygon.iter().map(|&vertex| value(middle, at(vertex))));
    }
    let corner_values = (0..values.len() as u32).collect();
    CornerAttribute {
        name: "set".into(),
        values,
        corner_values,
    }
}

fn carried(original: &PolygonSoup, mesh: &QuadFixture) -> (PolygonSoup, Vec<InputPoint>) {
    let repaired = repair(original, &RepairOptions::default(), &Watch::new()).unwrap();
    let tree = TriangleTree::of_surface(&repaired.surface);
    let origins: Vec<_> = mesh
        .positions
        .iter()
        .map(|&p| tree.closest(p).unwrap())
        .collect();
    let polygons: Polygons = mesh.quads.iter().map(|quad| &quad[..]).collect();
    let carry = Carry {
        original,
        repaired: &repaired,
        polygons: &polygons,
        origins: &origins,
    };
    (carry.to_soup(), carry.input_points())
}

fn sheet() -> PolygonSoup {
    soup(&grid(2.0, 1.0, 10, 5))
}

fn coarse(columns: u32, rows: u32) -> QuadFixture {
    quad_grid(DVec2::new(2.0, 1.0), columns, rows)
}

#[test]
fn linear_coordinates_and_colours_are_reproduced() {
    let mut original = sheet();
    let linear = |p: DVec3| DVec2::new(3.0 * p.x - p.y + 0.5, 2.0 * p.y);
    original.attributes.uv_sets = vec![per_corner(&original, |_, p| linear(p))];
    let color = |p: DVec3| [p.x as f32 / 2.0, p.y as f32, 0.25, 1.0];
    original.attributes.vertex_colors =
        Some(original.positions.iter().map(|&p| color(p)).collect());
    let mesh = coarse(7, 3);
    let (new, _) = carried(&original, &mesh);
    let set = &new.attributes.uv_sets[0];
    assert_eq!(set.name, "set");
    // One value for each vertex, although the original has one for each corner.
    assert_eq!(set.values.len(), mesh.positions.len());
    for (corner, &vertex) in new.polygons.corner_vertices().iter().enumerate() {
        let expected = linear(mesh.positions[vertex as usize]);
        assert!((set.get(corner).unwrap() - expected).length() < 1e-12);
    }
    for (new, &p) in new
        .attributes
        .vertex_colors
        .unwrap()
        .iter()
        .zip(&mesh.positions)
    {
        let expected = color(p);
        assert!(new.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}

#[test]
fn corners_take_the_side_of_a_seam_that_their_polygon_lies_on() {
    // The right half has coordinates of its own.
    let shift = |middle: DVec3| if middle.x > 1.0 { 10.0 } else { 0.0 };
    let mut original = sheet();
    original.attributes.uv_sets = vec![per_corner(&original, |middle, p| {
        DVec2::new(p.x + shift(middle), p.y)
    })];
    for (columns, on_the_seam) in [(4, true), (5, false)] {
        let mesh = coarse(columns, 3);
        let (new, _) = carried(&original, &mesh);
        let set = &new.attributes.uv_sets[0];
        for polygon in 0..new.polygons.len() {
            let vertices = new.polygons.vertices(polygon);
            let at = |vertex: u32| mesh.positions[vertex as usize];
            let middle = vertices.iter().map(|&v| at(v)).sum::<DVec3>() / 4.0;
            if !on_the_seam && (middle.x - 1.0).abs() < 1e-9 {
                // Lies across: all corners are to be of one side, whichever.
                let values: Vec<_> = new
                    .polygons
                    .corner_range(polygon)
                    .map(|c| set.get(c).unwrap())
                    .collect();
                let width = values
                    .iter()
                    .map(|uv| uv.x)
                    .fold(f64::NEG_INFINITY, f64::max)
                    - values.iter().map(|uv| uv.x).fold(f64::INFINITY, f64::min);
                assert!(width < 0.5, "{values:?}");
                continue;
            }
            for (corner, &vertex) in new.polygons.corner_range(polygon).zip(vertices) {
                let expected = at(vertex).truncate() + DVec2::X * shift(middle);
                assert!((set.get(corner).unwrap() - expected).length() < 1e-12);
            }
        }
    }
}

#[test]
fn a_cylinder_with_one_seam_keeps_its_coordinates() {
    // Both sides of the seam belong to the same chart, whose coordinates differ by 1 there.
    let around = |p: DVec3| (libm::atan2(p.y, p.x) / TAU).rem_euclid(1.0);
    let unrolled = |middle: DVec3, p: DVec3| {
        let u = around(p);
        let nearest = u + (around(middle) - u).round();
        DVec2::new(nearest, p.z)
    };
    let mut original = soup(&cylinder_patch(1.0, 2.0, 48, 10));
    original.attributes.uv_sets = vec![per_corner(&original, unrolled)];
    let mesh =
        quad_grid(DVec2::new(TAU, 2.0), 12, 4).map(|p| DVec3::new(p.x.cos(), p.x.sin(), p.z + p.y));
    let (new, _) = carried(&original, &mesh);
    let set = &new.attributes.uv_sets[0];
    for polygon in 0..new.polygons.len() {
        let values: Vec<_> = new
            .polygons
            .corner_range(polygon)
            .map(|c| set.get(c).unwrap().x)
            .collect();
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!((most - least - 1.0 / 12.0).abs() < 1e-3, "{values:?}");
    }
}

#[test]
fn materials_are_those_of_most_of_a_polygon() {
    let mut original = sheet();
    let polygon_names = original.polygons.iter().map(|triangle| {
        let middle = triangle
            .iter()
            .map(|&v| original.positions[v as usize].x)
            .sum::<f64>()
            / 3.0;
        u32::from(middle > 0.8)
    });
    let names = vec!["left".into(), "right".into()];
    let polygon_names = polygon_names.collect();
    original.attributes.materials = Some(PolygonLabels {
        names,
        polygon_names,
    });
    let (new, _) = carried(&original, &coarse(4, 2));
    let materials = new.attributes.materials.unwrap();
    let names: Vec<_> = (0..4)
        .map(|polygon| materials.get(polygon).unwrap())
        .collect();
    // The second quad reaches from 0.5 to 1.0.
    assert_eq!(names, ["left", "left", "right", "right"]);
}

#[test]
fn corners_without_value_stay_without() {
    let mut original = sheet();
    let mut set = per_corner(&original, |_, p| p.truncate());
    set.corner_values[..150].fill(NO_VALUE);
    original.attributes.uv_sets = vec![set];
    let (new, _) = carried(&original, &coarse(4, 2));
    let set = &new.attributes.uv_sets[0];
    assert_eq!(set.get(0), None);
    assert!(set.get(31).is_some());
}

#[test]
fn points_of_the_input_are_where_the_vertices_are() {
    // A quad of the file is cut in two, and its vertices are not those of the surface.
    let mut original = sheet();
    original.positions.insert(0, DVec3::splat(9.0));
    for vertex in original.polygons.corner_vertices_mut() {
        *vertex += 1;
    }
    let mesh = coarse(3, 3);
    let (new, points) = carried(&original, &mesh);
    for (point, position) in points.iter().zip(&new.positions) {
        let corners = point
            .vertices
            .map(|vertex| original.positions[vertex as usize]);
        let [a, b, c] = point.weights;
        assert!((corners[0] * a + corners[1] * b + corners[2] * c).distance(*position) < 1e-12);
        let polygon = original.polygons.vertices(point.polygon as usize);
        assert!(point.vertices.iter().all(|vertex| polygon.contains(vertex)));
    }
}
