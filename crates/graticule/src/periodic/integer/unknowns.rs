//! The coordinates of every corner in terms of real and whole unknowns.

use glam::DVec3;

use super::alignment::Alignment;
use super::cut::{Cut, Jump};
use super::form::Form;
use super::frames::FaceFrames;
use crate::mesh::{
    Element, HalfedgeId, PerComponent, PerCorner, PerVertex, Topology, TriangleMesh, VertexId,
};
use crate::periodic::QuarterTurn;

/// What a coordinate of a vertex is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// A real unknown.
    Real(u32),
    /// A sum of whole unknowns, by its number.
    Whole(u32),
}

/// How corners depend on the unknowns.
///
/// Each vertex has coordinates in the triangle of its first outgoing halfedge; those of its other
/// corners follow by the jumps on the way round. Whole unknowns are the shifts of the chains of the
/// cut, the places of singular vertices, and the constant coordinate of each line to be followed.
#[derive(Clone, Debug)]
pub(super) struct Unknowns {
    /// The jump from the vertex's own triangle to each corner's.
    pub(super) jumps: PerCorner<Jump>,
    /// Both coordinates of each vertex.
    pub(super) slots: PerVertex<[Slot; 2]>,
    /// The sums that [`Slot::Whole`] names.
    pub(super) sums: Vec<Form>,
    /// Number of real unknowns.
    pub(super) reals: usize,
    /// Number of whole unknowns.
    pub(super) wholes: usize,
    /// Sums of whole unknowns that have to vanish.
    pub(super) equations: Vec<Form>,
    /// The first unknown that is not the shift of a chain.
    pub(super) after_chains: u32,
    /// Singular vertices inside the surface.
    pub(super) singular: Vec<VertexId>,
}

/// The unknown, and its sign, that a turned pair of unknowns has as its coordinate 0 or 1.
pub(super) fn turned(turn: QuarterTurn, coordinate: usize) -> (usize, i64) {
    match (turn.quarters(), coordinate) {
        (0, _) => (coordinate, 1),
        (2, _) => (coordinate, -1),
        (1, 0) | (3, 1) => (1 - coordinate, -1),
        _ => (1 - coordinate, 1),
    }
}

impl Unknowns {
    pub(super) fn of(
        mesh: &TriangleMesh,
        frames: &FaceFrames,
        cut: &Cut,
        alignment: &Alignment,
    ) -> Self {
        let mut builder = Builder::new(mesh, frames, cut);
        builder.pin_components(alignment);
        builder.place_singular_vertices();
        builder.follow_lines(alignment);
        builder.close_fans(frames, cut);
        builder.finish()
    }

    /// What a coordinate of a corner is but for shifts, and its sign.
    pub(super) fn slot(
        &self,
        mesh: &TriangleMesh,
        corner: HalfedgeId,
        coordinate: usize,
    ) -> (Slot, i64) {
        let (which, sign) = turned(self.jumps[corner].turn, coordinate);
        (self.slots[mesh.origin(corner)][which], sign)
    }

    /// The points where real unknowns lie, and for each of these the number of its point.
    pub(super) fn points(&self, positions: &PerVertex<DVec3>) -> (Vec<DVec3>, Vec<u32>) {
        let mut points = Vec::with_capacity(self.slots.len());
        let mut point_of = Vec::with_capacity(self.reals);
        for (slots, &position) in self.slots.iter().zip(positions) {
            let reals = slots.iter().filter(|slot| matches!(slot, Slot::Real(_)));
            let before = point_of.len();
            point_of.extend(reals.map(|_| points.len() as u32));
            if point_of.len() > before {
                points.push(position);
            }
        }
        (points, point_of)
    }

    /// A coordinate of the shifts in a jump, as a sum of whole unknowns.
    pub(super) fn shift(jump: &Jump, coordinate: usize) -> Form {
        let mut sum = Form::default();
        for shift in &jump.shifts {
            let (which, sign) = turned(shift.turn, coordinate);
            sum.add(sign, &Form::unknown(2 * shift.chain + which as u32));
        }
        sum
    }
}

