//! Parts of an elimination that can be carried out side by side.

use std::ops::Range;

use super::plan::Block;

/// Eliminations of fewer multiplications are not parted: threads would cost more than they save.
const LEAST_WORK: f64 = 2e7;

/// The share of the work that a part may have. More and smaller ones would spread better, but leave
/// more updates waiting at once.
const MOST_OF_WORK: f64 = 1.0 / 16.0;

/// Ranges of blocks that hold all descendants of each of their blocks, as large as
/// [`MOST_OF_WORK`] allows; the blocks above them are in none.
pub(super) fn parts_of(blocks: &[Block]) -> Vec<Range<usize>> {
    let (work, firsts) = subtrees(blocks);
    let is_root = |index: &usize| blocks[*index].parent.is_none();
    let total: f64 = (0..blocks.len())
        .filter(is_root)
        .map(|root| work[root])
        .sum();
    if total < LEAST_WORK {
        return Vec::new();
    }
    let limit = MOST_OF_WORK * total;
    let mut parts: Vec<Range<usize>> = Vec::new();
    let mut filled = 0.0;
    for (index, block) in blocks.iter().enumerate() {
        let is_whole = block.parent.is_none_or(|parent| work[parent] > limit);
        if work[index] > limit || !is_whole {
            continue;
        }
        match parts.last_mut() {
            Some(part) if part.end == firsts[index] && filled + work[index] <= limit => {
                part.end = index + 1;
                filled += work[index];
            }
            _ => {
                parts.push(firsts[index]..index + 1);
                filled = work[index];
            }
        }
    }
    parts
}

/// For each block the multiplications of itself and its descendants, and the first of these.
fn subtrees(blocks: &[Block]) -> (Vec<f64>, Vec<usize>) {
    let mut work = vec![0.0; blocks.len()];
    let mut firsts: Vec<usize> = (0..blocks.len()).collect();
    for (index, block) in blocks.iter().enumerate() {
        work[index] += block.width() as f64 * (block.height() as f64).powi(2);
        if let Some(parent) = block.parent {
            work[parent] += work[index];
            firsts[parent] = firsts[parent].min(firsts[index]);
        }
    }
    (work, firsts)
}
