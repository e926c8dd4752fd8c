//! Maps without flips.

use glam::{DVec2, DVec3};
use graticule::flatten::{
    BoundaryCurve, BoundaryFreedom, DistortionEnergy, FixedOptions, FlattenError, InjectiveMap,
    InjectiveOptions, Overlap, Patch, Weights, boundary_on_curve, fixed_map, improve_map,
    injective_map,
};
use graticule::measure::{corner_uvs, measure_map};
use graticule::watch::Watch;
use graticule_fixtures::{
    Fixture, annulus, bumpy_patch, cylinder_patch, disk, grid, grid_with_flat_triangles, needles,
    spherical_cap,
};

use crate::support::{distance_up_to_similarity, patch, plane, rotated};

fn laid(patch: &Patch, options: &InjectiveOptions) -> InjectiveMap {
    injective_map(patch, options, &Watch::new()).unwrap()
}

fn free(patch: &Patch) -> InjectiveMap {
    laid(patch, &InjectiveOptions::default())
}

/// A closed tube of this many circumferences of length, open at one end.
fn finger(circumferences: u32) -> Fixture {
    let around = 12;
    let rows = around * circumferences;
    let height = std::f64::consts::TAU * f64::from(circumferences);
    let mut tube = cylinder_patch(1.0, height, around, rows);
    let rim: Vec<u32> = {
        let top = tube.positions.iter().map(|p| p.z).fold(f64::MIN, f64::max);
        let at_top = |&v: &u32| tube.positions[v as usize].z > top - 1e-9;
        (0..tube.positions.len() as u32).filter(at_top).collect()
    };
    let tip = tube.positions.len() as u32;
    tube.positions.push(DVec3::new(0.0, 0.0, height + 0.5));
    for (index, &vertex) in rim.iter().enumerate() {
        tube.triangles
            .push([vertex, rim[(index + 1) % rim.len()], tip]);
    }
    tube
}

#[test]
fn a_flat_patch_is_its_own_map() {
    for fixture in [disk(6), grid(3.0, 1.0, 12, 4), annulus(0.5, 1.0, 24, 4)] {
        let turned = patch(&fixture.clone().map(rotated));
        let map = free(&turned);
        assert!((map.energy - 4.0).abs() < 1e-5, "{}", map.energy);
        let flat = plane(&patch(&fixture));
        assert!(distance_up_to_similarity(&map.map.uv, &flat) < 2e-3);
    }
}

#[test]
fn nothing_is_flipped_on_hard_patches() {
    let fixtures = [
        bumpy_patch(12, 5),
        spherical_cap(2.8, 12),
        needles(8, 1e4, 3),
        grid_with_flat_triangles(8, 6),
        grid(1.0, 1.0, 1, 1),
        disk(1),
    ];
    for fixture in &fixtures {
        let patch = patch(fixture);
        let map = free(&patch);
        assert!(map.map.flips.is_zero());
        assert!(map.energy.is_finite() && map.energy >= 4.0 - 1e-9);
    }
}

/// Tutte's map of it shrinks by e^-2π with each circumference: beyond six, double precision is out.
#[test]
fn a_finger_far_too_long_for_convex_combinations_is_laid_down() {
    let patch = patch(&finger(12));
    let circle = boundary_on_curve(&patch, &BoundaryCurve::Circle, &Watch::new()).unwrap();
    let uniform = FixedOptions {
        weights: Weights::Uniform,
        ..FixedOptions::default()
    };
    let convex = fixed_map(&patch, &circle, &uniform, &Watch::new()).unwrap();
    let smallest = patch.mesh().faces().map(|face| {
        let [a, b, c] = patch.mesh().triangle(face).map(|vertex| convex.uv[vertex]);
        (b - a).perp_dot(c - a)
    });
    assert!(smallest.fold(f64::INFINITY, f64::min) < 1e-25);
    let map = free(&patch);
    assert!(map.map.flips.is_zero());
    // A cone of the best slope has about 2 L / √3 = 87 for a length L of 75 radii.
    assert!(map.energy < 130.0, "{}", map.energy);
}

#[test]
fn the_energy_is_that_of_the_measure_and_falls_with_every_step() {
    let patch = patch(&bumpy_patch(10, 2));
    let map = free(&patch);
    let corners = corner_uvs(patch.mesh(), &map.map.uv);
    let measure = measure_map(patch.surface(), &corners, &Watch::new()).unwrap();
    let measured = measure.distortion.unwrap().symmetric_dirichlet.unwrap();
    assert!(
        (measured - map.energy).abs() < 1e-8,
        "{measured} {}",
        map.energy
    );
    let energies = map.descent.history.windows(2);
    assert!(
        energies
            .into_iter()
            .all(|pair| pair[1].energy < pair[0].energy)
    );
    assert!(map.descent.converged);
}

