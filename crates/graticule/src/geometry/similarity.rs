use glam::DVec3;

use crate::mesh::{PerVertex, Surface};

/// A change of scale by a power of two and of place: `p ↦ (p - centre) · 2^exponent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    centre: DVec3,
    exponent: i32,
}

impl Similarity {
    /// What goes to the origin.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Lengths are multiplied by two to this power.
    #[must_use]
    pub fn exponent(&self) -> i32 {
        self.exponent
    }

    /// The image of a point.
    #[must_use]
    pub fn apply(&self, point: DVec3) -> DVec3 {
        scaled(point - self.centre, self.exponent)
    }

    /// The point that has this image.
    #[must_use]
    pub fn invert(&self, image: DVec3) -> DVec3 {
        scaled(image, -self.exponent) + self.centre
    }

    /// The length before, of a length after.
    #[must_use]
    pub fn invert_length(&self, length: f64) -> f64 {
        libm::ldexp(length, -self.exponent)
    }
}

/// The surface at the size 1: its largest extent in `1.0..2.0`, its coordinates within `-4.0..4.0`;
/// and the similarity that took it there.
///
/// Nothing is rounded, so that the similarity inverts to the very same coordinates (unless one is
/// smaller than the extent by some 2^1000). For that it moves the surface along an axis only if the
/// origin is farther from it than its extent; nearer to the origin, moving would lose digits of small
/// coordinates and gain nothing, as geometry works with differences.
#[must_use]
pub fn normalized(surface: &Surface) -> (Surface, Similarity) {
    let [low, high] = surface.bounding_box();
    let extent = (high - low).max_element();
    let (_, exponent) = libm::frexp(extent);
    let centre = DVec3::from_array([0, 1, 2].map(|axis| centre(low[axis], high[axis], exponent)));
    let similarity = Similarity {
        centre,
        exponent: 1 - exponent,
    };
    let positions = surface.positions().map(|&point| similarity.apply(point));
    let moved = Surface::new(surface.shared_mesh(), PerVertex::new(positions.into_vec()));
    let moved = moved.unwrap_or_else(|_| unreachable!("an extent between 1 and 2, all finite"));
    (moved, similarity)
}

/// A multiple of 2^exponent near the middle, where that is below every coordinate's size; else 0.
///
/// `low..=high` is no longer than 2^exponent. If all coordinates are larger than that, they are
/// multiples of 2^(exponent - 52), and so are their differences from the centre, which are below
/// 2^(exponent + 1) and hence are doubles.
fn centre(low: f64, high: f64, exponent: i32) -> f64 {
    let nearest_zero = if low > 0.0 { low } else { -high };
    if nearest_zero <= libm::ldexp(1.0, exponent) {
        return 0.0;
    }
    let middle = low + (high - low) / 2.0;
    libm::ldexp(libm::rint(libm::ldexp(middle, -exponent)), exponent)
}

fn scaled(vector: DVec3, exponent: i32) -> DVec3 {
    DVec3::from_array(vector.to_array().map(|x| libm::ldexp(x, exponent)))
}
