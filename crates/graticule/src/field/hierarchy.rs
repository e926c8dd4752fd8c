//! Coarser and coarser forms of a graph of phases: groups of nodes move as one, each by the rotation
//! that links it to its group.

use glam::{DVec2, DVec3};

use super::phase_graph::{Coupling, PhaseGraph, mirrored};
use crate::tolerance::LIKE_LENGTHS;
use crate::watch::{Stopped, Watch};

/// A fine node by its coarse one: `x = rotation · X`, or `rotation · conj X`.
#[derive(Clone, Copy, Debug)]
struct Member {
    group: u32,
    is_mirrored: bool,
    rotation: DVec2,
}

const UNASSIGNED: Member = Member {
    group: u32::MAX,
    is_mirrored: false,
    rotation: DVec2::X,
};

impl Member {
    fn is_assigned(self) -> bool {
        self.group != u32::MAX
    }

    /// The member that has `coupling` to this one.
    fn linked(self, coupling: &Coupling) -> Self {
        let own = mirrored(self.rotation, coupling.is_mirrored);
        Self {
            group: self.group,
            is_mirrored: self.is_mirrored != coupling.is_mirrored,
            rotation: coupling.factor.rotate(own).normalize_or(DVec2::X),
        }
    }

    fn value(self, groups: &[DVec2]) -> DVec2 {
        let group = mirrored(groups[self.group as usize], self.is_mirrored);
        self.rotation.rotate(group)
    }
}

/// A level: the form on groups of the nodes below.
struct Level {
    graph: PhaseGraph,
    members: Vec<Member>,
}

/// Coarsening that leaves more than this share of the nodes has come to where fields turn too much
/// for groups to hold together.
const STALLED: f64 = 0.8;

/// A form and its coarser versions.
///
/// The groups are those of algebraic multigrid without smoothing, with a rotation for each member
/// (the Galerkin form is of the same kind), so that a field without curl has its exact phases after
/// the way down. Groups do not bend, so that on each level what varies slowly costs more, by the ratio
/// of the distances between nodes: next to what else draws the nodes, coarse links are stiff.
///
/// Cost: linear.
pub(crate) struct Hierarchy<'a> {
    finest: &'a PhaseGraph,
    levels: Vec<Level>,
}

impl<'a> Hierarchy<'a> {
    /// Coarsens until at most so many nodes are left, or as long as nodes hang together.
    pub(crate) fn new(
        finest: &'a PhaseGraph,
        most_nodes: usize,
        watch: &Watch,
    ) -> Result<Self, Stopped> {
        let levels = Vec::new();
        let mut hierarchy = Self { finest, levels };
        loop {
            watch.check()?;
            let graph = hierarchy.coarsest();
            let count = graph.count();
            if count <= most_nodes {
                break;
            }
            let level = coarsened(graph);
            if level.graph.count() as f64 > STALLED * count as f64 {
                break;
            }
            hierarchy.levels.push(level);
        }
        Ok(hierarchy)
    }

    pub(crate) fn coarsest(&self) -> &PhaseGraph {
        self.levels.last().map_or(self.finest, |level| &level.graph)
    }

    /// The number of levels above the finest.
    pub(crate) fn depth(&self) -> usize {
        self.levels.len()
    }

    /// Sums over the coarsest nodes of what the finest have.
    pub(crate) fn sums(&self, mut values: Vec<f64>) -> Vec<f64> {
        for level in &self.levels {
            let mut sums = vec![0.0; level.graph.count()];
            for (member, value) in level.members.iter().zip(values) {
                sums[member.group as usize] += value;
            }
            values = sums;
        }
        values
    }

    /// For each coarsest node one of the points of its finest nodes.
    pub(crate) fn points(&self, mut points: Vec<DVec3>) -> Vec<DVec3> {
        for level in &self.levels {
            let mut chosen = vec![DVec3::ZERO; level.graph.count()];
            for (member, point) in level.members.iter().zip(points) {
                chosen[member.group as usize] = point;
            }
            points = chosen;
        }
        points
    }

    /// Takes values of the coarsest nodes to the finest; on each level on the way, `better` improves
    /// them.
    pub(crate) fn carried_down<E: From<Stopped>>(
        &self,
        mut values: Vec<DVec2>,
        watch: &Watch,
        mut better: impl FnMut(&PhaseGraph, &mut [DVec2]) -> Result<(), E>,
    ) -> Result<Vec<DVec2>, E> {
        for (depth, level) in self.levels.iter().enumerate().rev() {
            watch.check()?;
            let members = level.members.iter();
            values = members.map(|member| member.value(&values)).collect();
            let finer = depth
                .checked_sub(1)
                .map_or(self.finest, |finer| &self.levels[finer].graph);
            better(finer, &mut values)?;
        }
        Ok(values)
    }
}

