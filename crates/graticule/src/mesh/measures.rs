//! Sizes of faces and components, scaled piece by piece so that nothing over- or underflows.

use glam::DVec3;

use super::faces::Faces;

/// Longest side, and height over it: twice the area over the longest side squared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FaceShape {
    pub(super) longest: f64,
    /// Dimensionless; 0 where all corners coincide.
    pub(super) height: f64,
    /// Whether two corners in a row coincide.
    pub(super) has_zero_side: bool,
}

/// Measures a closed polygon.
pub(super) fn face_shape(corners: impl Iterator<Item = DVec3> + Clone) -> FaceShape {
    let mut next = corners.clone();
    let first = next.next().unwrap_or_default();
    let sides = corners.clone().zip(next.chain(std::iter::once(first)));
    let (longest, has_zero_side) = sides.fold((0.0_f64, false), |(longest, zero), (from, to)| {
        (longest.max(length(to - from)), zero || from == to)
    });
    let mut area = DVec3::ZERO;
    let mut previous = DVec3::ZERO;
    for corner in corners.skip(1) {
        let arm = (corner - first) / longest;
        area += previous.cross(arm);
        previous = arm;
    }
    FaceShape {
        longest,
        height: if longest > 0.0 { area.length() } else { 0.0 },
        has_zero_side,
    }
}

/// The length of a vector, also where the squares of its components overflow or underflow.
pub(crate) fn length(vector: DVec3) -> f64 {
    let largest = vector.abs().max_element();
    if (1e-100..1e100).contains(&largest) || largest == 0.0 {
        vector.length()
    } else if largest.is_finite() {
        largest * (vector / largest).length()
    } else {
        largest
    }
}

/// The place of the largest of three values, of equal ones the first.
#[inline]
pub(crate) fn largest_of(values: [f64; 3]) -> usize {
    let larger = |best, place| {
        if values[place] > values[best] {
            place
        } else {
            best
        }
    };
    larger(larger(0, 1), 2)
}

/// The smallest box around some points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    pub(super) const EMPTY: Self = Self {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
    };

    pub(super) fn add(&mut self, point: DVec3) {
        self.low = self.low.min(point);
        self.high = self.high.max(point);
    }

    /// The longest side; negative if there is no point.
    pub(super) fn extent(&self) -> f64 {
        (self.high - self.low).max_element()
    }
}

/// The box around each component.
pub(super) fn component_bounds(
    faces: &impl Faces,
    positions: &[DVec3],
    components: &[u32],
    count: usize,
) -> Vec<Bounds> {
    let mut bounds = vec![Bounds::EMPTY; count];
    for corner in 0..faces.corner_count() as u32 {
        let component = components[faces.face(corner) as usize] as usize;
        bounds[component].add(positions[faces.origin(corner) as usize]);
    }
    bounds
}

/// The signed volume of each component over its extent cubed, with the faces marked `reversed`
/// turned round: positive where a closed component faces outward, of no meaning for open ones.
pub(super) fn component_volumes(
    faces: &impl Faces,
    positions: &[DVec3],
    components: &[u32],
    bounds: &[Bounds],
    reversed: &[bool],
) -> Vec<f64> {
    let mut volumes = vec![0.0; bounds.len()];
    for face in 0..faces.face_count() as u32 {
        let component = components[face as usize] as usize;
        let Bounds { low, high } = bounds[component];
        let middle = low + (high - low) / 2.0;
        let extent = bounds[component].extent();
        let place = |corner| (positions[faces.origin(corner) as usize] - middle) / extent;
        let corners = faces.corners(face);
        let first = place(corners.start);
        let mut previous = place(corners.start + 1);
        let mut volume = 0.0;
        for corner in corners.start + 2..corners.end {
            let current = place(corner);
            volume += first.dot(previous.cross(current)) / 6.0;
            previous = current;
        }
        volumes[component] += if reversed[face as usize] {
            -volume
        } else {
            volume
        };
    }
    volumes
}
