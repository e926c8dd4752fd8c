//! How far the gradients of coordinates are from the axes that they should follow.

use glam::DVec2;

use super::frames::{FaceFrames, side_angle};
use super::{IntegerGridError, IntegerGridOptions, Stretch};
use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerFace, PerVertex};
use crate::solve::{SolveError, SymmetricMatrix};
use crate::tolerance::{LEAST_NEEDLE_WEIGHT, NEEDLE_COTANGENT};

/// The Dirichlet energy of the difference between coordinates and wished ones, side by side of each
/// triangle: `Σ w |p(j) - p(i) - d|²` with half the cotangent of the opposite angle as `w`, which
/// in sum is `½ Σ area |∇p - axes|²`.
#[derive(Clone, Debug)]
pub(super) struct SideEnergy {
    /// The weight of each halfedge within its own triangle.
    pub(super) weights: PerCorner<f64>,
    /// The difference of coordinates wished along each halfedge, in its own triangle.
    pub(super) wishes: PerCorner<DVec2>,
}

impl SideEnergy {
    /// Wishes coordinates that grow along the axes by the sizing per unit of length, and as much
    /// slower along the stretch as faster across.
    pub(super) fn along_frames(
        triangulation: &IntrinsicTriangulation,
        frames: &FaceFrames,
        options: &IntegerGridOptions,
    ) -> Self {
        let rates = PerFace::from_fn(triangulation.face_count(), |face| {
            let mean = options.sizing.as_ref().map_or(1.0, |scale| {
                let sum: f64 = triangulation.triangle(face).map(|v| scale[v]).iter().sum();
                sum / 3.0
            });
            let stretch = options.stretch.as_ref();
            mean * stretch.map_or(DVec2::ONE, |stretch| {
                stretched(triangulation, frames.angles[face], stretch, face)
            })
        });
        let wishes = PerCorner::from_fn(triangulation.halfedge_count(), |halfedge: HalfedgeId| {
            let face = halfedge.face();
            let corners = triangulation.shape(face).corners();
            let side = corners[halfedge.next().side()] - corners[halfedge.side()];
            let (sin, cos) = libm::sincos(-frames.angles[face]);
            DVec2::new(cos, sin).rotate(side) * rates[face]
        });
        Self {
            weights: side_weights(triangulation),
            wishes,
        }
    }
}

/// What the growth of both coordinates in a triangle is multiplied by, for a first axis at an angle
/// in the coordinates of its shape: the mean, in logarithms, of what the corners wish for.
fn stretched(
    triangulation: &IntrinsicTriangulation,
    axis: f64,
    stretch: &PerVertex<Stretch>,
    face: FaceId,
) -> DVec2 {
    let wished = face.halfedges().map(|corner| {
        let vertex = triangulation.origin(corner);
        let Stretch { direction, ratio } = stretch[vertex];
        let turned = direction - triangulation.direction(corner);
        let here =
            side_angle(triangulation, corner) + turned / triangulation.angle_scale(vertex) - axis;
        libm::log(ratio) * libm::cos(2.0 * here)
    });
    let half = wished.iter().sum::<f64>() / 6.0;
    DVec2::new(libm::exp(-half), libm::exp(half))
}

/// Half the cotangent of the angle opposite to each halfedge. Triangles so thin that a cotangent
/// exceeds [`NEEDLE_COTANGENT`] count less, so that it does not, and their sides
/// [`LEAST_NEEDLE_WEIGHT`] more: nothing else may lead from one part of a surface to another.
pub(super) fn side_weights(triangulation: &IntrinsicTriangulation) -> PerCorner<f64> {
    PerCorner::from_fn(triangulation.halfedge_count(), |halfedge: HalfedgeId| {
        let shape = triangulation.shape(halfedge.face());
        let dots = [0, 1, 2].map(|corner| shape.dot(corner).abs());
        let largest = dots.into_iter().fold(f64::MIN_POSITIVE, f64::max);
        let dot = shape.dot(halfedge.previous().side());
        let least_area = largest / NEEDLE_COTANGENT;
        if shape.double_area() < least_area {
            0.5 * dot / least_area + LEAST_NEEDLE_WEIGHT
        } else {
            0.5 * dot / shape.double_area()
        }
    })
}

/// The normal equations of a sum of weighted squares.
#[derive(Clone, Debug)]
pub(super) struct NormalEquations {
    diagonal: Vec<f64>,
    mixed: Vec<(usize, usize, f64)>,
    right_side: Vec<f64>,
    /// The terms of the last square, like ones put together.
    terms: Vec<(u32, f64)>,
}

impl NormalEquations {
    pub(super) fn new(unknowns: usize) -> Self {
        Self {
            diagonal: vec![0.0; unknowns],
            mixed: Vec::with_capacity(4 * unknowns),
            right_side: vec![0.0; unknowns],
            terms: Vec::new(),
        }
    }

    /// Adds `weight (Σ factor unknown - wish)²`.
    pub(super) fn add(
        &mut self,
        weight: f64,
        terms: impl IntoIterator<Item = (u32, f64)>,
        wish: f64,
    ) {
        merge_terms(terms, &mut self.terms);
        for (place, &(column, factor)) in self.terms.iter().enumerate() {
            let weighted = weight * factor;
            self.right_side[column as usize] += weighted * wish;
            self.diagonal[column as usize] += weighted * factor;
            let before = self.terms[..place].iter();
            self.mixed.extend(
                before.map(|&(other, more)| (column as usize, other as usize, weighted * more)),
            );
        }
    }

    /// Refuses more entries off the diagonal than `limit`: sums over many whole unknowns have the
    /// square of that many.
    pub(super) fn check_size(&self, limit: usize) -> Result<(), IntegerGridError> {
        if self.mixed.len() > limit {
            return Err(IntegerGridError::TooEntangled { limit });
        }
        Ok(())
    }

    /// The matrix and the right-hand side.
    pub(super) fn finish(self) -> Result<(SymmetricMatrix, Vec<f64>), SolveError> {
        let diagonal = self.diagonal.iter().enumerate();
        let diagonal = diagonal.map(|(column, &value)| (column, column, value));
        let matrix = SymmetricMatrix::from_triplets(
            self.right_side.len(),
            diagonal.chain(self.mixed.iter().copied()),
        )?;
        Ok((matrix, self.right_side))
    }
}

/// Puts like terms together, in `merged`; those that vanish are left out.
pub(super) fn merge_terms(
    terms: impl IntoIterator<Item = (u32, f64)>,
    merged: &mut Vec<(u32, f64)>,
) {
    merged.clear();
    for (column, factor) in terms {
        match merged.iter_mut().find(|term| term.0 == column) {
            Some(term) => term.1 += factor,
            None => merged.push((column, factor)),
        }
    }
    merged.retain(|term| term.1 != 0.0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_over_many_unknowns_counts_with_the_square_of_its_length() {
        let mut equations = NormalEquations::new(100);
        equations.add(1.0, (0..100).map(|column| (column, 1.0)), 0.5);
        let pairs = 100 * 99 / 2;
        assert_eq!(equations.check_size(pairs), Ok(()));
        let limit = pairs - 1;
        let refused = IntegerGridError::TooEntangled { limit };
        assert_eq!(equations.check_size(limit), Err(refused));
    }
}
