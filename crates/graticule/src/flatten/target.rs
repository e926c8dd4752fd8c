//! Conformal maps with told boundary lengths or turning angles, and with cones.
//!
//! A conformal change of the metric by `e^u` takes the curvature K of a surface and the turning k
//! of its boundary to others that follow from u by Laplace problems (H. Yamabe 1960 for the
//! curvature, P. Cherrier, *Problèmes de Neumann non linéaires sur les variétés riemanniennes*,
//! 1984, for the boundary): with L the positive semidefinite cotangent Laplacian,
//! `(L u)ᵢ = Θᵢ − Kᵢ` inside, Θ being the curvature that is to be left, and `k̃ᵢ = kᵢ + (L u)ᵢ` on
//! the boundary. Given u on the boundary, a Dirichlet problem tells the angles; given the angles, a
//! Neumann problem tells u. Lengths and angles make a curve, closed by the least change of its
//! lengths, and the interior is filled in by harmonic functions. That these linear problems make a
//! flattener is due to R. Sawhney and K. Crane, *Boundary First Flattening*, 2017; the code is our
//! own.

use std::f64::consts::{PI, TAU};

use faer::c64;
use glam::DVec2;

use crate::geometry::EdgeWeights;
use crate::mesh::{EdgeId, Element, PerVertex, VertexId};
use crate::solve::{DirichletSystem, Placement, SymmetricMatrix};
use crate::tolerance::{ANGLE_SUM, LEAST_CLOSING_SHARE, ROUNDING};
use crate::watch::Watch;

use super::conformal::Triangulation;
use super::domain::Domain;
use super::energy::complex;
use super::equations::index_pairs;
use super::flat_map::MapDraft;
use super::seam::cut_to;
use super::{FlatMap, FlattenError, FlipCount, Method, Patch};

/// Rounds in which lengths that would become too short are held.
const CLOSING_ROUNDS: usize = 20;

/// What is told of the outer boundary.
#[derive(Clone, Debug, PartialEq)]
pub enum BoundaryTarget {
    /// Factors by which lengths at these boundary vertices are multiplied, above 0; at the others
    /// 1. With none told the boundary keeps its lengths, which is the default.
    Scales(Vec<(VertexId, f64)>),
    /// By how much the boundary turns left at these vertices, in radians: 90° at each of four
    /// makes a rectangle. The others share what is left of a full turn by their lengths. Scales
    /// come out as they must.
    Angles(Vec<(VertexId, f64)>),
}

impl Default for BoundaryTarget {
    fn default() -> Self {
        Self::Scales(Vec::new())
    }
}

/// How the interior follows the boundary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extension {
    /// Both coordinates are harmonic with the boundary's values: the boundary is exact.
    #[default]
    Harmonic,
    /// One coordinate is, the other is its conjugate (Hilbert transform): angles are kept better,
    /// the boundary is met less exactly.
    Conjugate,
}

/// How a map with told boundary is made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetOptions {
    /// What is told of the outer boundary.
    pub target: BoundaryTarget,
    /// Interior vertices that keep a cone, with the angle around each in the map, in radians: the
    /// patch is cut open along a short way to them.
    pub cones: Vec<(VertexId, f64)>,
    /// Edges along which the cut to the cones may not run, such as diagonals of polygons.
    pub uncut: Vec<EdgeId>,
    /// How the interior follows.
    pub extension: Extension,
    /// The triangles that weights are taken from.
    pub triangulation: Triangulation,
}

/// A conformal map with told boundary.
#[derive(Clone, Debug)]
pub struct TargetMap {
    /// The patch that the map is of: cut open where there are cones. Triangles and their corners
    /// have the numbers that they had.
    pub patch: Patch,
    /// The vertex of the patch given behind each vertex of this one.
    pub vertex_sources: PerVertex<VertexId>,
    /// The map, with the area of the patch.
    pub map: FlatMap,
    /// The largest share by which a boundary length was changed to close the curve.
    pub closing_change: f64,
}

