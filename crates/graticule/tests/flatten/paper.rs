//! What the paper says, held against differences; its slips are numbered in `papers/DMA02.md`.

use glam::DVec2;
use graticule::flatten::{MapEnergy, NaturalOptions, natural_map};
use graticule::mesh::PerVertex;
use graticule::watch::Watch;
use graticule_fixtures::{Noise, irregular_disk};

use crate::support::{patch, plane};

/// The gradient of a function of a point, by central differences.
fn slope(f: impl Fn(DVec2) -> f64, at: DVec2) -> DVec2 {
    let step = 1e-5;
    let along = |axis: DVec2| (f(at + axis * step) - f(at - axis * step)) / (2.0 * step);
    DVec2::new(along(DVec2::X), along(DVec2::Y))
}

/// Counter-clockwise triangles P, A, B without tiny angles.
fn triangles() -> impl Iterator<Item = [DVec2; 3]> {
    let mut noise = Noise::new(12);
    std::iter::repeat_with(move || [0, 1, 2].map(|_| DVec2::new(noise.signed(), noise.signed())))
        .filter(|[p, a, b]| (a - p).perp_dot(b - p) > 0.2)
        .take(50)
}

/// Cotangent of the angle at `at` between the directions to the two others.
fn cotangent(at: DVec2, one: DVec2, other: DVec2) -> f64 {
    let (one, other) = (one - at, other - at);
    one.dot(other) / one.perp_dot(other).abs()
}

#[test]
fn the_gradient_of_an_area_is_half_the_opposite_side_turned() {
    for [p, a, b] in triangles() {
        let by_differences = slope(|p| (a - p).perp_dot(b - p) / 2.0, p);
        let turned = (b - a).perp() / 2.0;
        let (alpha, beta) = (cotangent(a, p, b), cotangent(b, p, a));
        let in_cotangents = ((p - a) * beta + (p - b) * alpha) / 2.0;
        assert!(by_differences.distance(turned) < 1e-9);
        assert!(by_differences.distance(in_cotangents) < 1e-9);
    }
}

#[test]
fn the_gradient_of_an_angle_takes_the_cotangents_at_the_other_two_corners() {
    for [p, a, b] in triangles() {
        let angle = |p: DVec2| (a - p).angle_to(b - p);
        let (alpha, beta) = (cotangent(a, p, b), cotangent(b, p, a));
        let [pa, pb] = [a - p, b - p];
        let by_cotangents = pa * alpha / pa.length_squared() + pb * beta / pb.length_squared();
        assert!(slope(angle, p).distance(by_cotangents) < 1e-8 * by_cotangents.length().max(1.0));
    }
}

#[test]
fn no_map_with_the_same_boundary_has_less_dirichlet_energy_than_the_plane_itself() {
    let patch = patch(&irregular_disk(6, 2));
    let energy = |uv: &PerVertex<DVec2>| {
        MapEnergy::of(patch.mesh(), patch.shapes(), uv).dirichlet / patch.unit_area()
    };
    let itself = energy(&plane(&patch));
    let mut noise = Noise::new(3);
    for size in [1e-3, 1e-1, 1.0] {
        let mut moved = plane(&patch);
        for vertex in patch.mesh().vertices() {
            if !patch.mesh().is_boundary_vertex(vertex) {
                moved[vertex] += DVec2::new(noise.signed(), noise.signed()) * size;
            }
        }
        assert!(energy(&moved) > itself);
    }
    assert!(energy(&plane(&patch).map(|&p| p / 2.0)) < itself);
}

#[test]
fn a_natural_map_may_flip_and_tells() {
    // A disk with spikes: obtuse and thin triangles everywhere.
    let spiky = |seed| {
        let mut noise = Noise::new(seed);
        let mut fixture = irregular_disk(6, seed);
        for position in &mut fixture.positions {
            position.z = noise.signed();
        }
        fixture
    };
    let mut flipped = 0;
    for seed in 0..10 {
        let watch = Watch::new();
        let map = natural_map(&patch(&spiky(seed)), &NaturalOptions::default(), &watch).unwrap();
        let told = watch
            .warnings()
            .iter()
            .any(|w| w.code == "flipped-triangles");
        assert_eq!(told, !map.flips.is_zero());
        flipped += map.flips.flipped;
    }
    assert!(flipped > 0);
}
