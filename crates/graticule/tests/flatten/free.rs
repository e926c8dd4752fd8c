//! Maps with a free boundary: natural with two pins, and spectral.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use graticule::Hint;
use graticule::flatten::{
    FlatMap, FlattenError, NaturalOptions, Patch, Pins, Triangulation, natural_map, spectral_map,
};
use graticule::mesh::{PerVertex, VertexId};
use graticule::watch::Watch;
use graticule_fixtures::{
    Fixture, annulus, bumpy_patch, cone_patch, cylinder_patch, disk, grid, irregular_disk,
    saddle_patch, spherical_cap,
};

use crate::least_squares::least_squares_map;
use crate::support::{distance, distance_up_to_similarity, in_old_numbers, patch, plane, rotated};

const TRIANGULATIONS: [Triangulation; 2] = [Triangulation::Given, Triangulation::IntrinsicDelaunay];

fn natural(patch: &Patch) -> FlatMap {
    natural_map(patch, &NaturalOptions::default(), &Watch::new()).unwrap()
}

fn spectral(patch: &Patch) -> FlatMap {
    spectral_map(patch, Triangulation::Given, &Watch::new()).unwrap()
}

fn pinned(patch: &Patch, pins: [(u32, DVec2); 2]) -> Result<FlatMap, FlattenError> {
    let options = NaturalOptions {
        pins: Pins::At(pins.map(|(vertex, place)| (VertexId(vertex), place))),
        ..NaturalOptions::default()
    };
    natural_map(patch, &options, &Watch::new())
}

fn curved() -> Vec<Fixture> {
    vec![
        bumpy_patch(6, 1),
        spherical_cap(1.2, 6),
        saddle_patch(8),
        cone_patch(4.0, 6),
        cylinder_patch(1.0, 0.7, 12, 4),
        bumpy_patch(3, 8).map(|p| p * DVec3::new(1.0, 0.1, 3.0)),
    ]
}

#[test]
fn a_flat_patch_is_its_own_map() {
    let flat = [
        disk(7),
        irregular_disk(9, 2),
        grid(3.0, 1.0, 9, 4),
        annulus(0.4, 1.0, 20, 4),
        grid(1.0, 1.0, 1, 1),
        disk(1),
        // Needles, and far from the origin.
        irregular_disk(6, 4).map(|p| DVec3::new(p.x, p.y * 1e-3, 0.0)),
        irregular_disk(6, 4).map(|p| p + DVec3::new(1e5, -2e5, 0.0)),
    ];
    for fixture in flat {
        let patch = patch(&fixture);
        for triangulation in TRIANGULATIONS {
            let options = NaturalOptions {
                triangulation,
                ..NaturalOptions::default()
            };
            let natural = natural_map(&patch, &options, &Watch::new()).unwrap();
            let spectral = spectral_map(&patch, triangulation, &Watch::new()).unwrap();
            for map in [natural, spectral] {
                let error = distance_up_to_similarity(&map.uv, &plane(&patch));
                assert!(
                    // Far from the origin, positions have ten digits.
                    error < 1e-9,
                    "{:?} {triangulation:?}: {error:e}",
                    map.method
                );
                assert!(map.flips.is_zero());
                assert!((map.energy.area - 1.0).abs() < 1e-9);
                assert!(map.energy.conformal < 1e-15);
            }
        }
    }
}

#[test]
fn a_bent_strip_unrolls() {
    let strip = grid(3.0, 1.0, 30, 10);
    let bent = strip.clone().map(|p| {
        let angle = p.x * 0.8;
        DVec3::new(angle.sin(), angle.cos(), p.y * 0.8)
    });
    // The flat grid whose cells are as wide as the chords of the bent one.
    let chord = 2.0 * (0.1_f64 * 0.8 / 2.0).sin();
    let unrolled = patch(&strip.map(|p| DVec3::new(p.x * chord * 10.0, p.y * 0.8, 0.0)));
    let bent = patch(&bent);
    for map in [natural(&bent), spectral(&bent)] {
        // The bent strip is seen from the side where it turns clockwise.
        let mirrored = plane(&unrolled).map(|p| DVec2::new(p.x, p.y));
        let error = distance_up_to_similarity(&map.uv, &mirrored);
        assert!(error < 1e-10, "{error:e}");
    }
}

#[test]
fn the_natural_map_is_the_least_squares_conformal_map_with_the_same_pins() {
    for fixture in curved() {
        let last = fixture.positions.len() as u32 - 1;
        for pins in [
            [(0, DVec2::new(1.0, 2.0)), (last, DVec2::new(-0.5, 0.3))],
            [(last, DVec2::ZERO), (last / 2, DVec2::X * 7.0)],
        ] {
            let map = pinned(&patch(&fixture), pins).unwrap();
            let expected = PerVertex::new(least_squares_map(&fixture, pins));
            let error = distance(&map.uv, &expected);
            assert!(error < 1e-8, "{error:e}");
            assert!(map.residual < 1e-14);
            for (vertex, place) in pins {
                assert!(map.uv[VertexId(vertex)].distance(place) < 1e-14);
            }
        }
    }
}

