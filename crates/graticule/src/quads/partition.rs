use std::collections::HashSet;

use glam::DVec3;

use crate::measure::scaled_jacobian;
use crate::tolerance::FLAT_CORNER;

/// The largest polygon of which all partitions are weighed; larger ones are halved first.
const WEIGHED_CORNERS: usize = 14;

/// Cost of a piece that is turned over or nearly so: more than any number of fair ones.
const INVERTED_PIECE: f64 = 1e3;

/// Cost of a piece along a chord that is an edge elsewhere: never.
const FORBIDDEN: f64 = f64::INFINITY;

/// Cuts polygons into quads, and one triangle each where the number of corners is odd.
pub(super) struct Partition<'a> {
    positions: &'a [DVec3],
    /// The edges of the mesh, chords included; asked, never walked.
    edges: &'a mut HashSet<[u32; 2]>,
}

/// The best partition of corners `from..=to` of a polygon: its cost, and the corners of the piece at
/// the chord between the ends.
#[derive(Clone, Copy)]
struct Best {
    cost: f64,
    piece: [usize; 2],
}

impl<'a> Partition<'a> {
    pub(super) fn new(positions: &'a [DVec3], edges: &'a mut HashSet<[u32; 2]>) -> Self {
        Self { positions, edges }
    }

    /// The pieces of a polygon by its vertices; `None` where every partition repeats an edge or turns
    /// a piece over.
    pub(super) fn pieces(&mut self, vertices: &[u32]) -> Option<Vec<Vec<u32>>> {
        if vertices.len() <= 4 {
            return Some(vec![vertices.to_vec()]);
        }
        if vertices.len() > WEIGHED_CORNERS {
            let [one, other] = self.halves(vertices)?;
            let mut pieces = self.pieces(&one)?;
            pieces.extend(self.pieces(&other)?);
            return Some(pieces);
        }
        let pieces = self.best_pieces(vertices)?;
        for piece in &pieces {
            for (index, &from) in piece.iter().enumerate() {
                self.edges
                    .insert(ordered(from, piece[(index + 1) % piece.len()]));
            }
        }
        Some(pieces)
    }

    /// The polygon cut along its shortest chord between corners an odd number of sides apart, each
    /// half with a third of the corners at least.
    fn halves(&mut self, vertices: &[u32]) -> Option<[Vec<u32>; 2]> {
        let count = vertices.len();
        let place = |index: usize| self.positions[vertices[index] as usize];
        let mut best: Option<(f64, usize, usize)> = None;
        for from in 0..count {
            for to in (from + 3..count).step_by(2) {
                let sides = (to - from).min(count - (to - from));
                let free = !self.edges.contains(&ordered(vertices[from], vertices[to]));
                let length = place(from).distance_squared(place(to));
                if 3 * sides >= count && free && best.is_none_or(|(least, ..)| length < least) {
                    best = Some((length, from, to));
                }
            }
        }
        let (_, from, to) = best?;
        self.edges.insert(ordered(vertices[from], vertices[to]));
        let one = vertices[from..=to].to_vec();
        let other = [&vertices[to..], &vertices[..=from]].concat();
        Some([one, other])
    }

    fn best_pieces(&self, vertices: &[u32]) -> Option<Vec<Vec<u32>>> {
        let count = vertices.len();
        let nothing = Best {
            cost: 0.0,
            piece: [0; 2],
        };
        let mut best = vec![nothing; count * count];
        for span in 2..count {
            for from in 0..count - span {
                let to = from + span;
                let whole = span == count - 1;
                best[from * count + to] = self.best_between(vertices, [from, to], whole, &best);
            }
        }
        if best[count - 1].cost >= INVERTED_PIECE {
            return None;
        }
        let mut pieces = Vec::new();
        let mut open = vec![[0, count - 1]];
        while let Some([from, to]) = open.pop() {
            if to - from < 2 {
                continue;
            }
            let [p, q] = best[from * count + to].piece;
            let mut piece = vec![from, p, q, to];
            piece.dedup();
            open.extend(piece.windows(2).map(|pair| [pair[0], pair[1]]));
            pieces.push(piece.into_iter().map(|index| vertices[index]).collect());
        }
        Some(pieces)
    }