/// The conformal map whose outer boundary has told scales or turning angles.
///
/// Holes are closed by cones while the map is made. The map is scaled to the area of the patch.
/// Flips and overlaps are not excluded: the boundary may cross itself. Where the extension asked
/// for flips triangles and the other flips fewer, the other is taken and a warning
/// (`other-extension`) says so; another (`boundary-held`) tells of boundary lengths that closing
/// the curve would have made too short.
///
/// Cost: one or two factorisations of the Laplacian, with cones three.
///
/// # Errors
/// [`FlattenError::BadTarget`] names a vertex that cannot be told a number, or not this one,
/// [`FlattenError::AngleSum`]; otherwise as of [`natural_map`](super::natural_map).
pub fn target_map(
    patch: &Patch,
    options: &TargetOptions,
    watch: &Watch,
) -> Result<TargetMap, FlattenError> {
    let _stage = watch.stage("conformal map with told boundary");
    let metric = Metric::new(patch, options.triangulation, watch)?;
    let left = metric.cone_curvatures(patch, &options.cones)?;
    let scaled = match &options.target {
        BoundaryTarget::Scales(scales) => {
            let scales = metric.told_scales(scales)?;
            metric.with_scales(&scales, &left)?
        }
        BoundaryTarget::Angles(angles) => {
            let angles = metric.told_angles(angles, &left)?;
            metric.with_angles(&angles, &left)?
        }
    };
    watch.check()?;
    if options.cones.is_empty() {
        let identity = |vertex: VertexId| vertex;
        let vertices = patch.mesh().vertex_count();
        let sources = PerVertex::from_fn(vertices, identity);
        return metric.lay(patch.clone(), sources, &scaled, options.extension, watch);
    }
    let tips: Vec<VertexId> = options.cones.iter().map(|cone| cone.0).collect();
    let (cut, sources) = cut_to(patch, &tips, &options.uncut, watch)?;
    let metric = Metric::new(&cut, options.triangulation, watch)?;
    let on_loop = metric.outline.iter();
    let scales: Vec<f64> = on_loop
        .map(|&vertex| scaled.log_scales[sources.as_slice()[vertex].index()])
        .collect();
    let nothing_left = vec![0.0; metric.curvatures.len()];
    let scaled = metric.with_scales(&scales, &nothing_left)?;
    metric.lay(cut, sources, &scaled, options.extension, watch)
}

/// Lengths and curvatures of a patch with its holes closed, and the Laplacian.
struct Metric {
    domain: Domain,
    weights: EdgeWeights,
    matrix: SymmetricMatrix,
    /// The vertices along the outer loop, and the length of the edge from each to the next.
    outline: Vec<usize>,
    steps: Vec<f64>,
    /// 2π less the angles around each vertex inside, π less those at each vertex of the boundary.
    curvatures: Vec<f64>,
    /// With the outline fixed.
    dirichlet: DirichletSystem,
}

/// A change of the metric.
struct Scaled {
    /// The logarithm of the factor of lengths at each vertex.
    log_scales: Vec<f64>,
    /// Turning angles along the outline.
    angles: Vec<f64>,
}

impl Metric {
    fn new(
        patch: &Patch,
        triangulation: Triangulation,
        watch: &Watch,
    ) -> Result<Self, FlattenError> {
        let stage = watch.stage("assemble");
        let holes: Vec<_> = patch.holes().collect();
        let mut domain = Domain::with_cones(patch, &holes)?;
        match triangulation {
            Triangulation::Given => domain.mollify(watch),
            Triangulation::IntrinsicDelaunay => domain.make_delaunay(watch)?,
        }
        let weights = domain.cotangent_weights()?;
        let matrix = SymmetricMatrix::laplacian(weights.vertex_count(), index_pairs(&weights))?;
        let outer = patch.loop_vertices(patch.outer_loop());
        let outline: Vec<usize> = outer.map(Element::index).collect();
        let mut full = vec![TAU; weights.vertex_count()];
        for &vertex in &outline {
            full[vertex] = PI;
        }
        let sums = domain.triangulation();
        let sums = sums.angle_sums().iter();
        let curvatures = full.iter().zip(sums).map(|(full, sum)| full - sum);
        drop(stage);
        watch.check()?;
        let _stage = watch.stage("order and factor");
        let placement = Placement::at(&domain.coordinates);
        Ok(Self {
            dirichlet: DirichletSystem::new(&matrix, &outline, placement)?,
            curvatures: curvatures.collect(),
            steps: patch.unit_steps(patch.outer_loop()).collect(),
            outline,
            weights,
            matrix,
            domain,
        })
    }

