//! Where to cut a part of a graph in two.

use glam::{DMat3, DVec3};

use super::graph::{ABSENT, Graph};
use super::separator::Side;

/// Places at which a cut across one direction is tried.
const BINS: usize = 256;

/// Least share of the vertices on either side of a cut.
const LEAST_SHARE: f64 = 0.3;

/// A cut that crosses more edges than this times the root of the part's size is poor: straight
/// cuts across a compact piece of a triangle mesh cross two to four.
const POOR_CUT: f64 = 6.0;

/// No other direction is tried where a cut crosses fewer edges than this times the root of the
/// part's size: one across a square piece of a triangle mesh crosses more.
const GOOD_CUT: f64 = 2.2;

/// Splits the vertices of a part in two non-empty sides with few edges between them.
///
/// `point` gives each vertex a finite place. The part has at least two vertices.
pub(super) fn choose_cut(graph: &Graph, point: impl Fn(u32) -> DVec3) -> Vec<Side> {
    let vertices = 0..graph.vertices() as u32;
    let root = (graph.vertices() as f64).sqrt();
    let points: Vec<DVec3> = vertices.clone().map(&point).collect();
    let mut best: Option<(Cut, Vec<u16>)> = None;
    for direction in directions(&points) {
        let slices = Slices::across(direction, &points);
        let bins = points.iter().map(|&point| slices.bin(point)).collect();
        best = better(best, best_cut(graph, bins));
        let crossing = best.as_ref().map_or(f64::INFINITY, |(cut, _)| cut.crossing);
        if crossing <= GOOD_CUT * root {
            break;
        }
    }
    if best
        .as_ref()
        .is_none_or(|(cut, _)| cut.crossing > POOR_CUT * root)
    {
        best = better(best, best_cut(graph, bins_of_steps(graph)));
    }
    match best {
        Some((cut, bins)) => bins.into_iter().map(|bin| cut.side(bin)).collect(),
        None => halves_by_height(&points),
    }
}

fn better<T>(best: Option<(Cut, T)>, other: Option<(Cut, T)>) -> Option<(Cut, T)> {
    match (best, other) {
        (Some(best), Some(other)) if other.0.cost < best.0.cost => Some(other),
        (None, other) => other,
        (best, _) => best,
    }
}

/// A cut between two neighbouring bins.
struct Cut {
    /// First bin on the right.
    boundary: u16,
    /// Edges across the cut.
    crossing: f64,
    /// What counts in the comparison of cuts.
    cost: f64,
}

impl Cut {
    fn side(&self, bin: u16) -> Side {
        if bin < self.boundary {
            Side::Left
        } else {
            Side::Right
        }
    }
}

/// Slices of equal thickness across a direction.
struct Slices {
    direction: DVec3,
    lowest: f64,
    per_length: f64,
}

impl Slices {
    fn across(direction: DVec3, sample: &[DVec3]) -> Self {
        let heights = || sample.iter().map(|point| point.dot(direction));
        let lowest = heights().fold(f64::INFINITY, f64::min);
        let highest = heights().fold(f64::NEG_INFINITY, f64::max);
        Self {
            direction,
            lowest,
            per_length: BINS as f64 / (highest - lowest).max(f64::MIN_POSITIVE),
        }
    }

    /// Points outside the sample's range go to the first or last slice.
    #[expect(clippy::cast_sign_loss, reason = "negative numbers saturate to 0")]
    fn bin(&self, point: DVec3) -> u16 {
        let bin = (point.dot(self.direction) - self.lowest) * self.per_length;
        (bin as u16).min(BINS as u16 - 1)
    }
}

/// The principal directions along which the points spread, widest first; those along which they
/// spread less than a third as far are left out.
fn directions(points: &[DVec3]) -> impl Iterator<Item = DVec3> {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let mut covariance = DMat3::ZERO;
    for &point in points {
        let d = point - mean;
        covariance += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    }
    let (variances, axes) = symmetric_eigenvectors(covariance);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| variances[b].total_cmp(&variances[a]));
    let widest = variances[order[0]];
    order
        .into_iter()
        .filter(move |&axis| widest > 0.0 && variances[axis] > 0.1 * widest)
        .map(move |axis| axes.col(axis))
}

