//! A quadratic form of complex numbers that want to differ from their neighbours by given rotations.

use std::ops::Range;

use glam::DVec2;

use crate::solve::{LinearOperator, Preconditioner};

/// `weight · |x_b − rotation · x_a|²`, with the conjugate of `x_b` where it is mirrored.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) ends: [usize; 2],
    pub(crate) is_mirrored: bool,
    pub(crate) rotation: DVec2,
    pub(crate) weight: f64,
}

/// What draws one node to another: `factor · x`, or `factor · conj x`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coupling {
    pub(crate) node: u32,
    pub(crate) is_mirrored: bool,
    pub(crate) factor: DVec2,
}

impl Coupling {
    #[inline]
    fn pull(&self, values: &[DVec2]) -> DVec2 {
        self.factor
            .rotate(mirrored(values[self.node as usize], self.is_mirrored))
    }
}

/// The complex number, or its conjugate.
#[inline]
pub(crate) fn mirrored(value: DVec2, is_mirrored: bool) -> DVec2 {
    if is_mirrored {
        DVec2::new(value.x, -value.y)
    } else {
        value
    }
}

/// The form `Σ w |x_b − r x_a|²` over the nodes that are free; fixed ones have the value 1.
///
/// Its gradient is `2 (d x − Σ factor · x_b − anchor)`. The numbers behind a node are complex, but the
/// form is linear over the real numbers only, because of the mirrored links.
#[derive(Clone, Debug)]
pub(crate) struct PhaseGraph {
    starts: Vec<u32>,
    couplings: Vec<Coupling>,
    pub(crate) diagonal: Vec<f64>,
    /// What fixed nodes pull at each node with.
    pub(crate) anchors: Vec<DVec2>,
    pub(crate) masses: Vec<f64>,
    /// Unit vectors to start from.
    pub(crate) starts_from: Vec<DVec2>,
    /// Whether a node is of one class with the one before: images of each other, of which none may
    /// take its turn first. Empty where every node is on its own.
    pub(crate) is_image: Vec<bool>,
    /// The constant part of the form: weights of links to fixed nodes.
    constant: f64,
    /// The place of each node of the caller among the free ones, or [`FIXED`].
    pub(crate) places: Vec<u32>,
}

/// In which order nodes take turns, and where each starts.
pub(crate) struct NodeOrder {
    /// All nodes.
    pub(crate) nodes: Vec<u32>,
    /// A unit vector for each, by its number.
    pub(crate) starts_from: Vec<DVec2>,
}

/// Stands for no place among the free nodes.
pub(crate) const FIXED: u32 = u32::MAX;

impl PhaseGraph {
    pub(crate) fn new(
        masses: &[f64],
        is_fixed: &[bool],
        order: &NodeOrder,
        links: impl Iterator<Item = Link> + Clone,
    ) -> Self {
        let mut places = vec![FIXED; masses.len()];
        let nodes = order.nodes.iter().map(|&node| node as usize);
        let free: Vec<usize> = nodes.filter(|&node| !is_fixed[node]).collect();
        for (place, &node) in free.iter().enumerate() {
            places[node] = place as u32;
        }
        let mut graph = Self {
            starts: Vec::new(),
            couplings: Vec::new(),
            diagonal: vec![0.0; free.len()],
            anchors: vec![DVec2::ZERO; free.len()],
            masses: free.iter().map(|&node| masses[node]).collect(),
            starts_from: free.iter().map(|&node| order.starts_from[node]).collect(),
            is_image: Vec::new(),
            constant: 0.0,
            places,
        };
        let mut rows = Vec::new();
        for link in links {
            graph.add(&link, &mut rows);
        }
        graph.collect(rows.iter().copied());
        graph
    }

    /// One with other rows; every node is free.
    pub(crate) fn from_rows(
        rows: impl Iterator<Item = (u32, Coupling)> + Clone,
        diagonal: Vec<f64>,
        anchors: Vec<DVec2>,
        masses: Vec<f64>,
        starts_from: Vec<DVec2>,
    ) -> Self {
        let mut graph = Self {
            starts: Vec::new(),
            couplings: Vec::new(),
            places: (0..diagonal.len() as u32).collect(),
            diagonal,
            anchors,
            masses,
            starts_from,
            is_image: Vec::new(),
            constant: 0.0,
        };
        graph.collect(rows);
        graph
    }

