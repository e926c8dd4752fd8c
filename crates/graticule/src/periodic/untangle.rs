use glam::{DMat2, DVec2};

use crate::geometry::IntrinsicTriangulation;
use crate::measure::SourceTriangle;
use crate::mesh::{FaceId, HalfedgeId, PerFace, PerVertex, TriangleMesh, VertexId};
use crate::tolerance::NEARLY_INVERTED;
use crate::watch::{Stopped, Watch};

use super::unroll::{FaceKind, VertexFrames};

/// Passes over the neighbourhoods at most.
const PASSES: usize = 200;

/// Passes that also work on triangles that are only nearly inverted.
const SMOOTHING_PASSES: usize = 40;

/// Rings of vertices round an inverted triangle that give way.
const RINGS: usize = 3;

/// Vertices rest when none moves by more than this share of the lowest height in its triangles,
/// or of a period.
const AT_REST: f64 = 5e-3;

/// Passes after which the vertices that take part are chosen anew.
const REFRESH: usize = 5;

/// What the coordinates stand on while vertices move.
pub(super) struct Untangling<'a> {
    pub(super) mesh: &'a TriangleMesh,
    pub(super) triangulation: &'a IntrinsicTriangulation,
    /// Periods per unit length wanted at each vertex.
    pub(super) density: &'a PerVertex<f64>,
    pub(super) whole: &'a PerVertex<[bool; 2]>,
    pub(super) kinds: &'a PerFace<FaceKind>,
}

/// A triangle at the size that it should have, in periods.
#[derive(Clone, Copy)]
struct Wanted {
    /// The gradients of the corners' hat functions.
    gradients: [DVec2; 3],
    area: f64,
}

