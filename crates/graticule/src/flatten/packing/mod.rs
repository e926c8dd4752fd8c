//! Islands of a map laid side by side without overlap.
//!
//! Each island is turned into its rectangle of least area, drawn on a grid with every cell that it
//! or its margin touches, and put, largest first, where the square around all grows least, in the
//! best of four quarter turns. Islands go into each other's bays; one that is longer than the square
//! need be is turned to fit into the smallest. No scale is changed: what has the
//! same size on the surface has it in the plane.

mod mask;
mod rectangle;

use glam::DVec2;
use serde::Serialize;

use self::mask::{Grid, Mask};
use self::rectangle::{least_rectangle, least_square};
use crate::watch::{Stopped, Watch};

/// How islands are packed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PackingOptions {
    /// Least distance of two islands, as a share of the side of the square around all.
    pub margin: f64,
    /// Cells of the grid along the side of the square, roughly: finer ones pack closer.
    pub resolution: u32,
}

impl Default for PackingOptions {
    fn default() -> Self {
        Self {
            margin: 1.0 / 512.0,
            resolution: 512,
        }
    }
}

/// An island: triangles in the plane.
#[derive(Clone, Copy, Debug)]
pub struct IslandShape<'a> {
    /// Where the vertices are.
    pub places: &'a [DVec2],
    /// The triangles, of either orientation.
    pub triangles: &'a [[u32; 3]],
}

/// A motion of the plane: a rotation, then a translation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Motion {
    /// Cosine and sine of the angle.
    pub rotation: DVec2,
    /// The translation.
    pub translation: DVec2,
}

impl Motion {
    /// The image of a point.
    #[must_use]
    pub fn apply(&self, place: DVec2) -> DVec2 {
        self.rotation.rotate(place) + self.translation
    }
}

/// Where islands went.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Packing {
    /// The motion of each island, as given.
    pub motions: Vec<Motion>,
    /// The side of the square from the origin that holds all, margins included.
    pub side: f64,
}

