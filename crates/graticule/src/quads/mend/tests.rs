use glam::DVec3;
use graticule_fixtures::{Fixture, grid};

use super::*;
use crate::geometry::TriangleTree;

fn surface_of(fixture: &Fixture) -> Surface {
    Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
}

/// Polygons over points near a surface.
fn mesh_on(surface: &Surface, points: &[[f64; 2]], polygons: &[[u32; 4]]) -> PolygonMesh {
    let tree = TriangleTree::of_surface(surface);
    let origins: Vec<_> = (points.iter())
        .map(|&[x, y]| tree.closest(DVec3::new(x, y, 0.0)).unwrap())
        .collect();
    PolygonMesh {
        positions: origins
            .iter()
            .map(|origin| origin.position(surface))
            .collect(),
        polygons: polygons.iter().map(|quad| &quad[..]).collect(),
        origins,
        feature_edges: Vec::new(),
    }
}

/// A square of 4 × 4 with a column of 4 quads to the left and one to the right, and between them a
/// column that is two quads wide but for the lowest row, where three quads meet at a vertex inside:
/// the one along the boundary has a straight corner there.
fn straight_corner() -> (Vec<[f64; 2]>, Vec<[u32; 4]>) {
    let xs = [0.0, 1.5, 2.0, 2.5, 4.0];
    let at = |x: u32, y: u32| 5 * y + x;
    let mut points = Vec::new();
    for y in 0..5 {
        points.extend(xs.iter().map(|&x| [x, f64::from(y)]));
    }
    points.push([2.0, 0.5]);
    let mut quads = Vec::new();
    for y in 0..4 {
        for x in 0..4 {
            if y > 0 || x == 0 || x == 3 {
                quads.push([at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]);
            }
        }
    }
    let inside = 25;
    quads.push([at(1, 0), at(2, 0), at(3, 0), inside]);
    quads.push([at(1, 0), inside, at(2, 1), at(1, 1)]);
    quads.push([inside, at(3, 0), at(3, 1), at(2, 1)]);
    (points, quads)
}

fn least(mesh: &PolygonMesh) -> f64 {
    let quads = (0..mesh.polygons.len()).map(|polygon| {
        let quad = <[u32; 4]>::try_from(mesh.polygons.vertices(polygon)).unwrap();
        scaled_jacobian(quad.map(|v| mesh.positions[v as usize]))
    });
    quads.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_straight_corner_on_the_boundary_gets_an_edge() {
    let surface = surface_of(&grid(4.0, 4.0, 8, 8));
    let (points, quads) = straight_corner();
    let mut mesh = mesh_on(&surface, &points, &quads);
    assert!(least(&mesh) <= 0.0);
    let report = mend(&mut mesh, &surface, &[], &Watch::new()).unwrap();
    assert!(report.poor_before > 0 && report.patches > 0);
    assert_eq!(report.poor_after, 0);
    assert!(least(&mesh) > 0.5, "{}", least(&mesh));
    mesh.check(&surface).unwrap();
}

#[test]
fn a_straight_corner_on_a_feature_gets_an_edge_and_the_feature_stays() {
    // The same square and its mirror image, joined along a feature.
    let surface = surface_of(&grid(4.0, 8.0, 8, 16).map(|p| p - 4.0 * DVec3::Y));
    let (mut points, mut quads) = straight_corner();
    let count = points.len() as u32;
    let mirrored = |vertex: u32| if vertex < 5 { vertex } else { vertex + count };
    points.extend(points.clone().iter().map(|&[x, y]| [x, -y]));
    quads.extend(
        quads
            .clone()
            .iter()
            .map(|&[a, b, c, d]| [d, c, b, a].map(mirrored)),
    );
    let mut mesh = mesh_on(&surface, &points, &quads);
    super::super::doublets::drop_unused(&mut mesh);
    mesh.feature_edges = (0..4).map(|k| [k, k + 1]).collect();
    let triangles = surface.mesh();
    let features: Vec<EdgeId> = (triangles.edges())
        .filter(|&edge| {
            let ends = triangles.ends(triangles.edge_halfedge(edge));
            ends.iter().all(|&vertex| surface.position(vertex).y == 0.0)
        })
        .collect();
    assert_eq!(features.len(), 8);
    let report = mend(&mut mesh, &surface, &features, &Watch::new()).unwrap();
    assert_eq!(report.poor_after, 0);
    assert!(least(&mesh) > 0.5, "{}", least(&mesh));
    mesh.check(&surface).unwrap();
    for &[a, b] in &mesh.feature_edges {
        let has_edge = |polygon| sides(mesh.polygons.vertices(polygon)).any(|side| side == [a, b]);
        assert!((0..mesh.polygons.len()).any(has_edge));
        assert!(mesh.positions[a as usize].y == 0.0 && mesh.positions[b as usize].y == 0.0);
    }
}

/// A square of 4 × 4 quads whose vertex in the middle lies beyond the far corner of one of them.
fn inverted_quad() -> (Vec<[f64; 2]>, Vec<[u32; 4]>) {
    let mut points: Vec<[f64; 2]> = (0..25)
        .map(|k| [f64::from(k % 5), f64::from(k / 5)])
        .collect();
    points[12] = [3.2, 3.2];
    let quad = |k: u32| [k, k + 1, k + 6, k + 5];
    let quads = (0..20).filter(|k| k % 5 < 4).map(quad).collect();
    (points, quads)
}

#[test]
fn features_that_hold_a_quad_inverted_are_given_up() {
    let surface = surface_of(&grid(4.0, 4.0, 8, 8));
    let (points, quads) = inverted_quad();
    let mut mesh = mesh_on(&surface, &points, &quads);
    // The surface has no edges there to slide along, and nothing is cut anew across the lines.
    mesh.feature_edges = vec![[12, 13], [12, 17], [13, 18], [17, 18]];
    let watch = Watch::new();
    let report = mend(&mut mesh, &surface, &[], &watch).unwrap();
    assert_eq!((report.released, report.poor_after), (4, 0));
    assert!(least(&mesh) >= MENDED_QUAD && mesh.feature_edges.is_empty());
    let is_told = |warning: &crate::watch::Warning| warning.code == "released-features";
    assert!(watch.warnings().iter().any(is_told));
    mesh.check(&surface).unwrap();
}

#[test]
fn a_vertex_between_two_folded_quads_goes() {
    // A strip of quads with a vertex in a quad's middle that only two quads have, drawn out beyond a
    // third corner: no place of it makes both quads convex.
    let surface = surface_of(&grid(3.0, 3.0, 6, 6));
    let mut points: Vec<[f64; 2]> = Vec::new();
    for y in 0..4 {
        points.extend((0..4).map(|x| [f64::from(x), f64::from(y)]));
    }
    points.push([1.3, 1.7]);
    let mut quads = Vec::new();
    for y in 0..3_u32 {
        for x in 0..3_u32 {
            let quad = [4 * y + x, 4 * y + x + 1, 4 * y + x + 5, 4 * y + x + 4];
            if (x, y) == (1, 1) {
                quads.push([quad[0], quad[1], quad[2], 16]);
                quads.push([quad[0], 16, quad[2], quad[3]]);
            } else {
                quads.push(quad);
            }
        }
    }
    let mut mesh = mesh_on(&surface, &points, &quads);
    let report = mend(&mut mesh, &surface, &[], &Watch::new()).unwrap();
    assert_eq!((report.poor_after, mesh.polygons.len()), (0, 9));
    mesh.check(&surface).unwrap();
}

#[test]
fn a_good_mesh_stays_what_it_is() {
    let surface = surface_of(&grid(2.0, 2.0, 4, 4));
    let points: Vec<[f64; 2]> = (0..9)
        .map(|k| [f64::from(k % 3), f64::from(k / 3)])
        .collect();
    let quads = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]];
    let mut mesh = mesh_on(&surface, &points, &quads);
    let before = mesh.clone();
    let report = mend(&mut mesh, &surface, &[], &Watch::new()).unwrap();
    assert_eq!((report, mesh), (MendReport::default(), before));
}

