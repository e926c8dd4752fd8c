use serde::Serialize;

use super::disjoint_sets::{DisjointSets, number_names};
use super::{
    BoundaryLoopId, ComponentId, CornerTable, Element, FaceId, HalfedgeId, PerComponent, PerCorner,
    PerElement, PerFace, PerVertex, Surface, TriangleMesh, VertexId,
};

/// One value for each boundary loop.
pub type PerBoundaryLoop<T> = PerElement<BoundaryLoopId, T>;

/// Counts of a component, or of a whole mesh.
///
/// They hold together: `euler_characteristic` = `vertices - edges + faces`
/// = `2 * components - 2 * genus - boundary_loops`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ComponentTopology {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of triangles.
    pub faces: usize,
    /// Number of boundary loops.
    pub boundary_loops: usize,
    /// Vertices less edges plus faces.
    pub euler_characteristic: i64,
    /// Number of handles; of several components together the sum.
    pub genus: usize,
}

impl ComponentTopology {
    /// Whether the component is a disk: no handle and one boundary loop.
    #[must_use]
    pub fn is_disk(&self) -> bool {
        self.genus == 0 && self.boundary_loops == 1
    }

    /// Whether the component has no boundary.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.boundary_loops == 0
    }

    /// Fills in what follows from the counts of `components` components.
    fn complete(&mut self, components: usize) {
        let signed = |count: usize| i64::try_from(count).unwrap_or(i64::MAX);
        let [vertices, edges, faces] = [self.vertices, self.edges, self.faces].map(signed);
        self.euler_characteristic = vertices - edges + faces;
        let loops = signed(self.boundary_loops);
        let handles = 2 * signed(components) - loops - self.euler_characteristic;
        debug_assert!(
            handles >= 0 && handles % 2 == 0,
            "an oriented surface: {self:?}"
        );
        self.genus = usize::try_from(handles / 2).unwrap_or_default();
    }
}

/// Components of a mesh and their topology.
///
/// A component is a set of triangles joined by edges; components are numbered by their first
/// triangle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Topology {
    /// Each component's counts.
    pub components: PerComponent<ComponentTopology>,
    /// The counts of all components together.
    pub total: ComponentTopology,
    /// The component of each triangle.
    #[serde(skip)]
    pub face_components: PerFace<ComponentId>,
    /// The component of each boundary loop.
    #[serde(skip)]
    pub loop_components: PerBoundaryLoop<ComponentId>,
}

impl Topology {
    /// Finds the components and counts their elements, in near-linear time.
    #[must_use]
    pub fn of(mesh: &TriangleMesh) -> Self {
        let (face_components, count) = find_components(mesh);
        let mut components = PerComponent::filled(count, ComponentTopology::default());
        let component = |halfedge: HalfedgeId| face_components[halfedge.face()];
        for &component in &face_components {
            components[component].faces += 1;
        }
        for edge in mesh.edges() {
            components[component(mesh.edge_halfedge(edge))].edges += 1;
        }
        for vertex in mesh.vertices() {
            components[component(mesh.vertex_halfedge(vertex))].vertices += 1;
        }
        let loop_components = PerBoundaryLoop::from_fn(mesh.boundary_loop_count(), |id| {
            component(mesh.boundary_loop(id)[0])
        });
        for &component in &loop_components {
            components[component].boundary_loops += 1;
        }
        for component in components.as_mut_slice() {
            component.complete(1);
        }
        let mut total = ComponentTopology {
            vertices: mesh.vertex_count(),
            edges: mesh.edge_count(),
            faces: mesh.face_count(),
            boundary_loops: mesh.boundary_loop_count(),
            ..ComponentTopology::default()
        };
        total.complete(count);
        Self {
            components,
            total,
            face_components,
            loop_components,
        }
    }

