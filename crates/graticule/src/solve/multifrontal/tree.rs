//! The elimination tree of a symmetric pattern, and how many entries each column of its factor has.

use std::ops::Range;

use crate::solve::Pattern;

/// Marks what is not there.
pub(super) const NONE: u32 = u32::MAX;

/// Pairs of neighbouring unknowns grouped by one end: for each place of the elimination order the
/// places on its other side, in no particular order.
#[derive(Debug)]
pub(super) struct Neighbours {
    starts: Vec<u32>,
    places: Vec<u32>,
    sources: Vec<Source>,
}

/// An entry of the lower triangle of a matrix, and whether it stands in the upper triangle of the
/// matrix in elimination order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Source(u32);

impl Source {
    /// A pattern has less than 2³¹ entries.
    fn new(entry: usize, is_upper: bool) -> Self {
        Self((entry as u32) << 1 | u32::from(is_upper))
    }

    /// An entry on the diagonal.
    pub(super) fn diagonal(entry: usize) -> Self {
        Self::new(entry, false)
    }

    pub(super) fn entry(self) -> usize {
        (self.0 >> 1) as usize
    }

    pub(super) fn is_upper(self) -> bool {
        self.0 & 1 == 1
    }
}

impl Neighbours {
    /// Of each place those before it. `places` gives each unknown of the lower triangle `pattern`
    /// its place.
    pub(super) fn earlier(pattern: &Pattern, places: &[u32]) -> Self {
        let mut starts = vec![0; places.len() + 1];
        for column in 0..places.len() {
            for &row in pattern.column(column) {
                let ends = [places[row as usize], places[column]];
                if ends[0] != ends[1] {
                    starts[ends[0].max(ends[1]) as usize + 1] += 1;
                }
            }
        }
        let mut listed = Self::with_room(starts);
        let mut next = listed.starts.clone();
        for column in 0..places.len() {
            for (entry, &row) in pattern.range(column).zip(pattern.column(column)) {
                let [row, column] = [places[row as usize], places[column]];
                if row != column {
                    let slot = &mut next[row.max(column) as usize];
                    listed.places[*slot as usize] = row.min(column);
                    listed.sources[*slot as usize] = Source::new(entry, row < column);
                    *slot += 1;
                }
            }
        }
        listed
    }

    /// `counts` stand one place too far right.
    fn with_room(mut counts: Vec<u32>) -> Self {
        sum_up(&mut counts);
        let length = counts.last().map_or(0, |&length| length as usize);
        Self {
            starts: counts,
            places: vec![0; length],
            sources: vec![Source::default(); length],
        }
    }

    /// Of each place those after it, from those before; both ends get new `labels`, which keep the
    /// order of each pair.
    pub(super) fn turned(&self, labels: &[u32]) -> Self {
        let mut starts = vec![0; labels.len() + 1];
        for &place in &self.places {
            starts[labels[place as usize] as usize + 1] += 1;
        }
        let mut listed = Self::with_room(starts);
        let mut next = listed.starts.clone();
        for (place, &label) in labels.iter().enumerate() {
            for (&other, &source) in self.of(place).iter().zip(self.sources(place)) {
                let slot = &mut next[labels[other as usize] as usize];
                listed.places[*slot as usize] = label;
                listed.sources[*slot as usize] = source;
                *slot += 1;
            }
        }
        listed
    }

    /// The same lists in another order, with new labels of the places in them.
    pub(super) fn relabelled(&self, sequence: &[u32], labels: &[u32]) -> Self {
        let mut listed = Self {
            starts: Vec::with_capacity(self.starts.len()),
            places: Vec::with_capacity(self.places.len()),
            sources: Vec::with_capacity(self.sources.len()),
        };
        listed.starts.push(0);
        for &old in sequence {
            let others = self.of(old as usize).iter();
            let others = others.map(|&other| labels[other as usize]);
            listed.places.extend(others);
            listed.sources.extend_from_slice(self.sources(old as usize));
            listed.starts.push(listed.places.len() as u32);
        }
        listed
    }

    pub(super) fn of(&self, place: usize) -> &[u32] {
        &self.places[self.range(place)]
    }

    /// Where the entry of each pair stands.
    pub(super) fn sources(&self, place: usize) -> &[Source] {
        &self.sources[self.range(place)]
    }

    fn range(&self, place: usize) -> Range<usize> {
        self.starts[place] as usize..self.starts[place + 1] as usize
    }
}

