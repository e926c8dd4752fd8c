use std::ops::Range;

use super::QuadsError;
use super::cells::{Cells, Census, join_faces, prune};
use super::extract::usual_cell_area;
use super::overlay::{ArcKind, Overlay, arc, twin};
use super::rectangles::keep_rectangles;
use crate::mesh::{
    EdgeId, Element, FaceId, HalfedgeId, PerEdge, Surface, SurfacePoint, TriangleMesh, VertexId,
};
use crate::periodic::{GridMap, Transition};
use crate::watch::Watch;

/// Halvings of the lines' distance, at most, in cells that are no disks.
const MOST_HALVINGS: u32 = 2;

/// Arcs on which no line runs, for [`Halvings`].
const NO_LINE: u32 = u32::MAX;

/// A surface cut along the lines of a map into cells that are disks: its triangles cut into flat
/// faces, with the arcs between them, of which some are part of the net.
///
/// Arcs come as two darts, `2a` and `2a + 1`, each with a face on the left. Nodes are numbered so:
/// the vertices of the surface, places on edges, lattice points inside triangles. Arcs so: pieces of
/// edges in the order of the edges, then pieces of lines inside triangles.
pub(crate) struct NetCells {
    overlay: Overlay,
    shape: Pieces,
    /// Lines drawn for each one of the map, where they are closest.
    pub(crate) factor: u32,
    /// Pieces of lines that ended inside a cell and were taken away.
    pub(crate) pruned: usize,
    /// Cells that were no disks, or stood out of the net, and got more lines.
    pub(crate) refined: usize,
    /// Cells that were none still, and were cut along edges.
    pub(crate) split: usize,
}

impl NetCells {
    /// Cuts the surface along the lines, and what is no disk along lines half or a quarter as far
    /// apart ([PGP06] §2.2: there everywhere), and at last along edges.
    ///
    /// # Errors
    /// [`QuadsError::TooFine`], or that it was stopped.
    ///
    /// [PGP06]: crate::papers::PGP06
    pub(crate) fn of(
        surface: &Surface,
        map: &GridMap,
        features: Option<&PerEdge<bool>>,
        watch: &Watch,
    ) -> Result<Self, QuadsError> {
        let mesh = surface.mesh();
        let cell_area = usual_cell_area(surface, map);
        let mut overlay = Overlay::of(surface, map, features, watch)?;
        let (mut factor, mut refined) = (1, 0);
        let mut pruned = prune(&mut overlay);
        let (of_face, count) = join_faces(&overlay);
        let census = Census::of(&overlay, &of_face, count, cell_area);
        if census.has_poor()
            && let Ok(finer) = map.subdivided(mesh, 1 << MOST_HALVINGS)
        {
            refined = census.poor.iter().filter(|&&poor| poor).count();
            factor = 1 << MOST_HALVINGS;
            overlay = Overlay::of(surface, &finer, features, watch)?;
            let pieces = Pieces::of(mesh, &overlay);
            let halvings = pieces.halvings(mesh, &overlay, &finer);
            pruned = draw_where_needed(&mut overlay, &halvings, cell_area);
        }
        let cells = Cells::settle(&mut overlay, cell_area, watch)?;
        Ok(Self {
            shape: Pieces::of(mesh, &overlay),
            overlay,
            factor,
            pruned: pruned + cells.pruned,
            refined,
            split: cells.split,
        })
    }

    /// Cuts the surface into rectangles with sides of about so many lines, as few as singular points
    /// allow; each singular point is a corner of those around it. What is no disk is cut along edges.
    ///
    /// # Errors
    /// [`QuadsError::TooFine`], or that it was stopped.
    pub(crate) fn rectangles(
        surface: &Surface,
        map: &GridMap,
        features: Option<&PerEdge<bool>>,
        spacings: f64,
        watch: &Watch,
    ) -> Result<Self, QuadsError> {
        let mesh = surface.mesh();
        let cell_area = usual_cell_area(surface, map) * spacings * spacings;
        let mut overlay = Overlay::of(surface, map, features, watch)?;
        let is_singular: Vec<bool> = (mesh.vertices())
            .map(|vertex| turns_round(mesh, map, vertex))
            .collect();
        let pruned = keep_rectangles(&mut overlay, &is_singular, spacings, cell_area);
        let cells = Cells::settle(&mut overlay, cell_area, watch)?;
        Ok(Self {
            shape: Pieces::of(mesh, &overlay),
            overlay,
            factor: 1,
            pruned: pruned + cells.pruned,
            refined: 0,
            split: cells.split,
        })
    }

    /// Where each node lies.
    pub(crate) fn points(&self) -> &[SurfacePoint] {
        &self.overlay.points
    }

    /// Whether lines of both families pass through a node.
    pub(crate) fn is_lattice(&self, node: u32) -> bool {
        self.overlay.lattice[node as usize]
    }

