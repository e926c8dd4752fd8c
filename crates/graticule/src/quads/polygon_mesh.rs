use glam::DVec3;

use super::QuadsError;
use crate::mesh::{
    ComponentTopology, MeshError, PolygonSoup, Polygons, Surface, SurfacePoint, Topology,
    TriangleMesh,
};

/// A mesh of polygons that lies on a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonMesh {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Polygons, counter-clockwise seen from outside, as indices of vertices.
    pub polygons: Polygons,
    /// For each vertex the point of the surface that it lies on.
    pub origins: Vec<SurfacePoint>,
    /// The edges along features of the surface, as pairs of vertices, the smaller one first, in
    /// order.
    pub feature_edges: Vec<[u32; 2]>,
}

impl PolygonMesh {
    /// The number of polygons with four corners.
    #[must_use]
    pub fn quad_count(&self) -> usize {
        (0..self.polygons.len())
            .filter(|&polygon| self.polygons.vertices(polygon).len() == 4)
            .count()
    }

    /// Topology of the mesh, once it is known to be sound: manifold, oriented, no vertex unused or
    /// twice in a polygon, no two edges or polygons with the same vertices.
    ///
    /// # Errors
    /// [`QuadsError::Unsound`].
    pub fn topology(&self) -> Result<Topology, QuadsError> {
        // With a vertex inside each polygon, triangles are sound exactly if the polygons are.
        let mut triangles = Vec::with_capacity(self.polygons.corner_count());
        let count = self.positions.len();
        for polygon in 0..self.polygons.len() {
            let vertices = self.polygons.vertices(polygon);
            let middle = (count + polygon) as u32;
            if vertices.len() < 3 {
                let vertex = vertices.first().copied().unwrap_or_default();
                let rule = "a polygon has fewer than three corners";
                return Err(QuadsError::Unsound { vertex, rule });
            }
            let sides = vertices.iter().zip(vertices.iter().cycle().skip(1));
            triangles.extend(sides.map(|(&from, &to)| [from, to, middle]));
        }
        let mesh = TriangleMesh::new(count + self.polygons.len(), &triangles);
        mesh.map(|mesh| Topology::of(&mesh))
            .map_err(|error| unsound(&error))
    }

    /// Checks that the mesh is sound and has the components, genera and boundary loops of the
    /// surface.
    ///
    /// # Errors
    /// [`QuadsError::Unsound`], [`QuadsError::Topology`].
    pub fn check(&self, surface: &Surface) -> Result<(), QuadsError> {
        let expected = Topology::of(surface.mesh());
        let found = self.topology()?;
        let whole = |count: usize| i64::try_from(count).unwrap_or(i64::MAX);
        let counts = |topology: &Topology| {
            let ComponentTopology {
                boundary_loops,
                euler_characteristic,
                ..
            } = topology.total;
            [
                ("components", whole(topology.components.len())),
                ("boundary loops", whole(boundary_loops)),
                ("as Euler characteristic", euler_characteristic),
            ]
        };
        for ((what, expected), (_, found)) in counts(&expected).into_iter().zip(counts(&found)) {
            if expected != found {
                return Err(QuadsError::Topology {
                    what,
                    found,
                    expected,
                });
            }
        }
        Ok(())
    }

    /// The polygons alone, to be written.
    #[must_use]
    pub fn into_soup(self) -> PolygonSoup {
        PolygonSoup {
            positions: self.positions,
            polygons: self.polygons,
            ..PolygonSoup::default()
        }
    }
}

fn unsound(error: &MeshError) -> QuadsError {
    let (vertex, rule) = match error {
        MeshError::RepeatedVertex { vertex, .. } => (vertex.0, "it is twice in a polygon"),
        MeshError::NonManifoldEdge { ends, .. } => (ends[0].0, "an edge has three polygons"),
        MeshError::InconsistentOrientation { ends, .. } => {
            (ends[0].0, "two polygons run along an edge in one direction")
        }
        MeshError::NonManifoldVertex { vertex } => (vertex.0, "its polygons form two fans"),
        MeshError::IsolatedVertex { vertex } => (vertex.0, "it belongs to no polygon"),
        _ => (0, "there are no polygons, or too many"),
    };
    QuadsError::Unsound { vertex, rule }
}
