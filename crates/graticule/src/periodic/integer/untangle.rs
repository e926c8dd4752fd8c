//! Makes flipped triangles of a net positive again, its whole numbers kept.

use glam::{DMat2, DVec2};
use rayon::prelude::*;

use super::descent::{Descent, Objective};
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerFace, PerVertex, TriangleMesh, VertexId};
use crate::periodic::Transition;
use crate::tolerance::{FLAT_IN_NET, SQUEEZED_IN_NET};
use crate::watch::{Stopped, Watch};

/// A net whose turns, shifts and whole coordinates are settled.
#[derive(Clone, Debug)]
pub(super) struct SettledNet<'a> {
    pub(super) mesh: &'a TriangleMesh,
    /// How the coordinates of a vertex become those of each of its corners.
    pub(super) corners: PerCorner<Transition>,
    /// Which coordinates of each vertex may move.
    pub(super) is_free: PerVertex<[bool; 2]>,
    /// Vertices whose coordinates are whole for good.
    pub(super) is_singular: PerVertex<bool>,
    /// Number of vertices that were on lines and may move now.
    pub(super) released: usize,
    /// The sides that triangles should have in the net, along each halfedge.
    pub(super) wishes: PerCorner<DVec2>,
    /// The coordinates of each vertex.
    pub(super) places: PerVertex<DVec2>,
}

