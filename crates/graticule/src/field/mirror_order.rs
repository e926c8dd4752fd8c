//! An order of vertices in which mirror images stand together.

use glam::{DMat3, DVec3};

use crate::mesh::{PerVertex, VertexId};
use crate::tolerance::LIKE_LENGTHS;

/// Vertices of a mirrored surface in an order that is known by their places alone, not by their
/// numbers: the same for both halves. Those of another surface in the order of their numbers.
pub(super) struct MirrorOrder {
    pub(super) vertices: Vec<VertexId>,
    /// Whether a vertex stands as far out as the one before, and so may be its image.
    pub(super) is_image: Vec<bool>,
}

/// Share of the vertices that must be images of others for a surface to count as mirrored: half of
/// them are where no vertex lies on the mirror.
const LEAST_IMAGES: f64 = 0.4;

/// What a step along each principal axis counts: so that hardly any two vertices count alike that are
/// not images of each other.
const STEPS: [f64; 3] = [1.0, 0.754_877_666_246_692_8, 0.569_840_290_998_053_3];

impl MirrorOrder {
    /// Orders the vertices for which `is_wanted` from the middle outwards, by the distances from the
    /// planes through the middle along the principal axes of all: any mirror of the vertices is one of
    /// these planes, but where two of the axes are alike.
    pub(super) fn of(positions: &PerVertex<DVec3>, is_wanted: impl Fn(&VertexId) -> bool) -> Self {
        let count = positions.len().max(1) as f64;
        let middle = positions.iter().sum::<DVec3>() / count;
        let square = |&p: &DVec3| {
            let d = p - middle;
            DMat3::from_cols(d * d.x, d * d.y, d * d.z)
        };
        let squares = positions.iter().map(square);
        let moment = squares.fold(DMat3::ZERO, |sum, square| sum + square);
        let axes = principal_axes(moment).transpose();
        let out = |vertex: VertexId| {
            (axes * (positions[vertex] - middle))
                .abs()
                .dot(STEPS.into())
        };
        let mut ordered: Vec<(f64, VertexId)> = (0..positions.len() as u32)
            .map(VertexId)
            .filter(is_wanted)
            .map(|vertex| (out(vertex), vertex))
            .collect();
        ordered.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let farthest = ordered.last().map_or(0.0, |last| last.0);
        let is_like = |pair: &[(f64, VertexId)]| pair[1].0 - pair[0].0 <= LIKE_LENGTHS * farthest;
        let first = ordered.first().map(|_| false);
        let images = ordered.windows(2).map(is_like);
        let is_image: Vec<bool> = first.into_iter().chain(images).collect();
        let count = is_image.iter().filter(|is| **is).count();
        if (count as f64) < LEAST_IMAGES * ordered.len() as f64 {
            ordered.sort_unstable_by_key(|&(_, vertex)| vertex);
            return Self::new(ordered, Vec::new());
        }
        Self::new(ordered, is_image)
    }

    fn new(ordered: Vec<(f64, VertexId)>, is_image: Vec<bool>) -> Self {
        Self {
            vertices: ordered.into_iter().map(|(_, vertex)| vertex).collect(),
            is_image,
        }
    }
}

/// Rounds over the three planes after which Jacobi's rotations have long converged.
const ROUNDS: usize = 16;

/// Share of the trace below which an entry beside the diagonal is none.
const NO_ENTRY: f64 = 1e-13;

/// The eigenvectors of a symmetric matrix, as columns, by Jacobi's rotations. Where eigenvalues are
/// equal, axes of coordinates stay as they are.
fn principal_axes(mut matrix: DMat3) -> DMat3 {
    let mut axes = DMat3::IDENTITY;
    let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
    for (p, q) in [(0, 1), (0, 2), (1, 2)].repeat(ROUNDS) {
        let off = matrix.col(q)[p];
        if off.abs() > NO_ENTRY * trace {
            let angle = 0.5 * libm::atan(2.0 * off / (matrix.col(p)[p] - matrix.col(q)[q]));
            let (sin, cos) = libm::sincos(angle);
            let mut rotation = DMat3::IDENTITY;
            rotation.col_mut(p)[p] = cos;
            rotation.col_mut(p)[q] = sin;
            rotation.col_mut(q)[p] = -sin;
            rotation.col_mut(q)[q] = cos;
            matrix = rotation.transpose() * matrix * rotation;
            axes *= rotation;
        }
    }
    axes
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    fn cloud(count: u32) -> Vec<DVec3> {
        let mut noise = Noise::new(3);
        let place = |_| {
            DVec3::new(
                3.0 * noise.unit() + 0.01,
                2.0 * noise.signed(),
                noise.signed(),
            )
        };
        (0..count).map(place).collect()
    }

    #[test]
    fn images_stand_together_whatever_the_direction_of_the_mirror() {
        let half = cloud(40);
        let turn = DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(1.1);
        let image = |p: &DVec3| DVec3::new(-p.x, p.y, p.z);
        let places = half.iter().copied().chain(half.iter().map(image));
        let places = PerVertex::new(places.map(|p| turn * p).collect());
        let order = MirrorOrder::of(&places, |_| true);
        assert!(order.is_image.iter().step_by(2).all(|is| !is));
        assert!(order.is_image.iter().skip(1).step_by(2).all(|is| *is));
        for pair in order.vertices.chunks(2) {
            assert_eq!(pair[0].0.abs_diff(pair[1].0), 40);
        }
    }

    #[test]
    fn without_images_numbers_decide() {
        let order = MirrorOrder::of(&PerVertex::new(cloud(40)), |vertex| vertex.0 != 3);
        assert!(order.is_image.is_empty() && order.vertices.len() == 39);
        assert!(order.vertices.is_sorted());
    }

    #[test]
    fn principal_axes_make_a_matrix_diagonal() {
        let sum = cloud(9).into_iter().fold(DMat3::ZERO, |sum, d| {
            sum + DMat3::from_cols(d * d.x, d * d.y, d * d.z)
        });
        let axes = principal_axes(sum);
        let diagonal = axes.transpose() * sum * axes;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            assert!(diagonal.col(p)[q].abs() < 1e-12 * diagonal.col(p)[p].max(1.0));
        }
        assert!((axes.determinant() - 1.0).abs() < 1e-12);
    }
}
