use glam::DVec3;
use graticule_fixtures::{cube, grid};

use super::*;

#[test]
fn cubes_that_share_a_vertex_an_edge_or_a_wall_come_apart_closed() {
    let places = [
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(1.0, 0.0, 0.0),
    ];
    for (place, shared) in places.into_iter().zip([1, 2, 4]) {
        let joined = joined_cubes(&[DVec3::ZERO, place]);
        assert_eq!(joined.positions.len(), 16 - shared);
        let mut inside_out = joined.clone();
        let turned: Polygons = joined
            .polygons
            .iter()
            .map(reversed)
            .collect::<Vec<_>>()
            .to_polygons();
        inside_out.polygons = turned;
        for soup in [joined, inside_out] {
            let repaired = repaired(&soup);
            assert_eq!(components(&repaired), 2);
            assert_eq!(total(&repaired).boundary_loops, 0);
            assert_eq!(repaired.changes.vertices_split.count(), shared);
            assert!((volume(&repaired.surface) - 2.0).abs() < 1e-12);
        }
    }
}

#[test]
fn a_fin_is_cut_off_and_the_sheet_stays_whole() {
    // A grid with a triangle standing on an inner edge, and one on a chain of edges.
    let sheet = grid(1.0, 1.0, 6, 6);
    let mut finned = soup_of(&sheet);
    let tip = finned.positions.len() as u32;
    finned.positions.push(DVec3::new(0.5, 0.5, 1.0));
    for edge in [[22, 23], [23, 24], [24, 25]] {
        finned.polygons.push(&[edge[0], edge[1], tip]);
    }
    let repaired = repaired(&finned);
    assert_eq!(components(&repaired), 2);
    assert_eq!(repaired.changes.edges_split.count(), 3);
    let topology = Topology::of(repaired.surface.mesh());
    let sheet_part = topology.components[topology.largest_component()];
    assert_eq!([sheet_part.vertices, sheet_part.boundary_loops], [49, 1]);
}

#[test]
fn flaps_folded_out_of_a_closed_surface_leave_it_closed() {
    // Two flaps side by side, on neighbouring edges of a cube, as pinched folds of a scan are.
    let mut soup = soup_of(&cube());
    let [a, b, c] = [0, 1, 2].map(|corner| soup.polygons.vertices(0)[corner]);
    let tip = soup.positions.len() as u32;
    soup.positions.push(DVec3::splat(2.0));
    for triangle in [[a, b, tip], [b, a, tip], [b, c, tip], [c, b, tip]] {
        soup.polygons.push(&triangle);
    }
    let repaired = repaired_with(&soup, RepairOptions::default());
    let topology = Topology::of(repaired.surface.mesh());
    let solid = topology.components[topology.largest_component()];
    assert_eq!([solid.faces, solid.boundary_loops], [12, 0]);
}

#[test]
fn three_faces_at_an_edge_become_manifold() {
    let repaired = repaired(&fin());
    assert_eq!(repaired.surface.mesh().face_count(), 3);
    assert_eq!(repaired.changes.edges_split.all(), [[0, 1]]);
    assert_eq!(repaired.changes.vertices_split.all(), [0, 1]);
}

#[test]
fn a_checkerboard_comes_apart_into_its_squares() {
    let mut board = PolygonSoup::default();
    for i in 0..9 {
        for j in 0..9 {
            board
                .positions
                .push(DVec3::new(f64::from(i), f64::from(j), 0.0));
        }
    }
    for i in 0..8_u32 {
        for j in (0..8).filter(|j| (i + j) % 2 == 0) {
            let v = 9 * i + j;
            board.polygons.push(&[v, v + 9, v + 10]);
            board.polygons.push(&[v, v + 10, v + 1]);
        }
    }
    let repaired = repaired(&board);
    assert_eq!(components(&repaired), 32);
    assert_eq!(repaired.changes.vertices_split.count(), 49);
}

#[test]
fn quads_that_share_two_opposite_corners_stay_manifold() {
    // Two quads around vertex 3, which has no other neighbours than 0 and 2.
    let doublet = soup(
        &[
            [0., 0., 0.],
            [1., -2., 0.],
            [2., 0., 0.],
            [1., 0.5, 0.],
            [1., 2., 0.],
        ],
        &[&[0, 1, 2, 3], &[0, 3, 2, 4]],
    );
    let repaired = repaired(&doublet);
    assert!(repaired.changes.vertices_split.is_empty());
    assert!(total(&repaired).is_disk());
}