/// A line edge as a relation between a coordinate of each of its ends.
#[derive(Clone, Copy)]
struct Link {
    /// The corners at its ends, in one triangle.
    corners: [HalfedgeId; 2],
    /// The coordinate there that is the same at both.
    coordinate: usize,
}

struct Builder<'a> {
    mesh: &'a TriangleMesh,
    jumps: PerCorner<Jump>,
    sum_of: PerVertex<[Option<u32>; 2]>,
    sums: Vec<Form>,
    wholes: u32,
    equations: Vec<Form>,
    after_chains: u32,
    singular: Vec<VertexId>,
}

impl<'a> Builder<'a> {
    fn new(mesh: &'a TriangleMesh, frames: &FaceFrames, cut: &Cut) -> Self {
        let mut jumps = PerCorner::filled(mesh.halfedge_count(), Jump::default());
        for vertex in mesh.vertices() {
            let mut jump = Jump::default();
            for halfedge in mesh.outgoing(vertex) {
                jumps[halfedge] = jump.clone();
                jump.across(&frames.turns, cut, halfedge.previous());
            }
        }
        let is_singular =
            |vertex: &VertexId| frames.steps[*vertex] != 0 && !mesh.is_boundary_vertex(*vertex);
        let after_chains = 2 * cut.chains as u32;
        Self {
            mesh,
            jumps,
            sum_of: PerVertex::filled(mesh.vertex_count(), [None; 2]),
            sums: Vec::new(),
            wholes: after_chains,
            equations: Vec::new(),
            after_chains,
            singular: mesh.vertices().filter(is_singular).collect(),
        }
    }

    fn set(&mut self, vertex: VertexId, coordinate: usize, sum: Form) {
        self.sum_of[vertex][coordinate] = Some(self.sums.len() as u32);
        self.sums.push(sum);
    }

    fn new_whole(&mut self) -> Form {
        self.wholes += 1;
        Form::unknown(self.wholes - 1)
    }

    /// Holds one vertex of each component at the origin: a singular one if there is one, else one
    /// on many lines. Moving a whole component by whole numbers makes no difference, nor by real
    /// ones along a coordinate that no line fixes.
    fn pin_components(&mut self, alignment: &Alignment) {
        let mesh = self.mesh;
        let mut merits = PerVertex::filled(mesh.vertex_count(), 0);
        for (halfedge, coordinate) in alignment.lines(mesh) {
            for corner in [halfedge, halfedge.next()] {
                let (which, _) = turned(self.jumps[corner].turn, coordinate);
                merits[mesh.origin(corner)] |= 1 << which;
            }
        }
        for &vertex in &self.singular {
            merits[vertex] = 4;
        }
        let components = Topology::of(mesh);
        let mut pins = PerComponent::filled(components.components.len(), None);
        for vertex in mesh.vertices() {
            let pin: &mut Option<VertexId> =
                &mut pins[components.face_components[mesh.vertex_halfedge(vertex).face()]];
            if pin.is_none_or(|pin| merits[vertex] > merits[pin]) {
                *pin = Some(vertex);
            }
        }
        for &pin in pins.iter().flatten() {
            for coordinate in 0..2 {
                self.set(pin, coordinate, Form::default());
            }
        }
    }

    fn place_singular_vertices(&mut self) {
        for vertex in self.singular.clone() {
            for coordinate in 0..2 {
                if self.sum_of[vertex][coordinate].is_none() {
                    let place = self.new_whole();
                    self.set(vertex, coordinate, place);
                }
            }
        }
    }