#[test]
fn the_natural_map_is_a_minimum_of_the_conformal_energy() {
    let fixture = bumpy_patch(5, 3);
    let patch = patch(&fixture);
    let map = natural(&patch);
    let energy = |uv: &PerVertex<DVec2>| {
        graticule::flatten::MapEnergy::of(patch.mesh(), patch.shapes(), uv).conformal
    };
    let least = energy(&map.uv);
    for vertex in patch.mesh().vertices().step_by(5) {
        for shift in [DVec2::X, DVec2::Y] {
            let moved = |step: f64| {
                let mut uv = map.uv.clone();
                uv[vertex] += shift * step;
                energy(&uv)
            };
            let is_pin = map.uv[vertex].y == 0.0 && patch.mesh().is_boundary_vertex(vertex);
            let slope = (moved(1e-4) - moved(-1e-4)) / 2e-4;
            assert!(is_pin || slope.abs() < 1e-9, "{slope:e}");
            assert!(moved(1e-2) > least);
        }
    }
}

#[test]
fn the_spectral_map_has_less_energy_for_its_boundary_than_any_pinned_map() {
    for fixture in curved() {
        let patch = patch(&fixture);
        let share = |map: &FlatMap| {
            let surface = patch.surface();
            let (mut centre, mut total) = (DVec2::ZERO, 0.0);
            let mut weighted = Vec::new();
            for boundary_loop in patch.mesh().boundary_loops() {
                for &side in patch.mesh().boundary_loop(boundary_loop) {
                    let half = surface.halfedge_vector(side).length() / 2.0;
                    for end in patch.mesh().ends(side) {
                        centre += map.uv[end] * half;
                        total += half;
                        weighted.push((map.uv[end], half));
                    }
                }
            }
            centre /= total;
            let inertia: f64 = weighted
                .iter()
                .map(|(p, m)| p.distance_squared(centre) * m)
                .sum();
            let shapes = patch.shapes();
            let energy = graticule::flatten::MapEnergy::of(patch.mesh(), shapes, &map.uv);
            energy.conformal / inertia
        };
        let spectral = share(&spectral(&patch));
        for other in [5, 11, 17] {
            let pins = [(0, DVec2::ZERO), (other, DVec2::X)];
            assert!(spectral <= share(&pinned(&patch, pins).unwrap()) * (1.0 + 1e-9));
        }
        assert!(spectral <= share(&natural(&patch)) * (1.0 + 1e-9));
    }
}

#[test]
fn scaling_by_a_power_of_two_is_exact() {
    let fixture = bumpy_patch(5, 3);
    for map_of in [natural, spectral] {
        let original = map_of(&patch(&fixture));
        for exponent in [-40, 40] {
            let scale = 2.0_f64.powi(exponent);
            let scaled = map_of(&patch(&fixture.clone().map(|p| p * scale)));
            assert_eq!(scaled.uv.map(|&p| p / scale), original.uv);
            assert_eq!(scaled.energy, original.energy);
        }
        for scale in [1e-30, 1e30, 1e-9, 1e9] {
            let scaled = map_of(&patch(&fixture.clone().map(|p| p * scale)));
            let error = distance(&scaled.uv.map(|&p| p / scale), &original.uv);
            assert!(error < 1e-10, "{error:e}");
        }
    }
}

#[test]
fn rotating_moving_and_renumbering_change_nothing_but_rounding() {
    let fixture = bumpy_patch(7, 5);
    let (renumbered, new_of_old) = fixture.renumbered(3);
    for map_of in [natural, spectral] {
        let original = map_of(&patch(&fixture)).uv;
        let moved = fixture
            .clone()
            .map(|p| rotated(p) + DVec3::new(3.0, -7.0, 2.0));
        let error = distance(&map_of(&patch(&moved)).uv, &original);
        assert!(error < 1e-10, "{error:e}");
        let other = in_old_numbers(&map_of(&patch(&renumbered)).uv, &new_of_old);
        // The pins may have changed places.
        let error = distance_up_to_similarity(&other, &original);
        assert!(error < 1e-10, "{error:e}");
    }
}

#[test]
fn a_far_offset_costs_only_the_digits_of_the_input() {
    let fixture = bumpy_patch(5, 3);
    let original = natural(&patch(&fixture)).uv;
    let far = natural(&patch(&fixture.map(|p| p + DVec3::splat(1e7)))).uv;
    // The coordinates themselves are rounded to 1e7 × 1e-16, edges are about 0.2 long.
    let error = distance(&far, &original);
    assert!(error < 1e-6, "{error:e}");
}

#[test]
fn the_lost_conformality_falls_with_the_square_of_the_edge_length() {
    let families: [fn(u32) -> Fixture; 3] = [
        |rings| spherical_cap(1.2, rings),
        |rings| cylinder_patch(1.0, 1.0, 4 * rings, rings),
        |rings| saddle_patch(2 * rings),
    ];
    for fixture_of in families {
        for map_of in [natural, spectral] {
            let shares = [6, 12, 24]
                .map(|rings| map_of(&patch(&fixture_of(rings))).energy.conformal_share());
            let order = (shares[0] / shares[2]).log2() / 2.0;
            assert!(order > 1.7, "{shares:?} order {order}");
        }
    }
}

