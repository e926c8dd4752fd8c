//! Of the lines of a close net, those that bound large rectangles.
//!
//! Lines run from the singular points of the net, all at the same speed, each until it meets another:
//! the motorcycle graph of D. Eppstein, M. Goodrich, E. Kim, R. Tamstorf, *Motorcycle Graphs: Canonical Quad
//! Mesh Partitioning*, 2008. What they leave are rectangles, and annuli; those that are too long are
//! cut across.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::FRAC_PI_4;

use super::cells::{Census, join_faces, prune};
use super::overlay::{ArcKind, NONE, Overlay, arc, twin};

/// Rounds of cutting cells in two, at most: sides of a million lines are cut down to one.
const MOST_ROUNDS: usize = 20;

/// Takes lines of the net away that are not needed to bound rectangles with sides of about `spacings`
/// lines. `is_singular` marks vertices round which the map turns.
///
/// Returns how many pieces of lines were taken away because they ended in a cell.
///
/// Cost: near-linear in the pieces.
pub(super) fn keep_rectangles(
    overlay: &mut Overlay,
    is_singular: &[bool],
    spacings: f64,
    cell_area: f64,
) -> usize {
    let mut pruned = prune(overlay);
    let mut thinning = Thinning::of(overlay);
    thinning.trace_from_singular_points(is_singular);
    pruned += prune(thinning.overlay);
    for _ in 0..MOST_ROUNDS {
        thinning.find_met();
        if thinning.cut_across(spacings, cell_area) == 0 {
            break;
        }
        pruned += prune(thinning.overlay);
    }
    pruned
}

/// A net of which only the lines wanted so far are drawn.
struct Thinning<'a> {
    overlay: &'a mut Overlay,
    /// Which arcs belong to the whole net.
    is_fine: Vec<bool>,
    /// Which nodes an arc that is drawn touches.
    is_met: Vec<bool>,
    /// For each node a dart of the whole net that leaves it.
    leaving: Vec<u32>,
}

impl<'a> Thinning<'a> {
    /// Nothing wanted yet but what is fixed.
    fn of(overlay: &'a mut Overlay) -> Self {
        let is_fine: Vec<bool> = (overlay.kinds.iter())
            .map(|&kind| kind != ArcKind::Inner)
            .collect();
        let mut leaving = vec![NONE; overlay.points.len()];
        for dart in overlay.darts().filter(|&dart| is_fine[arc(dart)]) {
            leaving[overlay.origins[dart as usize] as usize] = dart;
        }
        for kind in &mut overlay.kinds {
            if *kind == ArcKind::Line {
                *kind = ArcKind::Inner;
            }
        }
        let mut thinning = Self {
            is_met: Vec::new(),
            overlay,
            is_fine,
            leaving,
        };
        thinning.find_met();
        thinning
    }

    fn find_met(&mut self) {
        let degrees = self.overlay.degrees();
        self.is_met = degrees.iter().map(|&degree| degree > 0).collect();
    }

    /// The next dart of the whole net along the same cell of it.
    fn next_fine(&self, dart: u32) -> u32 {
        let mut next = self.overlay.next[dart as usize];
        while !self.is_fine[arc(next)] {
            next = self.overlay.next[twin(next) as usize];
        }
        next
    }

