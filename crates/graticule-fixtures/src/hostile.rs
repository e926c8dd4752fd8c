//! Polygon soups with every fault that a file can have.

use glam::DVec3;

use crate::{Fixture, annulus, block_with_holes, bumpy_patch, cube, grid, icosphere, torus};

/// Where a soup takes its choices from: a number below its argument, which is never 0.
pub type Choices<'a> = &'a mut dyn FnMut(usize) -> usize;

/// Polygons over positions, with faults.
#[derive(Clone, Debug, PartialEq)]
pub struct HostileSoup {
    /// Vertex positions, of which a few may not be finite.
    pub positions: Vec<DVec3>,
    /// Polygons; indices are in range, all else is open.
    pub polygons: Vec<Vec<u32>>,
}

/// A surface with up to a dozen faults of kinds that follow from `choose`: turned, missing, doubled
/// and stray polygons, joined and coinciding vertices, needles, slivers, polygons with more corners,
/// further components, extreme positions.
#[must_use]
pub fn hostile_soup(choose: Choices<'_>) -> HostileSoup {
    let mut soup = HostileSoup::of(&some_surface(choose));
    for _ in 0..choose(12) {
        soup.damage(choose);
    }
    if choose(8) == 0 {
        let factor = [1e-12, 1e-9, 1e9, 1e12, 1e100, 1e-100][choose(6)];
        soup.positions.iter_mut().for_each(|p| *p *= factor);
    }
    soup
}

fn some_surface(choose: Choices<'_>) -> Fixture {
    match choose(9) {
        0 => cube(),
        1 => icosphere(2),
        2 => torus(1.0, 0.4, 14, 8),
        3 => grid(2.0, 1.0, 8, 4),
        4 => annulus(0.4, 1.0, 16, 3),
        5 => block_with_holes(1),
        6 => bumpy_patch(6, choose(100) as u64),
        7 => cube().joined(&icosphere(1).map(|p| 0.3 * p)),
        _ => random_triangles(choose),
    }
}

/// Triangles over a few positions, neither manifold nor oriented.
fn random_triangles(choose: Choices<'_>) -> Fixture {
    let mut coordinate = || choose(9) as f64 - 4.0;
    let mut position = || DVec3::new(coordinate(), coordinate(), coordinate());
    let positions: Vec<DVec3> = (0..10).map(|_| position()).collect();
    let count = 1 + choose(24);
    let mut corner = || choose(positions.len()) as u32;
    let triangles = (0..count).map(|_| [corner(), corner(), corner()]).collect();
    Fixture {
        positions,
        triangles,
    }
}

impl HostileSoup {
    fn of(fixture: &Fixture) -> Self {
        Self {
            positions: fixture.positions.clone(),
            polygons: fixture.triangles.iter().map(|t| t.to_vec()).collect(),
        }
    }

    fn vertex(&self, choose: Choices<'_>) -> u32 {
        choose(self.positions.len()) as u32
    }

    fn damage(&mut self, choose: Choices<'_>) {
        let polygon = choose(self.polygons.len());
        match choose(14) {
            0 => self.polygons[polygon].reverse(),
            1 if self.polygons.len() > 1 => drop(self.polygons.swap_remove(polygon)),
            2 => self.polygons.push(self.polygons[polygon].clone()),
            3 => {
                let mut turned = self.polygons[polygon].clone();
                turned.reverse();
                self.polygons.push(turned);
            }
            4 => {
                let stray = (0..3 + choose(4)).map(|_| self.vertex(choose)).collect();
                self.polygons.push(stray);
            }
            5 => self.join_vertices(choose),
            6 => self.add_corner(polygon, choose),
            7 => self.merge(polygon, choose),
            8 => self.spoil_position(choose),
            9 => self.positions.push(DVec3::splat(3.0)),
            10 => self.add_fin(polygon),
            11 => self.repeat(choose),
            _ => self.move_vertex(polygon, choose),
        }
    }

    /// Lets one vertex stand for another wherever it is used.
    fn join_vertices(&mut self, choose: Choices<'_>) {
        let (kept, gone) = (self.vertex(choose), self.vertex(choose));
        let corners = self.polygons.iter_mut().flatten();
        corners.filter(|v| **v == gone).for_each(|v| *v = kept);
    }