    /// The best piece at the chord between two corners, with what lies behind its other sides.
    fn best_between(
        &self,
        vertices: &[u32],
        [from, to]: [usize; 2],
        whole: bool,
        best: &[Best],
    ) -> Best {
        let count = vertices.len();
        let mut least = Best {
            cost: FORBIDDEN,
            piece: [0; 2],
        };
        if !whole && self.edges.contains(&ordered(vertices[from], vertices[to])) {
            return least;
        }
        let even = (to - from) % 2 == 0;
        // Pieces behind an even number of sides hold the one triangle.
        for p in from + 1..to {
            for q in p..to {
                let behind = [[from, p], [p, q], [q, to]];
                let odd_ones = behind.iter().filter(|[a, b]| b > a && (b - a) % 2 == 0);
                let wanted = usize::from(even && p != q);
                if odd_ones.count() != wanted || p == q && !even {
                    continue;
                }
                let corners = [from, p, q, to].map(|index| vertices[index]);
                let rest: f64 = behind.iter().map(|[a, b]| best[a * count + b].cost).sum();
                let cost = rest + self.cost(corners);
                if cost < least.cost {
                    least = Best {
                        cost,
                        piece: [p, q],
                    };
                }
            }
        }
        least
    }

    /// What a piece costs by its shape; a triangle has its second corner twice.
    fn cost(&self, corners: [u32; 4]) -> f64 {
        let points = corners.map(|vertex| self.positions[vertex as usize]);
        let is_triangle = corners[1] == corners[2];
        let quality = if is_triangle {
            triangle_quality([points[0], points[1], points[3]])
        } else {
            scaled_jacobian(points)
        };
        // A triangle counts like one poor quad more.
        let extra = f64::from(u8::from(is_triangle));
        let inverted = if quality < FLAT_CORNER {
            INVERTED_PIECE
        } else {
            0.0
        };
        (1.0 - quality).powi(2) + extra + inverted
    }
}

/// 1 for an equilateral triangle, 0 for one without area.
fn triangle_quality([a, b, c]: [DVec3; 3]) -> f64 {
    let area = (b - a).cross(c - a).length();
    let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    2.0 * 3.0_f64.sqrt() * area / sides.max(f64::MIN_POSITIVE)
}

pub(super) fn ordered(from: u32, to: u32) -> [u32; 2] {
    [from.min(to), from.max(to)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(points: &[[f64; 2]], edges: &[[u32; 2]]) -> Option<Vec<Vec<u32>>> {
        let positions: Vec<DVec3> = points.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect();
        let vertices: Vec<u32> = (0..points.len() as u32).collect();
        let mut edges: HashSet<[u32; 2]> = edges.iter().copied().collect();
        Partition::new(&positions, &mut edges).pieces(&vertices)
    }

    const HEXAGON: [[f64; 2]; 6] = [
        [0.0, 0.0],
        [1.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [0.0, 1.0],
    ];

    #[test]
    fn a_domino_becomes_two_squares() {
        let mut pieces = cut(&HEXAGON, &[]).unwrap();
        for piece in &mut pieces {
            piece.sort_unstable();
        }
        pieces.sort_unstable();
        assert_eq!(pieces, [[0, 1, 4, 5], [1, 2, 3, 4]]);
    }

    #[test]
    fn an_edge_that_is_there_is_not_made_twice() {
        let pieces = cut(&HEXAGON, &[[1, 4]]);
        assert!(pieces.is_none_or(|pieces| pieces.iter().all(|p| p != &[0, 1, 4, 5])));
    }

    #[test]
    fn an_odd_polygon_has_one_triangle() {
        let house = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.8], [0.0, 1.0]];
        let mut sizes: Vec<usize> = cut(&house, &[]).unwrap().iter().map(Vec::len).collect();
        sizes.sort_unstable();
        assert_eq!(sizes, [3, 4]);
    }

    #[test]
    fn a_large_polygon_is_cut_whole() {
        for count in [16_usize, 25, 40] {
            let points: Vec<[f64; 2]> = (0..count)
                .map(|k| libm::sincos(k as f64 * std::f64::consts::TAU / count as f64))
                .map(|(sin, cos)| [cos, sin])
                .collect();
            let pieces = cut(&points, &[]).unwrap();
            let corners: usize = pieces.iter().map(|piece| piece.len() - 2).sum();
            assert_eq!(corners, count - 2);
            let triangles = pieces.iter().filter(|piece| piece.len() == 3).count();
            assert_eq!(triangles, count % 2);
        }
    }
}