/// The form with one node for each group of nodes.
fn coarsened(graph: &PhaseGraph) -> Level {
    let Groups { members, is_image } = Groups::of(graph);
    let count = is_image.len();
    let mut diagonal = vec![0.0; count];
    let mut anchors = vec![DVec2::ZERO; count];
    let mut masses = vec![0.0; count];
    // So that the first member starts where it wants to.
    let mut starts_from = vec![DVec2::ZERO; count];
    let mut rows = CoarseRows::new(count);
    for fine in in_order_of_groups(&members, count) {
        let member = members[fine];
        let group = member.group as usize;
        let back = mirrored(member.rotation, true);
        if starts_from[group] == DVec2::ZERO {
            let start = back.rotate(graph.starts_from[fine]);
            starts_from[group] = mirrored(start, member.is_mirrored);
        }
        diagonal[group] += graph.diagonal[fine];
        masses[group] += graph.masses[fine];
        anchors[group] += mirrored(back.rotate(graph.anchors[fine]), member.is_mirrored);
        for coupling in graph.couplings(fine) {
            let other = members[coupling.node as usize];
            let there = mirrored(other.rotation, coupling.is_mirrored);
            let factor = back.rotate(coupling.factor.rotate(there));
            let coarse = Coupling {
                node: other.group,
                is_mirrored: member.is_mirrored ^ other.is_mirrored ^ coupling.is_mirrored,
                factor: mirrored(factor, member.is_mirrored),
            };
            if coarse.node == member.group && !coarse.is_mirrored {
                // What is between members of one group no longer moves.
                diagonal[group] -= coarse.factor.x;
            } else {
                rows.add(member.group, coarse);
            }
        }
    }
    let rows = rows.entries.iter().copied();
    let mut graph = PhaseGraph::from_rows(rows, diagonal, anchors, masses, starts_from);
    graph.is_image = is_image;
    Level { graph, members }
}

/// Couplings of coarse nodes, those to the same node summed; rows come one after the other.
struct CoarseRows {
    entries: Vec<(u32, Coupling)>,
    /// For each coarse node and kind, where its coupling to the row in work is.
    latest: Vec<[u32; 2]>,
    row: u32,
    row_start: usize,
}

impl CoarseRows {
    fn new(count: usize) -> Self {
        Self {
            entries: Vec::new(),
            latest: vec![[u32::MAX; 2]; count],
            row: u32::MAX,
            row_start: 0,
        }
    }

    fn add(&mut self, row: u32, coupling: Coupling) {
        if row != self.row {
            (self.row, self.row_start) = (row, self.entries.len());
        }
        let latest = &mut self.latest[coupling.node as usize][usize::from(coupling.is_mirrored)];
        let place = *latest as usize;
        if place >= self.row_start && place < self.entries.len() {
            self.entries[place].1.factor += coupling.factor;
        } else {
            *latest = self.entries.len() as u32;
            self.entries.push((row, coupling));
        }
    }
}

/// The fine nodes, group by group.
fn in_order_of_groups(members: &[Member], count: usize) -> Vec<usize> {
    let mut starts = vec![0; count + 1];
    for member in members {
        starts[member.group as usize + 1] += 1;
    }
    for group in 0..count {
        starts[group + 1] += starts[group];
    }
    let mut order = vec![0; members.len()];
    for (fine, member) in members.iter().enumerate() {
        let place = &mut starts[member.group as usize];
        order[*place] = fine;
        *place += 1;
    }
    order
}

/// Share of the diagonal from which on a coupling holds two nodes together: half of what each
/// neighbour has in a regular triangulation.
const STRONG: f64 = 1.0 / 12.0;

fn is_strong(graph: &PhaseGraph, node: usize, coupling: &Coupling) -> bool {
    let product = graph.diagonal[node] * graph.diagonal[coupling.node as usize];
    coupling.node as usize != node && coupling.factor.length() >= STRONG * product.sqrt()
}

/// The couplings that hold a node to others.
fn strong(graph: &PhaseGraph, node: usize) -> impl Iterator<Item = &Coupling> {
    let couplings = graph.couplings(node).iter();
    couplings.filter(move |coupling| is_strong(graph, node, coupling))
}

/// Groups of a node and all that hang on it strongly; the rest joins the group it hangs on most, or
/// makes groups of its own.
///
/// Nodes that are images of each other are decided on at once: none of them gets what two of them
/// would. So the groups of a mirrored surface are mirrored.
struct Groups {
    members: Vec<Member>,
    /// For each group whether its first node is an image of that of the group before.
    is_image: Vec<bool>,
}

