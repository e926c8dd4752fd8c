//! Dense solves and matrices of meshes.

use graticule::solve::{SparseMatrix, SymmetricMatrix};
use graticule_fixtures::{Fixture, Noise};

/// Edges of a mesh, each once.
pub(crate) fn edges(fixture: &Fixture) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = fixture
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// The graph Laplacian of a mesh plus `shift` on the diagonal.
pub(crate) fn laplacian(fixture: &Fixture, shift: f64) -> SymmetricMatrix {
    let order = fixture.positions.len();
    let entries = edges(fixture).into_iter().flat_map(|[a, b]| {
        let [a, b] = [a as usize, b as usize];
        [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0)]
    });
    let diagonal = (0..order).map(|index| (index, index, shift));
    SymmetricMatrix::from_triplets(order, entries.chain(diagonal)).unwrap()
}

/// Random numbers in `-1.0..1.0`.
pub(crate) fn random(count: usize, seed: u64) -> Vec<f64> {
    let mut noise = Noise::new(seed);
    (0..count).map(|_| noise.signed()).collect()
}

/// A sparse symmetric matrix, positive definite by its dominant diagonal.
pub(crate) fn random_definite(order: usize, seed: u64) -> SymmetricMatrix {
    let mut noise = Noise::new(seed);
    let mut triplets: Vec<_> = (0..order).map(|i| (i, i, 8.0)).collect();
    for _ in 0..3 * order {
        triplets.push((noise.below(order), noise.below(order), 0.9 * noise.signed()));
    }
    SymmetricMatrix::from_triplets(order, triplets).unwrap()
}

/// A sparse matrix that is neither symmetric nor dominated by its diagonal.
pub(crate) fn random_general(order: usize, seed: u64) -> SparseMatrix {
    let mut noise = Noise::new(seed);
    let mut triplets: Vec<_> = noise
        .permutation(order)
        .into_iter()
        .enumerate()
        .map(|(row, column)| (row, column as usize, 2.0))
        .collect();
    for _ in 0..3 * order {
        triplets.push((noise.below(order), noise.below(order), noise.signed()));
    }
    SparseMatrix::from_triplets(order, order, triplets).unwrap()
}

/// Rows of a matrix.
pub(crate) fn dense(matrix: &SparseMatrix) -> Vec<Vec<f64>> {
    let mut rows = vec![vec![0.0; matrix.columns()]; matrix.rows()];
    for (row, column, value) in matrix.triplets() {
        rows[row][column] = value;
    }
    rows
}

/// Gaussian elimination with row exchanges.
pub(crate) fn dense_solve(mut rows: Vec<Vec<f64>>, right_side: &[f64]) -> Vec<f64> {
    let order = rows.len();
    let mut x = right_side.to_vec();
    for k in 0..order {
        let pivot = (k..order)
            .max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()))
            .unwrap();
        rows.swap(k, pivot);
        x.swap(k, pivot);
        for i in k + 1..order {
            let factor = rows[i][k] / rows[k][k];
            let (above, below) = rows.split_at_mut(i);
            for (entry, pivot_entry) in below[0].iter_mut().zip(&above[k]) {
                *entry -= factor * pivot_entry;
            }
            x[i] -= factor * x[k];
        }
    }
    for k in (0..order).rev() {
        let known: f64 = (k + 1..order).map(|j| rows[k][j] * x[j]).sum();
        x[k] = (x[k] - known) / rows[k][k];
    }
    x
}

/// Largest difference relative to the largest entry of the first.
pub(crate) fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = a.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    apart.fold(0.0, f64::max) / largest.max(f64::MIN_POSITIVE)
}
