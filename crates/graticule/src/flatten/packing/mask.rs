//! Islands as sets of grid cells, and the search for a place that is free.

use glam::DVec2;

const BITS: usize = 64;

/// Cells touched by an island, row by row from the bottom; in each row from the left.
pub(super) struct Mask {
    rows: Vec<Vec<u64>>,
    width: usize,
}

impl Mask {
    /// The cells of side 1 that lie within `margin` of the triangles, and perhaps a few beside
    /// them; all in the first quadrant.
    pub(super) fn of(places: &[DVec2], triangles: &[[u32; 3]], margin: f64) -> Self {
        let high = places.iter().fold(DVec2::ZERO, |high, &p| high.max(p)) + margin;
        let [width, height] = [high.x, high.y].map(|extent| cell(extent) + 1);
        let mut mask = Self {
            rows: vec![vec![0; width.div_ceil(BITS)]; height],
            width,
        };
        for triangle in triangles {
            mask.add(triangle.map(|vertex| places[vertex as usize]), margin);
        }
        mask
    }

    /// Adds each row's cells between the leftmost and the rightmost point of the triangle there.
    fn add(&mut self, corners: [DVec2; 3], margin: f64) {
        let [a, b, c] = corners;
        let [low, high] = [
            a.y.min(b.y).min(c.y) - margin,
            a.y.max(b.y).max(c.y) + margin,
        ];
        for row in cell(low)..=cell(high).min(self.rows.len() - 1) {
            let [bottom, top] = [row as f64 - margin, row as f64 + 1.0 + margin];
            let mut span = [f64::INFINITY, f64::NEG_INFINITY];
            for [p, q] in [[a, b], [b, c], [c, a]] {
                widen(&mut span, [p, q], [bottom, top]);
            }
            if span[0] <= span[1] {
                let first = cell(span[0] - margin);
                let last = cell(span[1] + margin).min(self.width - 1);
                (first..=last).for_each(|cell| self.rows[row][cell / BITS] |= 1 << (cell % BITS));
            }
        }
    }
}

/// The cell that holds a coordinate; the first one for those below 0.
#[expect(clippy::cast_sign_loss, reason = "not below zero")]
fn cell(coordinate: f64) -> usize {
    coordinate.max(0.0) as usize
}

/// Widens the span by the part of a segment that lies between two heights.
fn widen(span: &mut [f64; 2], [p, q]: [DVec2; 2], [bottom, top]: [f64; 2]) {
    let [low, high] = if p.y <= q.y { [p, q] } else { [q, p] };
    if high.y < bottom || low.y > top {
        return;
    }
    let at = |height: f64| {
        let share = (height - low.y) / (high.y - low.y);
        low.x + (high.x - low.x) * share.clamp(0.0, 1.0)
    };
    let ends = if high.y > low.y {
        [at(low.y.max(bottom)), at(high.y.min(top))]
    } else {
        [low.x, high.x]
    };
    for x in ends {
        *span = [span[0].min(x), span[1].max(x)];
    }
}

/// The cells taken so far.
pub(super) struct Grid {
    rows: Vec<Vec<u64>>,
    width: usize,
}

impl Grid {
    pub(super) fn new() -> Self {
        Self {
            rows: Vec::new(),
            width: 0,
        }
    }

    /// The side of the square around all that was put here.
    pub(super) fn side(&self) -> usize {
        self.width.max(self.rows.len())
    }

    /// Where, and by which of the masks, the square around all grows least; the lowest such place,
    /// of those the leftmost.
    pub(super) fn best_place(&self, masks: &[Mask; 4]) -> (usize, [usize; 2]) {
        let mut best = (usize::MAX, usize::MAX, 0, [0, 0]);
        for (turn, mask) in masks.iter().enumerate() {
            for y in 0..=self.rows.len() {
                let grown_height = self.rows.len().max(y + mask.rows.len());
                // Places further up are worse in every respect from here on.
                if (grown_height.max(self.width), y) >= (best.0, best.1) {
                    break;
                }
                let most = best.0.saturating_sub(mask.width);
                if let Some(x) = self.first_free(mask, y, most.min(self.width)) {
                    let grown = grown_height.max(self.width.max(x + mask.width));
                    if (grown, y) < (best.0, best.1) {
                        best = (grown, y, turn, [x, y]);
                    }
                }
            }
        }
        (best.2, best.3)
    }

    /// The leftmost free place of a mask in a row, up to `most`.
    fn first_free(&self, mask: &Mask, y: usize, most: usize) -> Option<usize> {
        let mut x = 0;
        while x <= most {
            match self.conflict(mask, [x, y]) {
                None => return Some(x),
                Some(skip) => x += skip,
            }
        }
        None
    }

    /// By how much a mask must at least go to the right to come off what it meets; `None` if it is
    /// free.
    fn conflict(&self, mask: &Mask, [x, y]: [usize; 2]) -> Option<usize> {
        let [words, shift] = [x / BITS, x % BITS];
        for (row, taken) in mask.rows.iter().zip(self.rows.iter().skip(y)) {
            for (index, &word) in row.iter().enumerate() {
                let low = taken.get(words + index).copied().unwrap_or(0) >> shift;
                let next = taken.get(words + index + 1).copied().unwrap_or(0);
                let high = if shift > 0 { next << (BITS - shift) } else { 0 };
                let seen = low | high;
                if word & seen != 0 {
                    // This cell of the island meets every cell of the run as it goes right.
                    let first = (word & seen).trailing_zeros();
                    return Some((seen >> first).trailing_ones() as usize);
                }
            }
        }
        None
    }

    /// Takes the cells of a mask.
    pub(super) fn put(&mut self, mask: &Mask, [x, y]: [usize; 2]) {
        self.width = self.width.max(x + mask.width);
        let height = self.rows.len().max(y + mask.rows.len());
        self.rows.resize(height, Vec::new());
        let [words, shift] = [x / BITS, x % BITS];
        for (row, taken) in mask.rows.iter().zip(&mut self.rows[y..]) {
            let needed = words + row.len() + 1;
            if taken.len() < needed {
                taken.resize(needed, 0);
            }
            for (index, &word) in row.iter().enumerate() {
                taken[words + index] |= word << shift;
                if shift > 0 {
                    taken[words + index + 1] |= word >> (BITS - shift);
                }
            }
        }
    }
}