impl Groups {
    fn of(graph: &PhaseGraph) -> Self {
        let mut groups = Self {
            members: vec![UNASSIGNED; graph.count()],
            is_image: Vec::new(),
        };
        let mut claims = vec![0; graph.count()];
        for wants_whole in [true, false] {
            for class in graph.classes() {
                let roots = class.filter(|&node| groups.may_begin(graph, node, wants_whole));
                let roots: Vec<usize> = roots.collect();
                groups.begin(graph, &roots, wants_whole, &mut claims);
            }
            if wants_whole {
                groups.join_neighbors(graph);
            }
        }
        groups
    }

    /// Whether a node has no group, and, if a group is to be whole, none of those that hang on it.
    fn may_begin(&self, graph: &PhaseGraph, node: usize, wants_whole: bool) -> bool {
        let is_taken = |node: usize| self.members[node].is_assigned();
        let mut around = strong(graph, node).map(|coupling| coupling.node as usize);
        !(is_taken(node) || wants_whole && around.any(is_taken))
    }

    /// Makes a group of each of some images. Whole groups that would overlap are not made; else
    /// what two of them lay claim to is left for later.
    fn begin(
        &mut self,
        graph: &PhaseGraph,
        roots: &[usize],
        wants_whole: bool,
        claims: &mut [u32],
    ) {
        let reach = |root: usize| {
            let around = strong(graph, root).map(|coupling| coupling.node as usize);
            std::iter::once(root).chain(around)
        };
        if let &[root] = roots {
            return self.make(graph, root, false, |_| true);
        }
        let all = || roots.iter().flat_map(|&root| reach(root));
        all().for_each(|node| claims[node] += 1);
        let mut is_image = false;
        for &root in roots {
            if wants_whole && reach(root).any(|node| claims[node] > 1) {
                continue;
            }
            self.make(graph, root, is_image, |node| claims[node] == 1);
            is_image = true;
        }
        all().for_each(|node| claims[node] = 0);
    }

    /// Makes a group of a root and what hangs on it, as far as that is free and granted.
    fn make(
        &mut self,
        graph: &PhaseGraph,
        root: usize,
        is_image: bool,
        is_granted: impl Fn(usize) -> bool,
    ) {
        let own = Member {
            group: self.is_image.len() as u32,
            ..UNASSIGNED
        };
        self.is_image.push(is_image);
        self.members[root] = own;
        for coupling in strong(graph, root) {
            let node = coupling.node as usize;
            if !self.members[node].is_assigned() && is_granted(node) {
                self.members[node] = own.linked(&from_other_end(coupling));
            }
        }
    }

    /// Puts nodes without a group into that of the neighbour they hang on most, of like ones the
    /// first. A node that hangs on images of each other alike stays on its own.
    fn join_neighbors(&mut self, graph: &PhaseGraph) {
        let before = self.members.clone();
        let classes = class_numbers(graph.count(), &graph.is_image);
        let group_classes = class_numbers(self.is_image.len(), &self.is_image);
        for (node, member) in self.members.iter_mut().enumerate() {
            if member.is_assigned() {
                continue;
            }
            let joined = |coupling: &Coupling| before[coupling.node as usize];
            let grouped = || strong(graph, node).filter(|c| joined(c).is_assigned());
            let length = |coupling: &Coupling| coupling.factor.length();
            let longest = grouped().map(length).fold(0.0, f64::max);
            let like = || grouped().filter(|c| length(c) >= (1.0 - LIKE_LENGTHS) * longest);
            let rank = |coupling: &&Coupling| {
                let group = joined(coupling).group as usize;
                (group_classes[group], classes[coupling.node as usize])
            };
            let Some(best) = like().min_by_key(rank) else {
                continue;
            };
            let is_image =
                |other: &Coupling| other.node != best.node && rank(&other) == rank(&best);
            if !like().any(is_image) {
                *member = joined(best).linked(best);
            }
        }
    }
}

/// For each of so many elements the number of its class: images have that of the one before.
fn class_numbers(count: usize, is_image: &[bool]) -> Vec<u32> {
    let mut number = 0;
    let of_element = |element: usize| {
        let is_image = is_image.get(element).copied().unwrap_or(false);
        number += u32::from(!is_image);
        number
    };
    (0..count).map(of_element).collect()
}

/// The coupling of the neighbour to the node that `coupling` belongs to.
fn from_other_end(coupling: &Coupling) -> Coupling {
    Coupling {
        factor: mirrored(coupling.factor, !coupling.is_mirrored),
        ..*coupling
    }
}
