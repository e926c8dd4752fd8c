use std::fmt;

use super::Element;

macro_rules! element_id {
    ($(#[$documentation:meta])* $name:ident, $noun:literal) => {
        $(#[$documentation])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u32);

        impl Element for $name {
            #[inline]
            fn from_index(index: usize) -> Self {
                Self(index as u32)
            }

            #[inline]
            fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(formatter, concat!($noun, " {}"), self.0)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(formatter, concat!($noun, " {}"), self.0)
            }
        }
    };
}

pub(crate) use element_id;

element_id!(
    /// A vertex of a [`TriangleMesh`](super::TriangleMesh).
    VertexId,
    "vertex"
);
element_id!(
    /// A triangle of a [`TriangleMesh`](super::TriangleMesh).
    FaceId,
    "face"
);
element_id!(
    /// An edge of a [`TriangleMesh`](super::TriangleMesh), without direction.
    EdgeId,
    "edge"
);
element_id!(
    /// A side of a triangle, directed so that the triangle lies to its left; also the corner of
    /// the triangle that the side leaves from.
    ///
    /// Triangle `f` owns halfedges `3f`, `3f + 1` and `3f + 2`; halfedge `3f + k` runs from its
    /// corner `k` to its corner `k + 1`.
    HalfedgeId,
    "halfedge"
);
element_id!(
    /// An edge-connected component of a mesh.
    ComponentId,
    "component"
);
element_id!(
    /// A closed walk along the boundary of a mesh.
    BoundaryLoopId,
    "boundary loop"
);

impl HalfedgeId {
    /// The side after this one, counter-clockwise in the same triangle.
    #[inline]
    #[must_use]
    pub fn next(self) -> Self {
        if self.0 % 3 == 2 {
            Self(self.0 - 2)
        } else {
            Self(self.0 + 1)
        }
    }

    /// The side before this one, counter-clockwise in the same triangle.
    #[inline]
    #[must_use]
    pub fn previous(self) -> Self {
        if self.0.is_multiple_of(3) {
            Self(self.0 + 2)
        } else {
            Self(self.0 - 1)
        }
    }

    /// The triangle that owns this side.
    #[inline]
    #[must_use]
    pub fn face(self) -> FaceId {
        FaceId(self.0 / 3)
    }

    /// Which side of its triangle this is: 0, 1 or 2.
    #[inline]
    #[must_use]
    pub fn side(self) -> usize {
        (self.0 % 3) as usize
    }
}

impl FaceId {
    /// The three sides of the triangle, counter-clockwise.
    #[inline]
    #[must_use]
    pub fn halfedges(self) -> [HalfedgeId; 3] {
        let first = 3 * self.0;
        [
            HalfedgeId(first),
            HalfedgeId(first + 1),
            HalfedgeId(first + 2),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_of_a_triangle_form_a_cycle() {
        for halfedge in FaceId(7).halfedges() {
            assert_eq!(halfedge.face(), FaceId(7));
            assert_eq!(halfedge.next().next(), halfedge.previous());
            assert_eq!(halfedge.next().previous(), halfedge);
        }
    }
}
