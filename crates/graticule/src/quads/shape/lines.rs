use glam::DVec3;

use crate::geometry::closest_on_segment;
use crate::mesh::{
    EdgeId, Element, HalfedgeId, PerEdge, PerVertex, Surface, SurfacePoint, VertexId,
};
use crate::tolerance;

/// The lines of a surface that vertices slide along: its boundary and its features.
pub(in crate::quads) struct Lines {
    on_line: PerEdge<bool>,
    /// The two edges of a line at each vertex that it passes; `None` off the lines and where lines
    /// end, meet or bend sharply.
    passing: PerVertex<Option<[EdgeId; 2]>>,
}

impl Lines {
    /// Vertices pass where a line turns by less than the angle with the cosine `corner`.
    pub(in crate::quads) fn new(surface: &Surface, features: &[EdgeId], corner: f64) -> Self {
        let mesh = surface.mesh();
        let mut on_line = PerEdge::from_fn(mesh.edge_count(), |edge| mesh.is_boundary_edge(edge));
        for &edge in features {
            if edge.index() < mesh.edge_count() {
                on_line[edge] = true;
            }
        }
        let mut at_vertex = PerVertex::filled(mesh.vertex_count(), (0_u32, [EdgeId(0); 2]));
        for (edge, _) in on_line.enumerate().filter(|(_, on_line)| **on_line) {
            for vertex in mesh.ends(mesh.edge_halfedge(edge)) {
                let (count, edges) = &mut at_vertex[vertex];
                if let Some(slot) = edges.get_mut(*count as usize) {
                    *slot = edge;
                }
                *count += 1;
            }
        }
        let passing = PerVertex::from_fn(mesh.vertex_count(), |vertex| {
            let (count, edges) = at_vertex[vertex];
            (count == 2 && straightness(surface, vertex, edges) > corner).then_some(edges)
        });
        Self { on_line, passing }
    }

    /// A halfedge of a line that the point lies on and may move along; `None` off the lines and at
    /// their corners.
    pub(super) fn halfedge_at(&self, surface: &Surface, point: SurfacePoint) -> Option<HalfedgeId> {
        let mesh = surface.mesh();
        if let Some(corner) = corner_at(point) {
            let [edge, _] = self.passing[mesh.origin(corner)]?;
            return Some(mesh.edge_halfedge(edge));
        }
        let is_zero = is_zero(point);
        let sides = point.face.halfedges();
        let side = (0..3).find(|&k| is_zero[(k + 2) % 3])?;
        self.on_line[mesh.edge(sides[side])].then_some(sides[side])
    }

    /// The point of the lines through either of two points that is nearest to `target`, of those
    /// reached by walking along them; `None` if both are off the lines.
    pub(in crate::quads) fn between(
        &self,
        surface: &Surface,
        ends: [SurfacePoint; 2],
        target: DVec3,
    ) -> Option<SurfacePoint> {
        let halfedges = ends.iter().flat_map(|&end| self.halfedges_at(surface, end));
        let reached = halfedges.map(|halfedge| {
            let point = self.slide_towards(surface, halfedge, target);
            (point.position(surface).distance_squared(target), point)
        });
        let nearest = reached.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, point)| point)
    }

    /// A halfedge of each line at the point, also where lines end or meet.
    fn halfedges_at(&self, surface: &Surface, point: SurfacePoint) -> Vec<HalfedgeId> {
        let mesh = surface.mesh();
        let Some(corner) = corner_at(point) else {
            return self.halfedge_at(surface, point).into_iter().collect();
        };
        mesh.outgoing(mesh.origin(corner))
            .flat_map(|side| [side, side.previous()])
            .filter(|&side| self.on_line[mesh.edge(side)])
            .collect()
    }

    /// The point reached from the line's halfedge by walking along the line, as far as every step
    /// comes nearer to `target`.
    ///
    /// At a corner, from which no vertex could move on and where another one may be, it stays a
    /// little before the end.
    pub(super) fn slide_towards(
        &self,
        surface: &Surface,
        start: HalfedgeId,
        target: DVec3,
    ) -> SurfacePoint {
        let mesh = surface.mesh();
        let on_halfedge = |halfedge: HalfedgeId| {
            let [from, to] = mesh.ends(halfedge).map(|vertex| surface.position(vertex));
            let share = closest_on_segment([from, to], target);
            (share, from.lerp(to, share).distance_squared(target))
        };
        let mut halfedge = start;
        let (mut share, mut least) = on_halfedge(halfedge);
        loop {
            let end = if share <= 0.0 {
                mesh.origin(halfedge)
            } else if share >= 1.0 {
                mesh.destination(halfedge)
            } else {
                break;
            };
            let Some(edges) = self.passing[end] else {
                share = share.clamp(tolerance::BEFORE_CORNER, 1.0 - tolerance::BEFORE_CORNER);
                break;
            };
            let here = mesh.edge(halfedge);
            let next = mesh.edge_halfedge(if edges[0] == here { edges[1] } else { edges[0] });
            let (next_share, distance) = on_halfedge(next);
            if distance >= least {
                break;
            }
            (halfedge, share, least) = (next, next_share, distance);
        }
        SurfacePoint::on_halfedge(halfedge, share)
    }
}

fn is_zero(point: SurfacePoint) -> [bool; 3] {
    point.barycentric.map(|weight| weight <= tolerance::ON_EDGE)
}

/// The corner that a point lies at.
fn corner_at(point: SurfacePoint) -> Option<HalfedgeId> {
    let is_zero = is_zero(point);
    let corner = (0..3).find(|&k| is_zero[(k + 1) % 3] && is_zero[(k + 2) % 3])?;
    Some(point.face.halfedges()[corner])
}

/// The cosine of the turn of a line at a vertex.
fn straightness(surface: &Surface, vertex: VertexId, edges: [EdgeId; 2]) -> f64 {
    let mesh = surface.mesh();
    let [first, second] = edges.map(|edge| {
        let [a, b] = mesh.ends(mesh.edge_halfedge(edge));
        let other = if a == vertex { b } else { a };
        (surface.position(other) - surface.position(vertex)).normalize_or_zero()
    });
    -first.dot(second)
}
