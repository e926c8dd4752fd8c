//! Which unknowns are eliminated together, and which others each such block acts on.

use std::ops::Range;

use super::columns::Columns;
use super::parts::parts_of;
use super::tree::{NONE, Neighbours, column_counts, elimination_tree, postorder, sum_up};
use crate::solve::{Ordering, Pattern};

/// Blocks of so many columns are joined with their parent while the share of zeros that this puts
/// into the factor stays below the number beside. Small blocks cost more by their number than by
/// their entries.
const JOINED: [(usize, f64); 4] = [(4, 0.8), (16, 0.1), (48, 0.05), (usize::MAX, 0.02)];

/// Consecutive columns with entries in the same rows.
#[derive(Clone, Debug)]
pub(in crate::solve) struct Block {
    /// Places of its columns.
    pub(in crate::solve) columns: Range<usize>,
    /// Range of [`Plan::rows`]: the later places that it acts on, ascending.
    below: Range<usize>,
    /// The block that its update goes to: that of the first row below.
    pub(in crate::solve) parent: Option<usize>,
    /// Whether its columns, or those of a block that passes on to it, hold complex numbers.
    pub(super) complex: bool,
}

impl Block {
    pub(in crate::solve) fn width(&self) -> usize {
        self.columns.len()
    }

    /// Rows below the block's own.
    pub(in crate::solve) fn depth(&self) -> usize {
        self.below.len()
    }

    /// All rows.
    pub(super) fn height(&self) -> usize {
        self.width() + self.depth()
    }
}

/// An elimination in blocks, descendants before their ancestors.
#[derive(Debug)]
pub(in crate::solve) struct Plan {
    order: Vec<u32>,
    places: Vec<u32>,
    blocks: Vec<Block>,
    rows: Vec<u32>,
    /// Ranges of blocks that hold all their descendants: each can be eliminated for itself.
    pub(super) parts: Vec<Range<usize>>,
    /// The entries of the matrix.
    pub(super) columns: Columns,
}

impl Plan {
    /// Plans the elimination of a matrix with this lower triangle. The order is kept up to
    /// exchanges that change no fill; `is_complex` tells of each unknown whether its column or row
    /// holds complex numbers.
    pub(in crate::solve) fn new(
        pattern: &Pattern,
        ordering: &Ordering,
        is_complex: impl Fn(u32) -> bool,
    ) -> Self {
        let earlier = Neighbours::earlier(pattern, ordering.places());
        let parents = elimination_tree(&earlier, ordering.len());
        let sequence = postorder(&parents);
        let labels = inverse(&sequence);
        let order = picked(ordering.order(), &sequence);
        let parents = relabelled(&parents, &sequence, &labels);
        let later = earlier.turned(&labels);
        drop(earlier);
        let counts = column_counts(&later, &parents);
        let complex = spread(&order, &parents, is_complex);
        let mut groups = Groups::of_equal_rows(&parents, &counts, &complex);
        groups.join_children(&parents);
        let (sequence, widths) = groups.columns_in_order(order.len());
        let order = picked(&order, &sequence);
        let complex = picked(&complex, &sequence);
        let later = later.relabelled(&sequence, &inverse(&sequence));
        let (blocks, rows) = blocks_of(&later, &widths, &complex);
        Self {
            parts: parts_of(&blocks),
            columns: Columns::new(pattern, &order, later),
            places: inverse(&order),
            order,
            blocks,
            rows,
        }
    }

    /// Places below a block that it acts on, ascending.
    pub(in crate::solve) fn rows_below(&self, block: &Block) -> &[u32] {
        &self.rows[block.below.clone()]
    }

    pub(in crate::solve) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Unknown at each place.
    pub(in crate::solve) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Place of each unknown.
    pub(in crate::solve) fn places(&self) -> &[u32] {
        &self.places
    }

    /// Entries of the factor's lower triangle, and multiplications to make it.
    pub(in crate::solve) fn cost(&self) -> (usize, f64) {
        let lengths = self.blocks.iter().flat_map(|block| {
            let depth = block.depth();
            (1..=block.width()).map(move |above| above + depth)
        });
        lengths.fold((0, 0.0), |(entries, operations), length| {
            (entries + length, operations + (length as f64).powi(2) / 2.0)
        })
    }
}

fn picked<T: Copy>(values: &[T], sequence: &[u32]) -> Vec<T> {
    sequence
        .iter()
        .map(|&place| values[place as usize])
        .collect()
}

/// The place of each number in a sequence.
fn inverse(sequence: &[u32]) -> Vec<u32> {
    let mut places = vec![0; sequence.len()];
    for (place, &number) in (0..).zip(sequence) {
        places[number as usize] = place;
    }
    places
}

/// The tree with its nodes numbered in sequence.
fn relabelled(parents: &[u32], sequence: &[u32], labels: &[u32]) -> Vec<u32> {
    let relabel = |&old: &u32| match parents[old as usize] {
        NONE => NONE,
        parent => labels[parent as usize],
    };
    sequence.iter().map(relabel).collect()
}

