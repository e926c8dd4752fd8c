//! Which boundary vertices become the corners of a rectangle.

use std::f64::consts::PI;

use crate::mesh::VertexId;
use crate::tolerance::{CORNER_TURNING, CORNER_WINDOW};

use super::curve::Outline;
use super::{BoundaryError, Patch};

/// How the corners of a rectangle are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Corners {
    /// Where the boundary turns most, measured within the surface and averaged along a short
    /// stretch; evenly spaced if nothing stands out.
    #[default]
    Automatic,
    /// A quarter of the boundary's length apart, from one of the two boundary points farthest
    /// apart.
    EvenlySpaced,
    /// These vertices of the outer loop. The first comes to the lower left, the others follow
    /// counter-clockwise in their order along the loop.
    At([VertexId; 4]),
}

/// The places of the corners on the loop, the first one first, the others in the loop's order
/// after it.
pub(super) fn choose_corners(
    patch: &Patch,
    outline: &Outline,
    corners: &Corners,
) -> Result<[usize; 4], BoundaryError> {
    let vertices = outline.vertices.len();
    if vertices < 4 {
        return Err(BoundaryError::TooFewVertices { vertices });
    }
    match corners {
        Corners::Automatic => {
            let sharpest = sharpest_turns(patch, outline);
            Ok(sharpest.unwrap_or_else(|| evenly_spaced(outline)))
        }
        Corners::EvenlySpaced => Ok(evenly_spaced(outline)),
        Corners::At(vertices) => given(outline, *vertices),
    }
}

fn given(outline: &Outline, vertices: [VertexId; 4]) -> Result<[usize; 4], BoundaryError> {
    let mut places = [0; 4];
    for (corner, &vertex) in vertices.iter().enumerate() {
        let bad = |reason| BoundaryError::BadCorner {
            corner,
            vertex,
            reason,
        };
        let place = outline
            .vertices
            .iter()
            .position(|&on_loop| on_loop == vertex);
        places[corner] = place.ok_or(bad("is not on the outer boundary loop"))?;
        if vertices[..corner].contains(&vertex) {
            return Err(bad("was given twice"));
        }
    }
    Ok(from_first_on(places, outline.vertices.len()))
}

/// The same places in the loop's order, beginning with the one that stands first.
fn from_first_on(mut places: [usize; 4], length: usize) -> [usize; 4] {
    let first = places[0];
    places.sort_unstable_by_key(|place| (place + length - first) % length);
    places
}

fn evenly_spaced(outline: &Outline) -> [usize; 4] {
    let length = outline.steps.len();
    let start = outline.default_start;
    let total: f64 = outline.steps.iter().sum();
    let mut corners = [start; 4];
    let (mut walked, mut offset) = (0.0, 0);
    for (k, corner) in corners.iter_mut().enumerate().skip(1) {
        let goal = total * k as f64 / 4.0;
        // At least one step from the last corner, and vertices left for the corners to come.
        let least = offset + 1;
        while offset < least || offset + 4 - k < length {
            let step = outline.steps[(start + offset) % length];
            if offset >= least && walked + step / 2.0 > goal {
                break;
            }
            walked += step;
            offset += 1;
        }
        *corner = (start + offset) % length;
    }
    corners
}

/// The four places with the largest turning, at least one window apart, if together they account
/// for enough of the full turn.
fn sharpest_turns(patch: &Patch, outline: &Outline) -> Option<[usize; 4]> {
    let turning = averaged(&turning_angles(patch, outline), &outline.steps);
    let arcs = Arcs::of(&outline.steps);
    let mut order: Vec<usize> = (0..turning.len()).collect();
    order.sort_by(|&a, &b| turning[b].total_cmp(&turning[a]));
    let mut chosen: Vec<usize> = Vec::with_capacity(4);
    for place in order {
        let apart = |&other: &usize| arcs.distance(place, other) >= CORNER_WINDOW * arcs.total;
        if chosen.iter().all(apart) {
            chosen.push(place);
        }
        if chosen.len() == 4 {
            break;
        }
    }
    let chosen: [usize; 4] = chosen.try_into().ok()?;
    let held: f64 = chosen.iter().map(|&place| turning[place]).sum();
    (held >= CORNER_TURNING).then(|| after_start(chosen, outline))
}