    /// The curvature that is to be left at each vertex.
    fn cone_curvatures(
        &self,
        patch: &Patch,
        cones: &[(VertexId, f64)],
    ) -> Result<Vec<f64>, FlattenError> {
        let mut left = vec![0.0; self.curvatures.len()];
        let mut told = vec![false; left.len()];
        for &(vertex, angle) in cones {
            let bad = |reason| FlattenError::BadTarget { vertex, reason };
            if vertex.index() >= patch.mesh().vertex_count() {
                return Err(bad("is no vertex of the patch"));
            }
            if patch.mesh().is_boundary_vertex(vertex) {
                return Err(bad("lies on the boundary and cannot be a cone"));
            }
            if !(angle.is_finite() && angle > 0.0) {
                return Err(bad("was told a cone angle that is not above 0"));
            }
            if std::mem::replace(&mut told[vertex.index()], true) {
                return Err(bad("is a cone twice"));
            }
            left[vertex.index()] = TAU - angle;
        }
        Ok(left)
    }

    /// Numbers told for vertices of the outline, in its order.
    fn told(&self, numbers: &[(VertexId, f64)]) -> Result<Vec<Option<f64>>, FlattenError> {
        let mut place_of = vec![None; self.curvatures.len()];
        for (place, &vertex) in self.outline.iter().enumerate() {
            place_of[vertex] = Some(place);
        }
        let mut told = vec![None; self.outline.len()];
        for &(vertex, number) in numbers {
            let bad = |reason| FlattenError::BadTarget { vertex, reason };
            let place = place_of.get(vertex.index()).copied().flatten();
            let place = place.ok_or(bad("is not on the outer boundary loop"))?;
            if !number.is_finite() {
                return Err(bad("was told a number that is not finite"));
            }
            if told[place].replace(number).is_some() {
                return Err(bad("was told two numbers"));
            }
        }
        Ok(told)
    }

    /// Logarithms of the scales along the outline.
    fn told_scales(&self, scales: &[(VertexId, f64)]) -> Result<Vec<f64>, FlattenError> {
        if let Some(&(vertex, _)) = scales.iter().find(|(_, scale)| *scale <= 0.0) {
            let reason = "was told a scale that is not above 0";
            return Err(FlattenError::BadTarget { vertex, reason });
        }
        let told = self.told(scales)?.into_iter();
        Ok(told.map(|scale| scale.map_or(0.0, libm::log)).collect())
    }

    /// Turning angles along the outline, those not told sharing what is left by length.
    fn told_angles(
        &self,
        angles: &[(VertexId, f64)],
        left: &[f64],
    ) -> Result<Vec<f64>, FlattenError> {
        let told = self.told(angles)?;
        let needed = TAU - left.iter().sum::<f64>();
        let rest = needed - told.iter().flatten().sum::<f64>();
        let count = self.steps.len();
        let length = |place: usize| self.steps[place] + self.steps[(place + count - 1) % count];
        let free = (0..count).filter(|&place| told[place].is_none());
        let total: f64 = free.map(length).sum();
        let none_left = told.iter().all(Option::is_some);
        if none_left && rest.abs() > ANGLE_SUM {
            let told = needed - rest;
            return Err(FlattenError::AngleSum { told, needed });
        }
        let share = |place: usize| {
            let share = if total > 0.0 {
                length(place) / total
            } else {
                0.0
            };
            told[place].unwrap_or(rest * share)
        };
        Ok((0..count).map(share).collect())
    }

