use glam::DVec3;

use super::QuadsError;
use super::edge_nodes::EdgeNodes;
use super::triangle_cut::TriangleCut;
use crate::mesh::{EdgeId, FaceId, HalfedgeId, PerEdge, Surface, SurfacePoint, TriangleMesh};
use crate::periodic::GridMap;
use crate::watch::Watch;

/// No face, dart or node.
pub(super) const NONE: u32 = u32::MAX;

/// What an arc is; of two that become one, the larger counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum ArcKind {
    /// A piece of an edge that nothing runs along: it lies inside a cell.
    Inner,
    /// A piece of a line of the net.
    Line,
    /// A cut through a cell that is no disk.
    Cut,
    /// A piece of a feature edge.
    Feature,
    /// A piece of the boundary.
    Boundary,
}

/// The triangles of a surface cut along the lines of a net: a cell complex that covers the surface,
/// whatever the map, because in each triangle the lines are straight.
///
/// Arcs come as two darts each, `2a` and `2a + 1`. A face lies to the left of its darts; beyond the
/// boundary there is [`NONE`].
pub(super) struct Overlay {
    /// Where each node lies: first the vertices of the mesh, then the places on edges, then lattice
    /// points inside triangles.
    pub(super) points: Vec<SurfacePoint>,
    /// The same in space.
    pub(super) positions: Vec<DVec3>,
    /// Whether lines of both families pass through the node.
    pub(super) lattice: Vec<bool>,
    /// The node that each dart leaves from.
    pub(super) origins: Vec<u32>,
    /// The next dart along the same face.
    pub(super) next: Vec<u32>,
    /// The face to the left of each dart.
    pub(super) faces: Vec<u32>,
    /// The number of faces.
    pub(super) face_count: usize,
    /// What each arc is.
    pub(super) kinds: Vec<ArcKind>,
    /// How far each arc leads along its line, in spacings: negative in triangles that the map turns
    /// over.
    pub(super) advances: Vec<f64>,
}

/// The dart of the same arc in the other direction.
#[inline]
pub(super) fn twin(dart: u32) -> u32 {
    dart ^ 1
}

/// The arc of a dart.
#[inline]
pub(super) fn arc(dart: u32) -> usize {
    (dart / 2) as usize
}

impl Overlay {
    /// Cuts the surface along the lines. Linear in the triangles and in the pieces.
    ///
    /// # Errors
    /// [`QuadsError::TooFine`], or that it was stopped.
    pub(super) fn of(
        surface: &Surface,
        map: &GridMap,
        features: Option<&PerEdge<bool>>,
        watch: &Watch,
    ) -> Result<Self, QuadsError> {
        let mesh = surface.mesh();
        let edge_nodes = EdgeNodes::of(mesh, map)?;
        let mut overlay = Self::of_edges(surface, &edge_nodes, map, features);
        let mut cut = TriangleCut::default();
        for face in mesh.faces() {
            if face.0.is_multiple_of(4096) {
                watch.check()?;
            }
            cut.gather(mesh, map, &edge_nodes, face);
            cut.lay_down(&mut overlay);
        }
        overlay.close_outside(mesh, &edge_nodes);
        overlay.positions = (overlay.points.iter())
            .map(|point| point.position(surface))
            .collect();
        Ok(overlay)
    }

    fn of_edges(
        surface: &Surface,
        edge_nodes: &EdgeNodes,
        map: &GridMap,
        features: Option<&PerEdge<bool>>,
    ) -> Self {
        let mesh = surface.mesh();
        let count = mesh.vertex_count() + edge_nodes.len();
        let pieces = edge_nodes.piece_count();
        let mut overlay = Self {
            points: Vec::with_capacity(count),
            positions: Vec::new(),
            lattice: Vec::with_capacity(count),
            origins: vec![NONE; 2 * pieces],
            next: vec![NONE; 2 * pieces],
            faces: vec![NONE; 2 * pieces],
            face_count: 0,
            kinds: Vec::with_capacity(pieces),
            advances: Vec::with_capacity(pieces),
        };
        for vertex in mesh.vertices() {
            overlay.add_node(SurfacePoint::at_corner(mesh.vertex_halfedge(vertex)), false);
        }
        for edge in mesh.edges() {
            overlay.add_edge(mesh, edge_nodes, map, edge);
            let kind = if mesh.is_boundary_edge(edge) {
                ArcKind::Boundary
            } else if features.is_some_and(|features| features[edge]) {
                ArcKind::Feature
            } else if edge_nodes.is_along(edge) {
                ArcKind::Line
            } else {
                ArcKind::Inner
            };
            let pieces = edge_nodes.of_edge(edge).len() + 1;
            overlay.kinds.extend(std::iter::repeat_n(kind, pieces));
        }
        overlay
    }