#[test]
fn a_symmetric_cap_gets_a_round_boundary() {
    let cap = patch(&spherical_cap(1.4, 12));
    let map = spectral(&cap);
    let boundary: Vec<_> = cap.boundary_vertices().map(|v| map.uv[v]).collect();
    let centre = boundary.iter().sum::<DVec2>() / boundary.len() as f64;
    let radii: Vec<f64> = boundary.iter().map(|p| p.distance(centre)).collect();
    let mean = radii.iter().sum::<f64>() / radii.len() as f64;
    // The mesh has six axes of symmetry; between them the radius may vary a little.
    assert!(
        radii.iter().all(|r| (r / mean - 1.0).abs() < 2e-3),
        "{radii:?}"
    );
    for step in 0..12 {
        assert!((radii[step] / radii[step + 12] - 1.0).abs() < 1e-9);
    }
    assert!(map.flips.is_zero());
}

#[test]
fn needles_and_degenerate_triangles_end_in_a_map() {
    let mut fixture = bumpy_patch(5, 1);
    // A vertex pushed onto the edge opposite to it: a triangle without area.
    let [a, b, c] = fixture.triangles[20].map(|v| v as usize);
    fixture.positions[a] = (fixture.positions[b] + fixture.positions[c]) / 2.0;
    for shift in [0.0, 1e-12, 1e-6] {
        let shifted = Fixture {
            positions: fixture
                .positions
                .iter()
                .map(|&p| p + DVec3::Z * shift * p.x.sin())
                .collect(),
            ..fixture.clone()
        };
        let patch = patch(&shifted);
        for map in [natural(&patch), spectral(&patch)] {
            assert!(map.residual <= 1e-9);
            assert!(map.uv.iter().all(|p| p.is_finite()));
        }
    }
}

#[test]
fn pins_that_fix_nothing_are_refused() {
    let patch = patch(&disk(3));
    let refused = |pins| {
        let error = pinned(&patch, pins).unwrap_err();
        assert!(error.hint().is_some());
        error
    };
    let same = refused([(3, DVec2::ZERO), (3, DVec2::X)]);
    assert!(matches!(
        same,
        FlattenError::SamePin {
            vertex: VertexId(3)
        }
    ));
    let absent = refused([(3, DVec2::ZERO), (99, DVec2::X)]);
    assert!(matches!(
        absent,
        FlattenError::NoSuchPin { vertices: 37, .. }
    ));
    for place in [DVec2::ZERO, DVec2::NAN, DVec2::INFINITY] {
        let nowhere = refused([(3, DVec2::ZERO), (4, place)]);
        assert!(matches!(nowhere, FlattenError::PinDistance { .. }));
    }
}

#[test]
fn pins_that_a_conformal_map_takes_to_one_point_are_refused() {
    // A flat ring cut open: the two copies of a vertex on the cut are one point of the plane.
    let strip = grid(1.0, 1.0, 24, 3).map(|p| {
        let (sin, cos) = (-2.0 * PI * p.x).sin_cos();
        DVec3::new(cos, sin, 0.0) * (1.0 + p.y)
    });
    let patch = patch(&strip);
    let refusal = pinned(&patch, [(0, DVec2::ZERO), (24, DVec2::X)]).unwrap_err();
    let told = matches!(
        refusal,
        FlattenError::Undetermined { .. } | FlattenError::Solve(_)
    );
    assert!(told && refusal.hint().is_some(), "{refusal:?}");
    for map in [natural(&patch), spectral(&patch)] {
        assert!(distance_up_to_similarity(&map.uv, &plane(&patch)) < 1e-10);
    }
}

#[test]
fn a_strip_as_thin_as_a_thread_still_unrolls() {
    for (width, columns) in [(0.03, 2000), (0.001, 400)] {
        let flat = patch(&grid(2000.0, width, columns, 1));
        let watch = Watch::new();
        let map = natural_map(&flat, &NaturalOptions::default(), &watch).unwrap();
        assert_eq!(watch.warnings()[0].code, "orthogonal-factorisation");
        assert!(map.flips.is_zero());
        let across = map.uv.as_slice()[columns as usize + 1] - map.uv.as_slice()[0];
        assert!((across.length() / width - 1.0).abs() < 1e-3, "{across}");
        assert!(distance_up_to_similarity(&map.uv, &plane(&flat)) < 1e-6);
        let watch = Watch::new();
        let spectral = spectral_map(&flat, Triangulation::Given, &watch).unwrap();
        assert_eq!(watch.warnings()[0].code, "pins-for-thin-patch");
        assert!(distance_up_to_similarity(&spectral.uv, &plane(&flat)) < 1e-6);
    }
}

#[test]
fn a_stopped_watch_stops_the_map() {
    let watch = Watch::new();
    watch.cancel_handle().cancel();
    let stopped = natural_map(&patch(&disk(3)), &NaturalOptions::default(), &watch);
    assert!(matches!(stopped, Err(FlattenError::Stopped(_))));
}