    /// What stands on the right of the equations: the curvature to be made.
    fn loads(&self, left: &[f64]) -> Vec<f64> {
        let pairs = left.iter().zip(&self.curvatures);
        pairs.map(|(left, curvature)| left - curvature).collect()
    }

    /// The metric with these scales on the outline: a Dirichlet problem.
    fn with_scales(&self, on_outline: &[f64], left: &[f64]) -> Result<Scaled, FlattenError> {
        let solved = self
            .dirichlet
            .solve_with_loads(on_outline, &self.loads(left))?;
        let flux = self.weights.apply(&PerVertex::new(solved.values.clone()));
        let turned = |&vertex: &usize| self.curvatures[vertex] + flux.as_slice()[vertex];
        Ok(Scaled {
            angles: self.outline.iter().map(turned).collect(),
            log_scales: solved.values,
        })
    }

    /// The metric with these turning angles on the outline: a Neumann problem.
    fn with_angles(&self, angles: &[f64], left: &[f64]) -> Result<Scaled, FlattenError> {
        let mut loads = self.loads(left);
        for (&vertex, angle) in self.outline.iter().zip(angles) {
            loads[vertex] = angle - self.curvatures[vertex];
        }
        let mut log_scales = self.neumann()?.solve_with_loads(&[0.0], &loads)?.values;
        // The scale of the whole is free: keep the boundary's length about as it is.
        let mean = self.outline.iter().map(|&v| log_scales[v]).sum::<f64>();
        let mean = mean / self.outline.len() as f64;
        for scale in &mut log_scales {
            *scale -= mean;
        }
        Ok(Scaled {
            log_scales,
            angles: angles.to_vec(),
        })
    }

    /// The Laplacian with one vertex of the outline pinned.
    fn neumann(&self) -> Result<DirichletSystem, FlattenError> {
        let placement = Placement::at(&self.domain.coordinates);
        Ok(DirichletSystem::new(
            &self.matrix,
            &self.outline[..1],
            placement,
        )?)
    }

    /// Lays the scaled metric into the plane.
    fn lay(
        &self,
        patch: Patch,
        vertex_sources: PerVertex<VertexId>,
        scaled: &Scaled,
        extension: Extension,
        watch: &Watch,
    ) -> Result<TargetMap, FlattenError> {
        let lengths = self.scaled_steps(scaled);
        let (outline, closing_change) = closed_curve(&lengths, &scaled.angles, watch)?;
        let _stage = watch.stage("fill in");
        let (mut positions, residual) = self.filled(&outline, extension)?;
        let flips = flip_count(&patch, &positions);
        if flips > 0 {
            let other = match extension {
                Extension::Harmonic => Extension::Conjugate,
                Extension::Conjugate => Extension::Harmonic,
            };
            let (others, _) = self.filled(&outline, other)?;
            let fewer = flip_count(&patch, &others);
            if fewer < flips {
                let message = format!(
                    "{extension:?} extension turns over or collapses {flips} triangles, \
                     {other:?} {fewer}: the latter is taken"
                );
                watch.warn("other-extension", message);
                positions = others;
            }
        }
        let positions: Vec<c64> = positions.into_iter().map(complex).collect();
        let intrinsic_flips = self.domain.intrinsic_flips(&positions);
        let mut draft = MapDraft {
            positions,
            method: Method::BoundaryTarget,
            residual,
            flip_free_in_theory: false,
            intrinsic_flips,
        };
        draft.positions.truncate(patch.mesh().vertex_count());
        Ok(TargetMap {
            map: draft.scaled_to_patch(&patch)?.finish(&patch, watch)?,
            patch,
            vertex_sources,
            closing_change,
        })
    }