    /// The component with the most triangles; among equals the first.
    #[must_use]
    pub fn largest_component(&self) -> ComponentId {
        let by_size = |(id, component): &(ComponentId, &ComponentTopology)| {
            (component.faces, std::cmp::Reverse(*id))
        };
        let largest = self.components.enumerate().max_by_key(by_size);
        largest.map_or(ComponentId(0), |(id, _)| id)
    }
}

/// The edge-connected component of each triangle, numbered by first triangle, and their number.
pub(crate) fn find_components(mesh: &CornerTable) -> (PerFace<ComponentId>, usize) {
    let mut sets = DisjointSets::new(mesh.face_count());
    for halfedge in mesh.halfedges() {
        if let Some(twin) = mesh.twin(halfedge) {
            sets.join(halfedge.face().0, twin.face().0);
        }
    }
    let mut names = sets.into_names();
    let count = number_names(&mut names);
    let components = names.into_iter().map(ComponentId).collect();
    (PerFace::new(components), count)
}

/// A part of a surface as a surface of its own, with the way back.
///
/// Vertices and triangles stand in the order they had.
#[derive(Clone, Debug, PartialEq)]
pub struct Submesh {
    /// The part.
    pub surface: Surface,
    /// The vertex of the whole for each vertex.
    pub vertex_sources: PerVertex<VertexId>,
    /// The corner of the whole for each corner.
    pub corner_sources: PerCorner<HalfedgeId>,
    /// The triangle of the whole for each triangle.
    pub face_sources: PerFace<FaceId>,
}

/// Takes one component out of a surface.
///
/// # Panics
/// If `topology` is not that of the surface, or has no such component.
///
/// # Errors
/// [`MeshError::ZeroExtent`](super::MeshError::ZeroExtent) if all vertices of the component
/// coincide.
pub fn extract_component(
    surface: &Surface,
    topology: &Topology,
    component: ComponentId,
) -> Result<Submesh, super::MeshError> {
    let faces = surface.mesh().faces();
    let own = faces.filter(|&face| topology.face_components[face] == component);
    submesh_of(surface, own.collect())
}

/// Takes components out of a surface one after another, any number of them: all together in linear
/// time.
#[derive(Clone, Debug)]
pub struct Components<'a> {
    surface: &'a Surface,
    /// The triangles of component `c` are `faces[starts[c]..starts[c + 1]]`, ascending.
    starts: Vec<u32>,
    faces: Vec<FaceId>,
    numbers: PerVertex<u32>,
}

impl<'a> Components<'a> {
    /// The components of a surface.
    ///
    /// # Panics
    /// If `topology` is not that of the surface.
    #[must_use]
    pub fn new(surface: &'a Surface, topology: &Topology) -> Self {
        let mesh = surface.mesh();
        let mut faces: Vec<FaceId> = mesh.faces().collect();
        faces.sort_by_key(|&face| topology.face_components[face]);
        let mut starts = vec![0; topology.components.len() + 1];
        for component in &topology.face_components {
            starts[component.index() + 1] += 1;
        }
        for component in 0..topology.components.len() {
            starts[component + 1] += starts[component];
        }
        Self {
            numbers: PerVertex::filled(mesh.vertex_count(), u32::MAX),
            surface,
            starts,
            faces,
        }
    }

    /// The triangles of a component, ascending.
    ///
    /// # Panics
    /// If there is no such component.
    #[must_use]
    pub fn faces(&self, component: ComponentId) -> &[FaceId] {
        let [start, end] = [0, 1].map(|next| self.starts[component.index() + next] as usize);
        &self.faces[start..end]
    }

    /// One component, as [`extract_component`] takes it out.
    ///
    /// # Panics
    /// If there is no such component.
    ///
    /// # Errors
    /// As [`extract_component`].
    pub fn extract(&mut self, component: ComponentId) -> Result<Submesh, super::MeshError> {
        let faces = self.faces(component).to_vec();
        submesh(self.surface, faces, &mut self.numbers)
    }
}