/// What a column holds, its ancestors' columns hold too.
fn spread(order: &[u32], parents: &[u32], is_complex: impl Fn(u32) -> bool) -> Vec<bool> {
    let mut complex: Vec<bool> = order.iter().map(|&unknown| is_complex(unknown)).collect();
    for place in 0..complex.len() {
        if let (true, Some(above)) = (complex[place], complex.get_mut(parents[place] as usize)) {
            *above = true;
        }
    }
    complex
}

/// Columns that are to be eliminated together.
struct Group {
    last: usize,
    width: usize,
    depth: usize,
    zeros: usize,
    complex: bool,
    /// The group that it has joined, later than itself.
    joined: Option<usize>,
}

struct Groups {
    all: Vec<Group>,
    group_of: Vec<u32>,
}

impl Groups {
    /// Chains of the tree whose columns have the same rows, but for their own.
    fn of_equal_rows(parents: &[u32], counts: &[u32], complex: &[bool]) -> Self {
        let mut children = vec![0_u32; parents.len()];
        for &parent in parents {
            if let Some(count) = children.get_mut(parent as usize) {
                *count += 1;
            }
        }
        let mut all: Vec<Group> = Vec::new();
        let mut group_of = Vec::with_capacity(parents.len());
        for column in 0..parents.len() {
            let goes_on = |last: usize| {
                parents[last] == column as u32
                    && children[column] == 1
                    && counts[last] == counts[column] + 1
                    && complex[last] == complex[column]
            };
            match all.last_mut() {
                Some(group) if goes_on(group.last) => {
                    group.last = column;
                    group.width += 1;
                    group.depth = counts[column] as usize;
                }
                _ => all.push(Group {
                    last: column,
                    width: 1,
                    depth: counts[column] as usize,
                    zeros: 0,
                    complex: complex[column],
                    joined: None,
                }),
            }
            group_of.push(all.len() as u32 - 1);
        }
        Self { all, group_of }
    }

    /// Joins groups with their parents where this puts few zeros into the factor.
    fn join_children(&mut self, parents: &[u32]) {
        for child in 0..self.all.len() {
            let above = parents[self.all[child].last];
            let Some(&parent) = self.group_of.get(above as usize) else {
                continue;
            };
            let parent = parent as usize;
            let Group {
                width,
                depth,
                zeros,
                complex,
                ..
            } = self.all[child];
            let group = &mut self.all[parent];
            let joined_width = width + group.width;
            let zeros = zeros + group.zeros + width * (group.width + group.depth - depth);
            let entries = joined_width * (joined_width + 1) / 2 + joined_width * group.depth;
            let allowed = JOINED.iter().find(|(most, _)| joined_width <= *most);
            let share = allowed.map_or(0.0, |(_, share)| *share);
            if complex == group.complex && zeros as f64 <= share * entries as f64 {
                group.width = joined_width;
                group.zeros = zeros;
                self.all[child].joined = Some(parent);
            }
        }
    }

    /// The columns, those of one joined group after the other, and the groups' widths.
    ///
    /// Groups are numbered in postorder and join later ones, so that those that have joined stand
    /// in order, descendants first.
    fn columns_in_order(&self, columns: usize) -> (Vec<u32>, Vec<usize>) {
        let mut heads: Vec<usize> = (0..self.all.len()).collect();
        for group in (0..self.all.len()).rev() {
            if let Some(joined) = self.all[group].joined {
                heads[group] = heads[joined];
            }
        }
        let mut starts = vec![0; self.all.len() + 1];
        for &group in &self.group_of {
            starts[heads[group as usize] + 1] += 1;
        }
        let widths = starts.iter().filter(|&&width| width > 0);
        let widths = widths.map(|&width| width as usize).collect();
        sum_up(&mut starts);
        let mut sequence = vec![0; columns];
        for (column, &group) in (0..).zip(&self.group_of) {
            let slot = &mut starts[heads[group as usize]];
            sequence[*slot as usize] = column;
            *slot += 1;
        }
        (sequence, widths)
    }
}

/// The blocks, and the rows below each: those of its own columns and of the blocks that pass on to it.
fn blocks_of(later: &Neighbours, widths: &[usize], complex: &[bool]) -> (Vec<Block>, Vec<u32>) {
    let blocks = widths.iter().enumerate();
    let block_of = blocks.flat_map(|(block, &width)| std::iter::repeat_n(block, width));
    let block_of: Vec<usize> = block_of.collect();
    let mut blocks: Vec<Block> = Vec::with_capacity(widths.len());
    let mut rows: Vec<u32> = Vec::new();
    // Children of each block as a linked list, later ones first.
    let mut children = Lists::new(widths.len());
    let mut marks = vec![NONE; complex.len()];
    let mut found = Vec::new();
    let mut begin = 0;
    for (index, &width) in widths.iter().enumerate() {
        let columns = begin..begin + width;
        let start = rows.len();
        found.clear();
        let mut take = |row: u32, found: &mut Vec<u32>| {
            if row as usize >= columns.end && marks[row as usize] != index as u32 {
                marks[row as usize] = index as u32;
                found.push(row);
            }
        };
        for child in children.of(index) {
            let below = blocks[child].below.clone();
            for at in below {
                take(rows[at], &mut found);
            }
        }
        for column in columns.clone() {
            for &row in later.of(column) {
                take(row, &mut found);
            }
        }
        found.sort_unstable();
        rows.extend_from_slice(&found);
        let parent = found.first().map(|&row| block_of[row as usize]);
        if let Some(parent) = parent {
            children.add(parent, index);
        }
        blocks.push(Block {
            below: start..rows.len(),
            parent,
            complex: complex[begin],
            columns,
        });
        begin += width;
    }
    (blocks, rows)
}

