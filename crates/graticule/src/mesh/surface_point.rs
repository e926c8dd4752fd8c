use std::ops::{Add, Mul};

use glam::DVec3;
use serde::{Serialize, Serializer};

use super::{FaceId, HalfedgeId, Surface, TriangleMesh};

/// A point of a surface: a triangle and barycentric coordinates in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SurfacePoint {
    /// The triangle.
    #[serde(serialize_with = "face_number")]
    pub face: FaceId,
    /// The weights of its three corners, each in `0.0..=1.0`, with the sum 1.
    pub barycentric: [f64; 3],
}

#[allow(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature is serde's"
)]
fn face_number<S: Serializer>(face: &FaceId, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u32(face.0)
}

impl SurfacePoint {
    /// The corner that the halfedge leaves from.
    #[must_use]
    pub fn at_corner(corner: HalfedgeId) -> Self {
        Self::on_halfedge(corner, 0.0)
    }

    /// The point that lies a `share` in `0.0..=1.0` along the halfedge.
    #[must_use]
    pub fn on_halfedge(halfedge: HalfedgeId, share: f64) -> Self {
        let mut barycentric = [0.0; 3];
        barycentric[halfedge.side()] = 1.0 - share;
        barycentric[halfedge.next().side()] = share;
        Self {
            face: halfedge.face(),
            barycentric,
        }
    }

    /// The mean of values at the three corners, with the weights of the point.
    #[must_use]
    pub fn interpolate<T: Add<Output = T> + Mul<f64, Output = T>>(&self, [a, b, c]: [T; 3]) -> T {
        let [u, v, w] = self.barycentric;
        a * u + b * v + c * w
    }

    /// The weights of the point in another triangle that it lies on too; `None` if it does not.
    #[must_use]
    pub fn weights_in(&self, mesh: &TriangleMesh, face: FaceId) -> Option<[f64; 3]> {
        if self.face == face {
            return Some(self.barycentric);
        }
        let (from, to) = (mesh.triangle(self.face), mesh.triangle(face));
        let mut weights = [0.0; 3];
        for (vertex, weight) in from.iter().zip(self.barycentric) {
            if let Some(corner) = to.iter().position(|other| other == vertex) {
                weights[corner] += weight;
            }
        }
        let sum: f64 = weights.iter().sum();
        (sum > 0.5).then(|| weights.map(|weight| weight / sum))
    }

    /// Where the point lies in space.
    #[must_use]
    pub fn position(&self, surface: &Surface) -> DVec3 {
        self.interpolate(surface.corner_positions(self.face))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_along_a_side_lies_between_its_ends() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let surface = Surface::from_triangles(corners.to_vec(), &[[0, 1, 2]]).unwrap();
        let point = SurfacePoint::on_halfedge(HalfedgeId(1), 0.25);
        assert_eq!(point.position(&surface), DVec3::new(0.75, 0.25, 0.0));
        let corner = SurfacePoint::at_corner(HalfedgeId(2));
        assert_eq!(corner.position(&surface), DVec3::Y);
        assert_eq!(
            point.interpolate([0.0, 1.0, 2.0]).to_bits(),
            1.25_f64.to_bits()
        );
    }
}
