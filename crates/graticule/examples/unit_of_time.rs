//! The unit of time **L** of `BENCHMARKS.md`: one analysis and factorisation of a mesh's cotangent
//! Laplacian by `faer`, in `faer`'s own ordering, on one thread.
//!
//! ```text
//! cargo run --release -p graticule --example unit_of_time -- RINGS
//! ```
//!
//! prints its seconds for the bumpy patch of so many rings, which has 3 RINGS² + 3 RINGS + 1
//! vertices.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::time::Instant;

use faer::sparse::{CreationError, SparseColMat, Triplet};
use faer::{Par, Side};
use graticule_fixtures::{Fixture, bumpy_patch};

fn main() -> Result<(), Box<dyn Error>> {
    let rings = std::env::args().nth(1).ok_or("argument: RINGS")?.parse()?;
    let laplacian = laplacian(&bumpy_patch(rings, 1)).map_err(|error| format!("{error:?}"))?;
    faer::set_global_parallelism(Par::Seq);
    let start = Instant::now();
    let factors = laplacian.sp_cholesky(Side::Lower);
    let seconds = start.elapsed().as_secs_f64();
    factors.map_err(|error| format!("{error:?}"))?;
    println!("{seconds}");
    Ok(())
}

/// The cotangent Laplacian plus 1e-6 on the diagonal, which makes it positive definite.
fn laplacian(patch: &Fixture) -> Result<SparseColMat<usize, f64>, CreationError> {
    let mut triplets = Vec::with_capacity(12 * patch.triangles.len());
    for triangle in &patch.triangles {
        let vertices = triangle.map(|vertex| vertex as usize);
        let [a, b, c] = vertices.map(|vertex| patch.positions[vertex]);
        let double_area = (b - a).cross(c - a).length();
        let sides = [(b - a, c - a), (c - b, a - b), (a - c, b - c)];
        for (corner, (one, other)) in sides.into_iter().enumerate() {
            let weight = one.dot(other) / double_area / 2.0;
            let [i, j] = [vertices[(corner + 1) % 3], vertices[(corner + 2) % 3]];
            triplets.extend([
                Triplet::new(i, i, weight),
                Triplet::new(j, j, weight),
                Triplet::new(i, j, -weight),
                Triplet::new(j, i, -weight),
            ]);
        }
    }
    let count = patch.positions.len();
    triplets.extend((0..count).map(|vertex| Triplet::new(vertex, vertex, 1e-6)));
    SparseColMat::try_new_from_triplets(count, count, &triplets)
}
