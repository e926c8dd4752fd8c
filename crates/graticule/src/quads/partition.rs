use std::collections::HashSet;

use glam::DVec3;

use super::overlay::NONE;
use crate::tolerance::FLAT_CORNER;

/// The largest polygon of which all partitions are weighed; larger ones are halved first.
pub(super) const WEIGHED_CORNERS: usize = 14;

/// Cost of a flat or inverted corner that can open when vertices move: more than that of any other
/// piece, less than that of a vertex more.
const LOOSE_CORNER: f64 = 20.0;

/// Cost of a flat or inverted corner between two sides on lines, which stays what it is.
const FIXED_CORNER: f64 = 1e3;

/// Cost of a piece along a chord that is an edge elsewhere: never.
const FORBIDDEN: f64 = f64::INFINITY;

/// Cost of a vertex in the middle.
const MIDDLE_COST: f64 = 0.5;

/// The number of the vertex in the middle in [`Pieces`].
pub(super) const MIDDLE: u32 = NONE;

/// A polygon cut into quads, and one triangle where the number of corners is odd.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pieces {
    /// The less, the better the shape.
    pub(super) cost: f64,
    /// Their vertices, [`MIDDLE`] for the one in the middle.
    pub(super) polygons: Vec<Vec<u32>>,
}

/// Finds the best way to cut a polygon into quads, and one triangle where the number of corners is
/// odd: of all ways, by dynamic programming over the stretches of its border.
pub(super) struct Partition<'a> {
    positions: &'a [DVec3],
    /// Vertices on lines: a corner between two sides of the polygon stays flat there.
    held: &'a [bool],
    /// Edges that must not be made twice; asked, never walked.
    edges: &'a HashSet<[u32; 2]>,
    vertices: &'a [u32],
    middle: DVec3,
    /// For each corner and number of sides the best partition of what lies between that stretch of
    /// the border and the chord between its ends.
    best: Vec<Stretch>,
}

/// The best partition at a stretch: its cost, and the corners of the piece at the chord, in sides
/// from the beginning.
#[derive(Clone, Copy)]
struct Stretch {
    cost: f64,
    piece: [usize; 2],
}

/// A step round the middle: the spoke it came from, how many there were before, and the corner that
/// it goes over.
#[derive(Clone, Copy)]
struct Step {
    cost: f64,
    from: usize,
    before: usize,
    over: usize,
}

const NOWHERE: Step = Step {
    cost: FORBIDDEN,
    from: 0,
    before: 0,
    over: 0,
};

/// Fewest spokes of a vertex in the middle.
const FEWEST_SPOKES: usize = 3;

impl<'a> Partition<'a> {
    /// `vertices` has 5 to [`WEIGHED_CORNERS`] corners.
    pub(super) fn of(
        vertices: &'a [u32],
        positions: &'a [DVec3],
        held: &'a [bool],
        edges: &'a HashSet<[u32; 2]>,
    ) -> Self {
        let count = vertices.len();
        let side = |place: usize| Stretch {
            cost: if place % count < 2 { 0.0 } else { FORBIDDEN },
            piece: [0; 2],
        };
        let mut partition = Self {
            positions,
            held,
            edges,
            vertices,
            middle: DVec3::ZERO,
            best: (0..count * count).map(side).collect(),
        };
        // Of even polygons no stretch with an even number of sides is ever cut off.
        let step = if count.is_multiple_of(2) { 2 } else { 1 };
        for span in (step + 1..count).step_by(step) {
            for from in 0..count {
                partition.best[from * count + span] = partition.best_at(from, span);
            }
        }
        partition
    }

    /// The best pieces without another vertex; `None` where each way would repeat an edge.
    pub(super) fn without_middle(&self) -> Option<Pieces> {
        let count = self.vertices.len();
        let cost = self.best[count - 1].cost;
        if cost == FORBIDDEN {
            return None;
        }
        let mut polygons = Vec::new();
        self.collect(0, count - 1, &mut polygons);
        Some(Pieces { cost, polygons })
    }

