use glam::DVec2;
use rayon::prelude::*;

use super::MeasureError;
use super::uv_map::UvMap;
use crate::mesh::HalfedgeId;
use crate::watch::Watch;

/// Most lines that a map is scanned along.
const MOST_LINES: usize = 4096;
/// Fewest lines, however many edges they cross.
const FEWEST_LINES: usize = 16;
/// Crossings of lines and edges to stay below if possible: the cost of the scan.
const CROSSINGS: f64 = 4e6;
/// Crossings that one task holds at a time, about.
const CROSSINGS_PER_BAND: f64 = 65536.0;

/// Areas of the plane by the number of triangles above a point, in scaled units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Coverage {
    /// Covered at least once.
    pub(super) covered: f64,
    /// Covered at least twice.
    pub(super) overlapped: f64,
    /// The sum of the cover's multiplicity beyond one.
    pub(super) excess: f64,
    /// Lines that were scanned.
    pub(super) lines: usize,
}

/// An edge at which the number of triangles over the plane changes.
struct Step {
    lower: DVec2,
    upper: DVec2,
    /// Change of the number of triangles when the edge is passed in the direction of x.
    change: i32,
}

/// Measures the covered area along evenly spaced lines of constant v.
///
/// Along a line the lengths are exact to rounding; between lines they are taken to be constant, so
/// that a region of perimeter P is known to within P/2 times the spacing. Only edges where the
/// cover changes (borders and folds) are looked at, and adjacent triangles share their edges
/// exactly, so that a map without overlap shows none.
pub(super) fn scan(map: &UvMap<'_>, watch: &Watch) -> Result<Coverage, MeasureError> {
    let _stage = watch.stage("covered area");
    let steps = steps(map);
    let bottom = steps
        .iter()
        .map(|step| step.lower.y)
        .fold(f64::INFINITY, f64::min);
    let top = steps
        .iter()
        .map(|step| step.upper.y)
        .fold(f64::NEG_INFINITY, f64::max);
    if bottom >= top {
        return Ok(Coverage::default());
    }
    let grid = Lines::new(&steps, bottom, top);
    let bands = grid.bands(&steps);
    let parts = bands.par_iter().enumerate().map(|(band, members)| {
        watch.check()?;
        Ok(grid.scan_band(band, members, &steps))
    });
    let parts = parts.collect::<Result<Vec<_>, MeasureError>>()?;
    let mut total = parts
        .iter()
        .fold(Coverage::default(), |sum, part| Coverage {
            covered: sum.covered + part.covered,
            overlapped: sum.overlapped + part.overlapped,
            excess: sum.excess + part.excess,
            lines: sum.lines,
        });
    total.covered *= grid.spacing;
    total.overlapped *= grid.spacing;
    total.excess *= grid.spacing;
    total.lines = grid.count;
    Ok(total)
}

fn steps(map: &UvMap<'_>) -> Vec<Step> {
    let halfedges = map.surface.mesh().halfedges();
    halfedges
        .filter_map(|halfedge| step(map, halfedge))
        .collect()
}

/// The step along a halfedge; `None` where the cover is the same on both sides, and for the second
/// halfedge of an edge.
fn step(map: &UvMap<'_>, halfedge: HalfedgeId) -> Option<Step> {
    let beyond = match map.continuation(halfedge) {
        Some(twin) if twin < halfedge => return None,
        Some(twin) => map.sign(twin.face()),
        None => 0,
    };
    // A triangle with positive area lies to the left of its sides, its neighbour to the right.
    let change = i32::from(beyond - map.sign(halfedge.face()));
    let [from, to] = map.image_of_side(halfedge);
    let (lower, upper, change) = if from.y < to.y {
        (from, to, change)
    } else {
        (to, from, -change)
    };
    (change != 0 && lower.y < upper.y).then_some(Step {
        lower,
        upper,
        change,
    })
}

struct Lines {
    bottom: f64,
    spacing: f64,
    count: usize,
    per_band: usize,
}

impl Lines {
    fn new(steps: &[Step], bottom: f64, top: f64) -> Self {
        let height = top - bottom;
        let heights: f64 = steps
            .iter()
            .map(|step| (step.upper.y - step.lower.y) / height)
            .sum();
        let mut count = MOST_LINES;
        while count > FEWEST_LINES && heights * count as f64 > CROSSINGS {
            count /= 2;
        }
        let mut per_band = 1;
        while per_band < count && heights * 2.0 * per_band as f64 <= CROSSINGS_PER_BAND {
            per_band *= 2;
        }
        Self {
            bottom,
            spacing: height / count as f64,
            count,
            per_band,
        }
    }

    fn place(&self, line: usize) -> f64 {
        self.bottom + (line as f64 + 0.5) * self.spacing
    }

    /// The lines that cross a step: those at or above its lower end and below its upper end.
    fn crossing(&self, step: &Step) -> std::ops::Range<usize> {
        let first_at_or_above = |y: f64| {
            let guess = ((y - self.bottom) / self.spacing - 0.5).ceil().max(0.0);
            #[allow(clippy::cast_sign_loss)] // at least 0
            let mut line = (guess as usize).min(self.count);
            while line > 0 && self.place(line - 1) >= y {
                line -= 1;
            }
            while line < self.count && self.place(line) < y {
                line += 1;
            }
            line
        };
        first_at_or_above(step.lower.y)..first_at_or_above(step.upper.y)
    }

    /// The steps that each band of lines crosses.
    fn bands(&self, steps: &[Step]) -> Vec<Vec<u32>> {
        let mut bands = vec![Vec::new(); self.count.div_ceil(self.per_band)];
        for (index, step) in steps.iter().enumerate() {
            let lines = self.crossing(step);
            if lines.is_empty() {
                continue;
            }
            for band in &mut bands[lines.start / self.per_band..=(lines.end - 1) / self.per_band] {
                band.push(index as u32);
            }
        }
        bands
    }

    /// Sums of lengths, not yet multiplied with the spacing.
    fn scan_band(&self, band: usize, members: &[u32], steps: &[Step]) -> Coverage {
        let first = band * self.per_band;
        let last = (first + self.per_band).min(self.count);
        let mut crossings: Vec<Vec<(f64, i32)>> = vec![Vec::new(); last - first];
        for step in members.iter().map(|&index| &steps[index as usize]) {
            let lines = self.crossing(step);
            for line in lines.start.max(first)..lines.end.min(last) {
                crossings[line - first].push((crossing_at(step, self.place(line)), step.change));
            }
        }
        let mut sum = Coverage::default();
        for line in &mut crossings {
            line.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            add_line(&mut sum, line);
        }
        sum
    }
}

/// Where a line of constant v meets a step.
fn crossing_at(step: &Step, y: f64) -> f64 {
    let share = (y - step.lower.y) / (step.upper.y - step.lower.y);
    let x = step.lower.x + share * (step.upper.x - step.lower.x);
    x.clamp(
        step.lower.x.min(step.upper.x),
        step.lower.x.max(step.upper.x),
    )
}

fn add_line(sum: &mut Coverage, crossings: &[(f64, i32)]) {
    let mut cover = 0;
    for pair in crossings.windows(2) {
        cover += pair[0].1;
        let length = pair[1].0 - pair[0].0;
        if cover >= 1 {
            sum.covered += length;
        }
        if cover >= 2 {
            sum.overlapped += length;
            sum.excess += f64::from(cover - 1) * length;
        }
    }
}