    /// The number of arcs.
    pub(crate) fn arc_count(&self) -> usize {
        self.overlay.kinds.len()
    }

    /// The node that a dart leaves from.
    pub(crate) fn origin(&self, dart: u32) -> u32 {
        self.overlay.origins[dart as usize]
    }

    /// The next dart along the same face.
    pub(crate) fn next(&self, dart: u32) -> u32 {
        self.overlay.next[dart as usize]
    }

    /// The face to the left of a dart; `None` beyond the boundary.
    pub(crate) fn face(&self, dart: u32) -> Option<u32> {
        let face = self.overlay.faces[dart as usize];
        ((face as usize) < self.overlay.face_count).then_some(face)
    }

    /// The number of faces.
    pub(crate) fn face_count(&self) -> usize {
        self.overlay.face_count
    }

    /// The triangle of each face.
    pub(crate) fn face_triangles(&self) -> &[FaceId] {
        &self.shape.face_triangles
    }

    /// What the arc of a dart is; [`ArcKind::Inner`] if it is not part of the net.
    pub(crate) fn kind(&self, dart: u32) -> ArcKind {
        self.overlay.kinds[arc(dart)]
    }

    /// Whether the dart runs along an edge of the surface.
    pub(crate) fn is_on_edge(&self, dart: u32) -> bool {
        arc(dart) < self.shape.edge_arc_count()
    }

    /// The nodes inside an edge, and whether they are ordered along its
    /// [`edge_halfedge`](crate::mesh::CornerTable::edge_halfedge).
    pub(crate) fn edge_nodes(&self, mesh: &TriangleMesh, edge: EdgeId) -> (Range<u32>, bool) {
        let first = 2 * self.shape.edge_starts[edge.index()];
        let forward = self.origin(first) == mesh.origin(mesh.edge_halfedge(edge)).0;
        (self.shape.edge_nodes(edge), forward)
    }
}

/// Whether the coordinates turn round a vertex inside the surface.
fn turns_round(mesh: &TriangleMesh, map: &GridMap, vertex: VertexId) -> bool {
    let steps: Option<Vec<Transition>> = (mesh.outgoing(vertex))
        .map(|corner| map.transition(corner.previous()))
        .collect();
    let round = steps.unwrap_or_default().into_iter();
    !(round.fold(Transition::identity(), Transition::then)).is_identity()
}

/// Which arcs and nodes lie on which edge, and which faces in which triangle.
struct Pieces {
    vertex_count: u32,
    /// For each edge its first arc, and the number of all at the end.
    edge_starts: Vec<u32>,
    face_triangles: Vec<FaceId>,
}

/// For each arc how often the number of its line can be halved.
struct Halvings(Vec<u32>);

impl Pieces {
    fn of(mesh: &TriangleMesh, overlay: &Overlay) -> Self {
        let vertex_count = mesh.vertex_count() as u32;
        let mut edge_starts = vec![0];
        let mut next = 0;
        for _ in mesh.edges() {
            while overlay.destination(2 * next) >= vertex_count {
                next += 1;
            }
            next += 1;
            edge_starts.push(next);
        }
        let mut pieces = Self {
            vertex_count,
            edge_starts,
            face_triangles: Vec::with_capacity(overlay.face_count),
        };
        for face in mesh.faces() {
            // The faces of a triangle are numbered in turn, from the one at its first corner on.
            let first =
                overlay.faces[pieces.first_dart(mesh, overlay, face.halfedges()[0]) as usize];
            let before = FaceId(face.0.saturating_sub(1));
            pieces.face_triangles.resize(first as usize, before);
        }
        let last = FaceId(mesh.face_count() as u32 - 1);
        pieces.face_triangles.resize(overlay.face_count, last);
        pieces
    }

    fn edge_arc_count(&self) -> usize {
        self.edge_starts[self.edge_starts.len() - 1] as usize
    }

    fn edge_nodes(&self, edge: EdgeId) -> Range<u32> {
        let [start, end] = [0, 1].map(|next| self.edge_starts[edge.index() + next]);
        let first = self.vertex_count + start - edge.0;
        first..first + (end - start - 1)
    }

    /// The first dart along a halfedge.
    fn first_dart(&self, mesh: &TriangleMesh, overlay: &Overlay, halfedge: HalfedgeId) -> u32 {
        let edge = mesh.edge(halfedge).index();
        let first = 2 * self.edge_starts[edge];
        if overlay.origins[first as usize] == mesh.origin(halfedge).0 {
            first
        } else {
            2 * self.edge_starts[edge + 1] - 1
        }
    }