    /// The best pieces round one vertex in the middle, which lies at `place`.
    pub(super) fn with_middle(&mut self, place: DVec3) -> Option<Pieces> {
        self.middle = place;
        let count = self.vertices.len();
        let mut best: Option<(usize, Vec<[Step; FEWEST_SPOKES + 1]>)> = None;
        for start in 0..count {
            let round = self.round(start);
            let cost = round[count][FEWEST_SPOKES].cost;
            let least = best
                .as_ref()
                .map(|(_, round)| round[count][FEWEST_SPOKES].cost);
            if cost < least.unwrap_or(FORBIDDEN) {
                best = Some((start, round));
            }
        }
        let (start, round) = best?;
        let mut polygons = Vec::new();
        let (mut to, mut spokes) = (count, FEWEST_SPOKES);
        while to > 0 {
            let step = round[to][spokes];
            let mut piece = vec![MIDDLE];
            piece.extend([step.from, step.over, to].map(|place| self.corner(start + place)));
            piece.dedup();
            polygons.push(piece);
            self.collect(start + step.from, step.over - step.from, &mut polygons);
            self.collect(start + step.over, to - step.over, &mut polygons);
            (to, spokes) = (step.from, step.before);
        }
        Some(Pieces {
            cost: round[count][FEWEST_SPOKES].cost + MIDDLE_COST,
            polygons,
        })
    }

    /// The cheapest ways round the middle from the spoke to corner `start`: for each corner after it,
    /// and each number of spokes up to [`FEWEST_SPOKES`] or more, the last step.
    fn round(&self, start: usize) -> Vec<[Step; FEWEST_SPOKES + 1]> {
        let count = self.vertices.len();
        let mut round = vec![[NOWHERE; FEWEST_SPOKES + 1]; count + 1];
        round[0][0].cost = 0.0;
        let is_odd = !count.is_multiple_of(2);
        for from in 0..count {
            // A step leaves two for the other spokes at least.
            for to in from + 1..=count.min(from + count - 2) {
                let even = (to - from).is_multiple_of(2);
                let best = if even {
                    (from + 1..to)
                        .step_by(2)
                        .map(|over| (self.step_cost(start, [from, over, to]), over))
                        .min_by(|a, b| a.0.total_cmp(&b.0))
                } else if is_odd && from.is_multiple_of(2) {
                    Some((self.step_cost(start, [from, to, to]), to))
                } else {
                    None
                };
                let Some((cost, over)) = best else { continue };
                for before in 0..=FEWEST_SPOKES {
                    let total = round[from][before].cost + cost;
                    let slot = &mut round[to][(before + 1).min(FEWEST_SPOKES)];
                    if total < slot.cost {
                        *slot = Step {
                            cost: total,
                            from,
                            before,
                            over,
                        };
                    }
                }
            }
        }
        round
    }

    /// The cost of the piece between two spokes with what lies behind it; a triangle goes over its
    /// end.
    fn step_cost(&self, start: usize, [from, over, to]: [usize; 3]) -> f64 {
        let behind =
            self.stretch(start + from, over - from) + self.stretch(start + over, to - over);
        let [a, b, c] = [from, over, to].map(|place| self.corner(start + place));
        behind + self.cost([MIDDLE, a, b, c])
    }

    fn corner(&self, place: usize) -> u32 {
        self.vertices[place % self.vertices.len()]
    }

    fn stretch(&self, from: usize, span: usize) -> f64 {
        let count = self.vertices.len();
        self.best[(from % count) * count + span].cost
    }

    /// The best piece at the chord between two corners, with what lies behind its other sides.
    fn best_at(&self, from: usize, span: usize) -> Stretch {
        let count = self.vertices.len();
        let mut least = Stretch {
            cost: FORBIDDEN,
            piece: [0; 2],
        };
        let ends = [from, from + span].map(|place| self.corner(place));
        if span + 1 < count && self.edges.contains(&ordered(ends[0], ends[1])) {
            return least;
        }
        let even = span.is_multiple_of(2);
        // Pieces behind an even number of sides hold the one triangle.
        for p in 1..span {
            for q in p..span {
                let spans = [p, q - p, span - q];
                let odd_ones = spans.iter().filter(|&&s| s > 0 && s.is_multiple_of(2));
                if odd_ones.count() != usize::from(even && p != q) || p == q && !even {
                    continue;
                }
                let rest = self.stretch(from, p)
                    + self.stretch(from + p, q - p)
                    + self.stretch(from + q, span - q);
                if rest >= least.cost {
                    continue;
                }
                let [b, c] = [p, q].map(|place| self.corner(from + place));
                let cost = rest + self.cost([ends[0], b, c, ends[1]]);
                if cost < least.cost {
                    least = Stretch {
                        cost,
                        piece: [p, q],
                    };
                }
            }
        }
        least
    }

