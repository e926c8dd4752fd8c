//! Maps whose boundary is moved until a functional is least ([DMA02] §5.2).
//!
//! The interior follows the boundary linearly, so that the boundary points are the only unknowns.
//! The paper takes the derivatives from one impulse response per boundary point; here one solve
//! with the transposed matrix gives the gradient by all of them, and a quasi-Newton method
//! (limited-memory BFGS: J. Nocedal, *Updating quasi-Newton matrices with limited storage*, 1980)
//! takes the place of plain descent.
//!
//! [DMA02]: crate::papers::DMA02

use glam::DVec2;
use robust::{Coord, orient2d};

use crate::mesh::{Element, PerVertex, TriangleMesh};
use crate::solve::{DirichletSystem, Placement, SymmetricMatrix};
use crate::tolerance::{DESCENT_AT_REST, FLATTENED_HEIGHT, SHARE_TO_COLLAPSE};
use crate::watch::Watch;

use super::collapse_time::collapse_time;
use super::conformal::Triangulation;
use super::domain::Domain;
use super::equations::index_pairs;
use super::fixed::Extended;
use super::functional::Measured;
use super::limited_memory::LimitedMemory;
use super::optimal::in_own_unit;
use super::shape_guard::ShapeGuard;
use super::{
    BoundaryPositions, FixedOptions, FixedSystem, FlatMap, FlattenError, Functional, MapEnergy,
    Method, Patch,
};

/// Trials of one line search.
const MOST_TRIALS: usize = 40;
/// Share of the decrease that the slope promises which a step must bring (Armijo).
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Share of the slope at which a step is long enough (weak Wolfe condition).
const REMAINING_SLOPE: f64 = 0.9;
/// Steps in a row of hardly any gain after which the descent is at rest.
const STEPS_AT_REST: usize = 3;

/// How the boundary is optimised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryOptimalOptions {
    /// What is made least.
    pub functional: Functional,
    /// How the interior follows the boundary.
    pub fixed: FixedOptions,
    /// Steps after which the descent ends, at rest or not.
    pub most_steps: usize,
}

impl Default for BoundaryOptimalOptions {
    /// Edge lengths, conformal weights, holes closed, 200 steps.
    fn default() -> Self {
        Self {
            functional: Functional::default(),
            fixed: FixedOptions::default(),
            most_steps: 200,
        }
    }
}

/// One state of the descent.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct DescentStep {
    /// The functional.
    pub value: f64,
    /// Length of the gradient, by all boundary coordinates, of what is lowered, in inverse unit
    /// lengths of the patch.
    pub gradient: f64,
    /// Share of the quasi-Newton step that was taken to come here; 0 for the start.
    pub step: f64,
}

/// A map with optimised boundary and how it came about.
#[derive(Clone, Debug)]
pub struct BoundaryOptimalMap {
    /// The map.
    pub map: FlatMap,
    /// The map at the start, in the surface's unit of length.
    pub start: PerVertex<DVec2>,
    /// The functional from the start to the end; it falls with each step.
    pub history: Vec<DescentStep>,
    /// Whether the descent came to rest, rather than to the last step allowed.
    pub at_rest: bool,
    /// Triangles left out of the functional, since the start had them turned over and no finite
    /// value exists with them.
    pub left_out: usize,
}

