//! How faces hang together: sides that lie on one edge, patches joined along edges, fans of faces
//! around vertices, boundary loops. Faces need be neither manifold nor oriented.

use super::disjoint_sets::{DisjointSets, number_names};
use super::faces::Faces;

/// No element.
pub(super) const NONE: u32 = u32::MAX;

/// The sides of all faces, grouped by the edge they lie on.
#[derive(Clone, Debug)]
pub(super) struct EdgeUses {
    corners: Vec<u32>,
    starts: Vec<u32>,
}

impl EdgeUses {
    /// Groups the sides; each is named by the corner it starts from, in ascending order.
    ///
    /// Cost: the sides are bucketed by their smaller vertex and each bucket is sorted.
    pub(super) fn of(faces: &impl Faces, vertex_count: usize) -> Self {
        let sides = 0..faces.corner_count() as u32;
        let mut bucket_starts = vec![0_u32; vertex_count + 1];
        for side in sides.clone() {
            bucket_starts[faces.edge(side)[0] as usize + 1] += 1;
        }
        for vertex in 0..vertex_count {
            bucket_starts[vertex + 1] += bucket_starts[vertex];
        }
        let mut filled = bucket_starts.clone();
        let mut bucketed = vec![(0_u32, 0_u32); faces.corner_count()];
        for side in sides {
            let [smaller, larger] = faces.edge(side);
            let slot = &mut filled[smaller as usize];
            bucketed[*slot as usize] = (larger, side);
            *slot += 1;
        }
        let mut starts = Vec::with_capacity(faces.corner_count() / 2 + 1);
        for range in bucket_starts.windows(2) {
            let bucket = &mut bucketed[range[0] as usize..range[1] as usize];
            bucket.sort_unstable();
            let mut start = range[0];
            for group in bucket.chunk_by(|a, b| a.0 == b.0) {
                starts.push(start);
                start += group.len() as u32;
            }
        }
        starts.push(faces.corner_count() as u32);
        let corners = bucketed.into_iter().map(|(_, side)| side).collect();
        Self { corners, starts }
    }

    /// The sides on each edge in turn.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.starts
            .windows(2)
            .map(|range| &self.corners[range[0] as usize..range[1] as usize])
    }

    /// Whether an edge has more than two sides.
    pub(super) fn is_crowded(&self) -> bool {
        self.iter().any(|group| group.len() > 2)
    }

    /// For each side the other one on its edge, or [`NONE`] where the edge has not just two.
    pub(super) fn twins(&self) -> Vec<u32> {
        let mut twins = vec![NONE; self.corners.len()];
        for group in self.iter() {
            if let &[first, second] = group {
                glue(&mut twins, first, second);
            }
        }
        twins
    }
}

/// Makes two sides each other's twin.
pub(super) fn glue(twins: &mut [u32], first: u32, second: u32) {
    twins[first as usize] = second;
    twins[second as usize] = first;
}

/// Whether two faces run in the same direction along their common edge.
pub(super) fn same_direction(faces: &impl Faces, side: u32, twin: u32) -> bool {
    faces.origin(side) == faces.origin(twin)
}

/// Faces joined by glued sides, each patch oriented like most of its faces.
#[derive(Clone, Debug)]
pub(super) struct Patches {
    /// The patch of each face; patches are numbered by their first face.
    pub(super) patch_of_face: Vec<u32>,
    /// Whether a face must be turned round to agree with its patch.
    pub(super) reversed: Vec<bool>,
    /// One side of each glued pair that cannot be made to agree: the patch is not orientable.
    pub(super) conflicts: Vec<u32>,
    pub(super) count: usize,
}

impl Patches {
    pub(super) fn of(faces: &impl Faces, twins: &[u32]) -> Self {
        let mut patches = Self {
            patch_of_face: vec![NONE; faces.face_count()],
            reversed: vec![false; faces.face_count()],
            conflicts: Vec::new(),
            count: 0,
        };
        let mut members = Vec::new();
        for first in 0..faces.face_count() as u32 {
            if patches.patch_of_face[first as usize] == NONE {
                patches.flood(faces, twins, first, &mut members);
                patches.side_with_the_majority(&members);
                patches.count += 1;
            }
        }
        patches.find_conflicts(faces, twins);
        patches
    }

    fn flood(&mut self, faces: &impl Faces, twins: &[u32], first: u32, members: &mut Vec<u32>) {
        let patch = self.count as u32;
        self.patch_of_face[first as usize] = patch;
        members.clear();
        members.push(first);
        let mut next = 0;
        while next < members.len() {
            let face = members[next];
            next += 1;
            for side in faces.corners(face) {
                let twin = twins[side as usize];
                if twin == NONE || self.patch_of_face[faces.face(twin) as usize] != NONE {
                    continue;
                }
                let neighbor = faces.face(twin);
                self.patch_of_face[neighbor as usize] = patch;
                self.reversed[neighbor as usize] =
                    self.reversed[face as usize] ^ same_direction(faces, side, twin);
                members.push(neighbor);
            }
        }
    }

    /// Of the two ways to orient a patch takes the one that turns fewer faces; among equals the
    /// one that leaves the first face.
    fn side_with_the_majority(&mut self, members: &[u32]) {
        let turned = members
            .iter()
            .filter(|&&face| self.reversed[face as usize])
            .count();
        if 2 * turned > members.len() {
            for &face in members {
                self.reversed[face as usize] ^= true;
            }
        }
    }

