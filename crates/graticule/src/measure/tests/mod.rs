//! Tests of whole maps.

mod figures;
mod injectivity;

use glam::{DVec2, DVec3};
use graticule_fixtures as fixtures;
use graticule_fixtures::{Fixture, Noise};

use super::*;
use crate::mesh::Surface;
use crate::watch::Watch;

fn surface(fixture: &Fixture) -> Surface {
    Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
}

fn measured(surface: &Surface, uvs: &PerCorner<DVec2>) -> MapMeasure {
    measure_map(surface, uvs, &Watch::new()).unwrap()
}

/// The map that takes each vertex to `image` of its position.
fn map_by(surface: &Surface, image: impl Fn(DVec3) -> DVec2) -> PerCorner<DVec2> {
    let mesh = surface.mesh();
    PerCorner::from_fn(mesh.halfedge_count(), |corner| {
        image(surface.position(mesh.origin(corner)))
    })
}

fn flat(p: DVec3) -> DVec2 {
    p.truncate()
}

#[track_caller]
fn assert_close(value: f64, expected: f64, tolerance: f64) {
    let error = (value - expected).abs();
    assert!(
        error <= tolerance * expected.abs().max(1.0),
        "{value} instead of {expected}"
    );
}

#[track_caller]
fn assert_isometric(measure: &MapMeasure, tolerance: f64) {
    let distortion = measure.distortion.unwrap();
    let ratio = distortion.quasi_conformal_error;
    for value in [ratio.mean, ratio.median, ratio.p95, ratio.p99, ratio.max] {
        assert_close(value, 1.0, tolerance);
    }
    assert_close(distortion.mips_mean, 2.0, tolerance);
    assert_close(distortion.angle_change_mean, 0.0, 60.0 * tolerance);
    let area = distortion.area_scale;
    for value in [area.log_mean, area.log_p95, area.log_max] {
        assert_close(value, 0.0, tolerance);
    }
    assert_close(area.min, 1.0, tolerance);
    assert_close(area.max, 1.0, tolerance);
    assert_close(distortion.l2_stretch, 1.0, tolerance);
    assert_close(distortion.linf_stretch, 1.0, tolerance);
    assert_close(distortion.symmetric_dirichlet.unwrap(), 4.0, tolerance);
    assert_close(distortion.dirichlet_energy, 1.0, tolerance);
    assert_close(distortion.edge_length_error, 0.0, tolerance);
    assert_close(distortion.shear_mean, 0.0, tolerance);
    assert_eq!(measure.faces.left_out, 0);
    assert_eq!(measure.faces.flipped, 0);
}

/// Shear depends on the direction of the coordinates, unlike all other figures.
#[track_caller]
fn assert_same_figures(a: &MapMeasure, b: &MapMeasure, tolerance: f64, shear: bool) {
    assert_eq!(a.bijective, b.bijective);
    assert_eq!(a.islands.count, b.islands.count);
    assert_eq!(a.islands.folded_vertices, b.islands.folded_vertices);
    assert_eq!(a.islands.boundary_edges, b.islands.boundary_edges);
    assert_eq!(a.faces.flipped, b.faces.flipped);
    assert_eq!(a.faces.degenerate, b.faces.degenerate);
    assert_eq!(a.overlap.any, b.overlap.any);
    assert_eq!(a.overlap.boundary_crossings, b.overlap.boundary_crossings);
    assert_close(a.islands.seam_length, b.islands.seam_length, tolerance);
    let [a, b] = [a, b].map(|measure| serde_json::to_value(measure.distortion).unwrap());
    compare_numbers(&a, &b, tolerance, shear);
}

fn compare_numbers(a: &serde_json::Value, b: &serde_json::Value, tolerance: f64, shear: bool) {
    for (key, value) in a.as_object().unwrap() {
        if let (Some(a), Some(b)) = (value.as_f64(), b[key].as_f64()) {
            if shear || key != "shear_mean" {
                assert_close(a, b, tolerance);
            }
        } else {
            compare_numbers(value, &b[key], tolerance, shear);
        }
    }
}

fn random_map(seed: u64, noise_size: f64) -> (Surface, PerCorner<DVec2>) {
    let mut noise = Noise::new(seed);
    let surface = surface(&fixtures::irregular_disk(3, seed));
    let uvs: PerVertex<DVec2> = surface.positions().map(|&p| {
        let shift = DVec2::new(noise.signed(), noise.signed()) * noise_size;
        let uv = flat(p) + shift;
        // Few digits, so that coincidences are frequent.
        if seed.is_multiple_of(2) {
            (uv * 8.0).round() / 8.0
        } else {
            uv
        }
    });
    let uvs = corner_uvs(surface.mesh(), &uvs);
    (surface, uvs)
}