/// Moves the placed boundary vertices until a functional of the map is at a local minimum, from
/// `start` scaled to the area of the patch ([DMA02] §5.2).
///
/// Each step lowers the functional, and none turns over a triangle that was not so before, by exact
/// signs. To functionals that would let triangles collapse a small barrier is added, which keeps the
/// descent from ending at the first that it squeezes flat. Parts of the boundary may come to overlap;
/// `measure` tells.
///
/// A warning (`descent-unfinished`) tells if the last step allowed comes before rest, another
/// (`flipped-left-out`) how many triangles were left out.
///
/// Cost: the factorisation of a map with fixed boundary and that of one more Laplacian; each step
/// takes three solves and some linear passes.
///
/// # Errors
/// [`FlattenError`].
///
/// [DMA02]: crate::papers::DMA02
pub fn boundary_optimal_map(
    patch: &Patch,
    start: &BoundaryPositions,
    options: &BoundaryOptimalOptions,
    watch: &Watch,
) -> Result<BoundaryOptimalMap, FlattenError> {
    let _stage = watch.stage("map with optimised boundary");
    let system = FixedSystem::new(patch, start, &options.fixed, watch)?;
    let extended = system.extended(&system.unit_places(start)?)?;
    let mut descent = Descent::new(&system, extended, options.functional, watch)?;
    let beginning = in_own_unit(patch, &descent.state.positions);
    let at_rest = {
        let _stage = watch.stage("descend");
        descent.run(options.most_steps, watch)?
    };
    if !at_rest {
        let message = format!(
            "the descent ended after {} steps, not at rest",
            options.most_steps
        );
        watch.warn("descent-unfinished", message);
    }
    let mut map = system.finished(&descent.state, false, watch)?;
    map.method = Method::BoundaryOptimal;
    Ok(BoundaryOptimalMap {
        map,
        start: beginning,
        history: descent.history,
        at_rest,
        left_out: descent.left_out,
    })
}

/// What a descent lowers.
struct Aim<'a> {
    measured: Measured<'a>,
    /// For functionals that would let triangles collapse.
    guard: Option<ShapeGuard>,
}

/// A value of it.
#[derive(Clone, Copy)]
struct Value {
    functional: f64,
    /// With what the guard adds.
    whole: f64,
}

impl Aim<'_> {
    fn value(&self, positions: &[DVec2]) -> Value {
        let functional = self.measured.value(positions);
        let guard = self.guard.as_ref();
        let added = guard.map_or(0.0, |guard| guard.value(positions));
        Value {
            functional,
            whole: functional + added,
        }
    }

    fn gradient(&self, positions: &[DVec2]) -> Vec<DVec2> {
        let (_, mut gradient) = self.measured.gradient(positions);
        if let Some(guard) = &self.guard {
            guard.add_gradient(positions, &mut gradient);
        }
        gradient
    }
}

struct Descent<'a> {
    system: &'a FixedSystem,
    aim: Aim<'a>,
    metric: BoundaryMetric,
    state: Extended,
    value: Value,
    /// By the places of the fixed vertices.
    gradient: Vec<DVec2>,
    history: Vec<DescentStep>,
    left_out: usize,
}

impl<'a> Descent<'a> {
    fn new(
        system: &'a FixedSystem,
        mut state: Extended,
        functional: Functional,
        watch: &Watch,
    ) -> Result<Self, FlattenError> {
        let patch = system.patch();
        let own = patch.mesh().vertex_count();
        scale_to_patch(patch, &mut state.positions)?;
        let mut measured = Measured::new(patch, functional);
        let left_out = measured.leave_out_flipped(&state.positions[..own]);
        if left_out > 0 {
            let message = format!(
                "{left_out} triangles are turned over at the start, where {functional:?} is \
                 infinite: they are left out of it; mean value weights turn none over on a circle"
            );
            watch.warn("flipped-left-out", message);
        }
        let guard =
            (!functional.is_barrier()).then(|| ShapeGuard::new(&measured, &state.positions[..own]));
        let aim = Aim { measured, guard };
        let mut descent = Self {
            metric: BoundaryMetric::new(system, watch)?,
            system,
            value: aim.value(&state.positions),
            aim,
            state,
            gradient: Vec::new(),
            history: Vec::new(),
            left_out,
        };
        if !descent.value.whole.is_finite() {
            return Err(FlattenError::NoFiniteValue { functional });
        }
        descent.evaluate(0.0)?;
        Ok(descent)
    }

    /// Computes value and gradient where the descent stands, and notes them.
    fn evaluate(&mut self, step: f64) -> Result<(), FlattenError> {
        let positions = &self.state.positions;
        self.value = self.aim.value(positions);
        self.gradient = self.system.pull_back(&self.aim.gradient(positions))?;
        self.history.push(DescentStep {
            value: self.value.functional,
            gradient: dot(&self.gradient, &self.gradient).sqrt(),
            step,
        });
        Ok(())
    }

