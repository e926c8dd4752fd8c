use std::collections::VecDeque;

use super::draft::Draft;
use super::{RepairChanges, RepairError};
use crate::mesh::HalfedgeId;
use crate::mesh::faces::{Faces, TriangleFaces};
use crate::mesh::gluing::{NONE, Patches, glue};
use crate::mesh::measures::{face_shape, largest_of, length};
use crate::tolerance;
use crate::watch::Watch;

/// Operations allowed for each triangle without area. A cap may hand its place on to a neighbour
/// that lies on the same line, and so on; each such step counts.
const OPERATIONS: usize = 32;

/// Removes triangles without area from an oriented manifold draft where the surface stays as it
/// is. Returns whether anything was changed: a triangle dropped may leave a bow-tie behind, and the
/// way free to others once that is parted.
pub(super) fn remove_degenerate(
    draft: &mut Draft,
    changes: &mut RepairChanges,
    watch: &Watch,
) -> Result<bool, RepairError> {
    let flat = flat_triangles(draft);
    if flat.is_empty() {
        return Ok(false);
    }
    let mut surgery = Surgery::new(draft, changes);
    let mut budget = OPERATIONS * flat.len();
    let mut waiting = VecDeque::from(flat);
    let mut stuck = Vec::new();
    let mut progress = false;
    let mut changed = false;
    loop {
        let Some(triangle) = waiting.pop_front() else {
            if !std::mem::replace(&mut progress, false) {
                break;
            }
            // What was done may have cleared the way.
            waiting.extend(stuck.drain(..));
            continue;
        };
        if budget == 0 {
            break;
        }
        budget -= 1;
        // At a vertex of many triangles a single step may take long.
        watch.check()?;
        if !surgery.alive[triangle as usize] || !is_flat(surgery.draft, triangle) {
            continue;
        }
        if surgery.treat(triangle, &mut waiting) {
            (progress, changed) = (true, true);
        } else {
            stuck.push(triangle);
        }
    }
    let alive = surgery.alive;
    draft.retain(&alive);
    Ok(changed)
}

fn flat_triangles(draft: &Draft) -> Vec<u32> {
    let triangles = 0..draft.triangles.len() as u32;
    triangles
        .filter(|&triangle| is_flat(draft, triangle))
        .collect()
}

fn is_flat(draft: &Draft, triangle: u32) -> bool {
    let corners = draft.triangles[triangle as usize].iter();
    let shape = face_shape(corners.map(|&vertex| draft.positions[vertex as usize]));
    shape.height <= tolerance::NO_AREA_HEIGHT
}

/// Drops components all of whose triangles are without area, as they hold no surface, and tells of
/// such triangles that are left in others. Returns whether any was dropped.
pub(super) fn drop_flat_components(draft: &mut Draft, changes: &mut RepairChanges) -> bool {
    let flat = flat_triangles(draft);
    if flat.is_empty() {
        return false;
    }
    let mut is_flat = vec![false; draft.triangles.len()];
    for &triangle in &flat {
        is_flat[triangle as usize] = true;
    }
    let twins = draft.twins();
    let patches = Patches::of(&draft.faces(), &twins);
    let mut has_area = vec![false; patches.count];
    for (&patch, flat) in patches.patch_of_face.iter().zip(is_flat) {
        has_area[patch as usize] |= !flat;
    }
    let keep: Vec<_> = patches
        .patch_of_face
        .iter()
        .map(|&patch| has_area[patch as usize])
        .collect();
    for triangle in flat {
        let polygon = draft.polygons[triangle as usize];
        if keep[triangle as usize] {
            changes.zero_area_left.push(polygon);
        } else {
            changes.zero_area_dropped.push(polygon);
        }
    }
    draft.retain(&keep);
    keep.contains(&false)
}

/// A draft under local changes, with neighbours kept up to date.
struct Surgery<'a> {
    draft: &'a mut Draft,
    changes: &'a mut RepairChanges,
    twins: Vec<u32>,
    /// A side that leaves each vertex, or [`NONE`].
    vertex_sides: Vec<u32>,
    alive: Vec<bool>,
}

impl<'a> Surgery<'a> {
    fn new(draft: &'a mut Draft, changes: &'a mut RepairChanges) -> Self {
        let twins = draft.twins();
        let mut vertex_sides = vec![NONE; draft.positions.len()];
        for (side, &vertex) in (0_u32..).zip(draft.triangles.as_flattened()) {
            vertex_sides[vertex as usize] = side;
        }
        let alive = vec![true; draft.triangles.len()];
        Self {
            draft,
            changes,
            twins,
            vertex_sides,
            alive,
        }
    }

