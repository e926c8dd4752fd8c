//! Mending of quads whose shape cannot be saved by moving vertices.
//!
//! A small disk of polygons around a poor one is cut anew in the best way, without or with one
//! vertex inside; then the vertices there and a little around are moved as in
//! [`shape()`](super::shape()). This covers what is otherwise told as many operations: to turn an
//! edge, to collapse a quad along a diagonal, to take out a vertex with two or three quads, to put
//! one in. What makes the quads of a neighbourhood better is kept. Features and the boundary are
//! never cut, until nothing else is left: then the net gives up the edges of features at the quads
//! that are still poor, and is let round the corners of the others and of the boundary there.

mod patch;
mod quilt;
#[cfg(test)]
mod tests;

use std::collections::{HashMap, HashSet};

use serde::Serialize;

use self::patch::{Candidate, Patch, new_vertex};
use self::quilt::{Quilt, sides};
use super::polygon_mesh::PolygonMesh;
use super::shape::{Ground, Net, Place, Run, ShapeOptions, quality};
use crate::geometry::slide_towards;
use crate::measure::scaled_jacobian;
use crate::mesh::{EdgeId, Polygons, Surface};
use crate::tolerance::{FLAT_CORNER, MENDED_QUAD, POOR_QUAD};
use crate::watch::{Stopped, Watch};

/// Times that all poor polygons are looked at.
const ROUNDS: usize = 4;

/// Polygons around a patch whose vertices move with it.
const RINGS: usize = 2;

/// How much is tried for one polygon.
#[derive(Clone, Copy)]
struct Effort {
    /// Polygons below this quality are worked on.
    below: f64,
    /// Candidates whose vertices are moved to see what becomes of them: those that promise most as
    /// they are.
    trials: usize,
    /// Rounds of work on the poor polygons of a trial.
    raising_rounds: usize,
    /// Whether patches are drawn in and get a ring of quads round them, rather than cut anew.
    pillows: bool,
}

/// A light effort for all poor polygons, then all that can be done for those that are inverted.
const EFFORTS: [Effort; 2] = [
    Effort {
        below: MENDED_QUAD,
        trials: 10,
        raising_rounds: 1,
        pillows: false,
    },
    Effort {
        below: FLAT_CORNER,
        trials: 40,
        raising_rounds: 4,
        pillows: false,
    },
];

/// What is done where features have given way.
const LAST_EFFORT: Effort = Effort {
    below: MENDED_QUAD,
    trials: 40,
    raising_rounds: 4,
    pillows: false,
};

/// What is done for quads that are still inverted. It takes eight irregular vertices for each.
const PILLOWS: Effort = Effort {
    below: FLAT_CORNER,
    trials: 6,
    raising_rounds: 4,
    pillows: true,
};

/// Pillows that are tried.
const MOST_PILLOWS: usize = 300;

/// Times that features give way to the quads that are still poor.
const RELEASES: usize = 3;

/// Times that each vertex of a trial is moved at most before that.
const SWEEPS: usize = 4;

/// Trials in all, and one more for each polygon: more than any model takes on which they help. Where
/// all polygons are poor, as on a few needles, each takes long and none helps.
const MOST_TRIALS: usize = 300;

/// What a polygon that is turned over counts beside what it lacks.
const INVERTED: f64 = 1.0;

/// Least lack that a change must take away.
const WORTH_A_CHANGE: f64 = 0.02;

/// What was mended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct MendReport {
    /// Polygons whose shape was too poor.
    pub poor_before: usize,
    /// Patches that were cut anew.
    pub patches: usize,
    /// Edges of the mesh along features that were given up.
    pub released: usize,
    /// Polygons whose shape is too poor still.
    pub poor_after: usize,
}

impl MendReport {
    fn warn(&self, watch: &Watch) {
        if self.released > 0 {
            let message = format!(
                "{} edges of the net were let go of features that leave no room for good quads",
                self.released
            );
            watch.warn("released-features", message);
        }
    }
}

/// Cuts small disks around polygons of poor shape anew, where that makes them better.
///
/// `features` are the edges of the surface along which the feature edges of the mesh run. The mesh
/// keeps its topology and its boundary, and its feature edges but those that leave no room for good
/// quads, which is a warning. Cost: linear where all is well, some
/// milliseconds for each polygon with a scaled Jacobian below [`MENDED_QUAD`], up to a bound.
///
/// # Errors
/// [`Stopped`].
pub fn mend(
    mesh: &mut PolygonMesh,
    surface: &Surface,
    features: &[EdgeId],
    watch: &Watch,
) -> Result<MendReport, Stopped> {
    if is_fine(mesh) {
        return Ok(MendReport::default());
    }
    let _stage = watch.stage("mend quads");
    let ground = Ground::of(surface, features);
    let mut mender = Mender {
        trials_left: MOST_TRIALS + mesh.polygons.len(),
        quilt: Quilt::of(mesh, &ground),
        ground,
        watch,
    };
    let mut report = MendReport {
        poor_before: mender.poor(MENDED_QUAD).len(),
        ..MendReport::default()
    };
    for effort in EFFORTS {
        report.patches += mender.work(effort)?;
    }
    for _ in 0..RELEASES {
        if mender.poor(MENDED_QUAD).is_empty() {
            break;
        }
        mender.ground.round_corners(features);
        report.released += mender.release();
        report.patches += mender.work(LAST_EFFORT)?;
    }
    mender.trials_left = MOST_PILLOWS;
    report.patches += mender.work(PILLOWS)?;
    report.poor_after = mender.poor(MENDED_QUAD).len();
    if report.patches + report.released > 0 {
        mender.quilt.write_to(mesh, surface);
    }
    report.warn(watch);
    Ok(report)
}

