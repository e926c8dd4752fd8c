//! What can be flattened: one piece of surface, without handles, with a boundary.

use std::sync::Arc;

use crate::Hint;
use crate::geometry::{TriangleShape, face_shapes, normalized, total_area};
use crate::mesh::{
    BoundaryLoopId, ComponentTopology, EdgeId, HalfedgeId, PerFace, Surface, Topology,
    TriangleMesh, VertexId,
};
use crate::watch::{Stopped, Watch};

/// Why a surface cannot be flattened as it is.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotAPatch {
    /// There is no boundary.
    #[error("the surface is closed (genus {genus}): it has no boundary to lay down")]
    Closed {
        /// Number of handles.
        genus: usize,
    },
    /// The surface falls into pieces.
    #[error("the surface has {components} components; a patch is one")]
    SeveralComponents {
        /// Number of edge-connected components.
        components: usize,
    },
    /// There are handles: the plane has none.
    #[error(
        "the surface has genus {genus} with {boundary_loops} boundary loops; a patch has genus 0"
    )]
    Handles {
        /// Number of handles.
        genus: usize,
        /// Number of boundary loops.
        boundary_loops: usize,
    },
    /// Every triangle is degenerate.
    #[error("the surface has no area")]
    NoArea,
    /// The loop asked for as the outer one is not there.
    #[error(
        "{boundary_loop} was asked for; the patch has {boundary_loops} boundary loops, counted from 0"
    )]
    NoSuchLoop {
        /// The loop asked for.
        boundary_loop: BoundaryLoopId,
        /// Number of boundary loops.
        boundary_loops: usize,
    },
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl Hint for NotAPatch {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::Closed { .. } => {
                "cut the surface open along a seam first, as `graticule flatten --cut` does"
            }
            Self::SeveralComponents { .. } => {
                "flatten each component by itself, or all side by side with `graticule flatten --injective`"
            }
            Self::Handles { .. } => {
                "cut the handles open along a seam first, as `graticule flatten --cut` does"
            }
            Self::NoArea => "check the units and the precision with which the file was exported",
            Self::NoSuchLoop { .. } => "`graticule info` lists the boundary loops",
            Self::Stopped(stopped) => return stopped.hint(),
        };
        Some(text.into())
    }
}

/// A connected surface of genus 0 with at least one boundary loop: a disk, perhaps with holes.
///
/// One loop is the outer one, the longest unless another is chosen; the others are holes.
#[derive(Clone, Debug)]
pub struct Patch {
    surface: Surface,
    unit: Surface,
    unit_length: f64,
    shapes: Arc<PerFace<TriangleShape>>,
    unit_area: f64,
    outer_loop: BoundaryLoopId,
}

impl Patch {
    /// Checks that the surface can be flattened. Linear time.
    ///
    /// # Errors
    /// [`NotAPatch`] says what is in the way.
    pub fn new(surface: Surface, watch: &Watch) -> Result<Self, NotAPatch> {
        let _stage = watch.stage("check patch");
        check_topology(surface.mesh())?;
        watch.check()?;
        let (unit, similarity) = normalized(&surface);
        let shapes = face_shapes(&unit);
        let unit_area = total_area(&shapes);
        // A boundary loop has three edges at least, so the length is above zero if any area is.
        if unit_area.is_nan() || unit_area <= 0.0 {
            return Err(NotAPatch::NoArea);
        }
        let outer_loop = longest_loop(&unit);
        Ok(Self {
            unit_length: similarity.invert_length(1.0),
            surface,
            unit,
            shapes: Arc::new(shapes),
            unit_area,
            outer_loop,
        })
    }

    /// The same patch with another loop as the outer one.
    ///
    /// # Errors
    /// [`NotAPatch::NoSuchLoop`].
    pub fn with_outer_loop(self, outer_loop: BoundaryLoopId) -> Result<Self, NotAPatch> {
        let boundary_loops = self.mesh().boundary_loop_count();
        if outer_loop.0 as usize >= boundary_loops {
            return Err(NotAPatch::NoSuchLoop {
                boundary_loop: outer_loop,
                boundary_loops,
            });
        }
        Ok(Self { outer_loop, ..self })
    }

