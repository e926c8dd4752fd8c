//! What the tests of the repair share; the tests themselves go by stage.

mod carrying;
mod cleaning;
mod cracks;
mod degenerate;
mod fins;
mod manifold;
mod orientation;
mod random;
mod welding;

use glam::DVec3;
use graticule_fixtures::{CUBE_QUADS, Fixture, cube};

use super::*;
use crate::mesh::test_soups::{fin, soup, soup_of};
use crate::mesh::{NO_VALUE, Polygons, Topology};

/// Every triangle with vertices of its own.
fn unwelded(fixture: &Fixture) -> Fixture {
    let corners = fixture.triangles.iter().flatten();
    Fixture {
        positions: corners.map(|&v| fixture.positions[v as usize]).collect(),
        triangles: (0..fixture.triangles.len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
    }
}

fn repaired_with(soup: &PolygonSoup, options: RepairOptions) -> Repaired {
    let repaired = repair(soup, &options, &Watch::new()).unwrap();
    check_maps(soup, &repaired);
    repaired
}

fn repaired(soup: &PolygonSoup) -> Repaired {
    let repaired = repaired_with(soup, RepairOptions::default());
    check_fixed_point(&repaired, Weld::Auto);
    repaired
}

fn refusal(soup: &PolygonSoup) -> RepairError {
    repair(soup, &RepairOptions::default(), &Watch::new()).unwrap_err()
}

/// Positions, corners and polygons come from where the maps say.
fn check_maps(soup: &PolygonSoup, repaired: &Repaired) {
    let mesh = repaired.surface.mesh();
    assert_eq!(repaired.vertex_sources.len(), mesh.vertex_count());
    assert_eq!(repaired.corner_sources.len(), mesh.halfedge_count());
    assert_eq!(repaired.face_polygons.len(), mesh.face_count());
    for vertex in mesh.vertices() {
        let source = repaired.vertex_sources[vertex] as usize;
        assert_eq!(repaired.surface.position(vertex), soup.positions[source]);
    }
    for corner in mesh.halfedges() {
        let source = repaired.corner_sources[corner] as usize;
        let vertex = soup.polygons.corner_vertices()[source] as usize;
        let gap = repaired.surface.position(mesh.origin(corner)) - soup.positions[vertex];
        let [low, high] = repaired.surface.bounding_box();
        assert!(gap.abs().max_element() <= 1e-9 * (high - low).max_element());
    }
    for corner in repaired.mesh_corners(soup) {
        assert!(corner == NO_VALUE || (corner as usize) < mesh.halfedge_count());
    }
    check_fixed_point(repaired, Weld::Never);
}

fn check_fixed_point(repaired: &Repaired, weld: Weld) {
    let again = PolygonSoup::from(&repaired.surface);
    let options = RepairOptions {
        weld,
        ..RepairOptions::default()
    };
    let twice = repair(&again, &options, &Watch::new()).unwrap();
    assert!(
        twice.changes.is_empty(),
        "repaired again: {}",
        twice.changes
    );
    assert_eq!(twice.surface, repaired.surface);
}

fn area(surface: &Surface) -> f64 {
    let triangles = surface
        .mesh()
        .faces()
        .map(|face| surface.corner_positions(face));
    triangles
        .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
        .sum()
}

fn volume(surface: &Surface) -> f64 {
    let triangles = surface
        .mesh()
        .faces()
        .map(|face| surface.corner_positions(face));
    triangles.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

fn total(repaired: &Repaired) -> crate::mesh::ComponentTopology {
    Topology::of(repaired.surface.mesh()).total
}

fn components(repaired: &Repaired) -> usize {
    Topology::of(repaired.surface.mesh()).components.len()
}

/// Cubes at several places whose coinciding corners are one vertex.
fn joined_cubes(places: &[DVec3]) -> PolygonSoup {
    let mut result = PolygonSoup::default();
    for &place in places {
        let numbers: Vec<u32> = cube()
            .positions
            .iter()
            .map(|corner| {
                let position = corner + place;
                let known = result.positions.iter().position(|&p| p == position);
                known.unwrap_or_else(|| {
                    result.positions.push(position);
                    result.positions.len() - 1
                }) as u32
            })
            .collect();
        for quad in CUBE_QUADS {
            result
                .polygons
                .push(&quad.map(|corner| numbers[corner as usize]));
        }
    }
    result
}

fn reversed(polygon: &[u32]) -> Vec<u32> {
    polygon.iter().rev().copied().collect()
}

trait ToPolygons {
    fn to_polygons(&self) -> Polygons;
}

impl ToPolygons for Vec<Vec<u32>> {
    fn to_polygons(&self) -> Polygons {
        self.iter().map(|polygon| &polygon[..]).collect()
    }
}

fn area_of_soup(soup: &PolygonSoup) -> f64 {
    let triangle = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length() / 2.0;
    let polygon = |vertices: &[u32]| -> f64 {
        let positions: Vec<_> = vertices
            .iter()
            .map(|&v| soup.positions[v as usize])
            .collect();
        let triangles = crate::mesh::triangulate_polygon(&positions).into_iter();
        triangles
            .map(|t| triangle(t.map(|corner| positions[corner as usize])))
            .sum()
    };
    soup.polygons.iter().map(polygon).sum()
}