/// These triangles, whose vertices no others have, as a surface.
///
/// # Errors
/// As [`extract_component`].
pub(crate) fn submesh_of(
    surface: &Surface,
    faces: Vec<FaceId>,
) -> Result<Submesh, super::MeshError> {
    let mut numbers = PerVertex::filled(surface.mesh().vertex_count(), u32::MAX);
    submesh(surface, faces, &mut numbers)
}

/// The same; `numbers` is scratch.
fn submesh(
    surface: &Surface,
    face_sources: Vec<FaceId>,
    numbers: &mut PerVertex<u32>,
) -> Result<Submesh, super::MeshError> {
    let mesh = surface.mesh();
    let mut vertex_sources: Vec<_> = face_sources
        .iter()
        .flat_map(|&face| mesh.triangle(face))
        .collect();
    vertex_sources.sort_unstable();
    vertex_sources.dedup();
    for (number, &vertex) in (0_u32..).zip(&vertex_sources) {
        numbers[vertex] = number;
    }
    let triangles: Vec<_> = face_sources
        .iter()
        .map(|&face| mesh.triangle(face).map(|vertex| numbers[vertex]))
        .collect();
    let positions = vertex_sources
        .iter()
        .map(|&vertex| surface.position(vertex));
    let corner_sources = face_sources.iter().flat_map(|face| face.halfedges());
    Ok(Submesh {
        surface: Surface::from_triangles(positions.collect(), &triangles)?,
        corner_sources: PerCorner::new(corner_sources.collect()),
        vertex_sources: PerVertex::new(vertex_sources),
        face_sources: PerFace::new(face_sources),
    })
}

#[cfg(test)]
mod tests {
    use graticule_fixtures::{Fixture, annulus, cube, icosphere, torus};

    use super::*;

    fn surface(fixture: &Fixture) -> Surface {
        Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
    }

    #[test]
    fn known_surfaces_have_their_topology() {
        let counts = |fixture: &Fixture| {
            let total = Topology::of(surface(fixture).mesh()).total;
            let ComponentTopology {
                boundary_loops,
                euler_characteristic,
                genus,
                ..
            } = total;
            (boundary_loops, euler_characteristic, genus)
        };
        assert_eq!(counts(&icosphere(2)), (0, 2, 0));
        assert_eq!(counts(&torus(2.0, 0.5, 12, 6)), (0, 0, 1));
        assert_eq!(counts(&annulus(1.0, 2.0, 10, 3)), (2, 0, 0));
        let both = torus(2.0, 0.5, 12, 6).joined(&annulus(5.0, 6.0, 10, 1));
        assert_eq!(counts(&both), (2, 0, 1));
    }

    #[test]
    fn a_component_taken_out_is_the_one_put_in() {
        let whole = torus(2.0, 0.5, 12, 6).joined(&cube());
        let (renumbered, _) = whole.renumbered(5);
        for fixture in [whole, renumbered] {
            let surface = surface(&fixture);
            let topology = Topology::of(surface.mesh());
            assert_eq!(topology.components.len(), 2);
            let smaller = ComponentId(1 - topology.largest_component().0);
            let part = extract_component(&surface, &topology, smaller).unwrap();
            let mut components = Components::new(&surface, &topology);
            let larger = components.extract(ComponentId(1 - smaller.0)).unwrap();
            assert_eq!(
                larger.surface.mesh().face_count() + 12,
                surface.mesh().face_count()
            );
            assert_eq!(components.faces(smaller), part.face_sources.as_slice());
            assert_eq!(components.extract(smaller).unwrap(), part);
            let own = Topology::of(part.surface.mesh());
            assert_eq!(own.total, topology.components[smaller]);
            assert_eq!(own.total.faces, 12);
            for corner in part.surface.mesh().halfedges() {
                let source = part.corner_sources[corner];
                assert_eq!(part.face_sources[corner.face()], source.face());
                let vertex = part.surface.mesh().origin(corner);
                assert_eq!(part.vertex_sources[vertex], surface.mesh().origin(source));
            }
        }
    }
}
