//! Pieces of a surface on their way into the plane.

use glam::DVec2;

use crate::flatten::injective::is_one_to_one;
use crate::flatten::{FlattenError, InjectiveMap, NotAPatch, Patch};
use crate::mesh::{
    ComponentId, Components, EdgeId, Element, HalfedgeId, PerCorner, PerVertex, Surface, Topology,
    cut_along,
};
use crate::watch::Watch;

/// Why a component was not laid down.
#[derive(Debug, thiserror::Error)]
pub(super) enum NotLaid {
    #[error(transparent)]
    NoPatch(#[from] NotAPatch),
    #[error(transparent)]
    Error(#[from] FlattenError),
}

/// A patch cut out of a surface.
pub(super) struct Piece {
    pub(super) patch: Patch,
    /// The corner of the whole surface for each corner.
    pub(super) sources: PerCorner<HalfedgeId>,
}

/// Pieces with their parts of a map.
pub(super) type Parts = Vec<(Piece, PerVertex<DVec2>)>;

/// A piece with its map.
pub(super) struct Sheet {
    pub(super) piece: Piece,
    pub(super) map: InjectiveMap,
}

impl Sheet {
    /// Whether no part of the map lies over another. Exact.
    pub(super) fn is_one_to_one(&self) -> bool {
        is_one_to_one(&self.piece.patch, &self.map.map.uv)
    }
}

impl Piece {
    pub(super) fn new(
        surface: Surface,
        sources: PerCorner<HalfedgeId>,
        watch: &Watch,
    ) -> Result<Self, NotAPatch> {
        let patch = Patch::new(surface, watch)?;
        Ok(Self { patch, sources })
    }

    /// The parts into which cuts along edges divide the piece, each with its part of a map; nothing
    /// where one of them would be no patch.
    pub(super) fn divided(
        &self,
        edges: Vec<EdgeId>,
        uv: &PerVertex<DVec2>,
        watch: &Watch,
    ) -> Result<Option<Parts>, FlattenError> {
        let cut = cut_along(self.patch.surface(), edges)?;
        let topology = Topology::of(cut.surface.mesh());
        let mut components = Components::new(&cut.surface, &topology);
        let mut parts = Vec::new();
        for component in (0..topology.components.len()).map(ComponentId::from_index) {
            watch.check()?;
            let Ok(part) = components.extract(component) else {
                return Ok(None);
            };
            let sources = part.corner_sources.map(|&corner| self.sources[corner]);
            let places = part.vertex_sources.map(|&v| uv[cut.vertex_sources[v]]);
            match Self::new(part.surface, sources, watch) {
                Ok(piece) => parts.push((piece, places)),
                Err(NotAPatch::Stopped(stopped)) => return Err(stopped.into()),
                Err(_) => return Ok(None),
            }
        }
        Ok(Some(parts))
    }
}
