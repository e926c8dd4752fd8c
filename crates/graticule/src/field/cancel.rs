use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use serde::Serialize;

use super::angle_fit::{AngleFit, STIFFENED_SOLVES};
use super::disk::{Ball, DiskFinder};
use super::face_path::{End, FacePath, FacePathFinder};
use super::matching::Matching;
use super::{CrossField, FieldDomain, FieldError, Guidance};
use crate::mesh::{DisjointSets, FaceId, HalfedgeId, PerFace, PerVertex, VertexId};
use crate::tolerance::{LIKE_LENGTHS, WIDEST_TURN_READ};
use crate::watch::Watch;

/// What [`FieldDomain::cancel_close_pairs`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Cancellation {
    /// Pairs that were tried.
    pub pairs_tried: usize,
    /// Singular triangles before.
    pub singularities_before: usize,
    /// Singular triangles after.
    pub singularities_after: usize,
}

/// Which singularities cancel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CancelOptions {
    /// Largest distance between the two along the surface, in the unit of the positions.
    pub distance: f64,
    /// The share of smoothness against guidance, as in
    /// [`SmoothingOptions`](super::SmoothingOptions).
    pub smoothing: f64,
}

impl FieldDomain<'_> {
    /// Lets singularities of opposite sign within a distance of each other cancel, nearest first.
    ///
    /// One step of the index is carried from the one to the other along the shortest path, and the
    /// angles around both (and around all pairs that touch them) are found anew for the jumps changed by that; further away the field stays
    /// as it is. It still follows its guidance as far as it can without the pair. A pair stays where
    /// a hard line runs between the two, or where the field would have to turn too fast.
    ///
    /// Cost: linear, and a small factorisation for each pair.
    ///
    /// # Errors
    /// [`FieldError`].
    pub fn cancel_close_pairs(
        &self,
        field: &CrossField,
        guidance: &Guidance,
        options: &CancelOptions,
        watch: &Watch,
    ) -> Result<(CrossField, Cancellation), FieldError> {
        let _stage = watch.stage("cancelling pairs");
        let mut run = Canceller::new(self, field, guidance, options);
        let before = run.count();
        loop {
            let pairs = run.untried_pairs();
            if pairs.is_empty() {
                break;
            }
            for group in run.groups(pairs) {
                watch.check()?;
                run.try_group(&group)?;
            }
        }
        let symmetry = field.symmetry();
        let angles = run.angles.map(|&angle| symmetry.reduce(angle).0);
        let field = CrossField::from_angles(symmetry, angles);
        let report = Cancellation {
            pairs_tried: run.tried.len(),
            singularities_before: before,
            singularities_after: run.count(),
        };
        Ok((field, report))
    }
}

/// Radius of the disk that is smoothed anew around either singularity, over their distance.
const REACH: f64 = 1.5;

/// The least such radius, in mean edge lengths: of the surface, or of the two triangles where these
/// are smaller.
const LEAST_REACH: f64 = 3.0;

/// Most vertices in such a disk.
const MOST_VERTICES: usize = 4_000;

/// Whether two lengths differ by no more than rounding, as those of mirror images.
fn is_like(a: f64, b: f64) -> bool {
    (a - b).abs() <= LIKE_LENGTHS * a.max(b)
}

/// A singularity, and the way to one of opposite sign.
struct Pair {
    positive: FaceId,
    negative: FaceId,
    path: FacePath,
}

/// A pair with the vertices around it at which the field is to change.
struct Candidate {
    pair: Pair,
    region: Vec<VertexId>,
}

struct Canceller<'a> {
    domain: &'a FieldDomain<'a>,
    guidance: &'a Guidance,
    distance: f64,
    step: f64,
    fit: AngleFit<'a>,
    angles: PerVertex<f64>,
    matching: Matching,
    steps: PerFace<i32>,
    tried: BTreeSet<[FaceId; 2]>,
    paths: FacePathFinder<'a>,
    disks: DiskFinder<'a>,
}