    fn add_edge(
        &mut self,
        mesh: &TriangleMesh,
        edge_nodes: &EdgeNodes,
        map: &GridMap,
        edge: EdgeId,
    ) {
        let side = edge_nodes.side(edge);
        let [from, to] = mesh.ends(side);
        let run = map.coordinate(side.next()) - map.coordinate(side);
        let length = run.length() * orientation_sign(map, side.face());
        let mut dart = 2 * edge_nodes.first_piece(edge);
        let (mut before, mut share_before) = (from.0, 0.0);
        for node in edge_nodes.of_edge(edge) {
            let number = self.points.len() as u32;
            let lattice = node.lines.iter().all(|&line| line != super::line::NO_LINE);
            self.add_node(SurfacePoint::on_halfedge(side, node.share), lattice);
            self.origins[dart] = before;
            self.origins[dart + 1] = number;
            self.advances.push((node.share - share_before) * length);
            (before, share_before) = (number, node.share);
            dart += 2;
        }
        self.origins[dart] = before;
        self.origins[dart + 1] = to.0;
        self.advances.push((1.0 - share_before) * length);
    }

    /// Adds a node and returns its number.
    pub(super) fn add_node(&mut self, point: SurfacePoint, lattice: bool) -> u32 {
        self.points.push(point);
        self.lattice.push(lattice);
        self.points.len() as u32 - 1
    }

    /// Adds a piece of a line inside a triangle and returns its dart from the first node.
    pub(super) fn add_line(&mut self, ends: [u32; 2], advance: f64) -> u32 {
        let dart = self.origins.len() as u32;
        self.origins.extend(ends);
        self.next.extend([NONE; 2]);
        self.faces.extend([NONE; 2]);
        self.kinds.push(ArcKind::Line);
        self.advances.push(advance);
        dart
    }

    /// Numbers the face to the left of a dart, unless it has a number.
    pub(super) fn number_face(&mut self, first: u32) {
        if self.faces[first as usize] != NONE {
            return;
        }
        let mut dart = first;
        while self.faces[dart as usize] == NONE {
            self.faces[dart as usize] = self.face_count as u32;
            dart = self.next[dart as usize];
        }
        self.face_count += 1;
    }

    fn close_outside(&mut self, mesh: &TriangleMesh, edge_nodes: &EdgeNodes) {
        for boundary_loop in mesh.boundary_loops() {
            let darts: Vec<u32> = (mesh.boundary_loop(boundary_loop).iter())
                .flat_map(|&halfedge| border_darts(mesh, edge_nodes, halfedge))
                .collect();
            let mut before = darts[darts.len() - 1];
            for dart in darts {
                self.next[twin(dart) as usize] = twin(before);
                before = dart;
            }
        }
    }

    /// The node that the dart runs to.
    #[inline]
    pub(super) fn destination(&self, dart: u32) -> u32 {
        self.origins[twin(dart) as usize]
    }

    /// Whether the dart's arc is part of the net.
    #[inline]
    pub(super) fn is_drawn(&self, dart: u32) -> bool {
        self.kinds[arc(dart)] != ArcKind::Inner
    }

    /// The next dart of the net along the same cell.
    pub(super) fn next_drawn(&self, dart: u32) -> u32 {
        let mut next = self.next[dart as usize];
        while !self.is_drawn(next) {
            next = self.next[twin(next) as usize];
        }
        next
    }

    /// The numbers of all darts.
    pub(super) fn darts(&self) -> std::ops::Range<u32> {
        0..self.origins.len() as u32
    }

    /// For each node the number of arcs of the net that end there.
    pub(super) fn degrees(&self) -> Vec<u32> {
        let mut degrees = vec![0; self.points.len()];
        for dart in self.darts().filter(|&dart| self.is_drawn(dart)) {
            degrees[self.origins[dart as usize] as usize] += 1;
        }
        degrees
    }

    /// The area vector of a closed walk of darts.
    pub(super) fn area_vector(&self, darts: impl Iterator<Item = u32> + Clone) -> DVec3 {
        let position = |dart: u32| self.positions[self.origins[dart as usize] as usize];
        let Some(apex) = darts.clone().next().map(position) else {
            return DVec3::ZERO;
        };
        let doubled: DVec3 = darts
            .map(|dart| (position(dart) - apex).cross(position(twin(dart)) - apex))
            .sum();
        doubled / 2.0
    }
}

/// The darts along a halfedge, in its direction.
pub(super) fn border_darts(
    mesh: &TriangleMesh,
    edge_nodes: &EdgeNodes,
    halfedge: HalfedgeId,
) -> impl Iterator<Item = u32> {
    let edge = mesh.edge(halfedge);
    let first = edge_nodes.first_piece(edge) as u32;
    let pieces = edge_nodes.of_edge(edge).len() as u32 + 1;
    let forward = edge_nodes.side(edge) == halfedge;
    (0..pieces).map(move |piece| {
        if forward {
            2 * (first + piece)
        } else {
            2 * (first + pieces - 1 - piece) + 1
        }
    })
}

/// 1 where the map keeps the triangle's orientation, -1 where it turns it over, 0 where it has no
/// area.
pub(super) fn orientation_sign(map: &GridMap, face: FaceId) -> f64 {
    let [a, b, c] = face
        .halfedges()
        .map(|corner| super::line::corner_steps(map, corner));
    let edge = |p: [i64; 2]| [p[0] - a[0], p[1] - a[1]].map(i128::from);
    let (ab, ac) = (edge(b), edge(c));
    (ab[0] * ac[1] - ab[1] * ac[0]).signum() as f64
}
