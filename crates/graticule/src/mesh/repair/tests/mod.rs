//! What the tests of the repair share; the tests themselves go by stage.

mod carrying;
mod cleaning;
mod degenerate;
mod manifold;
mod orientation;
mod random;
mod welding;

use glam::DVec3;
use graticule_fixtures::Fixture;

use super::*;
use crate::mesh::{NO_VALUE, Polygons, Topology};

fn soup(positions: &[[f64; 3]], polygons: &[&[u32]]) -> PolygonSoup {
    PolygonSoup {
        positions: positions.iter().map(|&p| DVec3::from_array(p)).collect(),
        polygons: polygons.iter().copied().collect(),
        ..PolygonSoup::default()
    }
}

fn soup_of(fixture: &Fixture) -> PolygonSoup {
    PolygonSoup {
        positions: fixture.positions.clone(),
        polygons: fixture.triangles.iter().map(|t| &t[..]).collect(),
        ..PolygonSoup::default()
    }
}

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

fn soup_of_surface(surface: &Surface) -> PolygonSoup {
    let mesh = surface.mesh();
    let triangles: Vec<_> = mesh
        .faces()
        .map(|f| mesh.triangle(f).map(|v| v.0))
        .collect();
    PolygonSoup {
        positions: surface.positions().as_slice().to_vec(),
        polygons: triangles.iter().map(|t| &t[..]).collect(),
        ..PolygonSoup::default()
    }
}

fn check_fixed_point(repaired: &Repaired, weld: Weld) {
    let again = soup_of_surface(&repaired.surface);
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

/// The faces of a cube whose corner `n` lies at the coordinates that are the bits of `n`.
const CUBE_QUADS: [[u32; 4]; 6] = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
];

fn cube_corner(corner: u32) -> DVec3 {
    let bit = |place: u32| f64::from((corner >> place) & 1);
    DVec3::new(bit(0), bit(1), bit(2))
}

/// Cubes at several places whose coinciding corners are one vertex.
fn joined_cubes(places: &[DVec3]) -> PolygonSoup {
    let mut result = PolygonSoup::default();
    for &place in places {
        let numbers: Vec<u32> = (0..8)
            .map(|corner| {
                let position = cube_corner(corner) + place;
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