    /// The edges of the outline in the scaled metric.
    fn scaled_steps(&self, scaled: &Scaled) -> Vec<f64> {
        let count = self.outline.len();
        let largest = self.outline.iter().map(|&v| scaled.log_scales[v]);
        // Only ratios matter; this way nothing overflows.
        let largest = largest.fold(f64::NEG_INFINITY, f64::max);
        let scale = |place: usize| scaled.log_scales[self.outline[place % count]] - largest;
        let places = self.steps.iter().enumerate();
        let length = |(place, step): (usize, &f64)| {
            step * libm::exp(f64::midpoint(scale(place), scale(place + 1)))
        };
        places.map(length).collect()
    }

    /// Positions of all vertices for these of the outline, and the residual.
    fn filled(
        &self,
        outline: &[DVec2],
        extension: Extension,
    ) -> Result<(Vec<DVec2>, f64), FlattenError> {
        let [us, vs] = [0, 1].map(|axis| outline.iter().map(move |p| p[axis]));
        let order = self.curvatures.len();
        let (us, vs, residual) = match extension {
            Extension::Harmonic => {
                let both = self.dirichlet.solve(&us.chain(vs).collect::<Vec<_>>())?;
                let (us, vs) = both.values.split_at(order);
                (us.to_vec(), vs.to_vec(), both.residual)
            }
            Extension::Conjugate => {
                let u = self.dirichlet.solve(&us.collect::<Vec<_>>())?;
                let count = outline.len();
                let mut fluxes = vec![0.0; order];
                for (place, &vertex) in self.outline.iter().enumerate() {
                    let next = outline[(place + 1) % count].x;
                    let previous = outline[(place + count - 1) % count].x;
                    fluxes[vertex] = 0.5 * (previous - next);
                }
                let v = self.neumann()?.solve_with_loads(&[0.0], &fluxes)?;
                (u.values, v.values, u.residual.max(v.residual))
            }
        };
        let pairs = us.iter().zip(&vs);
        Ok((pairs.map(|(&u, &v)| DVec2::new(u, v)).collect(), residual))
    }
}

/// Triangles of the patch turned over or collapsed.
fn flip_count(patch: &Patch, positions: &[DVec2]) -> usize {
    let mesh = patch.mesh();
    let corners = mesh.faces().map(|face| mesh.triangle(face));
    let places = corners.map(|corners| corners.map(|vertex| positions[vertex.index()]));
    let count = FlipCount::of_triangles(places);
    count.flipped + count.degenerate
}

/// The closed curve that turns by these angles, its lengths changed as little as closing it takes;
/// and the largest share by which one was changed.
///
/// Changes are least squares relative to the lengths. Lengths that would fall below
/// [`LEAST_CLOSING_SHARE`] of theirs are held there and the others changed anew.
fn closed_curve(
    lengths: &[f64],
    angles: &[f64],
    watch: &Watch,
) -> Result<(Vec<DVec2>, f64), FlattenError> {
    let mut direction = 0.0;
    let mut directions = Vec::with_capacity(lengths.len());
    for (place, angle) in angles.iter().enumerate() {
        // The first edge begins where the first vertex has turned already.
        direction += if place == 0 { 0.0 } else { *angle };
        let (sin, cos) = libm::sincos(direction);
        directions.push(DVec2::new(cos, sin));
    }
    let mut held = vec![false; lengths.len()];
    let mut closed = lengths.to_vec();
    for _ in 0..CLOSING_ROUNDS {
        let push = closing_push(lengths, &directions, &held);
        let push = push.ok_or(FlattenError::Unclosable)?;
        let mut again = false;
        for (place, length) in lengths.iter().enumerate() {
            if held[place] {
                continue;
            }
            closed[place] = length * (1.0 - directions[place].dot(push));
            if closed[place] < LEAST_CLOSING_SHARE * length {
                held[place] = true;
                closed[place] = LEAST_CLOSING_SHARE * length;
                again = true;
            }
        }
        if !again {
            let held = held.iter().filter(|held| **held).count();
            return Ok(laid_out(lengths, &closed, &directions, held, watch));
        }
    }
    Err(FlattenError::Unclosable)
}