/// Packs islands into a square as small as it finds. Deterministic.
///
/// Places must be finite. Cost: the number of islands times the cells of the grid in the worst
/// case; bays that are full are passed over quickly.
///
/// # Errors
/// [`Stopped`].
pub fn pack(
    islands: &[IslandShape<'_>],
    options: &PackingOptions,
    watch: &Watch,
) -> Result<Packing, Stopped> {
    let _stage = watch.stage("pack islands");
    let upright: Vec<Turned> = islands
        .iter()
        .map(|island| Turned::new(least_rectangle(island.places)))
        .collect();
    let fitting = total_area(&upright).sqrt();
    let is_long = |island: &Turned| island.size.max_element() >= fitting;
    if !upright.iter().any(is_long) {
        return put_all(islands, &upright, options, watch);
    }
    // An island longer than a square for all need be takes a smaller one on the slant, but may then
    // be in the way of others.
    let slanted: Vec<Turned> = upright
        .iter()
        .zip(islands)
        .map(|(turned, island)| {
            if is_long(turned) {
                Turned::new(least_square(island.places))
            } else {
                *turned
            }
        })
        .collect();
    let slanted = put_all(islands, &slanted, options, watch)?;
    let upright = match islands.len() {
        1 => return Ok(slanted),
        _ => put_all(islands, &upright, options, watch)?,
    };
    Ok(if slanted.side < upright.side {
        slanted
    } else {
        upright
    })
}

fn total_area(turned: &[Turned]) -> f64 {
    turned
        .iter()
        .map(|island| island.size.x * island.size.y)
        .sum()
}

/// Puts the islands, turned so or by a quarter, largest first.
fn put_all(
    islands: &[IslandShape<'_>],
    turned: &[Turned],
    options: &PackingOptions,
    watch: &Watch,
) -> Result<Packing, Stopped> {
    let longest = turned
        .iter()
        .map(|island| island.size.max_element())
        .fold(0.0, f64::max);
    let side = total_area(turned)
        .sqrt()
        .max(longest)
        .max(f64::MIN_POSITIVE);
    let cell = side / f64::from(options.resolution.max(8));
    let margin = options.margin.max(0.0) * side;
    let mut order: Vec<usize> = (0..islands.len()).collect();
    let size = |index: usize| turned[index].size.max_element();
    order.sort_by(|&a, &b| size(b).total_cmp(&size(a)).then(a.cmp(&b)));
    let mut grid = Grid::new();
    let mut motions = vec![
        Motion {
            rotation: DVec2::X,
            translation: DVec2::ZERO
        };
        islands.len()
    ];
    for (done, index) in order.into_iter().enumerate() {
        watch.check()?;
        watch.progress(done as f64 / islands.len() as f64);
        let masks = turned[index].masks(&islands[index], cell, margin);
        let (turn, [x, y]) = grid.best_place(&masks);
        grid.put(&masks[turn], [x, y]);
        let corner = DVec2::new(x as f64, y as f64) * cell + DVec2::splat(0.5 * margin);
        motions[index] = turned[index].motion(turn, corner);
    }
    Ok(Packing {
        motions,
        side: grid.side() as f64 * cell,
    })
}

/// An island in its rectangle of least area or square, lower left corner at the origin.
#[derive(Clone, Copy)]
struct Turned {
    rotation: DVec2,
    low: DVec2,
    size: DVec2,
}

/// Directions of the four quarter turns.
const QUARTERS: [DVec2; 4] = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];

impl Turned {
    fn new((rotation, [low, high]): (DVec2, [DVec2; 2])) -> Self {
        Self {
            rotation,
            low,
            size: high - low,
        }
    }

    /// The island in each quarter turn, with half the margin around it.
    fn masks(&self, island: &IslandShape<'_>, cell: f64, margin: f64) -> [Mask; 4] {
        [0, 1, 2, 3].map(|turn| {
            let motion = self.motion(turn, DVec2::splat(0.5 * margin));
            let places: Vec<DVec2> = island
                .places
                .iter()
                .map(|&p| motion.apply(p) / cell)
                .collect();
            Mask::of(&places, island.triangles, 0.5 * margin / cell)
        })
    }

    /// The motion that brings the island, turned by quarters, into the quadrant above `corner`.
    fn motion(&self, turn: usize, corner: DVec2) -> Motion {
        let quarter = QUARTERS[turn];
        let box_corners = [self.low, self.low + self.size].map(|p| quarter.rotate(p));
        let low = box_corners[0].min(box_corners[1]);
        Motion {
            rotation: quarter.rotate(self.rotation),
            translation: corner - low,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(width: f64, height: f64, angle: f64) -> Vec<DVec2> {
        let turn = DVec2::from_angle(angle);
        [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
            .map(|(x, y)| turn.rotate(DVec2::new(x, y)))
            .into()
    }

    const TWO: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    fn packed(shapes: &[Vec<DVec2>], options: &PackingOptions) -> (Vec<Vec<DVec2>>, f64) {
        let islands: Vec<_> = shapes
            .iter()
            .map(|places| IslandShape {
                places,
                triangles: &TWO,
            })
            .collect();
        let packing = pack(&islands, options, &Watch::new()).unwrap();
        let moved = shapes.iter().zip(&packing.motions);
        let moved = moved.map(|(places, motion)| places.iter().map(|&p| motion.apply(p)).collect());
        (moved.collect(), packing.side)
    }

    fn bounds(places: &[DVec2]) -> [DVec2; 2] {
        let low = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        [
            low,
            places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max),
        ]
    }

    #[test]
    fn a_single_island_is_turned_into_the_smallest_square() {
        let options = PackingOptions {
            margin: 0.0,
            ..PackingOptions::default()
        };
        let (moved, side) = packed(&[rectangle(3.0, 1.0, 0.7)], &options);
        let [low, high] = bounds(&moved[0]);
        assert!(low.length() < 1e-12);
        assert!(high.max_element() < 1.01 * 8.0_f64.sqrt());
        assert!(side < 1.02 * high.max_element());
    }

    #[test]
    fn an_island_longer_than_the_square_need_be_lies_on_the_slant() {
        let options = PackingOptions {
            margin: 0.0,
            ..PackingOptions::default()
        };
        let long = rectangle(10.0, 1.0, 0.3);
        let (_, side) = packed(&[long, rectangle(1.0, 1.0, 0.0)], &options);
        assert!(side < 1.02 * 11.0 / 2.0_f64.sqrt(), "{side}");
        // Two such are better laid side by side.
        let strips = [rectangle(3.0, 1.0, 0.3), rectangle(3.0, 1.0, 0.8)];
        let (_, side) = packed(&strips, &options);
        assert!(side < 3.05, "{side}");
    }

    #[test]
    fn squares_fill_a_square_and_keep_their_distance() {
        let options = PackingOptions {
            margin: 0.01,
            resolution: 256,
        };
        let shapes: Vec<_> = (0..16).map(|k| rectangle(1.0, 1.0, f64::from(k))).collect();
        let (moved, side) = packed(&shapes, &options);
        assert!(side < 4.3, "{side}");
        let boxes: Vec<_> = moved.iter().map(|places| bounds(places)).collect();
        for (index, [low, high]) in boxes.iter().enumerate() {
            assert!(low.min_element() >= 0.0 && high.max_element() <= side);
            for [other_low, other_high] in &boxes[..index] {
                let apart = (*low - *other_high).max(*other_low - *high).max_element();
                assert!(apart > 0.03, "{apart}");
            }
        }
    }

    #[test]
    fn small_islands_go_into_the_bays_of_large_ones() {
        // An L of two arms leaves a bay of 2 by 2.
        let l = [
            (0.0, 0.0),
            (3.0, 0.0),
            (3.0, 1.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ];
        let places: Vec<DVec2> = l.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        let small = rectangle(1.8, 1.8, 0.0);
        let islands = [
            IslandShape {
                places: &places,
                triangles: &triangles,
            },
            IslandShape {
                places: &small,
                triangles: &TWO,
            },
        ];
        let packing = pack(&islands, &PackingOptions::default(), &Watch::new()).unwrap();
        assert!(packing.side < 3.1, "{}", packing.side);
    }

    #[test]
    fn points_and_nothing_are_packed_too() {
        let (moved, _) = packed(
            &[vec![DVec2::ONE; 4], vec![DVec2::ONE; 4]],
            &PackingOptions::default(),
        );
        assert!(moved.iter().flatten().all(|p| p.is_finite()));
        let none = pack(&[], &PackingOptions::default(), &Watch::new()).unwrap();
        assert!(none.motions.is_empty());
    }
}