    fn add(&mut self, link: &Link, rows: &mut Vec<(u32, Coupling)>) {
        let [a, b] = link.ends.map(|node| self.places[node]);
        let weight = link.weight;
        // A link from a node to itself, unmirrored, costs every unit vector the same.
        if weight == 0.0 || (link.ends[0] == link.ends[1] && !link.is_mirrored) {
            return;
        }
        let forth = link.rotation * weight;
        let back = mirrored(forth, true);
        // x_a is drawn to back · x_b, x_b to forth · x_a or, mirrored, to back · conj x_a.
        let at_b = if link.is_mirrored { back } else { forth };
        for (node, factor, other) in [(a, back, b), (b, at_b, a)] {
            if node == FIXED {
                self.constant += weight;
                continue;
            }
            self.diagonal[node as usize] += weight;
            if other == FIXED {
                self.anchors[node as usize] += factor;
            } else {
                let coupling = Coupling {
                    node: other,
                    is_mirrored: link.is_mirrored,
                    factor,
                };
                rows.push((node, coupling));
            }
        }
        if a == FIXED && b == FIXED {
            self.constant -= 2.0 * weight * link.rotation.x;
        }
    }

    /// Sorts couplings by their row, keeping the order within.
    fn collect(&mut self, rows: impl Iterator<Item = (u32, Coupling)> + Clone) {
        let count = self.diagonal.len();
        let mut starts = vec![0_u32; count + 1];
        for (row, _) in rows.clone() {
            starts[row as usize + 1] += 1;
        }
        for row in 0..count {
            starts[row + 1] += starts[row];
        }
        let nothing = Coupling {
            node: 0,
            is_mirrored: false,
            factor: DVec2::ZERO,
        };
        let mut couplings = vec![nothing; starts[count] as usize];
        let mut filled = starts.clone();
        for (row, coupling) in rows {
            let place = &mut filled[row as usize];
            couplings[*place as usize] = coupling;
            *place += 1;
        }
        (self.starts, self.couplings) = (starts, couplings);
    }

    /// The number of free nodes.
    pub(crate) fn count(&self) -> usize {
        self.diagonal.len()
    }

    pub(crate) fn couplings(&self, node: usize) -> &[Coupling] {
        &self.couplings[self.starts[node] as usize..self.starts[node + 1] as usize]
    }

    /// For each node the number of the part of the graph that hangs together with it.
    pub(crate) fn components(&self) -> Vec<u32> {
        let mut components = vec![u32::MAX; self.count()];
        let mut found = 0;
        let mut waiting = Vec::new();
        for start in 0..self.count() {
            if components[start] != u32::MAX {
                continue;
            }
            components[start] = found;
            waiting.push(start);
            while let Some(node) = waiting.pop() {
                for coupling in self.couplings(node) {
                    let other = coupling.node as usize;
                    if components[other] == u32::MAX {
                        components[other] = found;
                        waiting.push(other);
                    }
                }
            }
            found += 1;
        }
        components
    }

    /// Where the neighbours of a node want it, times the sum of their weights.
    #[inline]
    pub(crate) fn pull(&self, node: usize, values: &[DVec2]) -> DVec2 {
        let pulls = self.couplings(node).iter();
        self.anchors[node] + pulls.map(|coupling| coupling.pull(values)).sum::<DVec2>()
    }

    /// The value of the form.
    pub(crate) fn energy(&self, values: &[DVec2]) -> f64 {
        let terms = (0..self.count()).map(|node| {
            let (own, pull) = (values[node], self.pull(node, values));
            self.diagonal[node] * own.length_squared() - own.dot(pull + self.anchors[node])
        });
        (terms.sum::<f64>() + self.constant).max(0.0)
    }

    /// The part of the form that one of its free nodes has: half of each of its links to unit vectors.
    pub(crate) fn energy_at(&self, node: usize, values: &[DVec2]) -> f64 {
        let own = values[node];
        self.diagonal[node] * own.length_squared() - own.dot(self.pull(node, values))
    }