    /// Descends; whether it came to rest.
    fn run(&mut self, most_steps: usize, watch: &Watch) -> Result<bool, FlattenError> {
        let mut memory = LimitedMemory::default();
        let mut resting = 0;
        for round in 0..most_steps {
            watch.check()?;
            watch.progress(round as f64 / most_steps as f64);
            let Some(accepted) = self.step(&mut memory)? else {
                // No descent along the remembered curvature: begin anew, or rest.
                if memory.is_empty() {
                    return Ok(true);
                }
                memory = LimitedMemory::default();
                continue;
            };
            let gained = accepted.before - self.value.whole;
            resting = if gained <= DESCENT_AT_REST * accepted.before {
                resting + 1
            } else {
                0
            };
            if resting >= STEPS_AT_REST {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// One step, if one lowers the functional.
    fn step(&mut self, memory: &mut LimitedMemory) -> Result<Option<Accepted>, FlattenError> {
        let metric = &self.metric;
        let direction = memory.direction(&self.gradient, |vector| metric.inverse(vector))?;
        let slope = dot(&self.gradient, &direction);
        if slope.is_nan() || slope >= 0.0 {
            return Ok(None);
        }
        let moved = self.system.extended(&direction)?;
        let Some((length, positions)) = self.search(&moved.positions, slope) else {
            return Ok(None);
        };
        let before = self.value.whole;
        let old_gradient = std::mem::take(&mut self.gradient);
        self.state.positions = positions;
        self.state.residual = self.state.residual.max(moved.residual);
        self.evaluate(length)?;
        let step = direction.iter().map(|d| *d * length).collect();
        let change = difference(&self.gradient, &old_gradient);
        memory.remember(step, change);
        Ok(Some(Accepted { before }))
    }

    /// A length along the way at which the functional has fallen enough and its slope has flattened
    /// (weak Wolfe conditions, by bisection), with the positions there.
    fn search(&self, way: &[DVec2], slope: f64) -> Option<(f64, Vec<DVec2>)> {
        let mesh = self.system.patch().mesh();
        let from = &self.state.positions;
        let limit = SHARE_TO_COLLAPSE * first_collapse(mesh, from, way);
        let [mut low, mut high] = [0.0, limit];
        let mut length = limit.min(1.0);
        let mut best = None;
        for _ in 0..MOST_TRIALS {
            let positions = along(from, way, length);
            let value = self.aim.value(&positions);
            let enough = self.value.whole + SUFFICIENT_DECREASE * length * slope;
            let falls = value.whole <= enough && value.functional < self.value.functional;
            if !falls || flips_anew(mesh, from, &positions) {
                high = length;
            } else {
                let steep = self.slope(&positions, way) < REMAINING_SLOPE * slope;
                best = Some((length, positions));
                if !steep || high - length <= f64::EPSILON * high {
                    break;
                }
                low = length;
            }
            length = if high.is_finite() {
                f64::midpoint(low, high)
            } else {
                2.0 * length
            };
        }
        best
    }

    fn slope(&self, positions: &[DVec2], way: &[DVec2]) -> f64 {
        dot(&self.aim.gradient(positions), way)
    }
}

/// A step that was taken.
struct Accepted {
    before: f64,
}

/// The boundary's own measure of smoothness: the Dirichlet energy of the harmonic function with
/// given boundary values. Its inverse turns a gradient into a direction without jitter, whatever
/// the number of boundary vertices.
struct BoundaryMetric {
    laplacian: DirichletSystem,
    /// The fixed vertices, the first of them pinned.
    vertices: Vec<usize>,
}

impl BoundaryMetric {
    fn new(system: &FixedSystem, watch: &Watch) -> Result<Self, FlattenError> {
        let _stage = watch.stage("boundary metric");
        // What there is to tell of the triangles has been told when the system was made.
        let domain = Domain::conformal(system.patch(), Triangulation::Given, &Watch::new())?;
        let weights = domain.cotangent_weights()?;
        let matrix = SymmetricMatrix::laplacian(weights.vertex_count(), index_pairs(&weights))?;
        let vertices: Vec<usize> = system.fixed().iter().map(|v| v.index()).collect();
        let placement = Placement::at(&domain.coordinates);
        Ok(Self {
            laplacian: DirichletSystem::new(&matrix, &vertices[..1], placement)?,
            vertices,
        })
    }

    /// The boundary values, with mean zero, whose fluxes are `gradient`.
    fn inverse(&self, gradient: &[DVec2]) -> Result<Vec<DVec2>, FlattenError> {
        let order = self.laplacian.free().len() + 1;
        let mut loads = vec![0.0; 2 * order];
        for (&vertex, gradient) in self.vertices.iter().zip(gradient) {
            loads[vertex] = gradient.x;
            loads[order + vertex] = gradient.y;
        }
        let solved = self.laplacian.solve_with_loads(&[0.0; 2], &loads)?.values;
        let (us, vs) = solved.split_at(order);
        let place = |&vertex: &usize| DVec2::new(us[vertex], vs[vertex]);
        let mut values: Vec<DVec2> = self.vertices.iter().map(place).collect();
        let mean = values.iter().sum::<DVec2>() / values.len() as f64;
        for value in &mut values {
            *value -= mean;
        }
        Ok(values)
    }
}

/// The sum of the products of two lists of vectors.
pub(super) fn dot(a: &[DVec2], b: &[DVec2]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

fn difference(a: &[DVec2], b: &[DVec2]) -> Vec<DVec2> {
    a.iter().zip(b).map(|(a, b)| *a - *b).collect()
}

fn along(from: &[DVec2], way: &[DVec2], length: f64) -> Vec<DVec2> {
    let pairs = from.iter().zip(way);
    pairs.map(|(from, way)| *from + *way * length).collect()
}

fn scale_to_patch(patch: &Patch, positions: &mut [DVec2]) -> Result<(), FlattenError> {
    let own = positions[..patch.mesh().vertex_count()].to_vec();
    let area = MapEnergy::of(patch.mesh(), patch.shapes(), &PerVertex::new(own)).area;
    let share = area / patch.unit_area();
    if share.is_nan() || share <= 0.0 {
        return Err(FlattenError::Collapsed { area: share });
    }
    for position in positions {
        *position /= share.sqrt();
    }
    Ok(())
}

/// How far along the way the first triangle that is not turned over collapses; infinite if none
/// does.
fn first_collapse(mesh: &TriangleMesh, from: &[DVec2], way: &[DVec2]) -> f64 {
    let times = mesh.faces().filter_map(|face| {
        let corners = mesh.triangle(face).map(Element::index);
        let [places, steps] = [from, way].map(|at| corners.map(|corner| at[corner]));
        let [a, b, c] = places;
        let is_upright = (b - a).perp_dot(c - a) > 0.0;
        is_upright.then(|| collapse_time(places, steps))
    });
    times.fold(f64::INFINITY, f64::min)
}

/// Whether a triangle that was laid down rightly is not so any more, by exact signs, or has become
/// flatter than [`FLATTENED_HEIGHT`].
fn flips_anew(mesh: &TriangleMesh, before: &[DVec2], after: &[DVec2]) -> bool {
    mesh.faces().any(|face| {
        let corners = mesh.triangle(face).map(Element::index);
        let [new, old] = [after, before].map(|at| height_ratio(corners.map(|corner| at[corner])));
        new <= 0.0 && old > 0.0 || new < FLATTENED_HEIGHT && old >= FLATTENED_HEIGHT
    })
}

/// The height of a triangle over its longest side, with the exact sign of its orientation.
fn height_ratio(corners: [DVec2; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| Coord { x: p.x, y: p.y });
    let [p, q, r] = corners;
    let sides = [q - p, r - q, p - r].map(DVec2::length_squared);
    let longest = sides.into_iter().fold(0.0, f64::max);
    let doubled_area = orient2d(a, b, c);
    // Dividing by a side that has vanished must not turn a zero into anything else.
    if longest > 0.0 {
        doubled_area / longest
    } else {
        doubled_area
    }
}
