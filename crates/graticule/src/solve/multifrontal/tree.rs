//! The elimination tree of a symmetric pattern, and how many entries each column of its factor has.

use crate::solve::Pattern;

/// Marks what is not there.
pub(super) const NONE: u32 = u32::MAX;

/// Pairs of neighbouring unknowns grouped by one end: for each place of the elimination order the
/// places on its other side, in no particular order.
pub(super) struct Neighbours {
    starts: Vec<u32>,
    places: Vec<u32>,
}

/// Which of the two ends of an edge a list is kept at.
#[derive(Clone, Copy)]
pub(super) enum End {
    /// Each place lists those before it.
    Later,
    /// Each place lists those after it.
    Earlier,
}

impl Neighbours {
    /// `places` gives each unknown of the lower triangle `pattern` its place.
    pub(super) fn listed_at(end: End, pattern: &Pattern, places: &[u32]) -> Self {
        let pairs = || {
            (0..pattern.columns()).flat_map(|column| {
                let place = places[column];
                let rows = pattern.column(column).iter();
                let others = rows.map(|&row| places[row as usize]);
                let others = others.filter(move |&other| other != place);
                others.map(move |other| match end {
                    End::Later => (place.max(other), place.min(other)),
                    End::Earlier => (place.min(other), place.max(other)),
                })
            })
        };
        let mut starts = vec![0; places.len() + 1];
        for (place, _) in pairs() {
            starts[place as usize + 1] += 1;
        }
        sum_up(&mut starts);
        let mut next = starts.clone();
        let mut listed = vec![0; starts[places.len()] as usize];
        for (place, other) in pairs() {
            let slot = &mut next[place as usize];
            listed[*slot as usize] = other;
            *slot += 1;
        }
        Self {
            starts,
            places: listed,
        }
    }

    pub(super) fn of(&self, place: usize) -> &[u32] {
        &self.places[self.starts[place] as usize..self.starts[place + 1] as usize]
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