    /// The darts of the whole net that leave the end of a dart, from the one next to it on, without
    /// its twin.
    fn onward(&self, dart: u32) -> impl Iterator<Item = u32> + '_ {
        let back = twin(dart);
        std::iter::successors(Some(self.next_fine(dart)), |&leaving| {
            Some(self.next_fine(twin(leaving)))
        })
        .take_while(move |&leaving| leaving != back)
    }

    /// The dart that goes on along the same line; `None` where the net is irregular.
    fn straight_on(&self, dart: u32) -> Option<u32> {
        let mut onward = self.onward(dart);
        let [first, second, third] = [0; 3].map(|_| onward.next());
        match (second, third, onward.next()) {
            (None, _, _) => first,
            (Some(opposite), Some(_), None) => Some(opposite),
            _ => None,
        }
    }

    /// Draws lines from all points where the net is irregular.
    fn trace_from_singular_points(&mut self, is_singular: &[bool]) {
        let mut starts = Vec::new();
        for node in 0..self.leaving.len() {
            let leaving = self.leaving[node];
            if leaving == NONE {
                continue;
            }
            let singular = is_singular.get(node) == Some(&true);
            let before = starts.len();
            self.lines_from(leaving, singular, &mut starts);
            self.is_met[node] |= starts.len() > before;
        }
        self.trace(&starts);
    }

    /// The lines to be drawn from the node that a dart leaves: all where it is singular, an end of a
    /// feature, or has another number of lines than where two cross; beside features and boundary
    /// those that divide more than a straight angle.
    fn lines_from(&self, leaving: u32, singular: bool, starts: &mut Vec<u32>) {
        let around: Vec<u32> = std::iter::once(leaving)
            .chain(self.onward(twin(leaving)))
            .collect();
        let is_line = |&dart: &u32| !self.overlay.is_drawn(dart);
        let fixed = around.iter().filter(|&dart| !is_line(dart)).count();
        if fixed < 2 {
            let irregular = singular || fixed == 1 || !matches!(around.len(), 2 | 4);
            if irregular {
                starts.extend(around.iter().filter(|&dart| is_line(dart)));
            }
            return;
        }
        let first = around.iter().position(|dart| !is_line(dart)).unwrap_or(0);
        let turned: Vec<u32> = (around[first..].iter().chain(&around[..first]).copied()).collect();
        for wedge in turned.split(|dart| !is_line(dart)) {
            if wedge.len() > 1 {
                starts.extend(wedge);
            }
        }
    }

    /// Draws lines, all at the same speed, each until it meets what is drawn.
    fn trace(&mut self, starts: &[u32]) {
        let advance = |overlay: &Overlay, dart: u32| overlay.advances[arc(dart)].abs();
        // Distances are not negative: their bits are in their order.
        let mut arrivals: BinaryHeap<Reverse<(u64, u32)>> = (starts.iter())
            .map(|&dart| Reverse((advance(self.overlay, dart).to_bits(), dart)))
            .collect();
        while let Some(Reverse((bits, dart))) = arrivals.pop() {
            if self.overlay.is_drawn(dart) {
                continue;
            }
            self.overlay.kinds[arc(dart)] = ArcKind::Line;
            let end = self.overlay.destination(dart) as usize;
            if std::mem::replace(&mut self.is_met[end], true) {
                continue;
            }
            if let Some(next) = self.straight_on(dart) {
                let distance = f64::from_bits(bits) + advance(self.overlay, next);
                arrivals.push(Reverse((distance.to_bits(), next)));
            }
        }
    }

    /// Cuts each cell that is too long, no disk or stands out too far in two, and returns how many
    /// were cut.
    fn cut_across(&mut self, spacings: f64, cell_area: f64) -> usize {
        let (of_face, count) = join_faces(self.overlay);
        let census = Census::of(self.overlay, &of_face, count, cell_area);
        let mut is_done = vec![false; count];
        let mut is_walked = vec![false; self.overlay.origins.len()];
        let mut starts = Vec::new();
        for first in self.overlay.darts() {
            let face = self.overlay.faces[first as usize];
            if face == NONE || is_walked[first as usize] || !self.overlay.is_drawn(first) {
                continue;
            }
            let walk = self.walk(first);
            for &dart in &walk {
                is_walked[dart as usize] = true;
            }
            let cell = of_face[face as usize] as usize;
            if is_done[cell] {
                continue;
            }
            if let Some(start) = self.cut_of(&walk, spacings, census.poor[cell]) {
                is_done[cell] = true;
                starts.push(start);
            }
        }
        let mut cuts = starts.len();
        for start in starts {
            self.trace(&[start]);
        }
        let is_open = |cell: u32| census.poor[cell as usize] && !is_done[cell as usize];
        cuts += self.cut_closed(&of_face, is_open);
        cuts
    }

    fn walk(&self, first: u32) -> Vec<u32> {
        let along = |&dart: &u32| Some(self.overlay.next_drawn(dart));
        let onward = std::iter::successors(Some(first), along).skip(1);
        let rest = onward.take_while(|&dart| dart != first);
        std::iter::once(first).chain(rest).collect()
    }

    /// Where to cut a cell across its longest side, by its border; `None` if it is small enough and
    /// not poor, or no line leads into it.
    fn cut_of(&self, walk: &[u32], spacings: f64, is_poor: bool) -> Option<u32> {
        let corners: Vec<Corner> = (0..walk.len())
            .map(|place| self.corner(walk[(place + walk.len() - 1) % walk.len()], walk[place]))
            .collect();
        let first = corners.iter().position(|corner| corner.turns).unwrap_or(0);
        let mut best: Option<Side> = None;
        let mut side = Side::default();
        for step in 0..walk.len() {
            let place = (first + step) % walk.len();
            if step > 0 && corners[place].turns {
                best = Some(side.longer_of(best));
                side = Side::default();
            }
            if let Some(inward) = corners[place].inward {
                side.inward.push((side.length, inward));
            }
            side.length += self.overlay.advances[arc(walk[place])].abs();
        }
        let longest = side.longer_of(best);
        let parts = (longest.length / spacings).round();
        if parts < 2.0 && !is_poor {
            return None;
        }
        let parts = parts.max(2.0);
        let aim = longest.length * (parts / 2.0).floor() / parts;
        let miss = |(length, _): &&(f64, u32)| (length - aim).abs();
        let nearest = (longest.inward.iter()).min_by(|a, b| miss(a).total_cmp(&miss(b)));
        nearest.map(|&(_, dart)| dart)
    }

    /// What the border of a cell does between one dart and the next.
    fn corner(&self, incoming: u32, outgoing: u32) -> Corner {
        let mut inside = self.onward(incoming).take_while(|&dart| dart != outgoing);
        let [first, second] = [0; 2].map(|_| inside.next());
        match (first, second) {
            (Some(inward), None) => Corner {
                inward: Some(inward),
                turns: false,
            },
            (Some(_), Some(_)) => Corner::default(),
            (None, _) => Corner {
                inward: None,
                turns: self.turns_without_lines(incoming, outgoing),
            },
        }
    }

    /// Whether the border turns where no line leads into the cell: two lines that cross do, what is
    /// fixed where it does in space.
    fn turns_without_lines(&self, incoming: u32, outgoing: u32) -> bool {
        let others = self.onward(incoming).count();
        let is_line = |dart: u32| self.overlay.kinds[arc(dart)] == ArcKind::Line;
        if is_line(incoming) || is_line(outgoing) {
            return others > 1;
        }
        let [from, at, to] = [
            self.overlay.origins[incoming as usize],
            self.overlay.origins[outgoing as usize],
            self.overlay.destination(outgoing),
        ]
        .map(|node| self.overlay.positions[node as usize]);
        (at - from).angle_between(to - at) > FRAC_PI_4
    }

    /// Draws the two lines through a point of each cell without border.
    fn cut_closed(&mut self, of_face: &[u32], is_open: impl Fn(u32) -> bool) -> usize {
        let mut seen = vec![false; of_face.len()];
        let mut starts = Vec::new();
        for node in 0..self.leaving.len() {
            let leaving = self.leaving[node];
            if leaving == NONE || self.is_met[node] {
                continue;
            }
            let cell = of_face[self.overlay.faces[leaving as usize] as usize];
            let around: Vec<u32> = std::iter::once(leaving)
                .chain(self.onward(twin(leaving)))
                .collect();
            if around.len() == 4
                && is_open(cell)
                && !std::mem::replace(&mut seen[cell as usize], true)
            {
                self.is_met[node] = true;
                starts.push(around);
            }
        }
        let cuts = starts.len();
        for around in &starts {
            self.trace(around);
        }
        cuts
    }
}

/// A place on the border of a cell.
#[derive(Clone, Copy, Default)]
struct Corner {
    /// The one line that leads straight into the cell.
    inward: Option<u32>,
    /// Whether a side ends there.
    turns: bool,
}

/// A side of a cell.
#[derive(Default)]
struct Side {
    length: f64,
    /// Lines that lead into the cell, by how far along the side.
    inward: Vec<(f64, u32)>,
}

impl Side {
    fn longer_of(self, other: Option<Self>) -> Self {
        match other {
            Some(other) if other.length >= self.length => other,
            _ => self,
        }
    }
}