#[test]
fn mips_keeps_angles_better_and_lengths_worse() {
    let patch = patch(&spherical_cap(1.5, 8));
    let mips = InjectiveOptions {
        energy: DistortionEnergy::Mips,
        ..InjectiveOptions::default()
    };
    let (angles, lengths) = (laid(&patch, &mips), free(&patch));
    let measured = |map: &InjectiveMap| {
        let corners = corner_uvs(patch.mesh(), &map.map.uv);
        let measure = measure_map(patch.surface(), &corners, &Watch::new()).unwrap();
        let distortion = measure.distortion.unwrap();
        (
            distortion.quasi_conformal_error.mean,
            distortion.symmetric_dirichlet,
        )
    };
    assert!(measured(&angles).0 < measured(&lengths).0);
    assert!(measured(&angles).1 > measured(&lengths).1);
}

#[test]
fn a_fixed_boundary_stays_and_the_energy_falls() {
    let patch = patch(&bumpy_patch(8, 4));
    let circle = boundary_on_curve(&patch, &BoundaryCurve::Circle, &Watch::new()).unwrap();
    let mean_value = FixedOptions {
        weights: Weights::MeanValue,
        ..FixedOptions::default()
    };
    let start = fixed_map(&patch, &circle, &mean_value, &Watch::new()).unwrap();
    let options = InjectiveOptions::default();
    let improved = improve_map(
        &patch,
        &start.uv,
        BoundaryFreedom::Fixed,
        &options,
        &Watch::new(),
    )
    .unwrap();
    for vertex in patch.boundary_vertices() {
        assert!(improved.map.uv[vertex].distance(start.uv[vertex]) < 1e-12);
    }
    assert!(improved.energy < improved.descent.history[0].energy);
    let freed = improve_map(
        &patch,
        &start.uv,
        BoundaryFreedom::Free,
        &options,
        &Watch::new(),
    )
    .unwrap();
    assert!(freed.energy < improved.energy);
    assert!((freed.energy / free(&patch).energy - 1.0).abs() < 1e-3);
}

#[test]
fn a_start_with_flips_is_refused() {
    let patch = patch(&disk(3));
    let mirrored = plane(&patch).map(|p| DVec2::new(-p.x, p.y));
    let options = InjectiveOptions::default();
    let refusal = improve_map(
        &patch,
        &mirrored,
        BoundaryFreedom::Free,
        &options,
        &Watch::new(),
    );
    assert!(matches!(
        refusal,
        Err(FlattenError::StartFlipped { flipped: 54 })
    ));
}

/// A spiral ramp of more than one turn covers itself when laid flat as it is.
#[test]
fn forbidden_overlaps_are_avoided() {
    let ramp = grid(1.0, 1.0, 60, 3).map(|p| {
        let angle = 8.0 * p.x;
        let radius = 1.0 + 0.6 * p.y;
        DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.02 * angle)
    });
    let patch = patch(&ramp);
    let bijective = |map: &InjectiveMap| {
        let corners = corner_uvs(patch.mesh(), &map.map.uv);
        measure_map(patch.surface(), &corners, &Watch::new())
            .unwrap()
            .bijective
    };
    let allowed = free(&patch);
    assert!(allowed.map.flips.is_zero() && !bijective(&allowed));
    let options = InjectiveOptions {
        overlap: Overlap::Forbidden,
        ..InjectiveOptions::default()
    };
    let forbidden = laid(&patch, &options);
    assert!(bijective(&forbidden));
    assert!(
        forbidden.energy > allowed.energy && forbidden.energy < 12.0,
        "{}",
        forbidden.energy
    );
    let again = improve_map(
        &patch,
        &allowed.map.uv,
        BoundaryFreedom::Free,
        &options,
        &Watch::new(),
    );
    assert!(matches!(again, Err(FlattenError::StartOverlaps)));
}

#[test]
fn scale_changes_nothing_but_the_scale() {
    let fixture = bumpy_patch(6, 9);
    let own = free(&patch(&fixture));
    for exponent in [-40, 40] {
        let factor = 2.0_f64.powi(exponent);
        let scaled = free(&patch(&fixture.clone().map(|p| p * factor)));
        let back = scaled.map.uv.map(|&p| p / factor);
        assert_eq!(back, own.map.uv);
    }
}
