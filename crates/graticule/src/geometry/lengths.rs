use std::ops::Index;

use crate::mesh::{EdgeId, PerEdge, Surface, TriangleMesh, length};

use super::GeometryError;

/// The length of each edge of a mesh: finite and not negative. All that intrinsic geometry needs.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeLengths(PerEdge<f64>);

impl EdgeLengths {
    /// The lengths of the edges of a surface in space.
    #[must_use]
    pub fn of(surface: &Surface) -> Self {
        let mesh = surface.mesh();
        Self(PerEdge::from_fn(mesh.edge_count(), |edge| {
            length(surface.halfedge_vector(mesh.edge_halfedge(edge)))
        }))
    }

    /// Takes lengths that come from elsewhere, such as a conformal change of metric. Whether they
    /// fit together to triangles is not asked here.
    ///
    /// # Errors
    /// [`GeometryError::LengthCount`] or [`GeometryError::InvalidLength`].
    pub fn new(mesh: &TriangleMesh, lengths: PerEdge<f64>) -> Result<Self, GeometryError> {
        if lengths.len() != mesh.edge_count() {
            let (lengths, edges) = (lengths.len(), mesh.edge_count());
            return Err(GeometryError::LengthCount { lengths, edges });
        }
        let invalid = |length: f64| !length.is_finite() || length < 0.0;
        if let Some((edge, &length)) = lengths.enumerate().find(|&(_, &length)| invalid(length)) {
            return Err(GeometryError::InvalidLength { edge, length });
        }
        Ok(Self(lengths))
    }

    /// The lengths in the order of the edges.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        self.0.as_slice()
    }

    /// The mean length, each edge counted once.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    /// The longest edge and its length.
    pub(super) fn longest(&self) -> (EdgeId, f64) {
        self.0
            .enumerate()
            .fold((EdgeId(0), 0.0), |longest, (edge, &length)| {
                if length > longest.1 {
                    (edge, length)
                } else {
                    longest
                }
            })
    }
}

impl Index<EdgeId> for EdgeLengths {
    type Output = f64;

    #[inline]
    fn index(&self, edge: EdgeId) -> &f64 {
        &self.0[edge]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::cube;

    fn unit_cube() -> Surface {
        let cube = cube();
        Surface::from_triangles(cube.positions, &cube.triangles).unwrap()
    }

    #[test]
    fn a_cube_has_twelve_edges_and_six_diagonals() {
        let lengths = EdgeLengths::of(&unit_cube());
        let mean = (12.0 + 6.0 * 2.0_f64.sqrt()) / 18.0;
        assert!((lengths.mean() - mean).abs() < 1e-15);
        assert!((lengths.longest().1 - 2.0_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn lengths_survive_any_scale() {
        for scale in [1e-200, 1e-9, 1e200] {
            let cube = cube().map(|p| p * scale);
            let surface = Surface::from_triangles(cube.positions, &cube.triangles).unwrap();
            let longest = EdgeLengths::of(&surface).longest().1;
            assert!((longest / scale - 2.0_f64.sqrt()).abs() < 1e-15);
        }
    }

    #[test]
    fn lengths_that_are_none_are_refused() {
        let surface = unit_cube();
        let with = |length: f64| {
            let mut lengths = PerEdge::filled(18, 1.0);
            lengths[EdgeId(7)] = length;
            EdgeLengths::new(surface.mesh(), lengths)
        };
        assert!(with(0.0).is_ok());
        for length in [-1.0, f64::NAN, f64::INFINITY] {
            let refusal = with(length).unwrap_err();
            assert!(matches!(
                refusal,
                GeometryError::InvalidLength {
                    edge: EdgeId(7),
                    ..
                }
            ));
        }
        let short = EdgeLengths::new(surface.mesh(), PerEdge::filled(17, 1.0));
        let expected = GeometryError::LengthCount {
            lengths: 17,
            edges: 18,
        };
        assert_eq!(short, Err(expected));
    }
}
