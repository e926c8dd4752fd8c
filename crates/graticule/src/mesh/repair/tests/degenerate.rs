use glam::DVec3;
use graticule_fixtures::{cube, grid};

use super::*;
use crate::mesh::Defects;

#[test]
fn a_cap_inside_the_surface_goes_by_an_exchange() {
    let cap = soup(
        &[
            [0., 0., 0.],
            [2., 0., 0.],
            [1., 1., 0.],
            [1., -1., 0.],
            [1., 0., 0.],
        ],
        &[&[0, 4, 2], &[4, 1, 2], &[0, 1, 4], &[1, 0, 3]],
    );
    let repaired = repaired(&cap);
    assert!(total(&repaired).is_disk());
    assert_eq!(total(&repaired).vertices, 5);
    assert_eq!(repaired.changes.edges_exchanged.all(), [2]);
    assert!((area(&repaired.surface) - 2.0).abs() < 1e-12);
    assert!(
        repaired
            .mesh_corners(&cap)
            .iter()
            .all(|&corner| corner != NO_VALUE)
    );
}

#[test]
fn a_cap_at_the_boundary_is_dropped() {
    let mut capped = soup_of(&grid(1.0, 1.0, 8, 8));
    capped.positions.push(DVec3::new(0.5, 0.0, 0.0));
    capped.polygons.push(&[0, 8, 81]);
    let dropped = repaired(&capped);
    assert_eq!(dropped.changes.zero_area_dropped.all(), [128]);
    assert!(total(&dropped).is_disk());
    // A cap that closes a T-junction with the boundary.
    let strip = soup(
        &[
            [0., 0., 0.],
            [2., 0., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [2., 1., 0.],
        ],
        &[&[0, 1, 2], &[0, 2, 3], &[2, 1, 4], &[2, 4, 3]],
    );
    let dropped = repaired(&strip);
    assert_eq!(dropped.changes.zero_area_dropped.all(), [0]);
    assert_eq!(dropped.surface.mesh().face_count(), 3);
    assert!(total(&dropped).is_disk());
}

#[test]
fn an_edge_without_length_is_collapsed() {
    let mut pinched = soup_of(&grid(1.0, 1.0, 8, 8));
    pinched.positions[40] = pinched.positions[41];
    let repaired = repaired(&pinched);
    assert_eq!(repaired.changes.edges_collapsed.all(), [[40, 41]]);
    assert_eq!(total(&repaired).vertices, 80);
    assert!(total(&repaired).is_disk());
    assert!((area(&repaired.surface) - 1.0).abs() < 0.1);
    assert!(
        repaired
            .mesh_corners(&pinched)
            .iter()
            .all(|&corner| corner != NO_VALUE)
    );
}

#[test]
fn many_points_on_one_line_leave_no_flat_triangle() {
    // A long edge against a chain of collinear points, filled with caps.
    let count = 20_u32;
    let mut filled = PolygonSoup::default();
    filled
        .positions
        .extend((0..=count).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)));
    filled
        .positions
        .extend([DVec3::new(10.0, 9.0, 0.0), DVec3::new(10.0, -9.0, 0.0)]);
    for i in 0..count {
        filled.polygons.push(&[i, i + 1, count + 1]);
    }
    filled.polygons.push(&[count, 0, count + 2]);
    for i in 1..count {
        filled.polygons.push(&[0, i + 1, i]);
    }
    let repaired = repaired(&filled);
    assert!(total(&repaired).is_disk());
    assert!((area(&repaired.surface) - 180.0).abs() < 1e-9);
    let defects = Defects::find(&soup_of_surface(&repaired.surface));
    assert!(defects.zero_area.is_empty() && defects.is_sound());
}

#[test]
fn two_cubes_of_very_different_size_stay_two_cubes() {
    let small = cube().map(|p| p * 1e-8);
    let large = cube().map(|p| (p + DVec3::ONE) * 1e8);
    let repaired = repaired(&soup_of(&small.joined(&large)));
    assert!(repaired.changes.is_empty());
    assert_eq!(components(&repaired), 2);
}
