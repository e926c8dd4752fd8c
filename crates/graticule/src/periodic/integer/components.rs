//! The components of a surface, each of which has a net of its own.
//!
//! Nothing but the density ties the nets of two components: apart from each other their whole
//! numbers are fewer to round at a time, and their order makes no difference.

use super::net::Draft;
use super::{IntegerGridError, IntegerGridOptions};
use crate::field::CrossField;
use crate::mesh::{
    ComponentId, Components, Element, FaceId, HalfedgeId, PerCorner, PerEdge, Submesh, Surface,
    Topology,
};
use crate::watch::Watch;

/// The way from a component to the whole surface.
pub(super) enum Component {
    /// It is the whole.
    Whole,
    /// It is a part, whose corners are these ones of the whole.
    Part(PerCorner<HalfedgeId>),
}

impl Component {
    pub(super) fn corner(&self, corner: HalfedgeId) -> HalfedgeId {
        match self {
            Self::Whole => corner,
            Self::Part(corners) => corners[corner],
        }
    }

    pub(super) fn face(&self, face: FaceId) -> FaceId {
        let [first, ..] = face.halfedges();
        self.corner(first).face()
    }
}

/// The components, and their nets before anything is factored.
///
/// What is wrong with a component is told in the numbers of the whole surface.
pub(super) fn drafts(
    surface: &Surface,
    field: &CrossField,
    options: &IntegerGridOptions,
    watch: &Watch,
) -> Result<(Vec<Component>, Vec<Draft>), IntegerGridError> {
    let of_whole = || Draft::of(surface.clone(), field, options, watch);
    let Some(parts) = parts(surface) else {
        return Ok((vec![Component::Whole], vec![of_whole()?]));
    };
    let mut is_feature = PerEdge::filled(surface.mesh().edge_count(), false);
    for &edge in &options.features {
        is_feature[edge] = true;
    }
    let mut components = Vec::with_capacity(parts.len());
    let mut drafts = Vec::with_capacity(parts.len());
    for part in parts {
        let options = options_on(&part, surface, options, &is_feature);
        let angles = part.vertex_sources.map(|&source| field.angles()[source]);
        let field = CrossField::from_angles(field.symmetry(), angles);
        match Draft::of(part.surface, &field, &options, watch) {
            Ok(draft) => drafts.push(draft),
            Err(error) => return Err(of_whole().err().unwrap_or(error)),
        }
        components.push(Component::Part(part.corner_sources));
    }
    Ok((components, drafts))
}

/// The components as surfaces; `None` where there is one alone, or one that is no surface for want
/// of extent.
fn parts(surface: &Surface) -> Option<Vec<Submesh>> {
    let topology = Topology::of(surface.mesh());
    if topology.components.len() < 2 {
        return None;
    }
    let mut components = Components::new(surface, &topology);
    let parts = (0..topology.components.len()).map(ComponentId::from_index);
    parts.map(|part| components.extract(part).ok()).collect()
}

fn options_on(
    part: &Submesh,
    surface: &Surface,
    options: &IntegerGridOptions,
    is_feature: &PerEdge<bool>,
) -> IntegerGridOptions {
    let (mesh, whole) = (part.surface.mesh(), surface.mesh());
    let source = |edge| whole.edge(part.corner_sources[mesh.edge_halfedge(edge)]);
    let vertices = &part.vertex_sources;
    let sizing = options.sizing.as_ref();
    let stretch = options.stretch.as_ref();
    IntegerGridOptions {
        features: mesh
            .edges()
            .filter(|&edge| is_feature[source(edge)])
            .collect(),
        sizing: sizing.map(|sizing| vertices.map(|&source| sizing[source])),
        stretch: stretch.map(|stretch| vertices.map(|&source| stretch[source])),
        ..*options
    }
}
