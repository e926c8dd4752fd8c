//! Maps that stay sound when their coordinates are rounded.
//!
//! Many programs hold texture coordinates in single precision, whatever the file gives. A triangle
//! thinner than its last digit may flip there. Mostly a corner has a place a few units in the last
//! place away at which nothing flips.

use glam::DVec2;

use super::injective::is_upright;

/// Units in the last place that a vertex is moved at most, each way.
const REACH: i32 = 8;

/// Passes over the triangles in trouble.
const PASSES: usize = 4;

/// A number that a program with single precision makes of a coordinate.
fn single(place: DVec2) -> DVec2 {
    place.as_vec2().as_dvec2()
}

/// Rounds `places` by `stored`, to what a file holds, and moves some a little where that, or reading
/// the file in single precision, would flip or collapse a triangle that is not so before. Returns how many
/// triangles it is not possible for within 8 units in the last place of single precision.
///
/// Cost: linear.
pub fn hold_rounding(
    triangles: &[[u32; 3]],
    places: &mut [DVec2],
    stored: impl Fn(DVec2) -> DVec2,
) -> usize {
    let corners = |triangle: u32, places: &[DVec2]| {
        triangles[triangle as usize].map(|vertex| places[vertex as usize])
    };
    let all = 0..triangles.len() as u32;
    let upright: Vec<u32> = all
        .filter(|&triangle| is_upright(corners(triangle, places)))
        .collect();
    for place in &mut *places {
        *place = stored(*place);
    }
    let is_lost = |&triangle: &u32| !is_sound(corners(triangle, places));
    let mut lost: Vec<u32> = upright.iter().copied().filter(is_lost).collect();
    if lost.is_empty() {
        return 0;
    }
    let mut mending = Mending::new(triangles, &upright, places, stored);
    for _ in 0..PASSES {
        let before = lost.len();
        lost.retain(|&triangle| !mending.mend(triangle));
        if lost.is_empty() || lost.len() == before {
            break;
        }
    }
    lost.len()
}

/// Whether a triangle is upright as stored and in single precision.
fn is_sound(corners: [DVec2; 3]) -> bool {
    is_upright(corners) && is_upright(corners.map(single))
}

struct Mending<'a, S> {
    triangles: &'a [[u32; 3]],
    places: &'a mut [DVec2],
    stored: S,
    /// The triangles in question by vertex: those of vertex `v` are
    /// `of_vertex[starts[v]..starts[v + 1]]`.
    starts: Vec<u32>,
    of_vertex: Vec<u32>,
    /// One unit in the last place of the largest coordinate.
    unit: f64,
}

impl<'a, S: Fn(DVec2) -> DVec2> Mending<'a, S> {
    fn new(triangles: &'a [[u32; 3]], upright: &[u32], places: &'a mut [DVec2], stored: S) -> Self {
        let mut pairs: Vec<(u32, u32)> = upright
            .iter()
            .flat_map(|&triangle| triangles[triangle as usize].map(|vertex| (vertex, triangle)))
            .collect();
        pairs.sort_unstable();
        let starts = (0..=places.len() as u32)
            .map(|vertex| pairs.partition_point(|&(other, _)| other < vertex) as u32);
        let largest = places
            .iter()
            .fold(0.0_f64, |m, p| m.max(p.abs().max_element()));
        Self {
            starts: starts.collect(),
            of_vertex: pairs.into_iter().map(|(_, triangle)| triangle).collect(),
            unit: largest * f64::from(f32::EPSILON) / 2.0,
            triangles,
            places,
            stored,
        }
    }

    /// Whether the triangle is sound, now or after moving one of its corners.
    fn mend(&mut self, triangle: u32) -> bool {
        let corners = self.triangles[triangle as usize];
        let is_sound_now = |places: &[DVec2]| is_sound(corners.map(|v| places[v as usize]));
        is_sound_now(self.places)
            || corners
                .iter()
                .any(|&vertex| self.move_vertex(vertex) && is_sound_now(self.places))
    }

