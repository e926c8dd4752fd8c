//! Surfaces with known answers, as plain arrays, for tests of every crate.
//!
//! The arrays are plain so that the library's own unit tests can use them too. All surfaces face
//! outward (flat ones toward +z) and are deterministic; irregular ones take a seed.

mod closed;
mod hard;
mod hostile;
mod noise;
mod patches;
mod quads;

pub use closed::{CUBE_QUADS, bumpy_sphere, cube, cylinder_closed, icosphere, tetrahedron, torus};
pub use hard::{
    block_with_holes, cone_closed, ellipsoid, grid_with_flat_triangles, hyperboloid, needles,
    sheared_strip,
};
pub use hostile::{Choices, HostileSoup, hostile_soup};
pub use noise::Noise;
pub use patches::{
    annulus, bumpy_patch, cone_patch, cylinder_patch, disk, grid, irregular_disk, saddle_patch,
    spherical_cap, vase,
};
pub use quads::{QuadFixture, quad_cube, quad_grid, quad_torus};

use std::fmt::Write;

use glam::DVec3;

/// A triangle mesh as plain arrays.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixture {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Fixture {
    /// The surface as an OBJ file.
    #[must_use]
    pub fn to_obj(&self) -> String {
        let mut text = String::new();
        for p in &self.positions {
            let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
        }
        for [a, b, c] in &self.triangles {
            let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
        }
        text
    }

    /// The same mesh with every position changed by `change`.
    #[must_use]
    pub fn map(mut self, change: impl Fn(DVec3) -> DVec3) -> Self {
        for position in &mut self.positions {
            *position = change(*position);
        }
        self
    }

    /// The same surface with vertices and triangles in a shuffled order, and each triangle's
    /// corners rotated; also returns the new number of each old vertex.
    #[must_use]
    pub fn renumbered(&self, seed: u64) -> (Self, Vec<u32>) {
        let mut noise = Noise::new(seed);
        let new_of_old = noise.permutation(self.positions.len());
        let mut positions = self.positions.clone();
        for (old, &new) in new_of_old.iter().enumerate() {
            positions[new as usize] = self.positions[old];
        }
        let mut triangles = self.triangles.clone();
        for (old, &new) in noise.permutation(triangles.len()).iter().enumerate() {
            let mut triangle = self.triangles[old].map(|vertex| new_of_old[vertex as usize]);
            triangle.rotate_left(old % 3);
            triangles[new as usize] = triangle;
        }
        (
            Self {
                positions,
                triangles,
            },
            new_of_old,
        )
    }

    /// Both meshes side by side in one, the second one's vertices after the first one's.
    #[must_use]
    pub fn joined(mut self, other: &Self) -> Self {
        let offset = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        let moved = other
            .triangles
            .iter()
            .map(|triangle| triangle.map(|vertex| vertex + offset));
        self.triangles.extend(moved);
        self
    }

    /// The same surface with every triangle split in four at the middles of its edges.
    #[must_use]
    pub fn subdivided(&self) -> Self {
        let mut positions = self.positions.clone();
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((self.positions[a as usize] + self.positions[b as usize]) / 2.0);
                positions.len() as u32 - 1
            })
        };
        let mut triangles = Vec::with_capacity(4 * self.triangles.len());
        for &[a, b, c] in &self.triangles {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        Self {
            positions,
            triangles,
        }
    }
}

/// The corners of each cell of a net, row after row, where `vertex` numbers the point at a row and
/// a column: along the row, then back along the next one.
fn cells(
    rows: u32,
    columns: u32,
    vertex: impl Fn(u32, u32) -> u32,
) -> impl Iterator<Item = [u32; 4]> {
    let places = (0..rows).flat_map(move |row| (0..columns).map(move |column| (row, column)));
    places.map(move |(row, column)| {
        [
            vertex(row, column),
            vertex(row, column + 1),
            vertex(row + 1, column + 1),
            vertex(row + 1, column),
        ]
    })
}