    /// For each node the length of the mean of what its neighbours want it to be: 1 where they agree,
    /// 0 where the phase is singular.
    pub(crate) fn agreements(&self, values: &[DVec2]) -> Vec<f64> {
        let of_node = |node| {
            let weight = self.diagonal[node];
            if weight > 0.0 {
                self.pull(node, values).length() / weight
            } else {
                1.0
            }
        };
        (0..self.count()).map(of_node).collect()
    }

    /// The classes of nodes that take their turn at once, as ranges of nodes, in order.
    pub(crate) fn classes(&self) -> impl DoubleEndedIterator<Item = Range<usize>> + '_ {
        let is_first = |node: &usize| !self.is_image.get(*node).copied().unwrap_or(false);
        let firsts = (0..self.count()).filter(is_first);
        firsts.map(|first| {
            let rest = self.is_image.iter().skip(first + 1);
            first..first + 1 + rest.take_while(|is_image| **is_image).count()
        })
    }

    /// Moves each node to the best unit vector for its neighbours as they are, in order and then
    /// back, images at once; the mean move of the second pass. The form never grows but between
    /// images that are neighbours.
    pub(crate) fn relax_units(&self, values: &mut [DVec2]) -> f64 {
        let mut images = Vec::new();
        for class in self.classes() {
            self.relax_class(class, values, &mut images);
        }
        let moves = self
            .classes()
            .rev()
            .map(|class| self.relax_class(class, values, &mut images));
        moves.sum::<f64>() / self.count().max(1) as f64
    }

    fn relax_class(
        &self,
        class: Range<usize>,
        values: &mut [DVec2],
        images: &mut Vec<DVec2>,
    ) -> f64 {
        // Where the neighbours cancel out, any unit vector is as good.
        let best = |node: usize, values: &[DVec2]| {
            let pull = self.pull(node, values);
            pull.try_normalize().unwrap_or(values[node])
        };
        if class.len() == 1 {
            let after = best(class.start, values);
            return std::mem::replace(&mut values[class.start], after).distance(after);
        }
        images.clear();
        images.extend(class.clone().map(|node| best(node, values)));
        let nodes = values[class].iter_mut().zip(images.iter());
        nodes
            .map(|(value, &after)| std::mem::replace(value, after).distance(after))
            .sum()
    }

    /// The operator `d x − Σ factor · x_b + step · mass · x`, for unknowns as pairs of numbers.
    pub(crate) fn shifted(&self, step: f64) -> ShiftedForm<'_> {
        ShiftedForm { graph: self, step }
    }
}

/// Half the form's matrix plus a multiple of the masses.
pub(crate) struct ShiftedForm<'a> {
    graph: &'a PhaseGraph,
    step: f64,
}

impl ShiftedForm<'_> {
    fn diagonal(&self, node: usize) -> f64 {
        self.graph.diagonal[node] + self.step * self.graph.masses[node]
    }
}

/// Nodes in one piece of parallel work.
const PIECE: usize = 4096;

impl LinearOperator for ShiftedForm<'_> {
    fn order(&self) -> usize {
        2 * self.graph.count()
    }

    fn apply(&self, input: &[f64], output: &mut [f64]) {
        use rayon::prelude::*;
        let values: Vec<DVec2> = input.chunks_exact(2).map(DVec2::from_slice).collect();
        let pieces = output.par_chunks_mut(2 * PIECE).enumerate();
        pieces.for_each(|(piece, output)| {
            for (node, place) in (piece * PIECE..).zip(output.chunks_exact_mut(2)) {
                let couplings = self.graph.couplings(node).iter();
                let pulls: DVec2 = couplings.map(|coupling| coupling.pull(&values)).sum();
                let result = values[node] * self.diagonal(node) - pulls;
                result.write_to_slice(place);
            }
        });
    }
}

impl Preconditioner for ShiftedForm<'_> {
    /// Division by the diagonal.
    fn apply(&self, input: &[f64], output: &mut [f64]) {
        let places = output.chunks_exact_mut(2).zip(input.chunks_exact(2));
        for (node, (to, from)) in places.enumerate() {
            let inverse = self.diagonal(node).recip();
            to[0] = from[0] * inverse;
            to[1] = from[1] * inverse;
        }
    }
}