    fn halvings(&self, mesh: &TriangleMesh, overlay: &Overlay, map: &GridMap) -> Halvings {
        let mut halvings = vec![NO_LINE; overlay.kinds.len()];
        for edge in mesh.edges() {
            let [start, end] = [0, 1].map(|next| self.edge_starts[edge.index() + next] as usize);
            let line = line_along(mesh, map, edge);
            halvings[start..end].fill(line.map_or(NO_LINE, i64::trailing_zeros));
        }
        let places = self.node_places(mesh, overlay);
        for (index, halvings) in halvings.iter_mut().enumerate().skip(self.edge_arc_count()) {
            let dart = 2 * index as u32;
            let face = self.face_triangles[overlay.faces[dart as usize] as usize];
            let [from, to] = [dart, twin(dart)].map(|dart| {
                let node = overlay.origins[dart as usize];
                let point = places.in_triangle(mesh, face, node, overlay);
                point.interpolate(map.face_coordinates(face))
            });
            let middle = ((from + to) / 2.0).round();
            let miss = (from - middle).abs().max((to - middle).abs());
            let line = if miss.x < miss.y { middle.x } else { middle.y };
            *halvings = (line as i64).trailing_zeros();
        }
        Halvings(halvings)
    }

    fn node_places(&self, mesh: &TriangleMesh, overlay: &Overlay) -> NodePlaces {
        let mut edges = Vec::new();
        for edge in mesh.edges() {
            let forward = mesh.edge_halfedge(edge);
            for node in self.edge_nodes(edge) {
                let point = overlay.points[node as usize];
                let share = if point.face == forward.face() {
                    point.barycentric[forward.next().side()]
                } else {
                    mesh.twin(forward)
                        .map_or(0.0, |twin| point.barycentric[twin.side()])
                };
                edges.push((edge, share));
            }
        }
        NodePlaces {
            vertex_count: self.vertex_count,
            edges,
        }
    }
}

/// On which edge, and where along its first halfedge, each node of an edge lies.
struct NodePlaces {
    vertex_count: u32,
    edges: Vec<(EdgeId, f64)>,
}

impl NodePlaces {
    /// A node as a point of a triangle that it touches.
    fn in_triangle(
        &self,
        mesh: &TriangleMesh,
        face: FaceId,
        node: u32,
        overlay: &Overlay,
    ) -> SurfacePoint {
        if node < self.vertex_count {
            let corner = (face.halfedges().into_iter()).find(|&c| mesh.origin(c).0 == node);
            return SurfacePoint::at_corner(corner.unwrap_or(face.halfedges()[0]));
        }
        let Some(&(edge, share)) = self.edges.get((node - self.vertex_count) as usize) else {
            return overlay.points[node as usize];
        };
        let side = mesh.edge_halfedge(edge);
        match mesh.twin(side).filter(|twin| twin.face() == face) {
            Some(twin) => SurfacePoint::on_halfedge(twin, 1.0 - share),
            None => SurfacePoint::on_halfedge(side, share),
        }
    }
}

/// The number of the line along an edge; of two the one that can be halved more often.
fn line_along(mesh: &TriangleMesh, map: &GridMap, edge: EdgeId) -> Option<i64> {
    let first = mesh.edge_halfedge(edge);
    let sides = [Some(first), mesh.twin(first)];
    let side = (sides.into_iter().flatten()).find(|side| !map.is_left_out(side.face()))?;
    let [from, to] = [side, side.next()].map(|corner| map.coordinate(corner));
    let on_line: [bool; 2] = (from.cmpeq(to) & from.cmpeq(from.round())).into();
    let lines = on_line.into_iter().zip(from.to_array());
    lines
        .filter(|&(on_line, _)| on_line)
        .map(|(_, line)| line as i64)
        .max_by_key(|line| line.trailing_zeros())
}

/// Of lines at a fraction of the map's distance leaves those of the map, and others only in cells
/// that are no disks without. Returns how many pieces were taken away because they ended in a cell.
fn draw_where_needed(overlay: &mut Overlay, halvings: &Halvings, cell_area: f64) -> usize {
    let is_line = |kind: ArcKind| kind == ArcKind::Line;
    for (kind, &halvings) in overlay.kinds.iter_mut().zip(&halvings.0) {
        if is_line(*kind) && halvings < MOST_HALVINGS {
            *kind = ArcKind::Inner;
        }
    }
    let mut pruned = prune(overlay);
    for level in (0..MOST_HALVINGS).rev() {
        let (of_face, count) = join_faces(overlay);
        let census = Census::of(overlay, &of_face, count, cell_area);
        if !census.has_poor() {
            break;
        }
        let is_poor = |dart: usize| {
            let face = overlay.faces[dart] as usize;
            (of_face.get(face)).is_some_and(|&cell| census.poor[cell as usize])
        };
        let shown: Vec<usize> = (0..overlay.kinds.len())
            .filter(|&arc| overlay.kinds[arc] == ArcKind::Inner)
            .filter(|&arc| halvings.0[arc] >= level && halvings.0[arc] != NO_LINE)
            .filter(|&arc| is_poor(2 * arc))
            .collect();
        for arc in shown {
            overlay.kinds[arc] = ArcKind::Line;
        }
        pruned += prune(overlay);
    }
    pruned
}