impl<'a> Canceller<'a> {
    fn new(
        domain: &'a FieldDomain<'a>,
        field: &CrossField,
        guidance: &'a Guidance,
        options: &CancelOptions,
    ) -> Self {
        let matching = Matching::nearest(domain, field);
        let step = field.symmetry().step();
        Self {
            domain,
            guidance,
            distance: options.distance,
            step,
            fit: AngleFit::new(domain, guidance, options.smoothing),
            angles: field.angles().clone(),
            steps: matching.steps(domain, step),
            matching,
            tried: BTreeSet::new(),
            paths: FacePathFinder::new(domain.surface()),
            disks: DiskFinder::new(domain.edge_graph()),
        }
    }

    /// The number of singular triangles.
    fn count(&self) -> usize {
        self.steps.iter().filter(|&&steps| steps != 0).count()
    }

    /// For each singularity of positive sign the nearest of negative sign that it was not tried with,
    /// nearest pairs first.
    fn untried_pairs(&mut self) -> Vec<Pair> {
        let Self {
            steps,
            tried,
            paths,
            ..
        } = self;
        let (mesh, guidance) = (self.domain.surface().mesh(), self.guidance);
        let is_open = |halfedge: HalfedgeId| {
            mesh.twin(halfedge).is_some() && !guidance.holds_ends(mesh, halfedge)
        };
        let positive = steps.enumerate().filter(|&(_, &steps)| steps > 0);
        let mut pairs = Vec::new();
        for (face, _) in positive {
            let is_opposite = |end| match end {
                End::Face(other) => steps[other] < 0 && !tried.contains(&[face, other]),
                End::Rim(_) => false,
            };
            let found = paths.nearest(face, self.distance, is_open, is_opposite);
            if let Some((End::Face(other), path)) = found.map(|path| (path.end, path)) {
                pairs.push(Pair {
                    positive: face,
                    negative: other,
                    path,
                });
            }
        }
        pairs.sort_by(|a, b| a.path.length.total_cmp(&b.path.length));
        pairs
    }

    /// The pairs, none with a singularity of one before it, in groups whose regions do not touch.
    fn groups(&mut self, pairs: Vec<Pair>) -> Vec<Vec<Candidate>> {
        let mesh = self.domain.surface().mesh();
        let mut candidates: Vec<Candidate> = Vec::new();
        let mut taken = BTreeSet::new();
        let mut owners = BTreeMap::<VertexId, u32>::new();
        let mut together = DisjointSets::new(pairs.len());
        for pair in pairs {
            let ends = [pair.positive, pair.negative];
            if ends.iter().any(|end| taken.contains(end)) {
                continue;
            }
            taken.extend(ends);
            self.tried.insert(ends);
            let number = candidates.len() as u32;
            let region = self.region(&pair);
            for &vertex in &region {
                for touched in std::iter::once(vertex).chain(mesh.neighbors(vertex)) {
                    if let Some(&other) = owners.get(&touched) {
                        together.join(number, other);
                    }
                }
            }
            owners.extend(region.iter().map(|&vertex| (vertex, number)));
            candidates.push(Candidate { pair, region });
        }
        let mut groups = BTreeMap::<u32, Vec<Candidate>>::new();
        for (number, candidate) in candidates.into_iter().enumerate() {
            let group = groups.entry(together.find(number as u32)).or_default();
            group.push(candidate);
        }
        groups.into_values().collect()
    }

    /// Cancels all pairs of a group at once; if that cannot be, one after the other, but still at once
    /// those at like distances: mirror images of each other, that would end unlike if one of them went
    /// first.
    fn try_group(&mut self, group: &[Candidate]) -> Result<(), FieldError> {
        let parts = || group.chunk_by(|a, b| is_like(a.pair.path.length, b.pair.path.length));
        let is_split = parts().nth(1).is_some();
        // Stiffening for the sake of one pair would spoil the field around unlike ones.
        let solves = if is_split { 0 } else { STIFFENED_SOLVES };
        if self.try_pairs(group, solves)? || !is_split {
            return Ok(());
        }
        for part in parts() {
            self.try_pairs(part, STIFFENED_SOLVES)?;
        }
        Ok(())
    }