impl SettledNet<'_> {
    /// The coordinates of a corner.
    pub(super) fn coordinate(&self, corner: HalfedgeId) -> DVec2 {
        self.corners[corner].apply(self.places[self.mesh.origin(corner)])
    }

    /// The area of the image of a triangle, with sign.
    pub(super) fn map_area(&self, face: FaceId) -> f64 {
        let [a, b, c] = face.halfedges().map(|corner| self.coordinate(corner));
        0.5 * (b - a).perp_dot(c - a)
    }

    /// The area of the image of a triangle over that wished for, with sign.
    fn stretch(&self, face: FaceId) -> f64 {
        let [first, second, _] = face.halfedges().map(|side| self.wishes[side]);
        let wished = 0.5 * first.perp_dot(second);
        self.map_area(face) / wished.max(f64::MIN_POSITIVE)
    }

    /// The triangles that are flipped, or next to it.
    pub(super) fn flipped(&self) -> Vec<FaceId> {
        let faces = self.mesh.faces();
        faces.filter(|&face| self.is_flipped(face)).collect()
    }

    fn is_flipped(&self, face: FaceId) -> bool {
        // Not `<=`: what is not a number is not positive either.
        let is_positive = self.stretch(face) > FLAT_IN_NET;
        !is_positive
    }

    /// Rearranges the neighbourhoods of flipped triangles, larger ones in each round, as long as any
    /// is left.
    ///
    /// In a neighbourhood the vertices inside move so that the regularised distortion of
    /// V. Garanzha et al., *Foldover-free maps in 50 lines of code*, 2021, falls; what is whole and
    /// what lies on the rim stays. A neighbourhood that does not end with fewer flips is put back.
    ///
    /// Where triangles stay flipped, their vertices are let go of the lines that they lie on.
    ///
    /// Small neighbourhoods come first. Where the net as a whole cannot do without flips, as on
    /// parts thinner than a cell, effort ends at [`MOST_EFFORT`] visits of each triangle, and rounds
    /// that bring little are not followed by others of their kind.
    pub(super) fn untangle(&mut self, rounds: usize, watch: &Watch) -> Result<(), Stopped> {
        let mut effort = MOST_EFFORT * self.mesh.face_count();
        let first_release = rounds.div_ceil(2);
        let mut before = usize::MAX;
        for round in 0..rounds {
            let flipped = self.flipped();
            let is_in_vain =
                flipped.len() > FEW_FLIPS && flipped.len() > before - before / PROGRESS;
            if flipped.is_empty() || is_in_vain && round > first_release {
                break;
            }
            if is_in_vain && round < first_release {
                continue;
            }
            before = flipped.len();
            if round >= first_release {
                self.release(&flipped);
            }
            let mut patches = self.patches(&flipped, round + 2);
            patches.sort_by_key(Vec::len);
            self.rearrange(&patches, &mut effort, PatchProblem::untangled, watch)?;
        }
        Ok(())
    }

    /// Lets the vertices of the triangles go of their lines.
    fn release(&mut self, flipped: &[FaceId]) {
        for vertex in flipped.iter().flat_map(|&face| self.mesh.triangle(face)) {
            if !self.is_singular[vertex] && self.is_free[vertex] != [true; 2] {
                self.is_free[vertex] = [true; 2];
                self.released += 1;
            }
        }
    }

    /// Rearranges the neighbourhoods of triangles that are positive and much distorted, larger ones in
    /// each round, so that the distortion of the whole neighbourhood falls. What is whole stays.
    pub(super) fn relax_squeezed(&mut self, rounds: usize, watch: &Watch) -> Result<(), Stopped> {
        let mut effort = MOST_EFFORT * self.mesh.face_count();
        for round in 0..rounds {
            let faces = self.mesh.faces();
            let squeezed: Vec<FaceId> = faces.filter(|&face| self.is_squeezed(face)).collect();
            if squeezed.is_empty() {
                break;
            }
            let patches = self.patches(&squeezed, round + LEAST_RELAXED_RINGS);
            self.rearrange(&patches, &mut effort, PatchProblem::relaxed, watch)?;
        }
        Ok(())
    }

    fn is_squeezed(&self, face: FaceId) -> bool {
        let Some(triangle) = triangle(self, &[], face) else {
            return false;
        };
        let jacobian = triangle.jacobian(&[]);
        let (distortion, _) = density(jacobian, LEAST_EPSILON);
        jacobian.determinant() > 0.0 && distortion > SQUEEZED_IN_NET
    }

    /// Takes over what `arrange` makes of patches that share no vertex, some side by side, as far as
    /// `effort` lasts.
    fn rearrange(
        &mut self,
        patches: &[Vec<FaceId>],
        effort: &mut usize,
        arrange: fn(&PatchProblem, usize) -> Arranged,
        watch: &Watch,
    ) -> Result<(), Stopped> {
        for batch in patches.chunks(SIDE_BY_SIDE) {
            watch.check()?;
            let most = *effort;
            let net = &*self;
            let done: Vec<_> = (batch.par_iter())
                .map(|patch| {
                    let problem = PatchProblem::new(net, patch);
                    let arranged = arrange(&problem, most);
                    (problem.variables, arranged)
                })
                .collect();
            for (variables, arranged) in done {
                *effort = effort.saturating_sub(arranged.effort);
                if let Some(point) = arranged.point {
                    self.put(&variables, &point);
                }
            }
        }
        Ok(())
    }

    fn put(&mut self, variables: &[(VertexId, usize)], point: &[f64]) {
        for (&(vertex, coordinate), &value) in variables.iter().zip(point) {
            self.places[vertex][coordinate] = value;
        }
    }

    /// The triangles within some rings of the given ones, those that hang together in one patch.
    fn patches(&self, seeds: &[FaceId], rings: usize) -> Vec<Vec<FaceId>> {
        let mesh = self.mesh;
        let mut is_inside = PerFace::filled(mesh.face_count(), false);
        let mut all: Vec<FaceId> = seeds.to_vec();
        for &face in seeds {
            is_inside[face] = true;
        }
        let mut start = 0;
        for _ in 0..rings {
            let end = all.len();
            for place in start..end {
                for face in faces_around(mesh, all[place]) {
                    if !std::mem::replace(&mut is_inside[face], true) {
                        all.push(face);
                    }
                }
            }
            start = end;
        }
        let mut patches = Vec::new();
        for &seed in seeds {
            if !std::mem::replace(&mut is_inside[seed], false) {
                continue;
            }
            let mut patch = vec![seed];
            let mut next = 0;
            while next < patch.len() {
                for face in faces_around(mesh, patch[next]) {
                    if std::mem::replace(&mut is_inside[face], false) {
                        patch.push(face);
                    }
                }
                next += 1;
            }
            patch.sort_unstable();
            patches.push(patch);
        }
        patches
    }
}

