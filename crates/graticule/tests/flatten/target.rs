//! Conformal maps with told boundary, and cones.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};
use graticule::Hint;
use graticule::flatten::{
    BoundaryTarget, Extension, FlattenError, Patch, TargetMap, TargetOptions, Triangulation,
    target_map,
};
use graticule::mesh::{PerVertex, VertexId};
use graticule::watch::Watch;
use graticule_fixtures::{
    Fixture, annulus, bumpy_patch, disk, grid, irregular_disk, saddle_patch, spherical_cap,
};

use crate::support::{distance_up_to_similarity, patch, plane};

fn options(target: BoundaryTarget, extension: Extension) -> TargetOptions {
    TargetOptions {
        target,
        extension,
        ..TargetOptions::default()
    }
}

fn map(patch: &Patch, options: &TargetOptions) -> TargetMap {
    target_map(patch, options, &Watch::new()).unwrap()
}

const EXTENSIONS: [Extension; 2] = [Extension::Harmonic, Extension::Conjugate];

/// By how much the map's outer boundary turns left at each vertex of its loop.
fn turning(found: &TargetMap) -> Vec<(VertexId, f64)> {
    let patch = &found.patch;
    let outline: Vec<_> = patch.loop_vertices(patch.outer_loop()).collect();
    let count = outline.len();
    let at = |k: usize| found.map.uv[outline[k % count]];
    let turn = |k: usize| (at(k) - at(k + count - 1)).angle_to(at(k + 1) - at(k));
    (0..count).map(|k| (outline[k], turn(k))).collect()
}

#[test]
fn a_flat_patch_that_keeps_its_boundary_lengths_is_its_own_map() {
    for fixture in [
        disk(5),
        irregular_disk(8, 3),
        grid(2.0, 1.0, 8, 5),
        annulus(0.3, 1.0, 18, 4),
    ] {
        let patch = patch(&fixture);
        for extension in EXTENSIONS {
            let found = map(&patch, &options(BoundaryTarget::default(), extension));
            let error = distance_up_to_similarity(&found.map.uv, &plane(&patch));
            // A closed hole is a cone that is not quite flat.
            let allowed = if patch.holes().count() > 0 {
                1e-2
            } else {
                1e-10
            };
            assert!(error < allowed, "{extension:?} {error:e}");
            assert!(found.closing_change < allowed);
        }
    }
}

#[test]
fn a_bent_strip_unrolls_and_a_cap_becomes_round() {
    let flat = grid(3.0, 1.0, 30, 10);
    let strip = flat.map(|p| DVec3::new((0.8 * p.x).sin(), (0.8 * p.x).cos(), 0.8 * p.y));
    let found = map(&patch(&strip), &TargetOptions::default());
    assert!(found.map.energy.conformal_share() < 1e-12);
    let cap = patch(&spherical_cap(1.5, 10));
    let found = map(&cap, &TargetOptions::default());
    let radii = turning(&found)
        .into_iter()
        .map(|(v, _)| found.map.uv[v].length());
    let (low, high) = radii.fold((f64::MAX, 0.0_f64), |(l, h), r| (l.min(r), h.max(r)));
    assert!(high / low < 1.02, "{low} {high}");
    assert!(found.map.flips.is_zero());
}

#[test]
fn told_turning_angles_are_those_of_the_map() {
    for fixture in [bumpy_patch(10, 3), saddle_patch(10), spherical_cap(2.0, 9)] {
        let patch = patch(&fixture);
        let outline: Vec<_> = patch.loop_vertices(patch.outer_loop()).collect();
        let corner = |k: usize| outline[k * outline.len() / 4];
        let told: Vec<_> = (0..4).map(|k| (corner(k), FRAC_PI_2)).collect();
        let found = map(
            &patch,
            &options(BoundaryTarget::Angles(told), Extension::Harmonic),
        );
        for (vertex, turn) in turning(&found) {
            let is_corner = (0..4).any(|k| corner(k) == vertex);
            let expected = if is_corner { FRAC_PI_2 } else { 0.0 };
            assert!((turn - expected).abs() < 1e-6, "{vertex}: {turn}");
        }
        assert!(found.map.energy.conformal_share() < 0.2);
    }
}