    /// Cancels pairs, unless the field cannot do without one of them; whether it could.
    /// Edges that turn too far are stiffened in so many solves.
    fn try_pairs(&mut self, group: &[Candidate], stiffened: usize) -> Result<bool, FieldError> {
        let mut region: Vec<VertexId> = group.iter().flat_map(|c| &c.region).copied().collect();
        region.sort_unstable();
        region.dedup();
        let mesh = self.domain.surface().mesh();
        let old: Vec<f64> = region.iter().map(|&vertex| self.angles[vertex]).collect();
        for Candidate { pair, .. } in group {
            self.matching.carry(mesh, &pair.path.crossed, 1);
        }
        let Self { fit, angles, .. } = self;
        fit.fit(angles, &self.matching, &region, stiffened)?;
        let crossed = group.iter().flat_map(|c| &c.pair.path.crossed);
        let around = region.iter().flat_map(|&vertex| mesh.outgoing(vertex));
        let sides = around.flat_map(|halfedge| [halfedge, halfedge.previous()]);
        let could = self.turn_little(sides.chain(crossed.copied()));
        for Candidate { pair, .. } in group {
            if could {
                self.steps[pair.positive] -= 1;
                self.steps[pair.negative] += 1;
            } else {
                self.matching.carry(mesh, &pair.path.crossed, -1);
            }
        }
        if !could {
            for (&vertex, angle) in region.iter().zip(old) {
                self.angles[vertex] = angle;
            }
        }
        Ok(could)
    }

    /// The vertices around both that are neither held nor torn.
    fn region(&mut self, pair: &Pair) -> Vec<VertexId> {
        let local = self
            .mean_side(pair.positive)
            .max(self.mean_side(pair.negative));
        let least = LEAST_REACH * self.domain.mean_edge_length().min(local);
        let radius = (REACH * pair.path.length).max(least);
        let (mesh, graph) = (self.domain.surface().mesh(), self.domain.edge_graph());
        let mut disk = Vec::new();
        let mut region = Vec::new();
        for face in [pair.positive, pair.negative] {
            let corners = mesh.triangle(face).map(|vertex| graph.rank(vertex));
            let center = self
                .domain
                .surface()
                .corner_positions(face)
                .iter()
                .sum::<DVec3>()
                / 3.0;
            let ball = Ball { center, radius };
            self.disks
                .find_in(&ball, &corners, MOST_VERTICES, &mut disk);
            region.extend(
                disk.iter()
                    .map(|entry| graph.vertices()[entry.rank as usize]),
            );
        }
        region.sort_unstable();
        region.dedup();
        region.retain(|&vertex| self.guidance.fixed(vertex).is_none() && !self.is_torn(vertex));
        region
    }

    /// The mean length of the sides of a triangle.
    fn mean_side(&self, face: FaceId) -> f64 {
        let surface = self.domain.surface();
        let sides = face.halfedges().map(|side| surface.halfedge_vector(side));
        sides.iter().map(|side| side.length()).sum::<f64>() / 3.0
    }

    /// Whether the field turns by half a step along an edge here. Rounding chooses the jump there, as
    /// on the plane of a mirror: a fit would carry that choice into the field.
    fn is_torn(&self, vertex: VertexId) -> bool {
        let around = self.domain.surface().mesh().outgoing(vertex);
        !self.turn_little(
            around
                .flat_map(|halfedge| [halfedge, halfedge.previous()])
                .filter(|&side| self.domain.surface().mesh().ends(side).contains(&vertex)),
        )
    }