    /// Carries the constant coordinate of each line from vertex to vertex.
    fn follow_lines(&mut self, alignment: &Alignment) {
        let links: Vec<Link> = alignment
            .lines(self.mesh)
            .map(|(halfedge, coordinate)| Link {
                corners: [halfedge, halfedge.next()],
                coordinate,
            })
            .collect();
        let mut at_node = vec![Vec::new(); 2 * self.mesh.vertex_count()];
        for (number, link) in links.iter().enumerate() {
            for end in 0..2 {
                at_node[self.node(link, end)].push((number, end));
            }
        }
        let mut is_used = vec![false; links.len()];
        let known = (0..at_node.len()).filter(|&node| self.known(node).is_some());
        let seeds: Vec<usize> = known.chain(0..at_node.len()).collect();
        for seed in seeds {
            if at_node[seed].is_empty() {
                continue;
            }
            if self.known(seed).is_none() {
                let line = self.new_whole();
                self.set(VertexId::from_index(seed / 2), seed % 2, line);
            }
            let mut pending = vec![seed];
            while let Some(node) = pending.pop() {
                for &(number, end) in &at_node[node] {
                    if !std::mem::replace(&mut is_used[number], true) {
                        pending.extend(self.carry(&links[number], end));
                    }
                }
            }
        }
    }

    fn node(&self, link: &Link, end: usize) -> usize {
        let corner = link.corners[end];
        let (which, _) = turned(self.jumps[corner].turn, link.coordinate);
        2 * self.mesh.origin(corner).index() + which
    }

    fn known(&self, node: usize) -> Option<u32> {
        self.sum_of[VertexId::from_index(node / 2)][node % 2]
    }

    /// Goes along a line edge from one end, whose coordinate is known. The other end gets its
    /// coordinate, or, if it has one, an equation. Gives the other end where it is new.
    fn carry(&mut self, link: &Link, end: usize) -> Option<usize> {
        let [here, there] = [link.corners[end], link.corners[1 - end]];
        let constant = self.corner_sum(here, link.coordinate)?;
        let jump = &self.jumps[there];
        let (_, sign) = turned(jump.turn, link.coordinate);
        let mut sum = Form::default();
        sum.add(sign, &constant);
        sum.add(-sign, &Unknowns::shift(jump, link.coordinate));
        let node = self.node(link, 1 - end);
        if let Some(known) = self.known(node) {
            sum.add(-1, &self.sums[known as usize]);
            self.require(sum);
            return None;
        }
        self.set(VertexId::from_index(node / 2), node % 2, sum);
        Some(node)
    }

    /// A coordinate of a corner, where it is a sum of whole unknowns.
    fn corner_sum(&self, corner: HalfedgeId, coordinate: usize) -> Option<Form> {
        let jump = &self.jumps[corner];
        let (which, sign) = turned(jump.turn, coordinate);
        let own = self.sum_of[self.mesh.origin(corner)][which]?;
        let mut sum = Unknowns::shift(jump, coordinate);
        sum.add(sign, &self.sums[own as usize]);
        Some(sum)
    }

    fn require(&mut self, sum: Form) {
        if !sum.is_zero() {
            self.equations.push(sum);
        }
    }

    /// Where chains meet, going round the vertex must come back to the same coordinates.
    fn close_fans(&mut self, frames: &FaceFrames, cut: &Cut) {
        for &vertex in &cut.nodes {
            let mut round = Jump::default();
            for halfedge in self.mesh.outgoing(vertex) {
                round.across(&frames.turns, cut, halfedge.previous());
            }
            for coordinate in 0..2 {
                let mut sum = Unknowns::shift(&round, coordinate);
                let (which, sign) = turned(round.turn, coordinate);
                for (place, factor) in [(which, sign), (coordinate, -1)] {
                    if let Some(own) = self.sum_of[vertex][place] {
                        sum.add(factor, &self.sums[own as usize]);
                    }
                }
                self.require(sum);
            }
        }
    }

    fn finish(self) -> Unknowns {
        let mut reals = 0;
        let slots = self.sum_of.map(|coordinates| {
            coordinates.map(|sum| {
                sum.map_or_else(
                    || {
                        reals += 1;
                        Slot::Real(reals - 1)
                    },
                    Slot::Whole,
                )
            })
        });
        Unknowns {
            jumps: self.jumps,
            slots,
            sums: self.sums,
            reals: reals as usize,
            wholes: self.wholes as usize,
            equations: self.equations,
            after_chains: self.after_chains,
            singular: self.singular,
        }
    }
}