impl Untangling<'_> {
    /// Turns over those of the candidates that are inverted or nearly so, by moving the vertices about
    /// them one after the other with all integers kept: each goes to the minimum of a distortion of its
    /// triangles whose barrier against inversion is finite
    /// (V. Garanzha et al., *Foldover-free maps in 50 lines of code*, 2021).
    ///
    /// Triangles that do not close have no say. A vertex is passed over until one beside it moves.
    /// The search ends when `visits` of triangles are used up.
    pub(super) fn run(
        &self,
        mut candidates: Vec<FaceId>,
        frames: &mut VertexFrames,
        visits: &mut usize,
        watch: &Watch,
    ) -> Result<(), Stopped> {
        let _stage = watch.stage("untangling");
        let faces = PerFace::from_fn(self.mesh.face_count(), |face| self.wanted(face));
        let mut is_awake = PerVertex::filled(self.mesh.vertex_count(), true);
        let mut moving = Vec::new();
        let mut pass = 0;
        while pass < PASSES {
            watch.check()?;
            watch.progress(pass as f64 / PASSES as f64);
            if pass.is_multiple_of(REFRESH) {
                moving = self.about_bad_faces(&faces, &candidates, least_area(pass), frames);
                candidates = self.faces_about(&moving);
                if pass >= SOFT_PASSES {
                    // The barrier is another one.
                    for &vertex in &moving {
                        is_awake[vertex] = true;
                    }
                }
            }
            if moving.is_empty() || *visits == 0 {
                break;
            }
            let awake = moving.iter().filter(|&&vertex| is_awake[vertex]);
            let triangles: usize = awake
                .map(|&vertex| self.mesh.outgoing(vertex).count())
                .sum();
            *visits = visits.saturating_sub(triangles);
            let rests = self.pass(&moving, softness(pass), &faces, &mut is_awake, frames);
            moving.reverse();
            pass = match (rests, pass < SOFT_PASSES) {
                (false, _) => pass + 1,
                (true, true) => SOFT_PASSES,
                (true, false) => (pass / REFRESH + 1) * REFRESH,
            };
        }
        Ok(())
    }

    /// Relaxes the vertices that are awake, in this order; whether all rest.
    fn pass(
        &self,
        moving: &[VertexId],
        softness: f64,
        faces: &PerFace<Option<Wanted>>,
        is_awake: &mut PerVertex<bool>,
        frames: &mut VertexFrames,
    ) -> bool {
        let mut rests = true;
        for &vertex in moving {
            if !std::mem::replace(&mut is_awake[vertex], false) {
                continue;
            }
            if self.relax(vertex, faces, softness, frames) >= AT_REST {
                rests = false;
                is_awake[vertex] = true;
                let neighbors = self.mesh.neighbors(vertex);
                neighbors.for_each(|neighbor| is_awake[neighbor] = true);
            }
        }
        rests
    }

    /// The triangle at the size wanted; `None` where it has no say.
    fn wanted(&self, face: FaceId) -> Option<Wanted> {
        if !self.kinds[face].closes() {
            return None;
        }
        let source = SourceTriangle::from_lengths(self.triangulation.shape(face).lengths())?;
        let vertices = self.mesh.triangle(face);
        let density = vertices.iter().map(|&v| self.density[v]).sum::<f64>() / 3.0;
        let gradients = source.corner_gradients().map(|gradient| gradient / density);
        let area = source.area() * density * density;
        Some(Wanted { gradients, area })
    }

    /// The triangles of these vertices, in order.
    fn faces_about(&self, vertices: &[VertexId]) -> Vec<FaceId> {
        let corners = vertices
            .iter()
            .flat_map(|&vertex| self.mesh.outgoing(vertex));
        let mut faces: Vec<FaceId> = corners.map(HalfedgeId::face).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    /// The vertices about those triangles whose area is not above `least` of the one wanted.
    fn about_bad_faces(
        &self,
        faces: &PerFace<Option<Wanted>>,
        candidates: &[FaceId],
        least: f64,
        frames: &VertexFrames,
    ) -> Vec<VertexId> {
        let is_bad = |face: &FaceId| {
            faces[*face].is_some_and(|Wanted { gradients, .. }| {
                let corners = frames.corners(self.mesh, *face);
                let rows = (0..3).fold([DVec2::ZERO; 2], |[u, v], k| {
                    [
                        u + gradients[k] * corners[k].x,
                        v + gradients[k] * corners[k].y,
                    ]
                });
                // Not `<=`: what is not a number is bad.
                let is_good = rows[0].perp_dot(rows[1]) > least;
                !is_good
            })
        };
        let bad = candidates.iter().copied().filter(is_bad);
        let mut found: Vec<VertexId> = bad.flat_map(|face| self.mesh.triangle(face)).collect();
        for _ in 1..RINGS {
            let around = found.iter().flat_map(|&vertex| self.mesh.neighbors(vertex));
            let wider: Vec<VertexId> = around.chain(found.iter().copied()).collect();
            found = wider;
            found.sort_unstable();
            found.dedup();
        }
        found
    }

    /// Moves a vertex by a step of Newton's method; how far, over the lowest height of its triangles
    /// or a period.
    fn relax(
        &self,
        vertex: VertexId,
        faces: &PerFace<Option<Wanted>>,
        least: f64,
        frames: &mut VertexFrames,
    ) -> f64 {
        let corners = self.mesh.outgoing(vertex);
        let star: Vec<Corner> = corners
            .filter_map(|corner| self.corner(corner, faces, frames))
            .collect();
        let place = frames.coordinates[vertex];
        let worst = star
            .iter()
            .map(|corner| corner.determinant(place))
            .fold(1.0, f64::min);
        let softness = (least * least + 0.04 * worst.min(0.0).powi(2)).sqrt();
        let at = |place| {
            star.iter()
                .map(|c| c.energy(place, softness))
                .sum::<Taylor>()
        };
        let value = |place| star.iter().map(|c| c.value(place, softness)).sum::<f64>();
        let before = at(place);
        let mut step = before.newton_step(self.whole[vertex]);
        let steepest = star.iter().map(|c| c.gradient.length()).fold(1.0, f64::max);
        let rest = AT_REST / steepest;
        while step.length() > rest {
            if value(place + step) < before.value {
                frames.coordinates[vertex] = place + step;
                return step.length() * steepest;
            }
            step *= 0.5;
        }
        0.0
    }

    fn corner(
        &self,
        corner: HalfedgeId,
        faces: &PerFace<Option<Wanted>>,
        frames: &VertexFrames,
    ) -> Option<Corner> {
        let Wanted { gradients, area } = faces[corner.face()]?;
        let [own, next, last] = [0, 1, 2].map(|k| gradients[(corner.side() + k) % 3]);
        let place = |halfedge: HalfedgeId| frames.coordinates[self.mesh.origin(halfedge)];
        let to_next = frames.jump(self.mesh, corner);
        let to_last = frames.jump(self.mesh, corner.previous()).inverse();
        let p = to_next.apply(place(corner.next()));
        let q = to_last.apply(place(corner.previous()));
        Some(Corner {
            gradient: own,
            rest: [next * p.x + last * q.x, next * p.y + last * q.y],
            area,
        })
    }
}

