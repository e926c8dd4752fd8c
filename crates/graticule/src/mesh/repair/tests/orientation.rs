use glam::DVec3;
use graticule_fixtures::{grid, icosphere};

use super::*;

#[test]
fn orientation_is_made_consistent_and_outward() {
    let mut mixed = soup_of(&grid(1.0, 1.0, 8, 8));
    let turned = |(i, polygon): (usize, &[u32])| match i % 3 {
        0 => reversed(polygon),
        _ => polygon.to_vec(),
    };
    mixed.polygons = mixed
        .polygons
        .iter()
        .enumerate()
        .map(turned)
        .collect::<Vec<_>>()
        .to_polygons();
    let fixed = repaired(&mixed);
    assert_eq!(fixed.changes.polygons_turned.count(), 43);
    let up = fixed.surface.mesh().faces().all(|face| {
        let [a, b, c] = fixed.surface.corner_positions(face);
        (b - a).cross(c - a).z > 0.0
    });
    assert!(up);
    for scale in [-660, -40, 0, 40, 300] {
        let scaled = icosphere(1).map(|p| p * 2.0_f64.powi(scale));
        let mut inward = soup_of(&scaled);
        inward.polygons = inward
            .polygons
            .iter()
            .map(reversed)
            .collect::<Vec<_>>()
            .to_polygons();
        let outward = repaired(&inward);
        assert_eq!(outward.changes.components_turned.all(), [0]);
        assert!(outward.changes.polygons_turned.is_empty());
        let corners = outward.surface.corner_positions(crate::mesh::FaceId(0));
        let [a, b, c] = corners.map(|p| p * 2.0_f64.powi(-scale));
        assert!((b - a).cross(c - a).dot(a) > 0.0);
    }
}

#[test]
fn a_cavity_stays_a_cavity_and_turns_with_what_is_around_it() {
    let outer = icosphere(2);
    let mut inner = icosphere(1).map(|p| p * 0.3 + DVec3::new(0.1, 0.2, 0.0));
    let beside = icosphere(1).map(|p| p + DVec3::X * 5.0);
    inner.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let hollow = outer.joined(&inner).joined(&beside);
    let kept = repaired(&soup_of(&hollow));
    assert!(kept.changes.is_empty());
    assert_eq!(kept.changes.cavities.all(), [320]);
    let mut inside_out = hollow.clone();
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let turned = repaired(&soup_of(&inside_out));
    assert_eq!(turned.changes.components_turned.all(), [0, 320, 400]);
    assert!((volume(&turned.surface) - volume(&kept.surface)).abs() < 1e-12);
}

/// A strip of quads closed with a half turn.
fn moebius(length: u32) -> PolygonSoup {
    let mut strip = PolygonSoup::default();
    for i in 0..length {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(length);
        for side in [-0.3, 0.3] {
            let radius = 1.0 + side * (angle / 2.0).cos();
            let height = side * (angle / 2.0).sin();
            strip.positions.push(DVec3::new(
                radius * angle.cos(),
                radius * angle.sin(),
                height,
            ));
        }
        let [a, b] = [2 * i, 2 * i + 1];
        let [c, d] = if i + 1 == length {
            [1, 0]
        } else {
            [a + 2, b + 2]
        };
        strip.polygons.push(&[a, c, d, b]);
    }
    strip
}

#[test]
fn a_moebius_strip_is_refused_or_cut_open() {
    let strip = moebius(20);
    assert!(matches!(refusal(&strip), RepairError::NonOrientable { .. }));
    let options = RepairOptions {
        non_orientable: NonOrientable::CutOpen,
        ..RepairOptions::default()
    };
    let cut = repaired_with(&strip, options);
    assert!(total(&cut).is_disk());
    assert!((area(&cut.surface) - area_of_soup(&strip)).abs() < 1e-9);
    assert_eq!(cut.changes.edges_cut.count(), 1);
}

#[test]
fn a_klein_bottle_is_refused_or_cut_open() {
    let [around, along] = [12_u32, 10_u32];
    let mut bottle = PolygonSoup::default();
    for i in 0..along {
        for j in 0..around {
            let [u, v] = [(i, along), (j, around)]
                .map(|(k, n)| std::f64::consts::TAU * f64::from(k) / f64::from(n));
            let w = (u / 2.0).cos() * v.sin() - (u / 2.0).sin() * (2.0 * v).sin();
            let height = (u / 2.0).sin() * v.sin() + (u / 2.0).cos() * (2.0 * v).sin();
            bottle
                .positions
                .push(DVec3::new((3.0 + w) * u.cos(), (3.0 + w) * u.sin(), height));
            let vertex = |i: u32, j: u32| {
                if i == along {
                    (around - j % around) % around
                } else {
                    i * around + j % around
                }
            };
            bottle.polygons.push(&[
                vertex(i, j),
                vertex(i + 1, j),
                vertex(i + 1, j + 1),
                vertex(i, j + 1),
            ]);
        }
    }
    assert!(matches!(
        refusal(&bottle),
        RepairError::NonOrientable { .. }
    ));
    let options = RepairOptions {
        non_orientable: NonOrientable::CutOpen,
        ..RepairOptions::default()
    };
    let cut = repaired_with(&bottle, options);
    assert_eq!([total(&cut).boundary_loops, total(&cut).genus], [2, 0]);
}