/// Turns counts that stand one place too far right into starts.
pub(super) fn sum_up(counts: &mut [u32]) {
    let mut sum = 0;
    for count in counts {
        sum += *count;
        *count = sum;
    }
}

/// The first later place at which the column of each place has an entry in the factor, or [`NONE`]
/// (J. Liu, *The role of elimination trees in sparse factorization*, 1990, with its compressed
/// paths). Nearly linear.
pub(super) fn elimination_tree(earlier: &Neighbours, order: usize) -> Vec<u32> {
    let mut parents = vec![NONE; order];
    let mut shortcuts = vec![NONE; order];
    for place in 0..order {
        for &start in earlier.of(place) {
            let mut at = start as usize;
            loop {
                let next = std::mem::replace(&mut shortcuts[at], place as u32);
                if next == place as u32 {
                    break;
                }
                if next == NONE {
                    parents[at] = place as u32;
                    break;
                }
                at = next as usize;
            }
        }
    }
    parents
}

/// The places in an order in which the descendants of each one stand directly before it; children
/// of one place, and roots, keep their order.
pub(super) fn postorder(parents: &[u32]) -> Vec<u32> {
    let order = parents.len();
    let mut first_child = vec![NONE; order];
    let mut sibling = vec![NONE; order];
    let mut first_root = NONE;
    for place in (0..order).rev() {
        let head = match parents[place] {
            NONE => &mut first_root,
            parent => &mut first_child[parent as usize],
        };
        sibling[place] = std::mem::replace(head, place as u32);
    }
    let mut sequence = Vec::with_capacity(order);
    let mut at = first_root;
    while at != NONE {
        // Down to the first leaf, then up over all that are complete.
        while first_child[at as usize] != NONE {
            at = std::mem::replace(&mut first_child[at as usize], NONE);
        }
        sequence.push(at);
        let next = sibling[at as usize];
        at = if next == NONE {
            parents[at as usize]
        } else {
            next
        };
    }
    sequence
}

/// Entries below the diagonal in each column of the factor.
///
/// `later` and `parents` are in postorder. The row subtrees are counted by their leaves
/// (J. Gilbert, E. Ng and B. Peyton, *An efficient algorithm to compute row and column counts for
/// sparse Cholesky factorization*, 1994). Nearly linear.
pub(super) fn column_counts(later: &Neighbours, parents: &[u32]) -> Vec<u32> {
    let order = parents.len();
    let mut first_descendant = vec![NONE; order];
    let mut counts = vec![0_i64; order];
    for place in 0..order {
        // Descendants come first, so that an untouched place has none.
        if first_descendant[place] == NONE {
            first_descendant[place] = place as u32;
            counts[place] = 1;
        }
        let first = first_descendant[place];
        if let Some(above) = first_descendant.get_mut(parents[place] as usize) {
            *above = (*above).min(first);
        }
    }
    let mut last_leaf = vec![NONE; order];
    let mut last_first = vec![NONE; order];
    let mut sets: Vec<u32> = (0..order as u32).collect();
    for place in 0..order {
        if let Some(above) = counts.get_mut(parents[place] as usize) {
            *above -= 1;
        }
        for &row in later.of(place) {
            let row = row as usize;
            let first = first_descendant[place];
            if last_first[row] != NONE && first <= last_first[row] {
                continue;
            }
            last_first[row] = first;
            counts[place] += 1;
            let previous = std::mem::replace(&mut last_leaf[row], place as u32);
            if previous != NONE {
                counts[representative(&mut sets, previous) as usize] -= 1;
            }
        }
        if parents[place] != NONE {
            sets[place] = parents[place];
        }
    }
    for place in 0..order {
        let count = counts[place];
        if let Some(above) = counts.get_mut(parents[place] as usize) {
            *above += count;
        }
    }
    // The diagonal entry is counted above.
    #[expect(clippy::cast_sign_loss, reason = "a column has its diagonal entry")]
    let below = |&count: &i64| (count - 1) as u32;
    counts.iter().map(below).collect()
}

fn representative(sets: &mut [u32], member: u32) -> u32 {
    let mut root = member;
    while sets[root as usize] != root {
        root = sets[root as usize];
    }
    let mut at = member;
    while at != root {
        at = std::mem::replace(&mut sets[at as usize], root);
    }
    root
}