/// Patches whose effort is counted together: any number of threads does the same.
const SIDE_BY_SIDE: usize = 16;

/// Rings of triangles round those squeezed that move in the first round.
const LEAST_RELAXED_RINGS: usize = 4;

/// Descents in one neighbourhood, each of which forgets what the last one learnt of the curvature.
const MOST_DESCENTS: usize = 4;

/// Relative decrease of the distortion in a descent above which another is worth while.
const WORTHWHILE_GAIN: f64 = 1e-2;

/// Visits of each triangle of the surface, in the mean, in the search for places without flips.
///
/// Surfaces on which all flips go take a few dozen.
const MOST_EFFORT: usize = 200;

/// So few flipped triangles are worth every round.
const FEW_FLIPS: usize = 200;

/// The one part of so many flipped triangles that has to go in a round for another one.
const PROGRESS: usize = 20;

/// Times that the regularisation is made weaker.
const MOST_REGULARISATIONS: usize = 25;

/// How much of the worst stretch the determinant is smoothed by.
const SMOOTHING: f64 = 0.2;

/// The least smoothing of the determinant, which is 1 where a triangle is as wished.
const LEAST_EPSILON: f64 = 1e-6;

/// Relative decrease of the distortion at which nothing moves any more.
const LEAST_GAIN: f64 = 1e-6;

/// Regularisations without fewer flips that are followed by others, and the relative decrease of the
/// distortion below which they are counted. Two of 1100 patches of a noisy scan that came out
/// without flips would have ended before, at half of the work for all.
const PATIENCE: usize = 2;
const LITTLE_GAIN: f64 = 1e-2;

fn faces_around(mesh: &TriangleMesh, face: FaceId) -> impl Iterator<Item = FaceId> + '_ {
    let vertices = mesh.triangle(face).into_iter();
    vertices.flat_map(|vertex| mesh.outgoing(vertex).map(HalfedgeId::face))
}

/// A corner of a triangle in a patch.
#[derive(Clone, Copy)]
struct PatchCorner {
    transition: Transition,
    /// Where the vertex is in its own coordinates, as far as it does not move.
    place: DVec2,
    /// The variables of its coordinates.
    variables: [Option<u32>; 2],
}

struct PatchTriangle {
    corners: [PatchCorner; 3],
    /// Takes the two sides from the first corner as wished to the unit vectors.
    inverse: DMat2,
    weight: f64,
}

/// What was found for a patch.
struct Arranged {
    /// Visits of triangles that it took.
    effort: usize,
    /// The variables, unless they are to stay.
    point: Option<Vec<f64>>,
}

/// A patch, with its variables in a row.
struct PatchProblem {
    variables: Vec<(VertexId, usize)>,
    start: Vec<f64>,
    triangles: Vec<PatchTriangle>,
}

impl PatchProblem {
    fn new(net: &SettledNet<'_>, patch: &[FaceId]) -> Self {
        let mesh = net.mesh;
        let mut corners: Vec<VertexId> = patch.iter().flat_map(|&f| mesh.triangle(f)).collect();
        corners.sort_unstable();
        let mut variables = Vec::new();
        for vertices in corners.chunk_by(|a, b| a == b) {
            let vertex = vertices[0];
            if vertices.len() == mesh.outgoing(vertex).count() {
                let free = (0..2).filter(|&coordinate| net.is_free[vertex][coordinate]);
                variables.extend(free.map(|coordinate| (vertex, coordinate)));
            }
        }
        let start = variables
            .iter()
            .map(|&(v, coordinate)| net.places[v][coordinate]);
        let start = start.collect();
        let triangles = patch
            .iter()
            .filter_map(|&face| triangle(net, &variables, face));
        let triangles = triangles.collect();
        Self {
            variables,
            start,
            triangles,
        }
    }

