//! The unit of time **L** of `BENCHMARKS.md`.

use std::error::Error;

use faer::sparse::{CreationError, SparseColMat, Triplet};
use faer::{Par, Side};
use graticule_fixtures::Fixture;

/// What `clock` advances by while the Laplacian of a mesh is analysed and factored once, on one
/// thread.
pub(crate) fn unit_of_time(mesh: &Fixture, clock: impl Fn() -> f64) -> Result<f64, Box<dyn Error>> {
    let laplacian = laplacian(mesh).map_err(|error| format!("{error:?}"))?;
    faer::set_global_parallelism(Par::Seq);
    let start = clock();
    let factors = laplacian.sp_cholesky(Side::Lower);
    let seconds = clock() - start;
    factors.map_err(|error| format!("{error:?}"))?;
    Ok(seconds)
}

/// The cotangent Laplacian plus 1e-6 on the diagonal, which makes it positive definite.
fn laplacian(mesh: &Fixture) -> Result<SparseColMat<usize, f64>, CreationError> {
    let mut triplets = Vec::with_capacity(12 * mesh.triangles.len());
    for triangle in &mesh.triangles {
        let vertices = triangle.map(|vertex| vertex as usize);
        let [a, b, c] = vertices.map(|vertex| mesh.positions[vertex]);
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
    let count = mesh.positions.len();
    triplets.extend((0..count).map(|vertex| Triplet::new(vertex, vertex, 1e-6)));
    SparseColMat::try_new_from_triplets(count, count, &triplets)
}