#[test]
fn scales_told_are_those_of_the_boundary() {
    let patch = patch(&disk(12));
    let outline: Vec<_> = patch.loop_vertices(patch.outer_loop()).collect();
    // A conformal map of the disk onto itself, z ↦ (z + a) / (1 + a z).
    let moved = |p: DVec2| {
        let a = 0.3;
        let (up, down) = (p + DVec2::X * a, DVec2::X + p * a);
        DVec2::new(up.dot(down), down.perp_dot(up)) / down.length_squared()
    };
    let scale = |v: VertexId| {
        let p = patch.surface().position(v).truncate();
        let a = 0.3;
        (1.0 - a * a) / (DVec2::X + p * a).length_squared()
    };
    let told = outline.iter().map(|&v| (v, scale(v))).collect();
    let found = map(
        &patch,
        &options(BoundaryTarget::Scales(told), Extension::Harmonic),
    );
    let expected = plane(&patch).map(|p| moved(*p));
    let error = distance_up_to_similarity(&found.map.uv, &expected);
    assert!(error < 0.02, "{error}");
}

#[test]
fn a_cone_with_its_own_angle_is_unrolled_without_distortion() {
    // A pyramid with plane sides: all curvature is at its tip.
    let (sides, rings) = (7, 6);
    let mut positions = vec![DVec3::Z];
    let mut triangles = Vec::new();
    let at = |ring: u32, side: u32| match ring {
        0 => 0,
        _ => 1 + (ring - 1) * sides + side % sides,
    };
    for ring in 1..=rings {
        for side in 0..sides {
            let (sin, cos) = (f64::from(side) * TAU / f64::from(sides)).sin_cos();
            let share = f64::from(ring) / f64::from(rings);
            positions.push(DVec3::Z.lerp(DVec3::new(cos, sin, 0.0), share));
            let [a, b] = [side, side + 1].map(|side| at(ring, side));
            let [c, d] = [side, side + 1].map(|side| at(ring - 1, side));
            triangles.push([c, a, b]);
            if ring > 1 {
                triangles.push([c, b, d]);
            }
        }
    }
    let cone = patch(&Fixture {
        positions,
        triangles,
    });
    let (mesh, tip) = (cone.mesh(), VertexId(0));
    let triangulation = graticule::geometry::IntrinsicTriangulation::of(cone.surface()).unwrap();
    let angle = triangulation.angle_sums()[tip];
    assert!(angle < 6.0);
    for extension in EXTENSIONS {
        let found = map(
            &cone,
            &TargetOptions {
                cones: vec![(tip, angle)],
                extension,
                ..TargetOptions::default()
            },
        );
        assert!(found.patch.mesh().vertex_count() > mesh.vertex_count());
        assert!(found.map.energy.conformal_share() < 1e-10);
        // Every edge keeps its length.
        let (mesh, surface) = (found.patch.mesh(), found.patch.surface());
        for side in mesh.halfedges() {
            let [a, b] = mesh.ends(side);
            let length = surface.position(a).distance(surface.position(b));
            let flat = found.map.uv[a].distance(found.map.uv[b]);
            assert!((flat / length - 1.0).abs() < 1e-8);
        }
    }
}