    fn start(&self) -> Vec<f64> {
        self.start.clone()
    }

    fn least_stretch(&self, point: &[f64]) -> f64 {
        let stretches = self
            .triangles
            .iter()
            .map(|t| t.jacobian(point).determinant());
        stretches.fold(f64::INFINITY, f64::min)
    }

    /// Moves the variables so that fewer triangles are flipped.
    fn untangled(&self, most_effort: usize) -> Arranged {
        let mut point = self.start();
        let before = self.flips_at(&point);
        let mut fewest = before;
        let mut in_vain = 0;
        let mut effort = 0;
        let cost = Descent::default().steps() * self.triangles.len();
        for _ in 0..MOST_REGULARISATIONS {
            if effort + cost > most_effort {
                break;
            }
            effort += cost;
            let least = self.least_stretch(&point);
            let smoothing = SMOOTHING * least.min(0.0);
            let regularised = Regularised {
                problem: self,
                epsilon: (LEAST_EPSILON * LEAST_EPSILON + smoothing * smoothing).sqrt(),
            };
            let gain = Descent::default().run(&regularised, &mut point);
            if (least > FLAT_IN_NET && self.least_stretch(&point) > FLAT_IN_NET)
                || gain < LEAST_GAIN
            {
                break;
            }
            let flips = self.flips_at(&point);
            in_vain = if flips < fewest { 0 } else { in_vain + 1 };
            fewest = fewest.min(flips);
            if in_vain > PATIENCE && gain < LITTLE_GAIN {
                break;
            }
        }
        let point = (self.flips_at(&point) < before).then_some(point);
        Arranged { effort, point }
    }

    /// Moves the variables so that the distortion falls, where no triangle is flipped.
    fn relaxed(&self, most_effort: usize) -> Arranged {
        let mut point = self.start();
        let mut effort = 0;
        if self.flips_at(&point) > 0 {
            let point = None;
            return Arranged { effort, point };
        }
        let cost = Descent::default().steps() * self.triangles.len();
        let energy = Regularised {
            problem: self,
            epsilon: LEAST_EPSILON,
        };
        for _ in 0..MOST_DESCENTS {
            if effort + cost > most_effort {
                break;
            }
            effort += cost;
            if Descent::default().run(&energy, &mut point) < WORTHWHILE_GAIN {
                break;
            }
        }
        let point = (self.flips_at(&point) == 0).then_some(point);
        Arranged { effort, point }
    }

    fn flips_at(&self, point: &[f64]) -> usize {
        let stretches = self
            .triangles
            .iter()
            .map(|t| t.jacobian(point).determinant());
        stretches
            .filter(|&stretch| stretch <= FLAT_IN_NET || stretch.is_nan())
            .count()
    }
}

/// `None` for a triangle that is wished to have no area.
fn triangle(
    net: &SettledNet<'_>,
    variables: &[(VertexId, usize)],
    face: FaceId,
) -> Option<PatchTriangle> {
    let [first, _, last] = face.halfedges().map(|side| net.wishes[side]);
    let wished = DMat2::from_cols(first, -last);
    let weight = wished.determinant();
    let inverse = wished.inverse();
    let corner = |corner: HalfedgeId| {
        let vertex = net.mesh.origin(corner);
        PatchCorner {
            transition: net.corners[corner],
            place: net.places[vertex],
            variables: [0, 1].map(|coordinate| {
                let found = variables.binary_search(&(vertex, coordinate)).ok();
                found.map(|place| place as u32)
            }),
        }
    };
    inverse.is_finite().then(|| PatchTriangle {
        corners: face.halfedges().map(corner),
        inverse,
        weight,
    })
}

