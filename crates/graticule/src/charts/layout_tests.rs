use super::layout_examples::{cube_net, torus_net};
use super::{ArcKind, ChartKind, ChartLayout, LayoutError};
use crate::mesh::{Element, PerEdge};
use glam::DVec2;

#[test]
fn a_cube_has_six_charts_twelve_arcs_eight_nodes() {
    let net = cube_net(3);
    let layout = ChartLayout::new(net.clone()).unwrap();
    let counts = [
        layout.nodes().len(),
        layout.arcs().len(),
        layout.charts().len(),
    ];
    assert_eq!(counts, [8, 12, 6]);
    for chart in layout.charts() {
        assert_eq!(chart.kind, ChartKind::Regular);
        assert!(chart.sides.iter().all(|side| side.len() == 1));
        assert_eq!(layout.side_vertices(&chart.sides[2]).len(), 4);
    }
    layout.check_areas(&net.refined.surface).unwrap();
}

#[test]
fn charts_of_a_torus_are_unit_squares_from_the_origin_on() {
    let layout = ChartLayout::new(torus_net(5, 3, 4)).unwrap();
    assert_eq!(layout.charts().len(), 15);
    assert_eq!(layout.singular_share().to_bits(), 0.0_f64.to_bits());
    let mesh = layout.surface().mesh();
    for corner in mesh.halfedges() {
        let point = layout.coordinates()[corner].unwrap();
        assert!(point.cmpge(DVec2::ZERO).all() && point.cmple(DVec2::ONE).all());
    }
    for chart in layout.charts() {
        let first = layout.side_vertices(&chart.sides[0]);
        for (place, &vertex) in first.iter().enumerate() {
            let seen = mesh.halfedges().filter(|&corner| {
                let of = layout.chart_of()[corner.face()];
                mesh.origin(corner) == vertex && layout.chart(of) == chart
            });
            for corner in seen {
                let expected = DVec2::new(place as f64 / 4.0, 0.0);
                assert!(layout.coordinates()[corner].unwrap().distance(expected) < 1e-12);
            }
        }
    }
}

#[test]
fn a_chart_without_coordinates_in_one_triangle_is_singular() {
    let mut net = cube_net(2);
    for corner in crate::mesh::FaceId(0).halfedges() {
        net.coordinates[corner] = None;
    }
    let layout = ChartLayout::new(net).unwrap();
    let kinds: Vec<_> = layout.charts().iter().map(|chart| chart.kind).collect();
    assert_eq!(
        kinds
            .iter()
            .filter(|&&kind| kind == ChartKind::Singular)
            .count(),
        1
    );
    assert_eq!(
        kinds
            .iter()
            .filter(|&&kind| kind == ChartKind::Regular)
            .count(),
        5
    );
}

#[test]
fn nets_that_leave_no_disks_are_refused() {
    let mut without = cube_net(2);
    without.edges = PerEdge::filled(without.edges.len(), None);
    let refusal = ChartLayout::new(without).unwrap_err();
    assert!(matches!(refusal, LayoutError::NoDisk { .. }), "{refusal}");
    let mut ring = torus_net(3, 3, 2);
    let mesh = ring.refined.surface.mesh();
    // Only lines across are left, so that charts are annuli.
    ring.edges = PerEdge::from_fn(mesh.edge_count(), |edge| {
        let [from, to] = mesh.ends(mesh.edge_halfedge(edge)).map(Element::index);
        let is_across = from / 6 == to / 6;
        ring.edges[edge].filter(|_| is_across)
    });
    let refusal = ChartLayout::new(ring).unwrap_err();
    assert!(matches!(refusal, LayoutError::NoDisk { .. }), "{refusal}");
    let mut dangling = cube_net(2);
    let inner = dangling.edges.enumerate().find(|(_, kind)| kind.is_none());
    let edge = inner.unwrap().0;
    dangling.edges[edge] = Some(ArcKind::Cut);
    let refusal = ChartLayout::new(dangling).unwrap_err();
    assert!(
        matches!(refusal, LayoutError::DanglingArc { .. }),
        "{refusal}"
    );
}