/// Eigenvalues and eigenvectors of a symmetric matrix by Jacobi rotations.
fn symmetric_eigenvectors(mut matrix: DMat3) -> (DVec3, DMat3) {
    let mut vectors = DMat3::IDENTITY;
    // Convergence is quadratic; a direction for a cut needs far less than six sweeps.
    for (p, q) in [(0, 1), (0, 2), (1, 2)].repeat(6) {
        let off = matrix.col(p)[q];
        if off == 0.0 {
            continue;
        }
        let ratio = (matrix.col(q)[q] - matrix.col(p)[p]) / (2.0 * off);
        let tangent = ratio.signum() / (ratio.abs() + ratio.hypot(1.0));
        let cosine = tangent.hypot(1.0).recip();
        let sine = tangent * cosine;
        let mut rotation = DMat3::IDENTITY;
        rotation.col_mut(p)[p] = cosine;
        rotation.col_mut(q)[q] = cosine;
        rotation.col_mut(q)[p] = sine;
        rotation.col_mut(p)[q] = -sine;
        matrix = rotation.transpose() * matrix * rotation;
        vectors *= rotation;
    }
    (matrix.diagonal(), vectors)
}

/// Bins by the number of steps along edges from a vertex that is far from some other one.
fn bins_of_steps(graph: &Graph) -> Vec<u16> {
    let (_, far) = steps_from(graph, 0);
    let (steps, last) = steps_from(graph, far);
    let most = steps[last as usize] as usize;
    let shrink = |step: u32| {
        // What is not reached lies on the far side, at no cost in edges.
        let step = (step as usize).min(most);
        (step * (BINS - 1) / most.max(BINS - 1)) as u16
    };
    steps.into_iter().map(shrink).collect()
}

/// Steps to every vertex (`ABSENT` where there is no path) and the vertex reached last.
fn steps_from(graph: &Graph, root: u32) -> (Vec<u32>, u32) {
    let mut steps = vec![ABSENT; graph.vertices()];
    steps[root as usize] = 0;
    let mut queue = vec![root];
    let mut head = 0;
    while let Some(&vertex) = queue.get(head) {
        head += 1;
        for &neighbour in graph.neighbours(vertex) {
            if steps[neighbour as usize] == ABSENT {
                steps[neighbour as usize] = steps[vertex as usize] + 1;
                queue.push(neighbour);
            }
        }
    }
    (steps, queue[queue.len() - 1])
}

/// The best boundary between bins that leaves enough on both sides, if there is one.
fn best_cut(graph: &Graph, bins: Vec<u16>) -> Option<(Cut, Vec<u16>)> {
    let mut counts = [0_usize; BINS];
    // Edges that begin minus edges that end in each bin.
    let mut opened = [0_isize; BINS];
    for (vertex, &bin) in (0..).zip(&bins) {
        counts[usize::from(bin)] += 1;
        // Without branches: which of two neighbours is higher cannot be predicted.
        let neighbours = graph.neighbours(vertex).iter();
        let others = neighbours.map(|&neighbour| bins[neighbour as usize]);
        let rises = others.map(|other| isize::from(other > bin) - isize::from(other < bin));
        opened[usize::from(bin)] += rises.sum::<isize>();
    }
    let total: usize = counts.iter().sum();
    let (mut left, mut crossing) = (0, 0);
    let mut best: Option<Cut> = None;
    for bin in 0..BINS - 1 {
        left += counts[bin];
        crossing += opened[bin];
        let smaller = left.min(total - left) as f64;
        if counts[bin] == 0 || smaller < LEAST_SHARE * total as f64 {
            continue;
        }
        // Mostly the fewest edges; halves of equal size decide between similar ones.
        let cost = crossing as f64 / smaller.sqrt().sqrt();
        if best.as_ref().is_none_or(|least| cost < least.cost) {
            best = Some(Cut {
                boundary: bin as u16 + 1,
                crossing: crossing as f64,
                cost,
            });
        }
    }
    best.map(|cut| (cut, bins))
}

/// Two halves of equal size along the widest direction: always possible, whatever the points.
fn halves_by_height(points: &[DVec3]) -> Vec<Side> {
    let direction = directions(points).next().unwrap_or(DVec3::X);
    let mut ranked: Vec<(f64, u32)> = (0..)
        .zip(points)
        .map(|(vertex, point)| (point.dot(direction), vertex))
        .collect();
    let middle = ranked.len() / 2;
    ranked.select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut sides = vec![Side::Right; points.len()];
    for &(_, vertex) in &ranked[..middle] {
        sides[vertex as usize] = Side::Left;
    }
    sides
}
