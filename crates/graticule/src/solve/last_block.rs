//! The block of a factor that belongs to the unknowns eliminated last.

use super::{Cholesky, SolveError};

impl Cholesky {
    /// The last block of `L`: a dense lower triangle, `last.len()²` numbers by rows.
    ///
    /// Times its own transpose it is the Schur complement of these unknowns, their matrix once all
    /// others take the values that are best for them
    /// (F. Zhang (ed.), *The Schur Complement and Its Applications*, 2005, §1.1).
    ///
    /// # Errors
    /// [`SolveError::BadFixedUnknown`] for an unknown that is not there, is named twice, or is
    /// eliminated before one that is not named or is named earlier.
    pub fn last_block(&self, last: &[u32]) -> Result<Vec<f64>, SolveError> {
        let order = self.matrix().order();
        let mut place_in_last = vec![u32::MAX; order];
        for (place, &unknown) in last.iter().enumerate() {
            let slot = place_in_last.get_mut(unknown as usize);
            let slot = slot.filter(|slot| **slot == u32::MAX);
            *slot.ok_or(bad(unknown, "named twice, or not there"))? = place as u32;
        }
        let count = last.len();
        let mut factor = vec![0.0; count * count];
        let mut misplaced = None;
        let unknowns = self.symbolic().plan().order();
        for column in self.multifrontal().real_columns() {
            let place_of = |row: usize| place_in_last[unknowns[row] as usize];
            let own = place_of(column.own.start);
            if own == u32::MAX {
                continue;
            }
            let below = column.below.iter().map(|&row| row as usize);
            for (row, &value) in column.own.chain(below).zip(column.values) {
                // Blocks are filled up with zeros between columns that do not meet.
                if value == 0.0 {
                    continue;
                }
                match place_of(row) {
                    row if row == u32::MAX || row < own => misplaced = Some(own),
                    row => factor[row as usize * count + own as usize] = value,
                }
            }
        }
        match misplaced {
            Some(column) => Err(bad(last[column as usize], "eliminated before others")),
            None => Ok(factor),
        }
    }
}

fn bad(unknown: u32, reason: &'static str) -> SolveError {
    let unknown = unknown as usize;
    SolveError::BadFixedUnknown { unknown, reason }
}

#[cfg(test)]
mod tests {
    use super::super::{Graph, Ordering, SymmetricMatrix};
    use super::*;
    use graticule_fixtures::Noise;

    /// A grid Laplacian plus the identity, with the unknowns of `last` in the last places.
    fn factored(side: usize, last: &[u32]) -> Cholesky {
        let mut noise = Noise::new(1);
        let vertex = |x: usize, y: usize| x + side * y;
        let mut entries = Vec::new();
        for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x, y))) {
            entries.push((vertex(x, y), vertex(x, y), 5.0 + noise.unit()));
            if x + 1 < side {
                entries.push((vertex(x + 1, y), vertex(x, y), noise.signed()));
            }
            if y + 1 < side {
                entries.push((vertex(x, y + 1), vertex(x, y), noise.signed()));
            }
        }
        let matrix = SymmetricMatrix::from_triplets(side * side, entries).unwrap();
        let free = Ordering::minimum_degree(&Graph::of_pattern(matrix.lower().pattern()));
        let mut order: Vec<u32> = free.order().to_vec();
        order.retain(|unknown| !last.contains(unknown));
        order.extend(last);
        let ordering = Ordering::from_order(order).unwrap();
        Cholesky::new(&matrix, &ordering).unwrap()
    }

    #[test]
    fn the_block_times_its_transpose_is_the_inverse_of_a_block_of_the_inverse() {
        for (side, last) in [(4, vec![3, 9, 6]), (40, vec![5, 800, 801, 1599])] {
            let cholesky = factored(side, &last);
            let block = cholesky.last_block(&last).unwrap();
            let rows = || block.chunks_exact(last.len());
            for column in 0..last.len() {
                // The solution for a load at one of them, times the complement, is a unit vector.
                let mut load = vec![0.0; side * side];
                load[last[column] as usize] = 1.0;
                let solved = cholesky.solve(&load).unwrap().values;
                for (row, entries) in rows().enumerate() {
                    let product = |other: &[f64]| -> f64 {
                        entries.iter().zip(other).map(|(a, b)| a * b).sum()
                    };
                    let terms = rows().map(product).zip(&last);
                    let sum: f64 = terms.map(|(s, &u)| s * solved[u as usize]).sum();
                    let unit = f64::from(u8::from(row == column));
                    assert!((sum - unit).abs() < 1e-12, "{row} {column} {sum}");
                }
            }
        }
    }

    #[test]
    fn unknowns_that_do_not_meet_may_be_eliminated_against_their_order() {
        // A tree in which the second unknown comes before the first, both in one block.
        let own = (0..4).map(|k| (k, k, 2.0));
        let coupled = [(2, 0, 1.0), (3, 1, 1.0), (3, 2, 1.0)];
        let matrix = SymmetricMatrix::from_triplets(4, own.chain(coupled)).unwrap();
        let cholesky = Cholesky::new(&matrix, &Ordering::natural(4)).unwrap();
        assert_ne!(cholesky.symbolic().plan().order(), [0, 1, 2, 3]);
        let block = cholesky.last_block(&[0, 1, 2, 3]).unwrap();
        for (row, column) in (0..4).flat_map(|row| (0..4).map(move |column| (row, column))) {
            let product: f64 = (0..4)
                .map(|k| block[4 * row + k] * block[4 * column + k])
                .sum();
            let entry = matrix.lower().get(row.max(column), row.min(column));
            assert!((product - entry).abs() < 1e-15, "{row} {column} {product}");
        }
    }

    #[test]
    fn unknowns_that_are_not_last_are_refused() {
        let cholesky = factored(4, &[3, 9]);
        for wrong in [&[3_u32, 3][..], &[16], &[5], &[9, 3]] {
            let refused = cholesky.last_block(wrong);
            assert!(matches!(refused, Err(SolveError::BadFixedUnknown { .. })));
        }
    }
}