/// Area over that wanted up to which triangles take part in a pass.
fn least_area(pass: usize) -> f64 {
    if pass < SMOOTHING_PASSES {
        NEARLY_INVERTED
    } else {
        0.0
    }
}

/// Least softness of the barrier in a pass: it lets determinants be this small without pushing back
/// harder. The last passes sharpen it, for triangles that a soft one leaves barely inverted.
fn softness(pass: usize) -> f64 {
    let sharpenings = pass.saturating_sub(SOFT_PASSES) / REFRESH;
    SOFTEST * libm::pow(0.75, sharpenings as f64)
}

/// Softness of the barrier for as long as it need not be sharper.
const SOFTEST: f64 = 0.02;

/// Passes with the softest barrier.
const SOFT_PASSES: usize = 100;

/// A triangle by one corner: the Jacobian's rows are linear in the place of that corner.
struct Corner {
    gradient: DVec2,
    rest: [DVec2; 2],
    area: f64,
}

impl Corner {
    fn rows(&self, place: DVec2) -> [DVec2; 2] {
        let [u, v] = self.rest;
        [u + self.gradient * place.x, v + self.gradient * place.y]
    }

    fn determinant(&self, place: DVec2) -> f64 {
        let [u, v] = self.rows(place);
        u.perp_dot(v)
    }

    /// The energy alone.
    fn value(&self, place: DVec2, softness: f64) -> f64 {
        let [u, v] = self.rows(place);
        let determinant = u.perp_dot(v);
        let size = u.length_squared() + v.length_squared() + 1.0 + determinant * determinant;
        0.5 * self.area / barrier(determinant, softness).0 * size
    }

    /// `A (|J|² + 1 + D²) / 2χ(D)` with `χ = (D + √(D² + ε²)) / 2`, least for an isometry.
    fn energy(&self, place: DVec2, softness: f64) -> Taylor {
        let [u, v] = self.rows(place);
        let determinant = u.perp_dot(v);
        let growth = DVec2::new(self.gradient.perp_dot(v), u.perp_dot(self.gradient));
        let square = self.gradient.length_squared();
        let size = u.length_squared() + v.length_squared() + 1.0 + determinant * determinant;
        let slope = 2.0 * DVec2::new(u.dot(self.gradient), v.dot(self.gradient))
            + growth * (2.0 * determinant);
        let bend = DMat2::from_diagonal(DVec2::splat(2.0 * square)) + outer(growth, growth) * 2.0;
        let (barrier, root) = barrier(determinant, softness);
        let rise = barrier / root;
        let curve = 0.5 * softness * softness / (root * root * root);
        let share = 0.5 * self.area / barrier;
        let ratio = rise / barrier;
        let mixed = outer(slope, growth) + outer(growth, slope);
        let along = size * (2.0 * ratio * ratio - curve / barrier);
        Taylor {
            value: share * size,
            slope: (slope - growth * (size * ratio)) * share,
            bend: (bend - mixed * ratio + outer(growth, growth) * along) * share,
        }
    }
}