#[test]
fn patches_are_disks_that_no_line_passes() {
    let (points, quads) = straight_corner();
    let plane = surface_of(&grid(4.0, 4.0, 8, 8));
    let mut mesh = mesh_on(&plane, &points, &quads);
    mesh.feature_edges = vec![[6, 11], [11, 16]];
    let ground = Ground::of(&plane, &[]);
    let quilt = Quilt::of(&mesh, &ground);
    for polygon in 0..quilt.polygon_count() as u32 {
        for patch in Patch::around(&quilt, polygon) {
            assert!(patch.polygons.contains(&polygon));
            let inner = patch
                .polygons
                .iter()
                .flat_map(|&p| sides(quilt.vertices(p)));
            let of_border: Vec<[u32; 2]> = sides(&patch.border).collect();
            for side in inner.filter(|side| quilt.is_line(*side)) {
                assert!(of_border.contains(&side));
            }
        }
    }
}

#[test]
fn a_straight_corner_with_lines_on_three_sides_gets_a_ring_of_quads() {
    // The tip of a wedge is one quad with a vertex in the middle of a side; lines are all round it, so
    // that it can be cut anew with no other.
    let surface = surface_of(&grid(2.0, 2.0, 4, 4));
    let points = [
        [0.0, 0.0],
        [0.5, 0.0],
        [1.0, 0.0],
        [0.5, 2.0],
        [2.0, 2.0],
        [2.0, 0.0],
    ];
    let quads = [[0, 1, 2, 3], [2, 5, 4, 3]];
    let mut mesh = mesh_on(&surface, &points, &quads);
    mesh.feature_edges = vec![[2, 3]];
    assert!(least(&mesh) <= 0.0);
    let report = mend(&mut mesh, &surface, &[], &Watch::new()).unwrap();
    assert!(report.patches > 0 && least(&mesh) > 0.1, "{}", least(&mesh));
    let topology = mesh.topology().unwrap().total;
    assert_eq!(
        (topology.boundary_loops, topology.euler_characteristic),
        (1, 1)
    );
}