#[test]
fn cones_take_area_distortion_away() {
    let cap = patch(&spherical_cap(2.8, 14));
    let mesh = cap.mesh();
    let height = |v: VertexId| cap.surface().position(v).z;
    let top = mesh
        .vertices()
        .max_by(|&a, &b| height(a).total_cmp(&height(b)))
        .unwrap();
    let spread = |found: &TargetMap| {
        let (mesh, uv) = (found.patch.mesh(), &found.map.uv);
        let scales = mesh.faces().map(|face| {
            let [a, b, c] = mesh.triangle(face).map(|v| uv[v]);
            let flat = (b - a).perp_dot(c - a);
            flat / (2.0 * cap.shapes()[face].area() * cap.unit_length().powi(2))
        });
        let (low, high) = scales.fold((f64::MAX, 0.0_f64), |(l, h), s| (l.min(s), h.max(s)));
        high / low
    };
    let smooth = map(&cap, &TargetOptions::default());
    let with_cone = map(
        &cap,
        &TargetOptions {
            cones: vec![(top, PI)],
            ..TargetOptions::default()
        },
    );
    assert!(spread(&with_cone) < spread(&smooth));
    assert!(with_cone.map.flips.is_zero());
    // The copies of a vertex along the seam have the names of its source.
    for (vertex, source) in with_cone.vertex_sources.enumerate() {
        assert_eq!(
            with_cone.patch.surface().position(vertex),
            cap.surface().position(*source)
        );
    }
}

#[test]
fn intrinsic_delaunay_and_holes_are_taken() {
    for fixture in [bumpy_patch(9, 4), annulus(0.2, 1.0, 24, 6)] {
        let patch = patch(&fixture);
        let found = map(
            &patch,
            &TargetOptions {
                triangulation: Triangulation::IntrinsicDelaunay,
                ..TargetOptions::default()
            },
        );
        assert!(found.map.intrinsic_flips.is_some());
        assert!(found.map.energy.conformal_share() < 0.05);
        let sources = PerVertex::from_fn(patch.mesh().vertex_count(), |v: VertexId| v);
        assert_eq!(found.vertex_sources, sources);
    }
}

#[test]
fn targets_that_cannot_be_are_refused_by_name() {
    let patch = patch(&disk(4));
    let mesh = patch.mesh();
    let outer = patch.loop_vertices(patch.outer_loop()).next().unwrap();
    let inner = mesh
        .vertices()
        .find(|&v| !mesh.is_boundary_vertex(v))
        .unwrap();
    let refuse = |target: BoundaryTarget, cones: Vec<(VertexId, f64)>| {
        let options = TargetOptions {
            target,
            cones,
            ..TargetOptions::default()
        };
        let refusal = target_map(&patch, &options, &Watch::new()).unwrap_err();
        assert!(refusal.hint().is_some());
        refusal
    };
    let bad = |refusal: FlattenError, vertex: VertexId| match refusal {
        FlattenError::BadTarget { vertex: named, .. } => assert_eq!(named, vertex),
        other => panic!("{other}"),
    };
    let nowhere = VertexId(9999);
    let scales = |list| BoundaryTarget::Scales(list);
    bad(refuse(scales(vec![(inner, 1.0)]), vec![]), inner);
    bad(refuse(scales(vec![(nowhere, 1.0)]), vec![]), nowhere);
    bad(refuse(scales(vec![(outer, 0.0)]), vec![]), outer);
    bad(refuse(scales(vec![(outer, f64::NAN)]), vec![]), outer);
    bad(
        refuse(scales(vec![(outer, 1.0), (outer, 2.0)]), vec![]),
        outer,
    );
    bad(refuse(scales(vec![]), vec![(outer, PI)]), outer);
    bad(refuse(scales(vec![]), vec![(nowhere, PI)]), nowhere);
    bad(refuse(scales(vec![]), vec![(inner, -1.0)]), inner);
    bad(
        refuse(scales(vec![]), vec![(inner, PI), (inner, PI)]),
        inner,
    );
    let all: Vec<_> = patch
        .loop_vertices(patch.outer_loop())
        .map(|v| (v, 0.1))
        .collect();
    let refusal = refuse(BoundaryTarget::Angles(all), vec![]);
    assert!(matches!(refusal, FlattenError::AngleSum { .. }));
}