    /// The surface, as given.
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Gives the surface back.
    #[must_use]
    pub fn into_surface(self) -> Surface {
        self.surface
    }

    /// The connectivity.
    #[must_use]
    pub fn mesh(&self) -> &TriangleMesh {
        self.surface.mesh()
    }

    /// The outer boundary loop.
    #[must_use]
    pub fn outer_loop(&self) -> BoundaryLoopId {
        self.outer_loop
    }

    /// The other boundary loops, in order.
    pub fn holes(&self) -> impl Iterator<Item = BoundaryLoopId> + '_ {
        let loops = self.mesh().boundary_loops();
        loops.filter(|&boundary_loop| boundary_loop != self.outer_loop)
    }

    /// The vertices along a boundary loop, the surface to their left.
    pub fn loop_vertices(&self, boundary_loop: BoundaryLoopId) -> impl Iterator<Item = VertexId> {
        let mesh = self.mesh();
        mesh.boundary_loop(boundary_loop)
            .iter()
            .map(|&halfedge| mesh.origin(halfedge))
    }

    /// The vertices of all boundary loops, loop after loop.
    pub fn boundary_vertices(&self) -> impl Iterator<Item = VertexId> + '_ {
        let loops = self.mesh().boundary_loops();
        loops.flat_map(|boundary_loop| self.loop_vertices(boundary_loop))
    }

    /// The number of vertices that do not lie on the boundary. A patch may have none; then its
    /// boundary alone decides a fixed map.
    #[must_use]
    pub fn interior_vertex_count(&self) -> usize {
        let mesh = self.mesh();
        let interior = mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v));
        interior.count()
    }

    /// The shape of each triangle, in [unit lengths](Self::unit_length).
    #[must_use]
    pub fn shapes(&self) -> &PerFace<TriangleShape> {
        &self.shapes
    }

    /// The patch moved and scaled to unit extent, in which all is computed: no product of a few
    /// lengths overflows or vanishes.
    #[must_use]
    pub fn unit_surface(&self) -> &Surface {
        &self.unit
    }

    /// The length of the surface that is 1 on the [unit surface](Self::unit_surface): a power of
    /// two.
    #[must_use]
    pub fn unit_length(&self) -> f64 {
        self.unit_length
    }

    /// The area of the unit surface.
    #[must_use]
    pub fn unit_area(&self) -> f64 {
        self.unit_area
    }

    /// The length of each edge of a boundary loop, in unit lengths, in the loop's order.
    pub(super) fn unit_steps(&self, boundary_loop: BoundaryLoopId) -> impl Iterator<Item = f64> {
        let halfedges = self.mesh().boundary_loop(boundary_loop).iter();
        halfedges.map(|&halfedge| halfedge_length(&self.unit, halfedge))
    }

    /// Edges inside the patch whose ends both lie on the outer loop: they divide it, and each part
    /// is laid down by itself once the loop is fixed.
    pub(super) fn dividing_edges(&self) -> impl Iterator<Item = EdgeId> {
        let mesh = self.mesh();
        let mut on_loop = vec![false; mesh.vertex_count()];
        for vertex in self.loop_vertices(self.outer_loop) {
            on_loop[vertex.0 as usize] = true;
        }
        mesh.edges().filter(move |&edge| {
            let ends = mesh.ends(mesh.edge_halfedge(edge));
            !mesh.is_boundary_edge(edge) && ends.iter().all(|end| on_loop[end.0 as usize])
        })
    }
}

fn check_topology(mesh: &TriangleMesh) -> Result<(), NotAPatch> {
    let topology = Topology::of(mesh);
    let components = topology.components.len();
    let ComponentTopology {
        boundary_loops,
        genus,
        ..
    } = topology.total;
    match (components, boundary_loops, genus) {
        (1, 0, genus) => Err(NotAPatch::Closed { genus }),
        (1, _, 0) => Ok(()),
        (1, boundary_loops, genus) => Err(NotAPatch::Handles {
            genus,
            boundary_loops,
        }),
        (components, ..) => Err(NotAPatch::SeveralComponents { components }),
    }
}

