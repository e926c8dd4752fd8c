use glam::{DVec2, DVec3};
use graticule_fixtures::{cube, grid, icosphere, torus};

use super::*;
use crate::mesh::CornerAttribute;

#[test]
fn triangles_with_vertices_of_their_own_are_welded() {
    for fixture in [grid(1.0, 1.0, 8, 8), icosphere(2), torus(2.0, 0.5, 12, 6)] {
        let welded = repaired(&soup_of(&unwelded(&fixture)));
        let expected = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let expected = Topology::of(expected.mesh());
        assert_eq!(
            Topology::of(welded.surface.mesh()).components,
            expected.components
        );
        assert!(!welded.changes.vertices_welded.is_empty());
    }
    let options = RepairOptions {
        weld: Weld::Never,
        ..RepairOptions::default()
    };
    let soup = soup_of(&unwelded(&cube()));
    let apart = repair(&soup, &options, &Watch::new()).unwrap();
    assert_eq!(components(&apart), 12);
}

/// A cylinder around z cut open along a line, optionally with texture coordinates per vertex.
fn cut_cylinder(textured: bool) -> PolygonSoup {
    let around = 12_u32;
    let mut soup = PolygonSoup::default();
    let mut uvs = Vec::new();
    for i in 0..=around {
        // Exactly the same positions at both ends.
        let angle = std::f64::consts::TAU * f64::from(i % around) / f64::from(around);
        for z in [0.0, 1.0, 2.0] {
            soup.positions.push(DVec3::new(angle.cos(), angle.sin(), z));
            uvs.push(DVec2::new(f64::from(i), z));
        }
    }
    for i in 0..around {
        for j in 0..2 {
            let v = 3 * i + j;
            soup.polygons.push(&[v, v + 3, v + 4, v + 1]);
        }
    }
    if textured {
        soup.attributes.uv_sets.push(CornerAttribute {
            name: String::new(),
            values: uvs,
            corner_values: soup.polygons.corner_vertices().to_vec(),
        });
    }
    soup
}

#[test]
fn a_cut_stays_open_but_a_texture_seam_closes() {
    let cut = repaired(&cut_cylinder(false));
    assert!(total(&cut).is_disk());
    assert_eq!(cut.changes.seams_left_open.count(), 2);
    let seam = repaired(&cut_cylinder(true));
    assert_eq!(
        [total(&seam).boundary_loops, total(&seam).vertices],
        [2, 36]
    );
    let options = RepairOptions {
        weld: Weld::Always,
        ..RepairOptions::default()
    };
    let closed = repaired_with(&cut_cylinder(false), options);
    assert_eq!(total(&closed).boundary_loops, 2);
}

#[test]
fn cracks_close_up_to_the_distance_asked_for() {
    let right = grid(1.0, 1.0, 4, 4).map(|p| p + DVec3::new(1.0 + 1e-4, 0.0, 0.0));
    let cracked = soup_of(&grid(1.0, 1.0, 4, 4).joined(&right));
    let within = |weld_within| {
        let options = RepairOptions {
            weld_within,
            ..RepairOptions::default()
        };
        repair(&cracked, &options, &Watch::new()).unwrap()
    };
    assert_eq!(components(&within(5e-5)), 2);
    let closed = within(2e-4);
    assert_eq!(components(&closed), 1);
    assert!(total(&closed).is_disk());
    assert_eq!(closed.changes.vertices_joined.count(), 5);
    assert!(closed.changes.keep_polygons());
    for vertex in closed.surface.mesh().vertices() {
        let source = closed.vertex_sources[vertex] as usize;
        assert_eq!(closed.surface.position(vertex), cracked.positions[source]);
    }
}
