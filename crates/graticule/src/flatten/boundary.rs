//! Where the boundary of a patch lies in the plane.

use glam::DVec2;

use crate::Hint;
use crate::mesh::{Element, PerVertex, VertexId};
use crate::watch::Stopped;

use super::Patch;

/// Why a boundary cannot be laid down as asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BoundaryError {
    /// A vertex of the outer loop has no place.
    #[error("{vertex} lies on the outer boundary loop and was given no place")]
    Missing {
        /// The vertex.
        vertex: VertexId,
    },
    /// A place is given to a vertex that is not on the boundary.
    #[error("{vertex} was given a place and does not lie on the boundary")]
    NotOnBoundary {
        /// The vertex.
        vertex: VertexId,
    },
    /// A vertex has two places.
    #[error("{vertex} was given a place twice")]
    Repeated {
        /// The vertex.
        vertex: VertexId,
    },
    /// A place is not finite.
    #[error("{vertex} was given the place ({}, {})", .place[0], .place[1])]
    NonFinite {
        /// The vertex.
        vertex: VertexId,
        /// The coordinates given.
        place: [f64; 2],
    },
    /// A corner is not a vertex of the outer loop, or is given twice.
    #[error("corner {corner} of the rectangle, {vertex}, {reason}")]
    BadCorner {
        /// Number of the corner, `0..4`.
        corner: usize,
        /// The vertex asked for.
        vertex: VertexId,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// Too few boundary vertices for four corners.
    #[error("the outer boundary loop has {vertices} vertices; a rectangle needs 4")]
    TooFewVertices {
        /// Vertices of the outer loop.
        vertices: usize,
    },
    /// A rectangle's sides are not lengths.
    #[error("the rectangle's aspect ratio is {aspect}")]
    BadAspect {
        /// Width over height as asked for.
        aspect: f64,
    },
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl Hint for BoundaryError {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::Missing { .. } => "give a place to every vertex of the outer loop",
            Self::NotOnBoundary { .. } => "give places to boundary vertices only",
            Self::Repeated { .. } => "give each vertex one place",
            Self::NonFinite { .. } => "give finite coordinates",
            Self::BadCorner { .. } => "choose four different vertices of the outer boundary loop",
            Self::TooFewVertices { .. } => "use a circle",
            Self::BadAspect { .. } => "give a width over height between 1e-6 and 1e6",
            Self::Stopped(stopped) => return stopped.hint(),
        };
        Some(text.into())
    }
}

/// Places in the plane for boundary vertices of a patch: all those of the outer loop, and of the
/// holes any that shall be fixed.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryPositions {
    places: Vec<(VertexId, DVec2)>,
    flip_free: bool,
}

impl BoundaryPositions {
    /// Takes places, in the surface's unit of length, counter-clockwise along the outer loop.
    ///
    /// # Errors
    /// [`BoundaryError`] names the vertex that has no place, two, or one that it must not have.
    pub fn new(
        patch: &Patch,
        places: impl IntoIterator<Item = (VertexId, DVec2)>,
    ) -> Result<Self, BoundaryError> {
        let places: Vec<_> = places.into_iter().collect();
        let mut placed = vec![false; patch.mesh().vertex_count()];
        for &(vertex, place) in &places {
            check_place(patch, vertex, place)?;
            if std::mem::replace(&mut placed[vertex.index()], true) {
                return Err(BoundaryError::Repeated { vertex });
            }
        }
        let mut outer = patch.loop_vertices(patch.outer_loop());
        if let Some(vertex) = outer.find(|vertex| !placed[vertex.index()]) {
            return Err(BoundaryError::Missing { vertex });
        }
        Ok(Self {
            places,
            flip_free: false,
        })
    }

    /// The outer loop where a map has it; holes are left to themselves.
    ///
    /// # Errors
    /// [`BoundaryError::NonFinite`].
    pub fn of_map(patch: &Patch, uv: &PerVertex<DVec2>) -> Result<Self, BoundaryError> {
        let outer = patch.loop_vertices(patch.outer_loop());
        Self::new(patch, outer.map(|vertex| (vertex, uv[vertex])))
    }

    /// Places of the outer loop along a curve; `flip_free` if each part of the patch that the loop
    /// encloses gets a convex outline with no three corners of a triangle on a straight side.
    pub(super) fn on_curve(places: Vec<(VertexId, DVec2)>, flip_free: bool) -> Self {
        Self { places, flip_free }
    }

    /// The vertices with their places.
    #[must_use]
    pub fn places(&self) -> &[(VertexId, DVec2)] {
        &self.places
    }

    /// Whether the outline satisfies what the theorems on flip-free maps ask for. Known for the
    /// curves of this module; for places given from elsewhere not claimed.
    pub(super) fn is_flip_free(&self) -> bool {
        self.flip_free
    }
}

fn check_place(patch: &Patch, vertex: VertexId, place: DVec2) -> Result<(), BoundaryError> {
    let known = vertex.index() < patch.mesh().vertex_count();
    if !known || !patch.mesh().is_boundary_vertex(vertex) {
        return Err(BoundaryError::NotOnBoundary { vertex });
    }
    if !place.is_finite() {
        let place = place.to_array();
        return Err(BoundaryError::NonFinite { vertex, place });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Surface;
    use crate::watch::Watch;
    use graticule_fixtures::annulus;

    #[test]
    fn places_are_asked_of_the_outer_loop_and_of_no_interior_vertex() {
        let ring = annulus(0.5, 1.0, 6, 2);
        let surface = Surface::from_triangles(ring.positions, &ring.triangles).unwrap();
        let patch = Patch::new(surface, &Watch::new()).unwrap();
        let own = |vertex| (vertex, patch.surface().position(vertex).truncate());
        let outer: Vec<_> = patch.loop_vertices(patch.outer_loop()).map(own).collect();
        let given = |places: Vec<_>| BoundaryPositions::new(&patch, places);
        assert!(given(outer.clone()).is_ok());
        let hole = patch.holes().next().unwrap();
        let all: Vec<_> = outer
            .iter()
            .copied()
            .chain(patch.loop_vertices(hole).map(own))
            .collect();
        assert!(given(all).is_ok());

        let missing = given(outer[1..].to_vec()).unwrap_err();
        assert_eq!(missing, BoundaryError::Missing { vertex: outer[0].0 });
        let with = |vertex, place| {
            let mut places = outer.clone();
            places.push((vertex, place));
            given(places).unwrap_err()
        };
        let inside = patch
            .mesh()
            .vertices()
            .find(|&v| !patch.mesh().is_boundary_vertex(v))
            .unwrap();
        assert_eq!(
            with(inside, DVec2::ZERO),
            BoundaryError::NotOnBoundary { vertex: inside }
        );
        let nowhere = VertexId(99);
        assert_eq!(
            with(nowhere, DVec2::ZERO),
            BoundaryError::NotOnBoundary { vertex: nowhere }
        );
        let vertex = outer[0].0;
        assert_eq!(
            with(vertex, DVec2::ZERO),
            BoundaryError::Repeated { vertex }
        );
        let nan = with(vertex, DVec2::new(f64::NAN, 0.0));
        assert!(matches!(nan, BoundaryError::NonFinite { .. }));
    }
}