/// The vector μ for which the lengths `l (1 − d·μ)` close, those held having their least share.
fn closing_push(lengths: &[f64], directions: &[DVec2], held: &[bool]) -> Option<DVec2> {
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    let (mut gap, mut total) = (DVec2::ZERO, 0.0);
    for ((length, d), held) in lengths.iter().zip(directions).zip(held) {
        if *held {
            gap += *d * (length * LEAST_CLOSING_SHARE);
            continue;
        }
        gap += *d * *length;
        total += length;
        xx += length * d.x * d.x;
        xy += length * d.x * d.y;
        yy += length * d.y * d.y;
    }
    let determinant = xx * yy - xy * xy;
    if determinant.is_nan() || determinant <= ROUNDING * total * total {
        return None;
    }
    let x = (yy * gap.x - xy * gap.y) / determinant;
    let y = (xx * gap.y - xy * gap.x) / determinant;
    Some(DVec2::new(x, y))
}

fn laid_out(
    lengths: &[f64],
    closed: &[f64],
    directions: &[DVec2],
    held: usize,
    watch: &Watch,
) -> (Vec<DVec2>, f64) {
    if held > 0 {
        let message = format!(
            "{held} boundary edges were held at {LEAST_CLOSING_SHARE} of their lengths to close \
             the boundary"
        );
        watch.warn("boundary-held", message);
    }
    let mut position = DVec2::ZERO;
    let mut positions = Vec::with_capacity(closed.len());
    for (length, direction) in closed.iter().zip(directions) {
        positions.push(position);
        position += *direction * *length;
    }
    let middle = positions.iter().sum::<DVec2>() / positions.len() as f64;
    for position in &mut positions {
        *position -= middle;
    }
    let changes = lengths.iter().zip(closed).map(|(l, c)| (c / l - 1.0).abs());
    (
        positions,
        changes.filter(|c| c.is_finite()).fold(0.0, f64::max),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_curve_that_closes_is_not_changed() {
        let (square, change) =
            closed_curve(&[2.0, 1.0, 2.0, 1.0], &[FRAC_PI_2; 4], &Watch::new()).unwrap();
        assert!(change < 1e-15);
        let expected = [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]].map(DVec2::from);
        for (found, expected) in square.iter().zip(expected) {
            assert!(found.distance(expected) < 1e-14);
        }
    }

    #[test]
    fn lengths_are_changed_as_little_as_closing_takes() {
        let lengths = [2.0, 1.0, 1.5, 1.0];
        let (curve, change) = closed_curve(&lengths, &[FRAC_PI_2; 4], &Watch::new()).unwrap();
        assert!((curve[1].distance(curve[0]) - curve[3].distance(curve[2])).abs() < 1e-14);
        // Relative changes of the two sides are weighed by their lengths.
        assert!((curve[1].distance(curve[0]) - 12.0 / 7.0).abs() < 1e-12);
        assert!((change - 1.0 / 7.0).abs() < 1e-12);
    }

    #[test]
    fn edges_do_not_turn_round_to_close_a_curve() {
        let watch = Watch::new();
        let angles = [FRAC_PI_2, FRAC_PI_2, 0.0, FRAC_PI_2, FRAC_PI_2];
        let (curve, _) = closed_curve(&[1.0, 1.0, 30.0, 1.0, 1.0], &angles, &watch).unwrap();
        for k in 0..5 {
            assert!(curve[k].distance(curve[(k + 1) % 5]) > 0.05);
        }
        let straight = closed_curve(&[1.0; 3], &[0.0; 3], &watch);
        assert_eq!(straight, Err(FlattenError::Unclosable));
    }
}