/// `χ` and the root in it, without cancellation. A determinant whose square overflows gives no value
/// to compare, and so no step.
fn barrier(determinant: f64, softness: f64) -> (f64, f64) {
    let square = softness * softness;
    let root = (determinant * determinant + square).sqrt();
    let barrier = if determinant > 0.0 {
        0.5 * (determinant + root)
    } else {
        0.5 * square / (root - determinant)
    };
    (barrier, root)
}

fn outer(a: DVec2, b: DVec2) -> DMat2 {
    DMat2::from_cols(a * b.x, a * b.y)
}

/// A function of a place to second order.
#[derive(Clone, Copy, Default)]
struct Taylor {
    value: f64,
    slope: DVec2,
    bend: DMat2,
}

impl std::iter::Sum for Taylor {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::default(), |a, b| Self {
            value: a.value + b.value,
            slope: a.slope + b.slope,
            bend: a.bend + b.bend,
        })
    }
}

impl Taylor {
    /// The step to the minimum of the quadratic, its curvature made positive, without the
    /// coordinates that are fixed.
    fn newton_step(&self, fixed: [bool; 2]) -> DVec2 {
        let [[xx, xy], [_, yy]] = self.bend.to_cols_array_2d();
        match fixed {
            [true, true] => DVec2::ZERO,
            [true, false] => DVec2::new(0.0, -self.slope.y / yy.abs()),
            [false, true] => DVec2::new(-self.slope.x / xx.abs(), 0.0),
            [false, false] => {
                let mean = f64::midpoint(xx, yy);
                let spread = (0.5 * (xx - yy)).hypot(xy);
                // Lift the smaller eigenvalue above a share of the larger one.
                let lift = (1e-3 * (mean.abs() + spread) - (mean - spread)).max(0.0);
                let [xx, yy] = [xx + lift, yy + lift];
                let determinant = xx * yy - xy * xy;
                let step = DVec2::new(
                    xy * self.slope.y - yy * self.slope.x,
                    xy * self.slope.x - xx * self.slope.y,
                );
                let step = step / determinant;
                if step.is_finite() { step } else { DVec2::ZERO }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    #[test]
    fn derivatives_agree_with_differences() {
        let mut noise = Noise::new(3);
        let mut vector = || DVec2::new(noise.signed(), noise.signed());
        for _ in 0..40 {
            let corner = Corner {
                gradient: vector(),
                rest: [vector(), vector()],
                area: 1.3,
            };
            let (place, softness, step) = (vector(), 0.3, 1e-5);
            let at = corner.energy(place, softness);
            for axis in [DVec2::X, DVec2::Y] {
                let [after, before] =
                    [1.0, -1.0].map(|sign| corner.energy(place + axis * (sign * step), softness));
                let slope = (after.value - before.value) / (2.0 * step);
                let scale = at.value + at.slope.length();
                assert!((slope - at.slope.dot(axis)).abs() < 1e-5 * scale.max(1.0));
                let bend = (after.slope - before.slope) / (2.0 * step);
                let size = at.bend.x_axis.length() + at.bend.y_axis.length();
                assert!(bend.distance(at.bend * axis) < 1e-4 * size.max(1.0));
            }
        }
    }

    #[test]
    fn an_isometry_has_the_least_energy() {
        let corner = Corner {
            gradient: DVec2::new(-1.0, -1.0),
            rest: [DVec2::X, DVec2::Y],
            area: 0.5,
        };
        let at = corner.energy(DVec2::ZERO, SOFTEST);
        assert!(
            (at.value - 1.0).abs() < 1e-3 && at.slope.length() < 1e-3,
            "{}",
            at.value
        );
    }
}