/// The places in the loop's order from its default start on, which does not depend on how the
/// vertices are numbered.
fn after_start(mut places: [usize; 4], outline: &Outline) -> [usize; 4] {
    let (start, length) = (outline.default_start, outline.vertices.len());
    places.sort_unstable_by_key(|place| (place + length - start) % length);
    places
}

/// How far the boundary turns left at each vertex of the loop: π less the angles of the triangles
/// there.
fn turning_angles(patch: &Patch, outline: &Outline) -> Vec<f64> {
    let mesh = patch.mesh();
    let angle =
        |corner: crate::mesh::HalfedgeId| patch.shapes()[corner.face()].angle(corner.side());
    let turning = |&vertex: &VertexId| PI - mesh.outgoing(vertex).map(angle).sum::<f64>();
    outline.vertices.iter().map(turning).collect()
}

/// Positions along a closed curve.
struct Arcs {
    starts: Vec<f64>,
    total: f64,
}

impl Arcs {
    fn of(steps: &[f64]) -> Self {
        let mut total = 0.0;
        let mut starts = Vec::with_capacity(steps.len());
        for step in steps {
            starts.push(total);
            total += step;
        }
        Self { starts, total }
    }

    /// The shorter way along the curve.
    fn distance(&self, a: usize, b: usize) -> f64 {
        let direct = (self.starts[a] - self.starts[b]).abs();
        direct.min(self.total - direct)
    }
}

/// Values summed along the curve with weights that fall linearly from 1 to 0 within one window.
fn averaged(values: &[f64], steps: &[f64]) -> Vec<f64> {
    let ahead = summed_ahead(values, steps);
    let reversed: Vec<f64> = values.iter().rev().copied().collect();
    // Reversed, the step after a vertex is the one that came before it.
    let mut reversed_steps: Vec<f64> = steps.iter().rev().copied().collect();
    reversed_steps.rotate_left(1);
    let mut behind = summed_ahead(&reversed, &reversed_steps);
    behind.reverse();
    let both = ahead.iter().zip(&behind);
    values
        .iter()
        .zip(both)
        .map(|(v, (a, b))| v + a + b)
        .collect()
}