fn halfedge_length(surface: &Surface, halfedge: HalfedgeId) -> f64 {
    surface.halfedge_vector(halfedge).length()
}

/// The longest boundary loop; of equally long ones the first.
fn longest_loop(surface: &Surface) -> BoundaryLoopId {
    let mesh = surface.mesh();
    let length = |boundary_loop| -> f64 {
        let halfedges = mesh.boundary_loop(boundary_loop).iter();
        halfedges
            .map(|&halfedge| halfedge_length(surface, halfedge))
            .sum()
    };
    let mut longest = (BoundaryLoopId(0), f64::NEG_INFINITY);
    for boundary_loop in mesh.boundary_loops() {
        let length = length(boundary_loop);
        if length > longest.1 {
            longest = (boundary_loop, length);
        }
    }
    longest.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::{Fixture, annulus, cube, cylinder_patch, disk, torus};

    fn patch(fixture: Fixture) -> Result<Patch, NotAPatch> {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        Patch::new(surface, &Watch::new())
    }

    #[test]
    fn a_disk_is_a_patch_without_holes() {
        let disk = patch(disk(3)).unwrap();
        assert_eq!(disk.holes().count(), 0);
        assert_eq!(disk.loop_vertices(disk.outer_loop()).count(), 18);
        assert_eq!(disk.interior_vertex_count(), 19);
        assert_eq!(disk.dividing_edges().count(), 0);
    }

    #[test]
    fn the_longest_loop_is_outside_and_another_may_be_chosen() {
        let ring = patch(annulus(0.5, 1.0, 12, 3)).unwrap();
        let radius = |p: &Patch| {
            let vertex = p.loop_vertices(p.outer_loop()).next().unwrap();
            p.surface().position(vertex).length()
        };
        assert!((radius(&ring) - 1.0).abs() < 1e-12);
        let hole = ring.holes().next().unwrap();
        let turned = ring.with_outer_loop(hole).unwrap();
        assert!((radius(&turned) - 0.5).abs() < 1e-12);
        let refusal = turned.with_outer_loop(BoundaryLoopId(2)).unwrap_err();
        assert!(matches!(
            refusal,
            NotAPatch::NoSuchLoop {
                boundary_loops: 2,
                ..
            }
        ));
    }

    #[test]
    fn what_is_no_patch_is_refused_by_name_and_with_a_hint() {
        let closed = patch(cube()).unwrap_err();
        assert_eq!(closed, NotAPatch::Closed { genus: 0 });
        let two = patch(disk(2).joined(&disk(2).map(|p| p + glam::DVec3::X * 3.0))).unwrap_err();
        assert_eq!(two, NotAPatch::SeveralComponents { components: 2 });
        let mut punctured = torus(2.0, 0.5, 8, 6);
        punctured.triangles.remove(0);
        let handle = patch(punctured).unwrap_err();
        assert_eq!(
            handle,
            NotAPatch::Handles {
                genus: 1,
                boundary_loops: 1
            }
        );
        let line = |k: i32| glam::DVec3::X * f64::from(k);
        let flat = Fixture {
            positions: vec![line(0), line(1), line(3)],
            triangles: vec![[0, 1, 2]],
        };
        assert_eq!(patch(flat).unwrap_err(), NotAPatch::NoArea);
        for refusal in [closed, two, handle, NotAPatch::NoArea] {
            assert!(refusal.hint().is_some());
        }
    }

    #[test]
    fn tiny_and_huge_patches_are_patches() {
        for scale in [1e-200, 1e-30, 1e30, 1e150] {
            let tube = patch(cylinder_patch(1.0, 1.0, 8, 2).map(|p| p * scale)).unwrap();
            assert!(tube.unit_area() > 0.01 && tube.unit_area() < 100.0);
            assert!((tube.unit_length() / scale).log2().abs() < 3.0);
        }
    }
}