impl PatchTriangle {
    fn jacobian(&self, point: &[f64]) -> DMat2 {
        let [a, b, c] = self.corners.map(|corner| corner.at(point));
        DMat2::from_cols(b - a, c - a) * self.inverse
    }
}

impl PatchCorner {
    fn at(&self, point: &[f64]) -> DVec2 {
        let [x, y] = [0, 1].map(|coordinate| {
            let variable = self.variables[coordinate];
            variable.map_or(self.place[coordinate], |variable| point[variable as usize])
        });
        self.transition.apply(DVec2::new(x, y))
    }

    fn pull_back(&self, gradient: DVec2, into: &mut [f64]) {
        let own = self.transition.turn.inverse().apply(gradient);
        for coordinate in 0..2 {
            if let Some(variable) = self.variables[coordinate] {
                into[variable as usize] += own[coordinate];
            }
        }
    }
}

/// `Σ area (|J|² + det² + 1) / χ(det)` with `χ(D) = (D + √(ε² + D²)) / 2`, which is finite for
/// flipped triangles too and the larger the more they are flipped.
struct Regularised<'a> {
    problem: &'a PatchProblem,
    epsilon: f64,
}

impl Objective for Regularised<'_> {
    fn value(&self, point: &[f64], gradient: &mut [f64]) -> f64 {
        gradient.fill(0.0);
        let mut total = 0.0;
        for triangle in &self.problem.triangles {
            let jacobian = triangle.jacobian(point);
            let (value, slope) = density(jacobian, self.epsilon);
            total += triangle.weight * value;
            // The derivative by the two sides from the first corner.
            let sides = slope * triangle.inverse.transpose() * triangle.weight;
            let [a, b, c] = &triangle.corners;
            a.pull_back(-sides.x_axis - sides.y_axis, gradient);
            b.pull_back(sides.x_axis, gradient);
            c.pull_back(sides.y_axis, gradient);
        }
        total
    }
}