    /// Adds the pieces of the best partition at a stretch.
    fn collect(&self, from: usize, span: usize, polygons: &mut Vec<Vec<u32>>) {
        let count = self.vertices.len();
        let mut open = vec![(from, span)];
        while let Some((from, span)) = open.pop() {
            if span < 2 {
                continue;
            }
            let [p, q] = self.best[(from % count) * count + span].piece;
            let mut piece = [0, p, q, span]
                .map(|place| self.corner(from + place))
                .to_vec();
            piece.dedup();
            polygons.push(piece);
            open.extend([(from, p), (from + p, q - p), (from + q, span - q)]);
        }
    }

    /// What a piece costs by its shape; a triangle has a corner twice.
    fn cost(&self, corners: [u32; 4]) -> f64 {
        let [a, b, c, d] = corners.map(|vertex| self.place(vertex));
        if corners[1] == corners[2] {
            return triangle_cost([a, b, d]);
        }
        if corners[2] == corners[3] {
            return triangle_cost([a, b, c]);
        }
        let normal = (c - a).cross(d - b).normalize_or_zero();
        let sides = [b - a, c - b, d - c, a - d].map(DVec3::normalize_or_zero);
        let mut least = f64::INFINITY;
        let mut flat = 0.0;
        for corner in 0..4 {
            let sine = sides[(corner + 3) % 4].cross(sides[corner]).dot(normal);
            least = least.min(sine);
            if sine < FLAT_CORNER {
                flat += if self.is_held(corners[corner]) {
                    FIXED_CORNER
                } else {
                    LOOSE_CORNER
                };
            }
        }
        (1.0 - least).powi(2) + flat
    }

    fn place(&self, vertex: u32) -> DVec3 {
        (self.positions.get(vertex as usize)).map_or(self.middle, |&place| place)
    }

    fn is_held(&self, vertex: u32) -> bool {
        self.held.get(vertex as usize).is_some_and(|&held| held)
    }
}

/// A triangle counts like one poor quad more.
fn triangle_cost(corners: [DVec3; 3]) -> f64 {
    let quality = triangle_quality(corners);
    let flat = if quality < FLAT_CORNER {
        FIXED_CORNER
    } else {
        0.0
    };
    1.0 + (1.0 - quality).powi(2) + flat
}

