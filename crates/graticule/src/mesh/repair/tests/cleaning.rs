use glam::DVec3;
use graticule_fixtures::{annulus, cube, grid, icosphere, torus};

use super::*;

#[test]
fn a_sound_surface_is_left_as_it_is() {
    for fixture in [
        cube(),
        icosphere(2),
        torus(2.0, 0.5, 12, 6),
        annulus(1.0, 2.0, 9, 2),
    ] {
        let repaired = repaired(&soup_of(&fixture));
        assert!(repaired.changes.is_empty() && repaired.changes.sentences().is_empty());
        let expected = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        assert_eq!(repaired.surface, expected);
    }
}

#[test]
fn what_is_no_surface_is_refused_by_name() {
    assert_eq!(
        refusal(&PolygonSoup::default()),
        RepairError::NoFaces { vertices: 0 }
    );
    let points = soup(&[[0.0; 3], [1.0; 3]], &[]);
    assert_eq!(refusal(&points), RepairError::NoFaces { vertices: 2 });
    let mut damaged = soup_of(&cube());
    damaged.polygons.push(&[0, 1, 8]);
    let error = RepairError::IndexOutOfRange {
        polygon: 12,
        index: 8,
        vertices: 8,
    };
    assert_eq!(refusal(&damaged), error);
    assert_eq!(
        error.to_string(),
        "polygon 12: vertex index 8 is out of range (8 vertices)"
    );
    let point = soup(&[[1.0; 3]; 3], &[&[0, 1, 2]]);
    assert_eq!(refusal(&point), RepairError::ZeroExtent);
    let line = soup(&[[0.0; 3], [1.0; 3], [2.0; 3]], &[&[0, 1, 2]]);
    assert_eq!(refusal(&line), RepairError::NothingLeft);
    let lines = soup(&[[0.0; 3], [1.0; 3]], &[&[0, 1], &[0, 1, 0]]);
    assert_eq!(refusal(&lines), RepairError::NoUsableFaces { polygons: 2 });
    let huge = soup(&[[-f64::MAX; 3], [f64::MAX; 3], [0.0; 3]], &[&[0, 1, 2]]);
    assert!(matches!(refusal(&huge), RepairError::ExtentOverflow { .. }));
    let watch = Watch::new();
    watch.cancel_handle().cancel();
    let stopped = repair(&soup_of(&cube()), &RepairOptions::default(), &watch);
    assert!(matches!(stopped, Err(RepairError::Stopped(_))));
}

#[test]
fn nan_is_refused_where_used_and_dropped_where_not() {
    let mut damaged = soup_of(&grid(1.0, 1.0, 4, 4));
    damaged.positions.push(DVec3::NAN);
    let with_unused = repaired(&damaged);
    assert_eq!(with_unused.changes.unused_vertices_dropped.all(), [25]);
    damaged.positions[12].y = f64::NAN;
    assert!(matches!(
        refusal(&damaged),
        RepairError::NonFinitePosition { vertex: 12, .. }
    ));
    let options = RepairOptions {
        non_finite: NonFinite::DropPolygons,
        ..RepairOptions::default()
    };
    let dropped = repaired_with(&damaged, options);
    assert!(!dropped.changes.non_finite_polygons_dropped.is_empty());
    assert_eq!(total(&dropped).boundary_loops, 2);
}

#[test]
fn repeated_corners_duplicates_and_short_polygons_go() {
    let mut damaged = soup_of(&cube());
    let first = damaged.polygons.vertices(0).to_vec();
    for extra in [
        &[0, 0, 1][..],
        &[2, 2, 2],
        &[0, 1],
        &[3],
        &first,
        &[first[2], first[1], first[0]],
    ] {
        damaged.polygons.push(extra);
    }
    let repaired = repaired(&damaged);
    assert_eq!(repaired.surface.mesh().face_count(), 12);
    assert_eq!(
        repaired.changes.collapsed_polygons_dropped.all(),
        [12, 13, 14, 15]
    );
    assert_eq!(repaired.changes.duplicate_polygons_dropped.all(), [16, 17]);
    assert!((volume(&repaired.surface) - 1.0).abs() < 1e-12);
    // The duplicates' corners follow the polygon that stays.
    let corners = repaired.mesh_corners(&damaged);
    let place = damaged.polygons.corner_range(16).start;
    assert_eq!(corners[place], corners[0]);
}

#[test]
fn a_sheet_folded_flat_becomes_a_single_sheet() {
    let folded = soup(
        &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]],
        &[&[0, 1, 2], &[0, 2, 1]],
    );
    let repaired = repaired(&folded);
    assert_eq!(repaired.surface.mesh().face_count(), 1);
    assert_eq!(repaired.changes.duplicate_polygons_dropped.all(), [1]);
}
