//! The part of a surface that is flattened: all of it, or one component.

use graticule::mesh::{
    ComponentId, HalfedgeId, NO_VALUE, PerCorner, PerVertex, Repaired, Submesh, Surface, Topology,
    VertexId, extract_component,
};

use crate::failure::Failure;

/// A surface cut out of another, with the way from the whole to the part.
pub(super) struct Piece {
    pub(super) surface: Surface,
    /// For each vertex of the whole that of the part, or [`NO_VALUE`]; `None` for the whole itself.
    vertices: Option<PerVertex<u32>>,
    /// The same for each corner.
    corners: Option<PerCorner<u32>>,
    /// For each vertex of the part that of the whole; `None` for the whole itself.
    sources: Option<PerVertex<VertexId>>,
}

impl Piece {
    /// The component asked for, or the whole surface.
    pub(super) fn choose(repaired: &Repaired, component: Option<u32>) -> Result<Self, Failure> {
        let whole = &repaired.surface;
        let Some(component) = component else {
            return several_components_told(whole);
        };
        let part = component_of(whole, component)?;
        let mut vertices = PerVertex::filled(whole.mesh().vertex_count(), NO_VALUE);
        for (vertex, &source) in part.vertex_sources.enumerate() {
            vertices[source] = vertex.0;
        }
        let mut corners = PerCorner::filled(whole.mesh().halfedge_count(), NO_VALUE);
        for (corner, &source) in part.corner_sources.enumerate() {
            corners[source] = corner.0;
        }
        Ok(Self {
            surface: part.surface,
            vertices: Some(vertices),
            corners: Some(corners),
            sources: Some(part.vertex_sources),
        })
    }

    /// The vertex of the part behind a vertex of the whole.
    pub(super) fn vertex(&self, whole: VertexId) -> Option<VertexId> {
        match &self.vertices {
            None => Some(whole),
            Some(vertices) => Some(vertices[whole])
                .filter(|&vertex| vertex != NO_VALUE)
                .map(VertexId),
        }
    }

    /// The corner of the part behind a corner of the whole.
    pub(super) fn corner(&self, whole: HalfedgeId) -> Option<HalfedgeId> {
        match &self.corners {
            None => Some(whole),
            Some(corners) => Some(corners[whole])
                .filter(|&corner| corner != NO_VALUE)
                .map(HalfedgeId),
        }
    }

    /// The vertex of the whole behind a vertex of the part.
    pub(super) fn source(&self, part: VertexId) -> VertexId {
        self.sources.as_ref().map_or(part, |sources| sources[part])
    }
}

/// A component by its number.
pub(super) fn component_of(whole: &Surface, component: u32) -> Result<Submesh, Failure> {
    let topology = Topology::of(whole.mesh());
    let count = topology.components.len();
    if component as usize >= count {
        return Err(Failure::new(
            format!("there is no component {component}: the surface has {count}, from 0 on"),
            "'graticule info' lists the components",
        ));
    }
    Ok(extract_component(whole, &topology, ComponentId(component))?)
}

/// The whole surface, or the advice to choose a component.
fn several_components_told(whole: &Surface) -> Result<Piece, Failure> {
    let count = Topology::of(whole.mesh()).components.len();
    if count > 1 {
        return Err(Failure::new(
            format!("the surface has {count} components; a patch is one"),
            "flatten all side by side with --injective, or one with --component N; 'graticule info' lists them",
        ));
    }
    Ok(Piece {
        surface: whole.clone(),
        vertices: None,
        corners: None,
        sources: None,
    })
}
