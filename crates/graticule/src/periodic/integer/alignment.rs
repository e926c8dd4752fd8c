//! Which edges become stretches of lines of the net, and along which axis.

use std::f64::consts::FRAC_PI_2;

use super::frames::FaceFrames;
use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{EdgeId, HalfedgeId, PerCorner, PerEdge, PerVertex, TriangleMesh, VertexId};

/// The edges that lie on lines of the net.
#[derive(Clone, Debug)]
pub(super) struct Alignment {
    /// For each halfedge of such an edge its direction in the axes of its triangle, in quarters.
    pub(super) directions: PerCorner<Option<u8>>,
    /// Edges that were to be aligned and are not, because a corner of the surface would have had
    /// no room in the net.
    pub(super) dropped: Vec<EdgeId>,
}

impl Alignment {
    /// Lays the edges along the nearest axes, and drops those that would make a corner of the
    /// surface flat, or a triangle straight.
    pub(super) fn of(
        mesh: &TriangleMesh,
        triangulation: &IntrinsicTriangulation,
        frames: &FaceFrames,
        wanted: &[EdgeId],
    ) -> Self {
        let mut aligner = Aligner {
            mesh,
            triangulation,
            frames,
            alignment: Self {
                directions: PerCorner::filled(mesh.halfedge_count(), None),
                dropped: Vec::new(),
            },
        };
        for &edge in wanted {
            aligner.lay(edge);
        }
        for &edge in wanted {
            aligner.straighten(edge);
        }
        aligner.drop_slanted(wanted);
        aligner.drop_cramped(wanted);
        aligner.alignment
    }

    /// Turns the axes of triangles with aligned edges so that these run along them, in the mean of
    /// several.
    pub(super) fn snap(
        &self,
        mesh: &TriangleMesh,
        triangulation: &IntrinsicTriangulation,
        frames: &mut FaceFrames,
    ) {
        for face in mesh.faces() {
            let aligned = face.halfedges().into_iter().filter_map(|halfedge| {
                let direction = f64::from(self.directions[halfedge]?);
                Some(centred(
                    frames.direction(triangulation, halfedge) - direction,
                ))
            });
            let (count, sum) = aligned.fold((0, 0.0), |(count, sum), off| (count + 1, sum + off));
            if count > 0 {
                frames.angles[face] += sum / f64::from(count) * FRAC_PI_2;
            }
        }
    }

    /// The aligned edges, one halfedge of each, and the coordinate that is constant along it: 0 or 1.
    pub(super) fn lines<'a>(
        &'a self,
        mesh: &'a TriangleMesh,
    ) -> impl Iterator<Item = (HalfedgeId, usize)> + 'a {
        mesh.edges().filter_map(|edge| {
            let halfedge = mesh.edge_halfedge(edge);
            let direction = self.directions[halfedge]?;
            Some((halfedge, usize::from(direction.is_multiple_of(2))))
        })
    }
}

struct Aligner<'a> {
    mesh: &'a TriangleMesh,
    triangulation: &'a IntrinsicTriangulation,
    frames: &'a FaceFrames,
    alignment: Alignment,
}

/// How far off its axis, in quarters, an edge may belong to the other one as well.
const AMBIGUOUS: f64 = 0.25;

/// How far off, in quarters, an edge inside the surface is not one that the field follows: 27°.
const SLANTED: f64 = 0.3;

/// An aligned edge as it leaves a vertex.
#[derive(Clone, Copy)]
struct Ray {
    edge: EdgeId,
    /// How far it is off its axis, in quarters.
    off: f64,
}

/// The triangles between one aligned edge and the next round a vertex.
struct Sector {
    sides: [Ray; 2],
    /// The angle in the net, in quarters.
    quarters: f64,
    faces: u32,
}