/// For each place, the values after it within one window, weighted. Linear time, by prefix sums of
/// the values and of the values times their position.
fn summed_ahead(values: &[f64], steps: &[f64]) -> Vec<f64> {
    let count = values.len();
    let window = CORNER_WINDOW * steps.iter().sum::<f64>();
    // Twice round, so that each window is one run.
    let (mut position, mut sums, mut moments) = (vec![0.0], vec![0.0], vec![0.0]);
    for place in 0..2 * count {
        let (here, value) = (position[place], values[place % count]);
        position.push(here + steps[place % count]);
        sums.push(sums[place] + value);
        moments.push(moments[place] + value * here);
    }
    let mut end = 0;
    let mut ahead = Vec::with_capacity(count);
    for place in 0..count {
        let here = position[place];
        while end < 2 * count && position[end] < here + window {
            end += 1;
        }
        let (from, to) = (place + 1, end.max(place + 1));
        let (sum, moment) = (sums[to] - sums[from], moments[to] - moments[from]);
        ahead.push(sum * (1.0 + here / window) - moment / window);
    }
    ahead
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Surface;
    use crate::watch::Watch;
    use graticule_fixtures::{Fixture, Noise, disk, grid};

    fn patch(fixture: &Fixture) -> Patch {
        let surface =
            Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap();
        Patch::new(surface, &Watch::new()).unwrap()
    }

    fn corners(patch: &Patch, corners: &Corners) -> [VertexId; 4] {
        let outline = Outline::of(patch, &Watch::new()).unwrap();
        choose_corners(patch, &outline, corners)
            .unwrap()
            .map(|place| outline.vertices[place])
    }

    #[test]
    fn a_rectangle_has_its_own_corners_found() {
        for (width, height) in [(1.0, 1.0), (8.0, 1.0)] {
            let bent = grid(width, height, 24, 24).map(|p| {
                let angle = p.x / width;
                glam::DVec3::new(angle.sin() * width, p.y, angle.cos() * width)
            });
            let patch = patch(&bent);
            let mut found = corners(&patch, &Corners::Automatic).map(|vertex| vertex.0);
            found.sort_unstable();
            assert_eq!(found, [0, 24, 600, 624]);
        }
    }

    #[test]
    fn a_circle_gets_corners_a_quarter_apart() {
        let patch = patch(&disk(8));
        let outline = Outline::of(&patch, &Watch::new()).unwrap();
        let places = choose_corners(&patch, &outline, &Corners::Automatic).unwrap();
        for k in 0..4 {
            assert_eq!((places[(k + 1) % 4] + 48 - places[k]) % 48, 12);
        }
    }

    #[test]
    fn evenly_spaced_corners_are_four_for_every_loop_of_four_vertices_or_more() {
        for cells in 1..6 {
            for seed in 0..20 {
                let mut noise = Noise::new(seed);
                let mut uneven = grid(1.0, 1.0, cells, 1);
                for position in &mut uneven.positions {
                    position.x += 10.0_f64.powf(3.0 * noise.signed());
                }
                let patch = patch(&uneven);
                let chosen = corners(&patch, &Corners::EvenlySpaced);
                let different: std::collections::BTreeSet<_> = chosen.into_iter().collect();
                assert_eq!(different.len(), 4);
            }
        }
    }

    #[test]
    fn given_corners_keep_their_first_and_follow_the_loop() {
        let patch = patch(&grid(1.0, 1.0, 3, 3));
        let ids = |numbers: [u32; 4]| numbers.map(VertexId);
        let shuffled = corners(&patch, &Corners::At(ids([3, 12, 15, 0])));
        assert_eq!(shuffled, ids([3, 15, 12, 0]));
        let outline = Outline::of(&patch, &Watch::new()).unwrap();
        for bad in [[0, 3, 5, 15], [0, 3, 3, 15], [0, 3, 99, 15]] {
            let refusal = choose_corners(&patch, &outline, &Corners::At(ids(bad))).unwrap_err();
            assert!(matches!(
                refusal,
                BoundaryError::BadCorner { corner: 2, .. }
            ));
        }
    }

    #[test]
    fn the_average_is_the_weighted_sum_that_it_stands_for() {
        let mut noise = Noise::new(11);
        let values: Vec<f64> = (0..200).map(|_| noise.signed()).collect();
        let steps: Vec<f64> = (0..200).map(|_| noise.unit() + 0.1).collect();
        let arcs = Arcs::of(&steps);
        let window = CORNER_WINDOW * arcs.total;
        let direct = |place: usize| -> f64 {
            let weight = |other| (1.0 - arcs.distance(place, other) / window).max(0.0);
            (0..200).map(|other| values[other] * weight(other)).sum()
        };
        for (place, average) in averaged(&values, &steps).into_iter().enumerate() {
            assert!((average - direct(place)).abs() < 1e-11);
        }
    }

    #[test]
    fn a_triangle_has_no_four_corners() {
        let triangle = Fixture {
            positions: vec![glam::DVec3::ZERO, glam::DVec3::X, glam::DVec3::Y],
            triangles: vec![[0, 1, 2]],
        };
        let patch = patch(&triangle);
        let refusal = choose_corners(
            &patch,
            &Outline::of(&patch, &Watch::new()).unwrap(),
            &Corners::Automatic,
        );
        assert_eq!(refusal, Err(BoundaryError::TooFewVertices { vertices: 3 }));
    }
}