    fn add_corner(&mut self, polygon: usize, choose: Choices<'_>) {
        let vertex = self.vertex(choose);
        let at = choose(self.polygons[polygon].len() + 1);
        self.polygons[polygon].insert(at, vertex);
    }

    /// Joins a polygon with another over an edge of both, if there is one.
    fn merge(&mut self, polygon: usize, choose: Choices<'_>) {
        let corners = self.polygons[polygon].clone();
        let side = choose(corners.len());
        let (from, to) = (corners[side], corners[(side + 1) % corners.len()]);
        let across = |other: &Vec<u32>| {
            let next = |at: usize| other[(at + 1) % other.len()];
            (0..other.len()).find(|&at| other[at] == to && next(at) == from)
        };
        let found = self.polygons.iter().position(|p| across(p).is_some());
        let Some(other) = found.filter(|&other| other != polygon) else {
            return;
        };
        let Some(at) = across(&self.polygons[other]) else {
            return;
        };
        let mut others = self.polygons[other].clone();
        others.rotate_left(at);
        let joined = &mut self.polygons[polygon];
        let after = joined.split_off(side + 1);
        joined.extend(others.into_iter().skip(2).chain(after));
        self.polygons.swap_remove(other);
    }

    /// Moves a vertex of a polygon onto another, onto the line of two others, or very near to one.
    fn move_vertex(&mut self, polygon: usize, choose: Choices<'_>) {
        let corners = &self.polygons[polygon];
        let mut corner = || corners[choose(corners.len())] as usize;
        let (moved, a, b) = (corner(), corner(), corner());
        let (a, b) = (self.positions[a], self.positions[b]);
        let near = self.positions[moved] - a;
        self.positions[moved] = match choose(5) {
            0 => a,
            1 => 0.5 * (a + b),
            2 => a + 1e-13 * near,
            3 => a + 1e-6 * near,
            _ => a + 30.0 * near,
        };
    }

    fn spoil_position(&mut self, choose: Choices<'_>) {
        let value = [f64::NAN, f64::INFINITY, 1e300, -1e154, 5e-324, 0.0][choose(6)];
        let vertex = self.vertex(choose) as usize;
        self.positions[vertex][choose(3)] = value;
    }

    /// A third polygon on an edge.
    fn add_fin(&mut self, polygon: usize) {
        let corners = &self.polygons[polygon];
        let (a, b) = (corners[0], corners[1 % corners.len()]);
        let tip = self.positions[a as usize] + DVec3::new(0.3, 0.2, 0.9);
        self.positions.push(tip);
        let tip = self.positions.len() as u32 - 1;
        self.polygons.push(vec![a, b, tip]);
    }

    /// The whole soup once more, elsewhere or in the same place.
    fn repeat(&mut self, choose: Choices<'_>) {
        if self.polygons.len() > 2000 {
            return;
        }
        let shift = [DVec3::ZERO, DVec3::X, DVec3::new(5.0, 0.1, 0.0)][choose(3)];
        let first = self.positions.len() as u32;
        let copies: Vec<DVec3> = self.positions.iter().map(|p| *p + shift).collect();
        self.positions.extend(copies);
        let copies: Vec<Vec<u32>> = self.polygons.clone();
        let moved = |polygon: Vec<u32>| polygon.into_iter().map(|v| v + first).collect();
        self.polygons.extend(copies.into_iter().map(moved));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Noise;

    #[test]
    fn indices_are_in_range_and_seeds_differ() {
        let soup = |seed| {
            let mut noise = Noise::new(seed);
            hostile_soup(&mut |count| noise.below(count))
        };
        for seed in 0..500 {
            let HostileSoup {
                positions,
                polygons,
            } = soup(seed);
            let mut corners = polygons.iter().flatten();
            assert!(corners.all(|&vertex| (vertex as usize) < positions.len()));
            assert!(!polygons.is_empty());
        }
        assert_ne!(soup(1).polygons, soup(2).polygons);
    }
}