impl Aligner<'_> {
    /// Lays an edge along the axis that is nearest in that of its triangles where it is nearer.
    fn lay(&mut self, edge: EdgeId) {
        let halfedge = self.mesh.edge_halfedge(edge);
        let twin = self.mesh.twin(halfedge);
        let sides = [Some(halfedge), twin];
        let off = |&side: &HalfedgeId| {
            let direction = self.frames.direction(self.triangulation, side);
            (direction - direction.round()).abs()
        };
        let best = sides.into_iter().flatten();
        let Some(best) = best.min_by(|a, b| off(a).total_cmp(&off(b))) else {
            return;
        };
        let direction = self.frames.direction(self.triangulation, best).round() as i32;
        self.alignment.directions[best] = Some(direction.rem_euclid(4) as u8);
        if let Some(other) = self.mesh.twin(best) {
            let there = direction + i32::from(self.frames.turns[best].quarters()) + 2;
            self.alignment.directions[other] = Some(there.rem_euclid(4) as u8);
        }
    }

    /// Gives an edge that is nearly as far from one axis as from the other the one with which the
    /// line has fewer corners.
    fn straighten(&mut self, edge: EdgeId) {
        let halfedge = self.mesh.edge_halfedge(edge);
        let Some(ray) = self.ray(halfedge) else {
            return;
        };
        if ray.off.abs() < AMBIGUOUS {
            return;
        }
        let before = self.corners_at(halfedge);
        let quarter = if ray.off > 0.0 { 1 } else { 3 };
        self.turn(halfedge, quarter);
        if self.corners_at(halfedge) >= before {
            self.turn(halfedge, 4 - quarter);
        }
    }

    /// Turns the direction of an edge by quarters.
    fn turn(&mut self, halfedge: HalfedgeId, quarters: u8) {
        for side in [Some(halfedge), self.mesh.twin(halfedge)]
            .into_iter()
            .flatten()
        {
            let direction = &mut self.alignment.directions[side];
            *direction = direction.map(|direction| (direction + quarters) % 4);
        }
    }

    /// Corners of lines at the ends of an edge.
    fn corners_at(&self, halfedge: HalfedgeId) -> usize {
        let ends = self.mesh.ends(halfedge).into_iter();
        let sectors = ends.flat_map(|vertex| self.sectors(vertex));
        sectors
            .filter(|sector| (sector.quarters - 2.0).abs() > 0.5)
            .count()
    }

    /// Drops edges inside the surface that the field does not follow.
    fn drop_slanted(&mut self, wanted: &[EdgeId]) {
        for &edge in wanted {
            let halfedge = self.mesh.edge_halfedge(edge);
            let is_slanted = |ray: Ray| ray.off.abs() > SLANTED;
            if !self.mesh.is_boundary_edge(edge) && self.ray(halfedge).is_some_and(is_slanted) {
                self.drop(edge);
            }
        }
    }

    fn drop(&mut self, edge: EdgeId) {
        let halfedge = self.mesh.edge_halfedge(edge);
        for side in [Some(halfedge), self.mesh.twin(halfedge)]
            .into_iter()
            .flatten()
        {
            self.alignment.directions[side] = None;
        }
        self.alignment.dropped.push(edge);
    }

    fn drop_cramped(&mut self, wanted: &[EdgeId]) {
        let mut pending: Vec<VertexId> = wanted
            .iter()
            .flat_map(|&edge| self.mesh.ends(self.mesh.edge_halfedge(edge)))
            .collect();
        while let Some(vertex) = pending.pop() {
            let Some(edge) = self.cramped_edge(vertex) else {
                continue;
            };
            self.drop(edge);
            pending.extend(self.mesh.ends(self.mesh.edge_halfedge(edge)));
        }
    }

    /// An edge at the vertex that has to go: the side, farther off its axis, of a sector without
    /// room.
    fn cramped_edge(&self, vertex: VertexId) -> Option<EdgeId> {
        let sector = self.sectors(vertex).into_iter().find(|sector| {
            let straight = 2.0 * f64::from(sector.faces);
            sector.sides[0].edge != sector.sides[1].edge
                && (sector.quarters < 0.5 || sector.quarters > straight - 0.5)
        })?;
        let [first, second] = sector.sides;
        let merit = |ray: Ray| (self.mesh.is_boundary_edge(ray.edge), -ray.off.abs());
        Some(if merit(first) < merit(second) {
            first.edge
        } else {
            second.edge
        })
    }

    fn sectors(&self, vertex: VertexId) -> Vec<Sector> {
        let fan: Vec<HalfedgeId> = self.mesh.outgoing(vertex).collect();
        let is_open = self.mesh.is_boundary_vertex(vertex);
        let start = fan.iter().position(|&h| self.ray(h).is_some());
        let Some(start) = start else {
            return Vec::new();
        };
        let mut sectors = Vec::new();
        let mut open: Option<Sector> = None;
        let count = if is_open {
            fan.len() - start
        } else {
            fan.len()
        };
        for place in 0..count {
            let leaving = fan[(start + place) % fan.len()];
            if let Some(ray) = self.ray(leaving) {
                open = Some(Sector {
                    sides: [ray; 2],
                    quarters: ray.off,
                    faces: 0,
                });
            }
            let Some(sector) = &mut open else { continue };
            let shape = self.triangulation.shape(leaving.face());
            sector.quarters += shape.angle(leaving.side()) / FRAC_PI_2;
            sector.faces += 1;
            let last = leaving.previous();
            if let Some(ray) = self.ray(last) {
                sector.sides[1] = ray;
                sector.quarters -= ray.off;
                sectors.extend(open.take());
            } else {
                sector.quarters += self.mismatch(last);
            }
        }
        sectors
    }

    fn ray(&self, halfedge: HalfedgeId) -> Option<Ray> {
        let direction = f64::from(self.alignment.directions[halfedge]?);
        let real = self.frames.direction(self.triangulation, halfedge);
        Some(Ray {
            edge: self.mesh.edge(halfedge),
            off: centred(real - direction),
        })
    }

    /// What the direction of an edge gains from the halfedge's triangle to its twin's, beside the
    /// turn of the coordinates.
    fn mismatch(&self, halfedge: HalfedgeId) -> f64 {
        let Some(twin) = self.mesh.twin(halfedge) else {
            return 0.0;
        };
        let direction = |side| self.frames.direction(self.triangulation, side);
        let turn = f64::from(self.frames.turns[halfedge].quarters());
        centred(direction(twin) - direction(halfedge) - 2.0 - turn)
    }
}

