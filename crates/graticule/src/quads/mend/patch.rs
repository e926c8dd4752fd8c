use std::collections::HashSet;

use glam::DVec3;

use super::super::partition::{Partition, WEIGHED_CORNERS, ordered};
use super::quilt::{Quilt, sides};

/// A disk of polygons that no line passes through.
pub(super) struct Patch {
    /// In ascending order.
    pub(super) polygons: Vec<u32>,
    /// The vertices round it, counter-clockwise.
    pub(super) border: Vec<u32>,
    /// The vertices inside.
    inside: Vec<u32>,
}

/// Polygons to put in the place of a patch.
pub(super) struct Candidate {
    /// Their vertices; [`MIDDLE`](super::super::partition::MIDDLE) for a new one.
    pub(super) polygons: Vec<Vec<u32>>,
    /// Where the new vertex is to be, if there is one.
    pub(super) middle: Option<DVec3>,
}

impl Patch {
    /// Patches with a polygon in them, small ones first.
    pub(super) fn around(quilt: &Quilt, polygon: u32) -> Vec<Self> {
        let own = quilt.vertices(polygon);
        let beside: Vec<u32> = sides(own)
            .filter(|&side| !quilt.is_line(side))
            .filter_map(|side| quilt.beyond(side))
            .collect();
        let fans: Vec<Vec<u32>> = own.iter().map(|&v| quilt.fan(v, polygon)).collect();
        let mut sets: Vec<Vec<u32>> = beside.iter().map(|&other| vec![polygon, other]).collect();
        sets.extend(fans.iter().cloned());
        for (index, &one) in beside.iter().enumerate() {
            sets.extend(
                beside[..index]
                    .iter()
                    .map(|&other| vec![polygon, one, other]),
            );
        }
        for (index, one) in fans.iter().enumerate() {
            sets.extend(fans[..index].iter().map(|other| [&one[..], other].concat()));
        }
        sets.push(fans.concat());
        for set in &mut sets {
            set.sort_unstable();
            set.dedup();
        }
        sets.sort_by_key(Vec::len);
        sets.dedup();
        sets.into_iter()
            .filter_map(|set| Self::of(quilt, set))
            .collect()
    }

    /// The polygons as a patch, if they are one and its border is not too long.
    fn of(quilt: &Quilt, polygons: Vec<u32>) -> Option<Self> {
        let all: Vec<[u32; 2]> = (polygons.iter())
            .flat_map(|&polygon| sides(quilt.vertices(polygon)))
            .collect();
        let (inner, outer): (Vec<_>, Vec<_>) = all
            .iter()
            .partition(|&&[from, to]| all.contains(&[to, from]));
        let count = outer.len();
        if !(4..=WEIGHED_CORNERS).contains(&count) || inner.iter().any(|&side| quilt.is_line(side))
        {
            return None;
        }
        let mut border: Vec<u32> = vec![outer[0][0]];
        for _ in 1..count {
            let mut leaving = outer
                .iter()
                .filter(|side| side[0] == border[border.len() - 1]);
            let (next, None) = (leaving.next()?[1], leaving.next()) else {
                return None;
            };
            border.push(next);
        }
        let mut once = border.clone();
        once.sort_unstable();
        once.dedup();
        if once.len() < count {
            return None;
        }
        let mut inside: Vec<u32> = all.iter().map(|side| side[0]).collect();
        inside.sort_unstable();
        inside.dedup();
        let vertices = inside.len();
        inside.retain(|vertex| once.binary_search(vertex).is_err());
        let is_disk = vertices + polygons.len() == count + inner.len() / 2 + 1;
        is_disk.then_some(Self {
            polygons,
            border,
            inside,
        })
    }

    /// Other polygons for this patch.
    pub(super) fn candidates(&self, quilt: &Quilt) -> Vec<Candidate> {
        let border = &self.border;
        if border.len() == 4 {
            return vec![Candidate {
                polygons: vec![border.clone()],
                middle: None,
            }];
        }
        let edges = self.edges_outside(quilt);
        let positions = quilt.positions();
        let mut partition = Partition::of(border, positions, quilt.held(), &edges);
        let mean = |vertices: &[u32]| {
            let sum: DVec3 = vertices.iter().map(|&v| positions[v as usize]).sum();
            sum / vertices.len() as f64
        };
        let middle = mean(if self.inside.is_empty() {
            border
        } else {
            &self.inside
        });
        let without = partition.without_middle().map(|pieces| Candidate {
            polygons: pieces.polygons,
            middle: None,
        });
        let with = partition.with_middle(middle).map(|pieces| Candidate {
            polygons: pieces.polygons,
            middle: Some(middle),
        });
        without.into_iter().chain(with).collect()
    }

    /// The edges between vertices of the border that polygons outside have.
    fn edges_outside(&self, quilt: &Quilt) -> HashSet<[u32; 2]> {
        let outside = (self.border.iter()).flat_map(|&vertex| quilt.around(vertex));
        outside
            .filter(|polygon| self.polygons.binary_search(polygon).is_err())
            .flat_map(|&polygon| sides(quilt.vertices(polygon)))
            .filter(|side| side.iter().all(|vertex| self.border.contains(vertex)))
            .map(|[from, to]| ordered(from, to))
            .collect()
    }

    /// The polygons around the patch, in ascending order, `rings` deep.
    pub(super) fn surroundings(&self, quilt: &Quilt, rings: usize) -> Vec<u32> {
        let mut vertices = self.border.clone();
        let mut found = Vec::new();
        for _ in 0..rings {
            found = (vertices.iter())
                .flat_map(|&vertex| quilt.around(vertex))
                .copied()
                .filter(|polygon| self.polygons.binary_search(polygon).is_err())
                .collect();
            found.sort_unstable();
            found.dedup();
            let of_found = found.iter().flat_map(|&polygon| quilt.vertices(polygon));
            vertices.extend(of_found);
            vertices.sort_unstable();
            vertices.dedup();
        }
        found
    }
}
