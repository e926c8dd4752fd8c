//! Components of a few triangles that together do not fill a quad, such as the fins that scans with
//! non-manifold edges fall into. No net has room on them, and in the search for one they would make
//! all others wait; so they are set aside and cut into quads by themselves.

use super::remesh::side_length;
use super::small_components::TriangleQuads;
use super::{PolygonMesh, RemeshOptions};
use crate::field::SingularityPlan;
use crate::mesh::{
    ComponentId, Components, EdgeId, Element, FaceId, HalfedgeId, PerEdge, Submesh, Surface,
    Topology, submesh_of,
};
use crate::periodic::GridDensity;
use crate::tolerance::SMALL_COMPONENT;

/// What was set aside, and the rest of the surface.
pub(super) struct Debris {
    /// The triangles of each component.
    components: Vec<Vec<FaceId>>,
    rest: Submesh,
    options: RemeshOptions,
    /// What the debris takes of the quads.
    quads: usize,
}

impl Debris {
    /// `None` where there is no debris, or nothing else. Where the user tells the field its way by
    /// places on the surface, nothing is set aside.
    pub(super) fn of(surface: &Surface, options: &RemeshOptions) -> Option<Self> {
        let topology = Topology::of(surface.mesh());
        if is_told_by_places(options) || topology.components.len() == 1 {
            return None;
        }
        let parts = Components::new(surface, &topology);
        let side = side_length(surface, options.density);
        let is_debris = |faces: &[FaceId]| {
            faces.len() <= SMALL_COMPONENT
                && faces.iter().map(|&face| area(surface, face)).sum::<f64>() < side * side
        };
        let all = (0..topology.components.len()).map(ComponentId::from_index);
        let (debris, kept): (Vec<_>, Vec<_>) = all
            .map(|component| parts.faces(component).to_vec())
            .partition(|faces| is_debris(faces));
        if debris.is_empty() || kept.is_empty() {
            return None;
        }
        let mut kept = kept.concat();
        kept.sort_unstable();
        let rest = submesh_of(surface, kept).ok()?;
        let quads = 3 * debris.iter().map(Vec::len).sum::<usize>();
        let mut options = options_for(&rest, surface, options);
        options.density = left(options.density, quads);
        Some(Self {
            components: debris,
            rest,
            options,
            quads,
        })
    }

    /// The surface without the debris, and the options for it.
    pub(super) fn rest(&self) -> (&Surface, &RemeshOptions) {
        (&self.rest.surface, &self.options)
    }

    /// The density of the rest, for one of the whole.
    pub(super) fn density(&self, whole: GridDensity) -> GridDensity {
        left(whole, self.quads)
    }

    /// Makes the mesh of the rest one of the whole surface. Returns the number of components that
    /// were added.
    pub(super) fn put_back(
        &self,
        mesh: &mut PolygonMesh,
        surface: &Surface,
        is_feature: &PerEdge<bool>,
    ) -> usize {
        for origin in &mut mesh.origins {
            origin.face = self.rest.face_sources[origin.face];
        }
        let mut quads = TriangleQuads::new(std::mem::take(mesh), surface, is_feature);
        for faces in &self.components {
            quads.add(faces);
        }
        *mesh = quads.finish();
        self.components.len()
    }
}

/// Whether the options name places of the surface, which parts of it do not know.
pub(super) fn is_told_by_places(options: &RemeshOptions) -> bool {
    let field = &options.field;
    !field.guides.is_empty()
        || !field.strokes.is_empty()
        || field.singularities != SingularityPlan::default()
}

fn area(surface: &Surface, face: FaceId) -> f64 {
    let [a, b, c] = surface.corner_positions(face);
    0.5 * (b - a).cross(c - a).length()
}

/// A density without the quads that the debris takes: a quarter of them at most, so that the rest
/// keeps its shape.
fn left(density: GridDensity, taken: usize) -> GridDensity {
    match density {
        GridDensity::Quads(quads) => GridDensity::Quads(quads - taken.min(quads / 4)),
        length @ GridDensity::EdgeLength(_) => length,
    }
}

/// The options with the features and sizes that are left.
pub(super) fn options_for(
    rest: &Submesh,
    surface: &Surface,
    options: &RemeshOptions,
) -> RemeshOptions {
    let (mesh, whole) = (rest.surface.mesh(), surface.mesh());
    let mut is_feature = PerEdge::filled(whole.edge_count(), false);
    for &edge in &options.field.features.edges {
        is_feature[edge] = true;
    }
    let source = |side: HalfedgeId| whole.edge(rest.corner_sources[side]);
    let mut options = options.clone();
    options.field.features.edges = mesh
        .edges()
        .filter(|&edge: &EdgeId| is_feature[source(mesh.edge_halfedge(edge))])
        .collect();
    options.sizing = options.sizing.on_part(&rest.vertex_sources);
    options
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::{Fixture, cube, icosphere, tetrahedron};

    fn surface(fixture: &Fixture) -> Surface {
        Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
    }

    fn options(quads: usize) -> RemeshOptions {
        RemeshOptions {
            density: GridDensity::Quads(quads),
            ..RemeshOptions::default()
        }
    }

    #[test]
    fn only_components_smaller_than_a_quad_are_debris() {
        let fixture = icosphere(3).joined(&tetrahedron().map(|p| p * 0.05 + 2.0));
        let surface = surface(&fixture);
        let debris = Debris::of(&surface, &options(300)).unwrap();
        assert_eq!(debris.components.len(), 1);
        assert_eq!(debris.rest.surface.mesh().face_count(), 1280);
        assert!(matches!(debris.rest().1.density, GridDensity::Quads(288)));
        assert!(Debris::of(&surface, &options(100_000)).is_none());
    }

    #[test]
    fn a_surface_of_debris_alone_is_left_as_it_is() {
        let pair = cube().joined(&cube().map(|p| p + 2.0));
        assert!(Debris::of(&surface(&pair), &options(1)).is_none());
    }

    #[test]
    fn features_keep_their_places_on_the_rest() {
        let fixture = tetrahedron().map(|p| p * 1e-3 - 2.0).joined(&cube());
        let surface = surface(&fixture);
        let mesh = surface.mesh();
        let mut options = options(100);
        options.field.features.edges = mesh.edges().collect();
        let debris = Debris::of(&surface, &options).unwrap();
        let (rest, options) = debris.rest();
        assert_eq!(rest.mesh().face_count(), 12);
        assert_eq!(options.field.features.edges.len(), 18);
    }
}