    /// Moves a vertex to the nearest of the places around it at which fewest of its triangles are
    /// unsound; whether that is better than before.
    fn move_vertex(&mut self, vertex: u32) -> bool {
        let from = self.places[vertex as usize];
        let mut steps: Vec<[i32; 2]> = (-REACH..=REACH)
            .flat_map(|x| (-REACH..=REACH).map(move |y| [x, y]))
            .collect();
        steps.sort_by_key(|[x, y]| x * x + y * y);
        let mut best = (self.unsound(vertex), from);
        let before = best.0;
        for [x, y] in steps {
            let moved = from + DVec2::new(f64::from(x), f64::from(y)) * self.unit;
            let place = (self.stored)(single(moved));
            self.places[vertex as usize] = place;
            let unsound = self.unsound(vertex);
            if unsound < best.0 {
                best = (unsound, place);
            }
            if best.0 == 0 {
                break;
            }
        }
        self.places[vertex as usize] = best.1;
        best.0 < before
    }

    fn unsound(&self, vertex: u32) -> usize {
        let [start, end] = [0, 1].map(|next| self.starts[vertex as usize + next] as usize);
        let triangles = self.of_vertex[start..end].iter();
        let corners = |&triangle: &u32| {
            self.triangles[triangle as usize].map(|vertex| self.places[vertex as usize])
        };
        triangles.filter(|t| !is_sound(corners(t))).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    /// A strip of triangles whose inner vertices lie so near its lower side that single precision
    /// takes some of them across.
    fn sliver_strip() -> (Vec<[u32; 3]>, Vec<DVec2>) {
        let mut noise = Noise::new(7);
        let (mut triangles, mut places) = (Vec::new(), Vec::new());
        for column in 0..200_u32 {
            let x = 0.3 + 0.003 * f64::from(column);
            let slant = |x: f64| 0.4 + x / 7.0;
            let height = 2e-9 * (2.0 + noise.signed());
            places.extend([
                DVec2::new(x, slant(x)),
                DVec2::new(x + 0.001, slant(x + 0.001) + height),
                DVec2::new(x + 0.002, slant(x + 0.002)),
            ]);
            triangles.push([0, 2, 1].map(|corner| 3 * column + corner));
        }
        (triangles, places)
    }

    fn flipped(triangles: &[[u32; 3]], places: &[DVec2], read: impl Fn(DVec2) -> DVec2) -> usize {
        let corners = |t: &[u32; 3]| t.map(|v| read(places[v as usize]));
        let flipped = triangles.iter().filter(|t| !is_upright(corners(t)));
        flipped.count()
    }

    #[test]
    fn slivers_survive_single_precision_and_hardly_move() {
        let (triangles, before) = sliver_strip();
        assert_eq!(flipped(&triangles, &before, |p| p), 0);
        assert!(flipped(&triangles, &before, single) > 20);
        for stored in [|p| p, single] {
            let mut places = before.clone();
            assert_eq!(hold_rounding(&triangles, &mut places, stored), 0);
            assert_eq!(flipped(&triangles, &places, |p| p), 0);
            assert_eq!(flipped(&triangles, &places, single), 0);
            for (now, before) in places.iter().zip(&before) {
                assert_eq!(stored(*now), *now);
                assert!(now.distance(*before) < 20.0 * f64::from(f32::EPSILON));
            }
        }
    }

    #[test]
    fn triangles_smaller_than_the_last_digit_are_counted() {
        let tiny = 1e-12;
        let corner = DVec2::new(0.7, 0.7);
        let mut places = vec![corner, corner + DVec2::X * tiny, corner + DVec2::Y * tiny];
        places.extend([corner + DVec2::splat(-0.1), corner + DVec2::NEG_Y * 0.1]);
        // A ring around the first keeps its corners from going far.
        let triangles = [[0, 1, 2], [3, 4, 0], [0, 4, 1], [3, 0, 2]];
        let left = hold_rounding(&triangles, &mut places, |p| p);
        assert_eq!(left, flipped(&triangles, &places, single));
    }

    #[test]
    fn what_is_flipped_before_is_left_alone() {
        let mut places = vec![DVec2::ZERO, DVec2::Y, DVec2::X];
        let before = places.clone();
        assert_eq!(hold_rounding(&[[0, 1, 2]], &mut places, single), 0);
        assert_eq!(places, before);
    }
}