/// The distortion of a Jacobian, its determinant smoothed by `epsilon`, and its derivative.
fn density(jacobian: DMat2, epsilon: f64) -> (f64, DMat2) {
    let determinant = jacobian.determinant();
    let root = (epsilon * epsilon + determinant * determinant).sqrt();
    // The sum cancels where the determinant is negative.
    let smoothed = if determinant >= 0.0 {
        f64::midpoint(determinant, root)
    } else {
        0.5 * epsilon * epsilon / (root - determinant)
    };
    let smoothed_slope = smoothed / root;
    let [x, y] = [jacobian.x_axis, jacobian.y_axis];
    let above = x.length_squared() + y.length_squared() + determinant * determinant + 1.0;
    let cofactors = DMat2::from_cols(DVec2::new(y.y, -y.x), DVec2::new(-x.y, x.x));
    let by_determinant =
        2.0 * determinant / smoothed - above / smoothed * (smoothed_slope / smoothed);
    let slope = jacobian * (2.0 / smoothed) + cofactors * by_determinant;
    (above / smoothed, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Element, Surface};
    use graticule_fixtures::{Noise, disk};

    /// A flat disk whose net is the plane itself, with some vertices far from their places.
    fn tangled<'a>(mesh: &'a TriangleMesh, surface: &Surface, moved: &[u32]) -> SettledNet<'a> {
        let flat = |vertex: VertexId| surface.position(vertex).truncate() * 8.0;
        let mut net = SettledNet {
            mesh,
            corners: PerCorner::filled(mesh.halfedge_count(), Transition::identity()),
            is_free: PerVertex::from_fn(mesh.vertex_count(), |v| [!mesh.is_boundary_vertex(v); 2]),
            is_singular: PerVertex::filled(mesh.vertex_count(), true),
            released: 0,
            wishes: PerCorner::from_fn(mesh.halfedge_count(), |h| {
                flat(mesh.destination(h)) - flat(mesh.origin(h))
            }),
            places: PerVertex::from_fn(mesh.vertex_count(), flat),
        };
        for &vertex in moved {
            net.places[VertexId(vertex)] += DVec2::new(2.5, -1.5);
        }
        net
    }

    #[test]
    fn flipped_triangles_become_positive_and_what_is_fixed_stays() {
        let disk = disk(8);
        let surface = Surface::from_triangles(disk.positions, &disk.triangles).unwrap();
        let mesh = surface.mesh();
        let mut net = tangled(mesh, &surface, &[0, 5, 40, 60]);
        net.is_free[VertexId(0)] = [false; 2];
        net.places[VertexId(0)] = DVec2::new(0.3, 0.2);
        let before = net.places.clone();
        assert!(net.flipped().len() > 5);
        net.untangle(6, &Watch::new()).unwrap();
        assert_eq!(net.flipped(), []);
        for vertex in mesh.vertices().filter(|&v| !net.is_free[v][0]) {
            assert_eq!(net.places[vertex], before[vertex]);
        }
    }

    #[test]
    fn squeezed_triangles_are_given_room_and_none_is_flipped() {
        let disk = disk(8);
        let surface = Surface::from_triangles(disk.positions, &disk.triangles).unwrap();
        let mesh = surface.mesh();
        let mut net = tangled(mesh, &surface, &[]);
        net.is_free[VertexId(0)] = [false; 2];
        let beside = mesh.outgoing(VertexId(0)).next().unwrap();
        let neighbor = mesh.destination(beside);
        net.places[VertexId(0)] = net.places[VertexId(0)].lerp(net.places[neighbor], 0.995);
        let squeezed = |net: &SettledNet<'_>| mesh.faces().filter(|&f| net.is_squeezed(f)).count();
        assert!(net.flipped().is_empty() && squeezed(&net) > 0);
        net.relax_squeezed(3, &Watch::new()).unwrap();
        assert_eq!((net.flipped(), squeezed(&net)), (vec![], 0));
    }

    #[test]
    fn the_derivative_of_the_distortion_is_that_of_differences() {
        let disk = disk(3);
        let surface = Surface::from_triangles(disk.positions, &disk.triangles).unwrap();
        let net = tangled(surface.mesh(), &surface, &[0, 3]);
        let patch: Vec<FaceId> = surface.mesh().faces().collect();
        let problem = PatchProblem::new(&net, &patch);
        let regularised = Regularised {
            problem: &problem,
            epsilon: 0.3,
        };
        let mut noise = Noise::new(2);
        let point: Vec<f64> = problem
            .start()
            .iter()
            .map(|x| x + 0.1 * noise.signed())
            .collect();
        let mut gradient = vec![0.0; point.len()];
        let mut unused = gradient.clone();
        regularised.value(&point, &mut gradient);
        for place in 0..point.len() {
            let step = 1e-6;
            let mut at = |offset: f64| {
                let mut moved = point.clone();
                moved[place] += offset;
                regularised.value(&moved, &mut unused)
            };
            let difference = (at(step) - at(-step)) / (2.0 * step);
            let scale = difference.abs().max(1.0);
            assert!((difference - gradient[place]).abs() < 1e-5 * scale);
        }
    }

    #[test]
    fn patches_hold_their_rings_and_do_not_meet() {
        let disk = disk(8);
        let surface = Surface::from_triangles(disk.positions, &disk.triangles).unwrap();
        let net = tangled(surface.mesh(), &surface, &[]);
        let last = FaceId::from_index(surface.mesh().face_count() - 1);
        let patches = net.patches(&[FaceId(0), last], 1);
        assert_eq!(patches.len(), 2);
        assert!(patches[0].iter().all(|face| !patches[1].contains(face)));
        assert_eq!(net.patches(&[FaceId(0), last], 9).len(), 1);
    }
}
