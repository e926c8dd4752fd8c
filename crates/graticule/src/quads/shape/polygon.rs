use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec3;

use super::ground::Place;
use crate::measure::vector_area;

/// The normal of a polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub(super) normal: DVec3,
    /// The least cosine between it and the normal of the surface at a corner.
    pub(super) facing: f64,
}

impl View {
    /// Of the polygon with its vertices at these places.
    pub(super) fn of<'a>(places: impl Iterator<Item = &'a Place> + Clone) -> Self {
        let area = vector_area(places.clone().map(|place| place.position));
        let normal = area.normalize_or_zero();
        let cosines = places.clone().map(|place| normal.dot(place.normal));
        Self {
            normal: facing(normal, places.map(|place| place.normal).sum()),
            facing: cosines.fold(f64::INFINITY, f64::min),
        }
    }
}

/// The least sine at a corner of a polygon over that of the regular polygon, negative where it is
/// turned over.
pub(in crate::quads) fn quality(places: &[Place]) -> f64 {
    let normal = View::of(places.iter()).normal;
    least_sine(places.len(), normal, |corner| places[corner].position)
}

/// The least sine at a corner of a polygon with `count` corners over that of the regular polygon.
pub(super) fn least_sine(count: usize, normal: DVec3, at: impl Fn(usize) -> DVec3) -> f64 {
    least_sine_of(0..count, count, normal, at)
}

/// The same at some of its corners; those from `count` on are those from 0 on again.
pub(super) fn least_sine_of(
    corners: Range<usize>,
    count: usize,
    normal: DVec3,
    at: impl Fn(usize) -> DVec3,
) -> f64 {
    let around = |corner: usize| at(corner % count);
    let sine = |corner: usize| {
        let [before, after] = [around(corner + count - 1), around(corner + 1)];
        corner_sine([before, around(corner), after], normal)
    };
    corners.map(sine).fold(f64::INFINITY, f64::min) / regular_angle(count).1
}

/// Cosine and sine of the angle of a regular polygon.
pub(super) fn regular_angle(corners: usize) -> (f64, f64) {
    match corners {
        4 => (0.0, 1.0),
        3 => (0.5, 0.75_f64.sqrt()),
        count => {
            let turn = TAU / count as f64;
            (-libm::cos(turn), libm::sin(turn))
        }
    }
}

/// The normal of a polygon, or that of the surface where the polygon is turned over or has none:
/// then its corners count as inverted.
fn facing(normal: DVec3, of_surface: DVec3) -> DVec3 {
    if normal.dot(of_surface) > 0.0 || of_surface == DVec3::ZERO {
        normal
    } else {
        of_surface.normalize_or_zero()
    }
}

/// The sine of the angle at a corner, negative where the corner is inverted; -1 where a side has no
/// length.
fn corner_sine([before, corner, after]: [DVec3; 3], normal: DVec3) -> f64 {
    let [out, back] = [after - corner, before - corner];
    let lengths = (out.length_squared() * back.length_squared()).sqrt();
    if lengths > 0.0 {
        out.cross(back).dot(normal) / lengths
    } else {
        -1.0
    }
}