    /// Removes one triangle without area if there is a sound way; new neighbours are to be looked
    /// at again.
    fn treat(&mut self, triangle: u32, waiting: &mut VecDeque<u32>) -> bool {
        let sides = [0, 1, 2].map(|side| 3 * triangle + side);
        let lengths = sides.map(|side| {
            let [from, to] = self.ends(side).map(|v| self.draft.positions[v as usize]);
            length(to - from)
        });
        let [longest, shortest] = [lengths, lengths.map(|length| -length)].map(largest_of);
        if lengths[shortest] <= tolerance::NO_AREA_HEIGHT * lengths[longest] {
            return self.collapse(sides[shortest]);
        }
        let side = sides[longest];
        match self.twins[side as usize] {
            NONE => self.drop_cap(side),
            twin => {
                if !self.exchange(side, twin) {
                    return false;
                }
                waiting.extend([side, twin].map(|side| side / 3));
            }
        }
        true
    }

    fn faces(&self) -> TriangleFaces<'_> {
        self.draft.faces()
    }

    fn ends(&self, side: u32) -> [u32; 2] {
        [self.faces().origin(side), self.faces().destination(side)]
    }

    fn apex(&self, side: u32) -> u32 {
        self.faces().origin(previous(side))
    }

    /// The sides that leave a vertex.
    fn outgoing(&self, vertex: u32) -> Vec<u32> {
        let first = self.vertex_sides[vertex as usize];
        let mut sides = vec![first];
        loop {
            let last = sides[sides.len() - 1];
            match self.twins[previous(last) as usize] {
                NONE => break,
                left if left == first => return sides,
                left => sides.push(left),
            }
        }
        let mut side = first;
        while self.twins[side as usize] != NONE {
            side = next(self.twins[side as usize]);
            sides.push(side);
        }
        sides
    }

    fn neighbors(&self, vertex: u32) -> Vec<u32> {
        let sides = self.outgoing(vertex).into_iter();
        let ends = sides.flat_map(|side| [self.faces().destination(side), self.apex(side)]);
        let mut neighbors: Vec<_> = ends.collect();
        neighbors.sort_unstable();
        neighbors.dedup();
        neighbors
    }

    fn is_boundary_vertex(&self, vertex: u32) -> bool {
        self.outgoing(vertex).into_iter().any(|side| {
            [side, previous(side)]
                .iter()
                .any(|&s| self.twins[s as usize] == NONE)
        })
    }

    fn is_shorter(&self, edge: [u32; 2], other: [u32; 2]) -> bool {
        let [edge, other] = [edge, other].map(|ends| {
            let [from, to] = ends.map(|vertex| self.draft.positions[vertex as usize]);
            length(to - from)
        });
        edge < other
    }

    /// Exchanges the long edge of a cap for the one from its tip to the corner across, unless that
    /// edge exists already. Among triangles on one line edges only get shorter, so that no
    /// exchange is undone.
    fn exchange(&mut self, side: u32, twin: u32) -> bool {
        let [tip, across] = [side, twin].map(|side| self.apex(side));
        let [flat, other] = [side, twin].map(|side| side / 3);
        if tip == across
            || self.neighbors(tip).binary_search(&across).is_ok()
            || (is_flat(self.draft, other) && !self.is_shorter([tip, across], self.ends(side)))
        {
            return false;
        }
        self.changes
            .edges_exchanged
            .push(self.draft.polygons[flat as usize]);
        self.lose_corner(side, next(twin));
        self.lose_corner(next(side), twin);
        let outer = [next(side), previous(side), next(twin), previous(twin)]
            .map(|side| self.twins[side as usize]);
        self.draft.exchange([side, twin]);
        self.draft.polygons[flat as usize] = self.draft.polygons[other as usize];
        // `Draft::exchange` makes (from, across, tip) and (across, to, tip) of the two.
        let inner = [3 * other + 1, 3 * flat + 2, 3 * flat, 3 * other];
        for (side, twin) in inner.into_iter().zip(outer) {
            self.set_twin(side, twin);
        }
        glue(&mut self.twins, 3 * flat + 1, 3 * other + 2);
        for triangle in [flat, other] {
            for side in [0, 1, 2].map(|side| 3 * triangle + side) {
                let origin = self.faces().origin(side);
                self.vertex_sides[origin as usize] = side;
            }
        }
        true
    }

    fn set_twin(&mut self, side: u32, twin: u32) {
        self.twins[side as usize] = twin;
        if twin != NONE {
            self.twins[twin as usize] = side;
        }
    }

    /// Drops a cap whose long edge lies on the boundary: the boundary goes over its tip without
    /// it. A tip that was on the boundary before becomes two vertices.
    fn drop_cap(&mut self, side: u32) {
        let triangle = side / 3;
        let polygon = self.draft.polygons[triangle as usize];
        self.changes.zero_area_dropped.push(polygon);
        self.alive[triangle as usize] = false;
        let tip = self.apex(side);
        let was_boundary = self.is_boundary_vertex(tip);
        for side in [0, 1, 2].map(|side| 3 * triangle + side) {
            let [out, back] = [side, previous(side)].map(|side| self.twins[side as usize]);
            let bearer = if out == NONE { back } else { next(out) };
            let origin = self.faces().origin(side) as usize;
            if bearer != NONE {
                self.lose_corner(side, bearer);
            }
            self.vertex_sides[origin] = bearer;
        }
        let [before_tip, after_tip] =
            [next(side), previous(side)].map(|side| self.twins[side as usize]);
        for side in [0, 1, 2].map(|side| 3 * triangle + side) {
            let twin = std::mem::replace(&mut self.twins[side as usize], NONE);
            if twin != NONE {
                self.twins[twin as usize] = NONE;
            }
        }
        if was_boundary && before_tip != NONE && after_tip != NONE {
            self.split(tip, before_tip);
        }
    }

    /// Gives the fan that holds a side leaving the vertex a vertex of its own.
    fn split(&mut self, vertex: u32, side: u32) {
        let copy = self.draft.positions.len() as u32;
        let source = self.draft.vertex_sources[vertex as usize];
        self.draft
            .positions
            .push(self.draft.positions[vertex as usize]);
        self.draft.vertex_sources.push(source);
        self.vertex_sides.push(side);
        for corner in self.outgoing(copy) {
            self.draft.triangles[corner as usize / 3][corner as usize % 3] = copy;
        }
    }

    /// Collapses an edge if the surface keeps its topology: the link condition of
    /// [Dey, Edelsbrunner, Guha, Nekhayev 1999].
    fn collapse(&mut self, side: u32) -> bool {
        if !self.may_collapse(side) {
            return false;
        }
        let [from, to] = self.ends(side);
        self.changes
            .edges_collapsed
            .push(self.draft.source_edge(side));
        let twin = self.twins[side as usize];
        let [kept, gone] = [from.min(to), from.max(to)];
        let moved = self.outgoing(gone);
        for corner in moved {
            self.draft.triangles[corner as usize / 3][corner as usize % 3] = kept;
        }
        self.vertex_sides[gone as usize] = NONE;
        self.vertex_sides[kept as usize] = NONE;
        for side in [side, twin].into_iter().filter(|&side| side != NONE) {
            self.close_over(side);
        }
        true
    }

    fn may_collapse(&self, side: u32) -> bool {
        let [from, to] = self.ends(side);
        let twin = self.twins[side as usize];
        let mut apexes: Vec<_> = [side, twin]
            .into_iter()
            .filter(|&side| side != NONE)
            .map(|side| self.apex(side))
            .collect();
        apexes.sort_unstable();
        let beside_to = self.neighbors(to);
        let mut common = self.neighbors(from);
        common.retain(|vertex| beside_to.binary_search(vertex).is_ok());
        let pinches = twin != NONE && self.is_boundary_vertex(from) && self.is_boundary_vertex(to);
        common == apexes && !pinches && !self.folds(side) && (twin == NONE || !self.folds(twin))
    }

    /// Whether the two triangles beside the one at `side` would come to lie on the same vertices.
    fn folds(&self, side: u32) -> bool {
        let outer = [next(side), previous(side)].map(|side| self.twins[side as usize]);
        outer.iter().all(|&side| side != NONE) && self.apex(outer[0]) == self.apex(outer[1])
    }

    /// Takes out the triangle at a collapsed side and joins its neighbours.
    fn close_over(&mut self, side: u32) {
        self.alive[side as usize / 3] = false;
        let [after, before] = [next(side), previous(side)];
        // They run from the apex to the merged vertex, and back.
        let [to_merged, from_merged] = [after, before].map(|side| self.twins[side as usize]);
        let [apex, merged] = [self.apex(side), self.faces().origin(side)];
        let mut at_merged = [from_merged, to_merged].into_iter().filter(|&s| s != NONE);
        if let Some(neighbor) = at_merged.next() {
            let corners = [neighbor, next(neighbor)];
            let place =
                |vertex: u32| corners[usize::from(self.faces().origin(corners[0]) != vertex)];
            let [at_merged, at_apex] = [place(merged), place(apex)];
            self.lose_corner(side, at_merged);
            self.lose_corner(after, at_merged);
            self.lose_corner(before, at_apex);
            self.vertex_sides[merged as usize] = at_merged;
            self.vertex_sides[apex as usize] = at_apex;
        } else {
            self.vertex_sides[apex as usize] = NONE;
        }
        if to_merged != NONE {
            self.twins[to_merged as usize] = from_merged;
        }
        if from_merged != NONE {
            self.twins[from_merged as usize] = to_merged;
        }
        for side in [side, after, before] {
            self.twins[side as usize] = NONE;
        }
    }

    fn lose_corner(&mut self, corner: u32, bearer: u32) {
        let sources = self.draft.corner_sources.as_flattened();
        let pair = [corner, bearer].map(|corner| sources[corner as usize]);
        self.draft.stand_ins.push(pair);
    }
}

fn next(side: u32) -> u32 {
    HalfedgeId(side).next().0
}

fn previous(side: u32) -> u32 {
    HalfedgeId(side).previous().0
}
