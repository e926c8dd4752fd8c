use glam::DVec3;

use super::*;
use crate::mesh::Polygons;
use crate::mesh::test_soups::{fin, soup, soup_of};

fn cube() -> PolygonSoup {
    soup_of(&graticule_fixtures::cube())
}

#[test]
fn a_cube_is_sound() {
    let defects = Defects::find(&cube());
    assert!(defects.is_sound() && defects.findings().is_empty());
    assert_eq!([defects.components, defects.boundary_loops], [1, 0]);
}

#[test]
fn damaged_polygons_and_vertices_are_named() {
    let mut damaged = cube();
    damaged
        .positions
        .extend([DVec3::NAN, DVec3::INFINITY, DVec3::Y]);
    for polygon in [
        &[0, 1, 99][..],
        &[0, 1, 8],
        &[0, 1],
        &[3],
        &[0, 1, 1, 2],
        &[4, 4, 4],
        &[2, 0, 3],
    ] {
        damaged.polygons.push(polygon);
    }
    let first = damaged.polygons.vertices(0).to_vec();
    damaged.polygons.push(&[first[1], first[0], first[2]]);
    let defects = Defects::find(&damaged);
    assert_eq!(defects.out_of_range.all(), [12]);
    assert_eq!(defects.non_finite_vertices.all(), [8]);
    assert_eq!(defects.non_finite_polygons.all(), [13]);
    assert_eq!(defects.non_finite_unused_vertices.all(), [9]);
    assert_eq!(defects.isolated_vertices.all(), [9, 10]);
    assert_eq!(defects.too_few_corners.all(), [14, 15]);
    assert_eq!(defects.repeated_corners.all(), [16, 17]);
    assert_eq!(defects.collapsed.all(), [17]);
    assert!(defects.duplicate_polygons.all().contains(&19));
    assert!(!defects.is_sound());
    let codes: Vec<_> = defects.findings().iter().map(|f| f.code).collect();
    assert_eq!(codes[..2], ["non-finite-vertices", "out-of-range"]);
}

#[test]
fn degenerate_polygons_are_found_at_every_scale() {
    for exponent in [-660, -40, 0, 40, 330] {
        let scale = 2.0_f64.powi(exponent);
        let positions = [[0., 0.], [2., 0.], [1., 0.], [0., 1.], [1., 1e-5], [0., 0.]]
            .map(|[x, y]| [x * scale, y * scale, 0.0]);
        let triangles: [&[u32]; 4] = [&[0, 1, 2], &[0, 1, 3], &[0, 1, 4], &[0, 5, 3]];
        let defects = Defects::find(&soup(&positions, &triangles));
        assert_eq!(defects.zero_area.all(), [0, 3]);
        assert_eq!(defects.slivers.all(), [2]);
        assert_eq!(defects.zero_length_edges.all(), [3]);
        assert_eq!(defects.duplicate_vertices.all(), [5]);
    }
}

#[test]
fn non_manifold_and_badly_oriented_places_are_named() {
    let defects = Defects::find(&fin());
    assert_eq!(defects.non_manifold_edges.all(), [[0, 1]]);
    assert!(defects.non_manifold_vertices.is_empty());
    let bow_tie = soup(
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [-1., 0., 0.],
            [0., -1., 0.],
        ],
        &[&[0, 1, 2], &[0, 3, 4]],
    );
    assert_eq!(Defects::find(&bow_tie).non_manifold_vertices.all(), [0]);
    let turned = soup(
        &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]],
        &[&[0, 1, 2], &[1, 2, 3]],
    );
    assert_eq!(Defects::find(&turned).inconsistent_edges.all(), [[1, 2]]);
}

#[test]
fn a_moebius_strip_is_not_orientable() {
    let strip: Vec<[u32; 4]> = (0..8)
        .map(|i| [2 * i, 2 * i + 1, (2 * i + 3) % 16, (2 * i + 2) % 16])
        .collect();
    let twisted = |i: usize, quad: [u32; 4]| match i {
        7 => [14, 15, 0, 1],
        _ => quad,
    };
    let quads: Vec<_> = strip
        .iter()
        .enumerate()
        .map(|(i, &q)| twisted(i, q))
        .collect();
    let polygons: Polygons = quads.iter().map(|quad| &quad[..]).collect();
    let positions = (0..16).map(|i| DVec3::new(f64::from(i), f64::from(i * i), 1.0));
    let moebius = PolygonSoup {
        positions: positions.collect(),
        polygons,
        ..PolygonSoup::default()
    };
    let defects = Defects::find(&moebius);
    assert_eq!(defects.non_orientable.all(), [0]);
    assert_eq!(defects.boundary_loops, 1);
    assert_eq!(defects.polygon_sizes, BTreeMap::from([(4, 8)]));
}

#[test]
fn a_cube_turned_inside_out_and_a_tiny_one_are_noted() {
    let cube = graticule_fixtures::cube();
    let tiny = cube.clone().map(|p| p * 1e-8 + DVec3::splat(3.0));
    let mut both = cube.joined(&tiny);
    for triangle in &mut both.triangles[12..] {
        triangle.swap(0, 1);
    }
    let defects = Defects::find(&soup_of(&both));
    assert_eq!(defects.components, 2);
    assert_eq!(defects.inside_out.all(), [12]);
    assert_eq!(defects.tiny_components.all(), [12]);
    assert!(defects.zero_area.is_empty());
}

#[test]
fn t_junctions_and_open_seams_are_noted() {
    let junction = soup(
        &[
            [0., 0., 0.],
            [2., 0., 0.],
            [2., 2., 0.],
            [0., 2., 0.],
            [1., 0., 0.],
            [1., -1., 0.],
            [2., -1., 0.],
            [0., -1., 0.],
        ],
        &[
            &[0, 1, 2],
            &[0, 2, 3],
            &[4, 7, 5],
            &[0, 7, 4],
            &[4, 5, 6],
            &[4, 6, 1],
        ],
    );
    let defects = Defects::find(&junction);
    assert_eq!(defects.t_junctions.all(), [4]);
    assert_eq!(defects.non_manifold_vertices.all(), [0, 1]);
    let seam = soup(
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [1., 1., 0.],
        ],
        &[&[0, 1, 2], &[4, 3, 5]],
    );
    let defects = Defects::find(&seam);
    assert_eq!(defects.open_seams.all(), [[1, 2]]);
    assert_eq!(defects.duplicate_vertices.all(), [3, 4]);
}

#[test]
fn nothing_in_a_soup_makes_the_search_fail() {
    let empty = Defects::find(&PolygonSoup::default());
    assert_eq!(empty, Defects::default());
    let huge = soup(
        &[
            [f64::MAX; 3],
            [-f64::MAX; 3],
            [f64::MAX, 0.0, 0.0],
            [0.0; 3],
        ],
        &[&[0, 1, 2], &[0, 1, 3]],
    );
    assert_eq!(Defects::find(&huge).components, 1);
}

#[test]
fn the_report_counts_all_and_shows_a_few() {
    let mut many = cube();
    many.positions
        .extend((0..500).map(|i| DVec3::splat(f64::from(i))));
    let defects = Defects::find(&many);
    let json = serde_json::to_value(&defects).unwrap();
    assert_eq!(json["isolated_vertices"]["count"], 500);
    assert_eq!(
        json["isolated_vertices"]["first"].as_array().unwrap().len(),
        20
    );
    let message = &defects.findings()[0].message;
    assert_eq!(message, "500 vertices without polygon: vertex 8, 9, 10, …");
}