    /// Whether the field turns so little along these halfedges that its jumps are those that anyone
    /// would read off its angles.
    fn turn_little(&self, mut sides: impl Iterator<Item = HalfedgeId>) -> bool {
        sides.all(|side| {
            let turn = self
                .matching
                .turn(self.domain, &self.angles, self.step, side);
            turn.abs() <= WIDEST_TURN_READ * self.step
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Singularities, Symmetry};
    use crate::geometry::vertex_frames;
    use crate::mesh::Surface;
    use glam::DVec2;
    use graticule_fixtures::disk;

    /// A cross field on a flat disk of radius 1 with a quarter-pole of sign `steps` at each place.
    fn poles(surface: &Surface, poles: &[(DVec2, f64)]) -> CrossField {
        let frames = vertex_frames(surface);
        let angles = PerVertex::from_fn(surface.mesh().vertex_count(), |vertex: VertexId| {
            let p = surface.position(vertex).truncate();
            let turned = |(place, steps): &(DVec2, f64)| {
                steps * libm::atan2(p.y - place.y, p.x - place.x) / 4.0
            };
            let angle: f64 = poles.iter().map(turned).sum();
            let along = frames[vertex].project(DVec3::new(angle.cos(), angle.sin(), 0.0));
            libm::atan2(along.y, along.x)
        });
        CrossField::from_angles(Symmetry::Cross, angles)
    }

    /// The signs of the singularities before and after, and the sums of the indices.
    fn cancelled(places: &[(DVec2, f64)], distance: f64) -> ([Vec<i32>; 2], [f64; 2]) {
        let disk = disk(20);
        let surface = Surface::from_triangles(disk.positions, &disk.triangles).unwrap();
        let domain = FieldDomain::of(&surface, &Watch::new()).unwrap();
        let before = poles(&surface, places);
        let options = CancelOptions {
            distance,
            smoothing: 0.8,
        };
        let guidance = Guidance::none(Symmetry::Cross, surface.mesh().vertex_count());
        let (after, report) = domain
            .cancel_close_pairs(&before, &guidance, &options, &Watch::new())
            .unwrap();
        let found = [&before, &after].map(|field| domain.singularities(field));
        assert_eq!(report.singularities_before, found[0].count());
        assert_eq!(report.singularities_after, found[1].count());
        let signs = |found: &Singularities| found.faces.iter().map(|s| s.steps).collect();
        (
            found.each_ref().map(signs),
            found.each_ref().map(Singularities::index_sum),
        )
    }

    #[test]
    fn a_close_pair_vanishes() {
        let pair = [
            (DVec2::new(0.06, 0.011), 1.0),
            (DVec2::new(-0.05, 0.013), -1.0),
        ];
        let (signs, sums) = cancelled(&pair, 0.15);
        assert_eq!(signs[0].len(), 2);
        assert!(signs[1].is_empty(), "{signs:?}");
        assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-9), "{sums:?}");
    }

    #[test]
    fn a_lone_pole_and_a_distant_pair_stay() {
        let pole = [(DVec2::new(0.01, 0.011), 1.0)];
        let pair = [
            (DVec2::new(0.31, 0.011), 1.0),
            (DVec2::new(-0.32, 0.013), -1.0),
        ];
        for places in [&pole[..], &pair] {
            let (signs, sums) = cancelled(places, 0.15);
            assert_eq!(signs[0], signs[1]);
            assert_eq!(signs[0].len(), places.len());
            assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-9), "{sums:?}");
        }
    }

    #[test]
    fn the_third_of_three_poles_stays() {
        let three = [
            (DVec2::new(0.06, 0.011), 1.0),
            (DVec2::new(-0.05, 0.013), -1.0),
            (DVec2::new(0.01, -0.09), 1.0),
        ];
        let (signs, _) = cancelled(&three, 0.15);
        assert_eq!(signs[1], [1]);
    }
}
