use crate::Hint;
use crate::watch::Stopped;

/// Why there is no quad mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum QuadsError {
    /// The map is for another mesh.
    #[error("the map has coordinates for {given} corners, the mesh has {needed}")]
    OtherMesh {
        /// Corners of the map.
        given: usize,
        /// Corners of the mesh.
        needed: usize,
    },
    /// More lines than can be numbered.
    #[error("lines would cross edges {crossings} times; the limit is {limit}")]
    TooFine {
        /// How often lines cross edges, at most.
        crossings: u64,
        /// The limit.
        limit: u64,
    },
    /// The polygons found do not form a manifold, oriented surface.
    #[error("the net is unsound at vertex {vertex}: {rule}")]
    Unsound {
        /// A vertex of the polygons.
        vertex: u32,
        /// Which rule is broken.
        rule: &'static str,
    },
    /// The polygons found have another topology than the surface.
    #[error("the net has {found} {what}, the surface has {expected}")]
    Topology {
        /// "components", "boundary loops" or "as Euler characteristic".
        what: &'static str,
        /// For the polygons.
        found: i64,
        /// For the surface.
        expected: i64,
    },
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl Hint for QuadsError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::TooFine { .. } => Some("ask for fewer quads".into()),
            Self::Unsound { .. } | Self::Topology { .. } => {
                Some("ask for more quads, or repair the mesh first".into())
            }
            Self::Stopped(stopped) => stopped.hint(),
            Self::OtherMesh { .. } => None,
        }
    }
}
