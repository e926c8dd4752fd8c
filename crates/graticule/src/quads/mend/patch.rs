use std::collections::HashSet;

use glam::DVec3;

use super::super::partition::{MIDDLE, Partition, WEIGHED_CORNERS, ordered};
use super::quilt::{Quilt, sides};

/// Share of the way to the middle of a patch at which the vertices of a pillow begin.
const PILLOW_INSET: f64 = 0.5;

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
    /// Their vertices; new ones are numbered from [`MIDDLE`] down.
    pub(super) polygons: Vec<Vec<u32>>,
    /// Where the new vertices are to be.
    pub(super) middles: Vec<DVec3>,
}

/// Which of the new vertices a number of a [`Candidate`] stands for, if it is not too large for one.
pub(super) fn new_vertex(vertex: u32) -> usize {
    (MIDDLE - vertex) as usize
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

    /// The patches with a polygon in them that a pillow may cover: it alone, then others.
    pub(super) fn under_pillows(quilt: &Quilt, polygon: u32) -> Vec<Self> {
        let alone = Self::of(quilt, vec![polygon]);
        let others = Self::around(quilt, polygon);
        alone.into_iter().chain(others).collect()
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
                middles: Vec::new(),
            }];
        }
        let edges = self.edges_outside(quilt);
        let positions = quilt.positions();
        let mut partition = Partition::of(border, positions, quilt.held(), &edges);
        let middle = self.middle(quilt);
        let without = partition.without_middle().map(|pieces| Candidate {
            polygons: pieces.polygons,
            middles: Vec::new(),
        });
        let with = partition.with_middle(middle).map(|pieces| Candidate {
            polygons: pieces.polygons,
            middles: vec![middle],
        });
        without.into_iter().chain(with).collect()
    }

    /// The mean of the vertices inside, or of the border where there are none.
    fn middle(&self, quilt: &Quilt) -> DVec3 {
        let vertices = if self.inside.is_empty() {
            &self.border
        } else {
            &self.inside
        };
        let positions = quilt.positions();
        let sum: DVec3 = vertices.iter().map(|&v| positions[v as usize]).sum();
        sum / vertices.len() as f64
    }

    /// A ring of quads along the border, and quads within that; `None` where these cannot be.
    ///
    /// So each corner of the border is shared by two quads at least, whatever is outside: also one of
    /// 180° or more between two sides on lines (a *pillow*: S. Mitchell, T. Tautges, *Pillowing doublets:
    /// refining a mesh to ensure that faces share at most one edge*, 1995).
    pub(super) fn pillow(&self, quilt: &Quilt) -> Option<Candidate> {
        let (border, centre) = (&self.border, self.middle(quilt));
        let count = border.len();
        let middles: Vec<DVec3> = (border.iter())
            .map(|&vertex| quilt.positions()[vertex as usize].lerp(centre, PILLOW_INSET))
            .collect();
        let ring: Vec<u32> = (0..count as u32).collect();
        let within = if count == 4 {
            vec![ring.clone()]
        } else {
            let (held, edges) = (vec![false; count], HashSet::new());
            let partition = Partition::of(&ring, &middles, &held, &edges);
            partition.without_middle()?.polygons
        };
        let new = |place: u32| MIDDLE - place;
        let beside = ring.iter().map(|&place| {
            let next = (place + 1) % count as u32;
            let [from, to] = [place, next].map(|at| border[at as usize]);
            vec![from, to, new(next), new(place)]
        });
        let within = within
            .into_iter()
            .map(|piece| piece.into_iter().map(new).collect());
        Some(Candidate {
            polygons: beside.chain(within).collect(),
            middles,
        })
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