/// Short lists of numbers, one for each number, the latest entry first.
struct Lists {
    heads: Vec<u32>,
    next: Vec<u32>,
}

impl Lists {
    fn new(count: usize) -> Self {
        Self {
            heads: vec![NONE; count],
            next: vec![NONE; count],
        }
    }

    fn add(&mut self, list: usize, member: usize) {
        self.next[member] = std::mem::replace(&mut self.heads[list], member as u32);
    }

    fn of(&self, list: usize) -> impl Iterator<Item = usize> + '_ {
        let following = |member: u32| (member != NONE).then_some(member);
        let head = following(self.heads[list]);
        std::iter::successors(head, move |&member| following(self.next[member as usize]))
            .map(|member| member as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::SymmetricMatrix;
    use graticule_fixtures::Noise;

    /// A random sparse pattern of several pieces.
    #[expect(clippy::cast_sign_loss, reason = "noise is not negative")]
    fn pattern(order: usize, seed: u64) -> SymmetricMatrix {
        let mut noise = Noise::new(seed);
        let mut entries: Vec<_> = (0..order).map(|k| (k, k, 1.0)).collect();
        for _ in 0..order {
            let [a, b] = [0; 2].map(|_| (noise.unit() * order as f64) as usize % order);
            // No entry between the two halves.
            if a != b && (a < order / 2) == (b < order / 2) {
                entries.push((a.max(b), a.min(b), 1.0));
            }
        }
        SymmetricMatrix::from_triplets(order, entries).unwrap()
    }

    /// Rows below the diagonal of each column of the factor, by elimination on sets.
    fn eliminated(pattern: &Pattern, places: &[u32]) -> Vec<Vec<u32>> {
        let mut columns = vec![std::collections::BTreeSet::new(); places.len()];
        for column in 0..places.len() {
            for &row in pattern.column(column) {
                let [a, b] = [places[column], places[row as usize]];
                if a != b {
                    columns[a.min(b) as usize].insert(a.max(b));
                }
            }
        }
        for column in 0..columns.len() {
            let mut rows = columns[column].clone();
            if let Some(parent) = rows.pop_first() {
                columns[parent as usize].extend(rows);
            }
        }
        columns.into_iter().map(Vec::from_iter).collect()
    }

    #[test]
    fn column_counts_are_those_of_elimination_on_sets() {
        for seed in 0..20 {
            let matrix = pattern(60, seed);
            let pattern = matrix.lower().pattern();
            let places: Vec<u32> = (0..60).collect();
            let earlier = Neighbours::earlier(pattern, &places);
            let parents = elimination_tree(&earlier, 60);
            let sequence = postorder(&parents);
            let places = inverse(&sequence);
            let parents = relabelled(&parents, &sequence, &places);
            let later = earlier.turned(&places);
            let columns = eliminated(pattern, &places);
            let counts = columns.iter().map(|rows| rows.len() as u32);
            assert_eq!(column_counts(&later, &parents), counts.collect::<Vec<_>>());
            let first = columns.iter().map(|rows| rows.first().copied());
            let first: Vec<u32> = first.map(|row| row.unwrap_or(NONE)).collect();
            assert_eq!(parents, first);
        }
    }

    #[test]
    fn blocks_hold_every_entry_of_the_factor_and_stand_after_their_children() {
        for seed in 0..20 {
            let matrix = pattern(80, seed);
            let pattern = matrix.lower().pattern();
            let plan = Plan::new(pattern, &Ordering::natural(80), |unknown| unknown % 9 == 0);
            let columns = eliminated(pattern, &plan.places);
            let mut next = 0;
            for (index, block) in plan.blocks.iter().enumerate() {
                assert_eq!(block.columns.start, next);
                next = block.columns.end;
                let below = plan.rows_below(block);
                assert!(below.is_sorted() && block.parent.is_none_or(|parent| parent > index));
                for column in block.columns.clone() {
                    let known =
                        |row: &u32| block.columns.contains(&(*row as usize)) || below.contains(row);
                    assert!(columns[column].iter().all(known));
                    let complex = plan.order[column].is_multiple_of(9);
                    assert!(block.complex || !complex);
                }
                if let Some(parent) = block.parent {
                    assert!(plan.blocks[parent].complex || !block.complex);
                }
            }
            assert_eq!(next, 80);
        }
    }
}
