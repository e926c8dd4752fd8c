use glam::DVec3;
use graticule_fixtures::{Noise, grid};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::*;
use crate::mesh::Defects;

/// Polygons over few vertices, many of them at the same places: everything is wrong.
fn random_soup() -> impl Strategy<Value = PolygonSoup> {
    let positions = prop::collection::vec(prop::array::uniform3(0_u8..4), 4..24);
    let polygon = |vertices: u32| prop::collection::vec(0..vertices, 2..7);
    positions.prop_flat_map(move |positions| {
        let polygons = prop::collection::vec(polygon(positions.len() as u32), 1..30);
        (Just(positions), polygons).prop_map(|(positions, polygons)| PolygonSoup {
            positions: positions
                .iter()
                .map(|p| DVec3::from_array(p.map(f64::from)))
                .collect(),
            polygons: polygons.to_polygons(),
            ..PolygonSoup::default()
        })
    })
}

/// The same cases in every run, and no files left behind.
fn cases(count: u32) -> ProptestConfig {
    ProptestConfig {
        cases: count,
        rng_seed: RngSeed::Fixed(2006),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

fn check_random(soup: &PolygonSoup, options: RepairOptions) {
    match repair(soup, &options, &Watch::new()) {
        Err(error) => assert!(!matches!(error, RepairError::Mesh(_)), "{error}"),
        Ok(repaired) => {
            let topology = Topology::of(repaired.surface.mesh());
            for component in &topology.components {
                let [genus, loops] = [component.genus, component.boundary_loops].map(|n| n as u32);
                let expected = 2 - 2 * i64::from(genus) - i64::from(loops);
                assert_eq!(component.euler_characteristic, expected);
            }
            check_maps(soup, &repaired);
            let whole = repaired.to_soup(soup);
            assert!(whole.polygons.len() <= repaired.surface.mesh().face_count());
        }
    }
}

proptest! {
    #![proptest_config(cases(1500))]

    #[test]
    fn a_random_soup_ends_in_a_surface_or_a_named_refusal(soup in random_soup()) {
        let _ = Defects::find(&soup).findings();
        check_random(&soup, RepairOptions::default());
        for weld in [Weld::Auto, Weld::Always, Weld::Never] {
            let options = RepairOptions {
                weld,
                non_orientable: NonOrientable::CutOpen,
                ..RepairOptions::default()
            };
            check_random(&soup, options);
        }
    }
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn scaling_by_powers_of_two_changes_nothing(soup in random_soup()) {
        let answer = |exponent: i32| {
            let mut scaled = soup.clone();
            for position in &mut scaled.positions {
                *position *= 2.0_f64.powi(exponent);
            }
            let repaired = repair(&scaled, &RepairOptions::default(), &Watch::new());
            repaired.map(|repaired| (repaired.surface.shared_mesh(), repaired.changes))
        };
        let expected = answer(0);
        for exponent in [-400, -40, 40, 400] {
            prop_assert_eq!(&answer(exponent), &expected);
        }
    }
}

#[test]
fn a_patch_far_from_the_origin_is_left_as_it_is() {
    let far = grid(0.01, 0.01, 8, 8).map(|p| p + DVec3::splat(1e7));
    assert!(repaired(&soup_of(&far)).changes.is_empty());
}

#[test]
fn renumbering_changes_no_count() {
    let mut noise = Noise::new(7);
    let joined = joined_cubes(&[DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0), DVec3::X * 3.0]);
    let expected = Topology::of(repaired(&joined).surface.mesh());
    for _ in 0..20 {
        let new_of_old = noise.permutation(joined.positions.len());
        let mut shuffled = PolygonSoup {
            positions: joined.positions.clone(),
            ..PolygonSoup::default()
        };
        for (&new, &position) in new_of_old.iter().zip(&joined.positions) {
            shuffled.positions[new as usize] = position;
        }
        for polygon in noise.permutation(joined.polygons.len()) {
            let vertices = joined.polygons.vertices(polygon as usize).iter();
            let mut renumbered: Vec<_> = vertices.map(|&v| new_of_old[v as usize]).collect();
            renumbered.rotate_left(noise.below(4));
            shuffled.polygons.push(&renumbered);
        }
        let result = repaired(&shuffled);
        assert_eq!(Topology::of(result.surface.mesh()).total, expected.total);
        assert!((volume(&result.surface) - 3.0).abs() < 1e-12);
    }
}
