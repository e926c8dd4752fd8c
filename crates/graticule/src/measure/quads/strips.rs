use serde::Serialize;

use crate::mesh::PolygonConnectivity;

/// Rows of quads, each joined to the next by the side opposite to the one it was entered by. Every
/// quad lies in two rows, or in one that crosses itself there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Strips {
    /// The number of rows.
    pub count: usize,
    /// Those that return to where they began; the others end at the boundary or at a polygon that
    /// is no quad.
    pub closed: usize,
    /// Steps of the longest one; a quad where it crosses itself counts twice.
    pub longest: usize,
    /// Those that cross themselves.
    pub self_crossing: usize,
    /// Those that run beside themselves: spirals.
    pub spiral: usize,
}

const NONE: u32 = u32::MAX;

pub(super) fn count(mesh: &PolygonConnectivity) -> Strips {
    let mut rows = Rows::new(mesh);
    let mut strips = Strips::default();
    for polygon in 0..mesh.polygon_count() {
        for way in 0..2 {
            if rows.is_quad(polygon) && rows.rows[polygon][way] == NONE {
                let (length, closed) = rows.walk(polygon, way as u32, strips.count as u32);
                strips.count += 1;
                strips.closed += usize::from(closed);
                strips.longest = strips.longest.max(length);
            }
        }
    }
    strips.self_crossing = distinct(rows.crossings());
    strips.spiral = distinct(rows.neighbors_of_their_own());
    strips
}

fn distinct(mut rows: Vec<u32>) -> usize {
    rows.sort_unstable();
    rows.dedup();
    rows.len()
}

struct Rows<'a> {
    mesh: &'a PolygonConnectivity,
    /// For each quad the row through its sides 0 and 2, and that through 1 and 3.
    rows: Vec<[u32; 2]>,
}

impl<'a> Rows<'a> {
    fn new(mesh: &'a PolygonConnectivity) -> Self {
        let rows = vec![[NONE; 2]; mesh.polygon_count()];
        Self { mesh, rows }
    }

    fn is_quad(&self, polygon: usize) -> bool {
        self.mesh.vertices(polygon).len() == 4
    }

    /// Gives a row its number, both ways from a quad; returns its steps and whether it is closed.
    fn walk(&mut self, start: usize, way: u32, row: u32) -> (usize, bool) {
        self.rows[start][way as usize] = row;
        let mut steps = 1;
        for first in [way + 2, way] {
            let mut side = self.mesh.corners(start).start + first;
            while let Some(entered) = self.quad_beyond(side) {
                let polygon = self.mesh.polygon(entered);
                let place = entered - self.mesh.corners(polygon).start;
                let slot = &mut self.rows[polygon][place as usize % 2];
                if *slot == row {
                    return (steps, true);
                }
                *slot = row;
                steps += 1;
                side = self.mesh.next(self.mesh.next(entered));
            }
        }
        (steps, false)
    }

    /// The side of the quad on the other side of this side.
    fn quad_beyond(&self, side: u32) -> Option<u32> {
        let twin = self.mesh.twin(side)?;
        self.is_quad(self.mesh.polygon(twin)).then_some(twin)
    }

    /// The rows that have both ways through a quad.
    fn crossings(&self) -> Vec<u32> {
        let both = self
            .rows
            .iter()
            .filter(|[first, second]| first == second && *first != NONE);
        both.map(|[row, _]| *row).collect()
    }

    /// The row along each edge that is the same on both sides of it.
    fn neighbors_of_their_own(&self) -> Vec<u32> {
        let row_along = |side: u32| {
            let polygon = self.mesh.polygon(side);
            let place = side - self.mesh.corners(polygon).start;
            self.rows[polygon][(place as usize + 1) % 2]
        };
        let pairs = self.mesh.edges().filter_map(|sides| match *sides {
            [first, second] => Some([row_along(first), row_along(second)]),
            _ => None,
        });
        pairs
            .filter(|[first, second]| first == second && *first != NONE)
            .map(|[row, _]| row)
            .collect()
    }
}