    fn find_conflicts(&mut self, faces: &impl Faces, twins: &[u32]) {
        for side in 0..faces.corner_count() as u32 {
            let twin = twins[side as usize];
            if twin == NONE || twin < side {
                continue;
            }
            let [first, second] = [side, twin].map(|side| faces.face(side) as usize);
            if self.reversed[first] ^ self.reversed[second] != same_direction(faces, side, twin) {
                self.conflicts.push(side);
            }
        }
    }
}

/// For each corner the smallest corner of its fan: the corners at one vertex that glued sides
/// join. A vertex with one fan is manifold.
pub(super) fn fans(faces: &impl Faces, twins: &[u32]) -> Vec<u32> {
    let mut fans = vec![NONE; faces.corner_count()];
    for first in 0..faces.corner_count() as u32 {
        if fans[first as usize] == NONE {
            fans[first as usize] = first;
            for leave_by_own_side in [true, false] {
                walk_fan(faces, twins, first, leave_by_own_side, &mut fans);
            }
        }
    }
    fans
}

/// Walks around a vertex from its corner `first`, leaving each face by the side it was not entered
/// by, to the boundary or a corner seen before.
fn walk_fan(
    faces: &impl Faces,
    twins: &[u32],
    first: u32,
    mut leave_by_own_side: bool,
    fans: &mut [u32],
) {
    let vertex = faces.origin(first);
    let mut corner = first;
    loop {
        let side = if leave_by_own_side {
            corner
        } else {
            faces.previous(corner)
        };
        let twin = twins[side as usize];
        if twin == NONE {
            return;
        }
        leave_by_own_side = faces.origin(twin) != vertex;
        corner = if leave_by_own_side {
            faces.next(twin)
        } else {
            twin
        };
        if fans[corner as usize] != NONE {
            return;
        }
        fans[corner as usize] = first;
    }
}

/// Joins the corners at both ends of two sides of one edge.
pub(super) fn join_ends(sets: &mut DisjointSets, faces: &impl Faces, side: u32, twin: u32) {
    let [after_side, after_twin] = [faces.next(side), faces.next(twin)];
    if same_direction(faces, side, twin) {
        sets.join(side, twin);
        sets.join(after_side, after_twin);
    } else {
        sets.join(side, after_twin);
        sets.join(after_side, twin);
    }
}

/// Vertices made of fans.
#[derive(Clone, Debug)]
pub(super) struct FanVertices {
    /// The vertex of each corner.
    pub(super) corner_vertices: Vec<u32>,
    /// For each vertex the one it was made of. The first fan of every vertex comes first, in the
    /// order of those vertices; further fans follow in the order of their corners.
    pub(super) sources: Vec<u32>,
}

/// Gives every fan a vertex of its own; unused vertices go.
pub(super) fn number_fans(faces: &impl Faces, fans: &[u32], vertex_count: usize) -> FanVertices {
    let mut first_fans = vec![NONE; vertex_count];
    let mut further = Vec::new();
    for (corner, &fan) in fans.iter().enumerate() {
        let slot = &mut first_fans[faces.origin(corner as u32) as usize];
        if *slot == NONE {
            *slot = fan;
        } else if fan == corner as u32 {
            further.push(fan);
        }
    }
    let firsts = first_fans.iter().copied().filter(|&fan| fan != NONE);
    let mut numbers = vec![NONE; fans.len()];
    let mut sources = Vec::new();
    for fan in firsts.chain(further) {
        numbers[fan as usize] = sources.len() as u32;
        sources.push(faces.origin(fan));
    }
    let corner_vertices = fans.iter().map(|&fan| numbers[fan as usize]).collect();
    FanVertices {
        corner_vertices,
        sources,
    }
}

/// The boundary loop of each side without twin, and the number of loops; [`NONE`] elsewhere.
pub(super) fn boundary_loops(faces: &impl Faces, twins: &[u32], fans: &[u32]) -> (Vec<u32>, usize) {
    let mut sets = DisjointSets::new(fans.len());
    let is_boundary = |side: u32| twins[side as usize] == NONE;
    let sides = (0..fans.len() as u32).filter(|&side| is_boundary(side));
    for side in sides.clone() {
        sets.join(fans[side as usize], fans[faces.next(side) as usize]);
    }
    let mut names: Vec<u32> = sides.clone().map(|side| fans[side as usize]).collect();
    for name in &mut names {
        *name = sets.find(*name);
    }
    let mut numbered = vec![NONE; fans.len()];
    let mut order = NumberedNames::new(fans.len());
    for (side, name) in sides.zip(names) {
        numbered[side as usize] = order.number(name);
    }
    (numbered, order.count as usize)
}

/// Numbers given to names in the order of their first appearance.
struct NumberedNames {
    numbers: Vec<u32>,
    count: u32,
}

impl NumberedNames {
    fn new(names: usize) -> Self {
        Self {
            numbers: vec![NONE; names],
            count: 0,
        }
    }

    fn number(&mut self, name: u32) -> u32 {
        let number = &mut self.numbers[name as usize];
        if *number == NONE {
            *number = self.count;
            self.count += 1;
        }
        *number
    }
}

/// Components of faces that share an edge, however many faces it has: the component of each face,
/// numbered by first face, and their number.
pub(super) fn edge_components(faces: &impl Faces, uses: &EdgeUses) -> (Vec<u32>, usize) {
    let mut sets = DisjointSets::new(faces.face_count());
    for group in uses.iter() {
        for pair in group.windows(2) {
            sets.join(faces.face(pair[0]), faces.face(pair[1]));
        }
    }
    let mut components = sets.into_names();
    let count = number_names(&mut components);
    (components, count)
}