/// The polygon cut along its shortest chord between corners an odd number of sides apart, each half
/// with a third of the corners at least; `None` where each such chord is an edge already.
pub(super) fn halves(
    vertices: &[u32],
    positions: &[DVec3],
    edges: &HashSet<[u32; 2]>,
) -> Option<[Vec<u32>; 2]> {
    let count = vertices.len();
    let place = |index: usize| positions[vertices[index] as usize];
    let mut best: Option<(f64, usize, usize)> = None;
    for from in 0..count {
        for to in (from + 3..count).step_by(2) {
            let sides = (to - from).min(count - (to - from));
            let free = !edges.contains(&ordered(vertices[from], vertices[to]));
            let length = place(from).distance_squared(place(to));
            if 3 * sides >= count && free && best.is_none_or(|(least, ..)| length < least) {
                best = Some((length, from, to));
            }
        }
    }
    let (_, from, to) = best?;
    let one = vertices[from..=to].to_vec();
    let other = [&vertices[to..], &vertices[..=from]].concat();
    Some([one, other])
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

    /// A polygon in the plane to be cut.
    struct Case {
        positions: Vec<DVec3>,
        held: Vec<bool>,
        edges: HashSet<[u32; 2]>,
    }

    impl Case {
        fn of(points: &[[f64; 2]]) -> Self {
            Self {
                positions: points.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect(),
                held: vec![false; points.len()],
                edges: HashSet::new(),
            }
        }

        fn regular(count: usize) -> Self {
            let points: Vec<[f64; 2]> = (0..count)
                .map(|k| libm::sincos(k as f64 * std::f64::consts::TAU / count as f64))
                .map(|(sin, cos)| [cos, sin])
                .collect();
            Self::of(&points)
        }

        fn cut(&self, middle: Option<DVec3>) -> Option<Pieces> {
            let vertices: Vec<u32> = (0..self.positions.len() as u32).collect();
            let mut partition = Partition::of(&vertices, &self.positions, &self.held, &self.edges);
            match middle {
                Some(place) => partition.with_middle(place),
                None => partition.without_middle(),
            }
        }
    }

    const HEXAGON: [[f64; 2]; 6] = [
        [0.0, 0.0],
        [1.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [0.0, 1.0],
    ];

    fn sorted(mut pieces: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
        for piece in &mut pieces {
            piece.sort_unstable();
        }
        pieces.sort_unstable();
        pieces
    }

    #[test]
    fn a_domino_becomes_two_squares() {
        let pieces = Case::of(&HEXAGON).cut(None).unwrap();
        assert_eq!(sorted(pieces.polygons), [[0, 1, 4, 5], [1, 2, 3, 4]]);
        assert!(pieces.cost < 1e-12);
    }

    #[test]
    fn an_edge_that_is_there_is_not_made_twice() {
        let mut case = Case::of(&HEXAGON);
        case.edges.insert([1, 4]);
        let pieces = case.cut(None).unwrap();
        assert!(!sorted(pieces.polygons).contains(&vec![0, 1, 4, 5]));
        case.edges.extend([[0, 3], [2, 5]]);
        assert_eq!(case.cut(None), None);
        assert!(case.cut(Some(DVec3::new(1.0, 0.5, 0.0))).is_some());
    }

    #[test]
    fn chords_end_at_corners_that_stay_straight() {
        for corner in 0..6 {
            let mut case = Case::regular(6);
            let [before, after] = [5, 1].map(|step| case.positions[(corner + step) % 6]);
            case.positions[corner] = (before + after) / 2.0;
            case.held[corner] = true;
            let pieces = case.cut(None).unwrap();
            assert!(pieces.cost < LOOSE_CORNER);
            for piece in &pieces.polygons {
                assert!(piece.contains(&(corner as u32)));
            }
        }
    }

    #[test]
    fn spokes_end_at_corners_that_stay_straight() {
        // A square with straight corners in the middle of two sides that meet: without a vertex in
        // the middle one of them stays.
        let points = [
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [2.0, 2.0],
            [0.0, 2.0],
        ];
        let mut case = Case::of(&points);
        case.held = vec![true; 6];
        assert!(case.cut(None).unwrap().cost >= FIXED_CORNER);
        let pieces = case.cut(Some(DVec3::new(1.0, 1.0, 0.0))).unwrap();
        assert!(pieces.cost < 1.0);
        let expected = [
            vec![0, 1, 5, MIDDLE],
            vec![1, 2, 3, MIDDLE],
            vec![3, 4, 5, MIDDLE],
        ];
        assert_eq!(sorted(pieces.polygons), expected);
    }

    #[test]
    fn an_odd_polygon_has_one_triangle() {
        let house = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.8], [0.0, 1.0]];
        let case = Case::of(&house);
        for middle in [None, Some(DVec3::new(0.5, 0.6, 0.0))] {
            let pieces = case.cut(middle).unwrap().polygons;
            let triangles = pieces.iter().filter(|piece| piece.len() == 3).count();
            assert_eq!(triangles, 1);
            assert!(pieces.iter().all(|piece| (3..=4).contains(&piece.len())));
        }
    }

    #[test]
    fn pieces_with_and_without_a_middle_cover_the_polygon() {
        for count in 5..=WEIGHED_CORNERS {
            let case = Case::regular(count);
            let area = |pieces: &[Vec<u32>]| -> f64 {
                let place = |&v: &u32| case.positions.get(v as usize).map_or(DVec3::ZERO, |p| *p);
                let doubled = |piece: &Vec<u32>| -> f64 {
                    let points: Vec<DVec3> = piece.iter().map(place).collect();
                    let next = points.iter().cycle().skip(1);
                    points.iter().zip(next).map(|(a, b)| a.cross(*b).z).sum()
                };
                pieces.iter().map(doubled).sum()
            };
            let whole = area(&[(0..count as u32).collect()]);
            for middle in [None, Some(DVec3::ZERO)] {
                let pieces = case.cut(middle).unwrap();
                assert!((area(&pieces.polygons) - whole).abs() < 1e-12, "{count}");
                let corners: usize = pieces.polygons.iter().map(|piece| piece.len() - 2).sum();
                let inner = if middle.is_some() { 2 } else { 0 };
                assert_eq!(corners, count - 2 + inner);
            }
        }
    }

    #[test]
    fn halves_hold_all_corners() {
        let case = Case::regular(25);
        let vertices: Vec<u32> = (0..25).collect();
        let [one, other] = halves(&vertices, &case.positions, &case.edges).unwrap();
        assert_eq!(one.len() + other.len(), 27);
        assert!(one.len().min(other.len()) > 8);
    }
}
