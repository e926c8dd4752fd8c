//! Layouts with known answers, for tests.

use glam::DVec2;
use graticule_fixtures::{QuadFixture, quad_cube, quad_torus};

use super::{ArcKind, EmbeddedNet};
use crate::mesh::{Element, PerCorner, PerEdge, PerVertex, RefinedSurface, Surface};

/// A mesh of quads, each cut into two triangles, with the arcs of a predicate on the quads' edges
/// and each quad a unit square over `cells`.
fn quad_net(fixture: &QuadFixture, cells: f64, is_arc: impl Fn([u32; 2]) -> bool) -> EmbeddedNet {
    let triangles: Vec<[u32; 3]> = (fixture.quads.iter())
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    let surface = Surface::from_triangles(fixture.positions.clone(), &triangles).unwrap();
    let mesh = surface.mesh();
    let square = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|point| point / cells);
    let edges = PerEdge::from_fn(mesh.edge_count(), |edge| {
        let [from, to] = mesh.ends(mesh.edge_halfedge(edge)).map(|vertex| vertex.0);
        is_arc([from, to]).then_some(ArcKind::Line)
    });
    EmbeddedNet {
        nodes: PerVertex::filled(mesh.vertex_count(), false),
        coordinates: PerCorner::from_fn(mesh.halfedge_count(), |corner| {
            let places = [[0, 1, 2], [0, 2, 3]][corner.face().index() % 2];
            Some(square[places[corner.side()]])
        }),
        edges,
        refined: RefinedSurface::whole(surface),
    }
}

/// A cube whose faces are the charts, each of `cells` by `cells` quads.
pub(crate) fn cube_net(cells: u32) -> EmbeddedNet {
    let fixture = quad_cube(cells);
    let positions = fixture.positions.clone();
    quad_net(&fixture, f64::from(cells), |[from, to]| {
        let [a, b] = [from, to].map(|vertex| positions[vertex as usize]);
        let shared = (0..3).filter(|&axis| (a[axis] * b[axis] - 1.0).abs() < 1e-9);
        shared.count() == 2
    })
}

/// A torus with `around` by `across` charts, each of `cells` by `cells` quads; three or more each
/// way.
pub(crate) fn torus_net(around: u32, across: u32, cells: u32) -> EmbeddedNet {
    let [columns, rows] = [around * cells, across * cells];
    let fixture = quad_torus(2.0, 0.7, columns, rows);
    let place = |vertex: u32| [vertex / rows, vertex % rows];
    quad_net(&fixture, f64::from(cells), |[from, to]| {
        let ([i, j], [k, l]) = (place(from), place(to));
        i == k && i % cells == 0 || j == l && j % cells == 0
    })
}