/// Quarters of a circle, less whole circles, within half a circle.
fn centred(quarters: f64) -> f64 {
    quarters - 4.0 * (quarters / 4.0).round()
}

/// For each vertex the index, in quarters, that gives every corner between aligned edges there the
/// quarters nearest to its angle, at least one: for the corner of a cube one, for a vertex of a
/// smooth line none. 0 on the boundary and where fewer than two such edges meet.
pub(super) fn wished_indices(
    mesh: &TriangleMesh,
    triangulation: &IntrinsicTriangulation,
    wanted: &[EdgeId],
) -> PerVertex<i32> {
    let is_wanted = marked_edges(mesh, wanted);
    PerVertex::from_fn(mesh.vertex_count(), |vertex| {
        let fan: Vec<HalfedgeId> = mesh.outgoing(vertex).collect();
        let starts: Vec<usize> = (0..fan.len())
            .filter(|&place| is_wanted[mesh.edge(fan[place])])
            .collect();
        if mesh.is_boundary_vertex(vertex) || starts.len() < 2 {
            return 0;
        }
        let quarters = starts.iter().enumerate().map(|(number, &start)| {
            let end = starts
                .get(number + 1)
                .map_or(starts[0] + fan.len(), |&end| end);
            let corners = (start..end).map(|place| fan[place % fan.len()]);
            let angles = corners.map(|h| triangulation.shape(h.face()).angle(h.side()));
            (angles.sum::<f64>() / FRAC_PI_2).round().max(1.0) as i32
        });
        4 - quarters.sum::<i32>()
    })
}

/// The edges to be aligned, once each: those given, and the boundary if wanted.
pub(super) fn wanted_edges(
    mesh: &TriangleMesh,
    features: &[EdgeId],
    boundary: bool,
) -> Vec<EdgeId> {
    let is_wanted = marked_edges(mesh, features);
    let edges = mesh.edges();
    edges
        .filter(|&edge| is_wanted[edge] || (boundary && mesh.is_boundary_edge(edge)))
        .collect()
}

/// Marks the vertices of edges.
pub(super) fn ends_of(mesh: &TriangleMesh, edges: &[EdgeId]) -> PerVertex<bool> {
    let mut marked = PerVertex::filled(mesh.vertex_count(), false);
    for &edge in edges {
        for vertex in mesh.ends(mesh.edge_halfedge(edge)) {
            marked[vertex] = true;
        }
    }
    marked
}

/// Marks edges.
pub(super) fn marked_edges(mesh: &TriangleMesh, edges: &[EdgeId]) -> PerEdge<bool> {
    let mut marked = PerEdge::filled(mesh.edge_count(), false);
    for &edge in edges {
        marked[edge] = true;
    }
    marked
}