/// Whether all quads are good enough by their shapes alone, and there are no other polygons.
fn is_fine(mesh: &PolygonMesh) -> bool {
    (0..mesh.polygons.len()).all(|polygon| {
        <[u32; 4]>::try_from(mesh.polygons.vertices(polygon)).is_ok_and(|quad| {
            scaled_jacobian(quad.map(|v| mesh.positions[v as usize])) >= MENDED_QUAD
        })
    })
}

struct Mender<'a> {
    trials_left: usize,
    quilt: Quilt,
    ground: Ground,
    watch: &'a Watch,
}

/// A candidate after its vertices were moved.
struct Trial {
    /// What the polygons lack in all.
    lack: f64,
    polygons: Vec<Vec<u32>>,
    /// How many of its vertices are new.
    new_vertices: usize,
    /// Where vertices are now.
    moved: Vec<(u32, Place)>,
}

impl Mender<'_> {
    /// Mends what it can with some effort; returns the number of patches that were cut anew.
    fn work(&mut self, effort: Effort) -> Result<usize, Stopped> {
        // What failed once would most likely fail again.
        let mut failed = HashSet::new();
        let mut patches = 0;
        for _ in 0..ROUNDS {
            let before = patches;
            for polygon in self.poor(effort.below) {
                self.watch.check()?;
                if self.trials_left == 0 {
                    return Ok(patches);
                }
                if failed.contains(&polygon) {
                    continue;
                }
                if self.mend(polygon, effort)? {
                    patches += 1;
                } else {
                    failed.insert(polygon);
                }
            }
            if patches == before {
                break;
            }
        }
        Ok(patches)
    }

    /// Gives up the edges along features at the polygons that are poor; returns how many.
    fn release(&mut self) -> usize {
        let mut released = 0;
        for polygon in self.poor(MENDED_QUAD) {
            for vertex in self.quilt.vertices(polygon).to_vec() {
                released += self.quilt.release_lines_at(vertex);
            }
        }
        released
    }

    /// The polygons below a quality, the worst first.
    fn poor(&self, below: f64) -> Vec<u32> {
        let mut poor: Vec<(f64, u32)> = (0..self.quilt.polygon_count() as u32)
            .map(|polygon| (self.quality(polygon), polygon))
            .filter(|&(quality, _)| quality < below)
            .collect();
        poor.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        poor.into_iter().map(|(_, polygon)| polygon).collect()
    }

    /// The quality of a polygon; the best where it was taken out.
    fn quality(&self, polygon: u32) -> f64 {
        let vertices = self.quilt.vertices(polygon);
        let places: Vec<Place> = vertices.iter().map(|&v| self.quilt.place(v)).collect();
        if places.is_empty() {
            1.0
        } else {
            quality(&places)
        }
    }

    /// Takes the best change of a patch with the polygon in it, if there is a good one.
    fn mend(&mut self, polygon: u32, effort: Effort) -> Result<bool, Stopped> {
        if self.quality(polygon) >= effort.below {
            return Ok(false);
        }
        let quilt = &self.quilt;
        let patches = if effort.pillows {
            Patch::under_pillows(quilt, polygon)
        } else {
            Patch::around(quilt, polygon)
        };
        let mut ideas: Vec<(f64, &Patch, Candidate)> = (patches.iter())
            .flat_map(|patch| {
                let candidates = if effort.pillows {
                    patch.pillow(quilt).into_iter().collect()
                } else {
                    patch.candidates(quilt)
                };
                (candidates.into_iter()).map(move |candidate| (patch, candidate))
            })
            .map(|(patch, candidate)| (self.promise(patch, &candidate), patch, candidate))
            .collect();
        ideas.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<(f64, &Patch, Trial)> = None;
        for (_, patch, candidate) in ideas.into_iter().take(effort.trials.min(self.trials_left)) {
            self.trials_left -= 1;
            let around = patch.surroundings(&self.quilt, RINGS);
            let before: f64 = (patch.polygons.iter().chain(&around))
                .map(|&polygon| lack(self.quality(polygon)))
                .sum();
            let trial = self.tried(patch, &around, candidate, effort)?;
            let gain = before - trial.lack;
            let least = best.as_ref().map_or(WORTH_A_CHANGE, |(gain, ..)| *gain);
            let is_enough = trial.lack == 0.0;
            if gain > least {
                best = Some((gain, patch, trial));
            }
            if is_enough {
                break;
            }
        }
        let Some((_, patch, trial)) = best else {
            return Ok(false);
        };
        self.take(&patch.polygons, trial);
        Ok(true)
    }

    /// What the polygons of a candidate lack before any vertex moves.
    fn promise(&self, patch: &Patch, candidate: &Candidate) -> f64 {
        let new = self.new_places(patch, candidate);
        let place = |&vertex: &u32| {
            let new = new.get(new_vertex(vertex)).copied();
            new.unwrap_or_else(|| self.quilt.place(vertex))
        };
        (candidate.polygons.iter())
            .map(|polygon| lack(quality(&polygon.iter().map(place).collect::<Vec<_>>())))
            .sum()
    }

    /// Puts a candidate in, as far as its neighbourhood, and moves its vertices.
    fn tried(
        &self,
        patch: &Patch,
        around: &[u32],
        candidate: Candidate,
        effort: Effort,
    ) -> Result<Trial, Stopped> {
        let quilt = &self.quilt;
        let outer = around.iter().map(|&polygon| quilt.vertices(polygon));
        let all = || {
            candidate
                .polygons
                .iter()
                .map(Vec::as_slice)
                .chain(outer.clone())
        };
        let mut vertices: Vec<u32> = all().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let local = |vertex: u32| vertices.partition_point(|&other| other < vertex) as u32;
        let renamed: Vec<Vec<u32>> = all()
            .map(|polygon| polygon.iter().map(|&v| local(v)).collect())
            .collect();
        let polygons: Polygons = renamed.iter().map(Vec::as_slice).collect();
        let lines: Vec<[u32; 2]> = all()
            .flat_map(sides)
            .filter(|&side| quilt.is_line(side))
            .map(|side| side.map(local))
            .collect();
        let is_inside = |polygon: &u32| {
            around.binary_search(polygon).is_ok() || patch.polygons.binary_search(polygon).is_ok()
        };
        let new = self.new_places(patch, &candidate);
        let origins: Vec<_> = (vertices.iter())
            .map(|&vertex| {
                let new = new.get(new_vertex(vertex)).copied();
                new.unwrap_or_else(|| quilt.place(vertex)).origin
            })
            .collect();
        let net = Net {
            surface: &self.ground.surface,
            features: &[],
            polygons: &polygons,
            feature_edges: &lines,
        };
        let is_held = |index: usize| {
            new_vertex(vertices[index]) >= new.len()
                && !quilt.around(vertices[index]).iter().all(is_inside)
        };
        let options = ShapeOptions {
            sweeps: SWEEPS,
            ..ShapeOptions::default()
        };
        let mut run = Run::new(&self.ground, &net, &origins, options, is_held);
        run.settle(effort.raising_rounds, self.watch)?;
        let lack = run.qualities().map(lack).sum();
        let new_vertices = new.len();
        let places = run.origins().map(|origin| self.ground.place(origin));
        let moved = vertices.iter().copied().zip(places).collect();
        Ok(Trial {
            lack,
            polygons: candidate.polygons,
            new_vertices,
            moved,
        })
    }

    /// The places of the new vertices of a candidate.
    fn new_places(&self, patch: &Patch, candidate: &Candidate) -> Vec<Place> {
        let wanted = candidate.middles.iter();
        wanted.map(|&place| self.near(patch, place)).collect()
    }

    /// The point of the surface near a place in a patch.
    fn near(&self, patch: &Patch, place: glam::DVec3) -> Place {
        let starts = patch.border.iter().map(|&vertex| self.quilt.place(vertex));
        let reached = starts.map(|start| {
            let origin = slide_towards(&self.ground.surface, start.origin, place);
            self.ground.place(origin)
        });
        let distance = |reached: &Place| reached.position.distance_squared(place);
        let nearest = reached.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.unwrap_or_else(|| self.quilt.place(patch.border[0]))
    }

    fn take(&mut self, polygons: &[u32], mut trial: Trial) {
        let mut numbers = HashMap::new();
        for (vertex, place) in trial.moved {
            if new_vertex(vertex) < trial.new_vertices {
                numbers.insert(vertex, self.quilt.add_vertex(place));
            } else {
                self.quilt.put(vertex, place);
            }
        }
        for corner in trial.polygons.iter_mut().flatten() {
            *corner = numbers.get(corner).copied().unwrap_or(*corner);
        }
        self.quilt.replace(polygons, trial.polygons);
    }
}

/// What a polygon lacks to be fair.
fn lack(quality: f64) -> f64 {
    let inverted = if quality > 0.0 { 0.0 } else { INVERTED };
    (POOR_QUAD - quality).max(0.0) + inverted
}
