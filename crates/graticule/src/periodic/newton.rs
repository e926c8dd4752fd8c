use glam::{DVec2, DVec3};

use super::PeriodicError;
use super::minimize::{Minimum, NewtonOptions};
use super::phase_graph::PhaseGraph;
use crate::solve::{Cholesky, Ordering, Placement, SolveError, Symbolic, SymmetricMatrix};
use crate::watch::Watch;

/// Inverse iterations for the linear solution: it is a start, no more.
const LINEAR_STEPS: usize = 8;

/// What keeps the matrix of the linear solution definite, against the masses.
const SHIFT: f64 = 1e-6;

/// Shortest step of the line search.
const SHORTEST: f64 = 1e-6;

/// Minimises `F** = F* + ε Σ m (|x|² − 1)²` as [PGP06] §2.5 does: Newton's method from the linear
/// solution. The penalty has the area m of the vertex over the mean in it (erratum 5).
///
/// Where the Hessian is not positive definite, as far from the minimum, its penalty part is replaced
/// by the nearest one that is. One factorisation for each iteration.
///
/// [PGP06]: crate::papers::PGP06
pub(super) fn newton(
    graph: &PhaseGraph,
    points: &[DVec3],
    options: &NewtonOptions,
    watch: &Watch,
) -> Result<Minimum, PeriodicError> {
    let mut run = Newton::new(graph, points, options)?;
    let mut values = run.linear_solution(watch)?;
    let mut steps = 0;
    loop {
        watch.check()?;
        let gradient = run.gradient(&values);
        let size = root_mean_square(&gradient);
        if size <= options.tolerance || steps == options.iterations {
            let moduli = values.iter().map(|value| value.length()).collect();
            let units: Vec<DVec2> = values.iter().map(|v| v.normalize_or(DVec2::X)).collect();
            return Ok(Minimum {
                energy: graph.energy(&units),
                values: units,
                moduli,
                steps,
                inner_iterations: run.factorisations,
                gradient: Some(size),
            });
        }
        if !run.step(&mut values, &gradient)? {
            steps = options.iterations;
            continue;
        }
        steps += 1;
        watch.progress(steps as f64 / options.iterations as f64);
    }
}

struct Newton<'a> {
    graph: &'a PhaseGraph,
    penalty: f64,
    ordering: Ordering,
    factorisations: usize,
}

impl<'a> Newton<'a> {
    fn new(
        graph: &'a PhaseGraph,
        points: &[DVec3],
        options: &NewtonOptions,
    ) -> Result<Self, SolveError> {
        let matrix = matrix(graph, |_| [SHIFT, 0.0, SHIFT])?;
        let placement = Placement::at(points).with_block(2);
        Ok(Self {
            graph,
            penalty: options.penalty,
            ordering: placement.ordering(matrix.lower().pattern())?,
            factorisations: 0,
        })
    }

    /// The smallest eigenvector of each component, or, where values are fixed, the solution of the
    /// linear system; with mean square 1.
    fn linear_solution(&mut self, watch: &Watch) -> Result<Vec<DVec2>, PeriodicError> {
        let graph = self.graph;
        let shift = |node: usize| [SHIFT * graph.masses[node], 0.0, SHIFT * graph.masses[node]];
        let factor = self.factored(&matrix(graph, shift)?)?;
        let components = graph.components();
        let mut values = graph.starts_from.clone();
        for _ in 0..LINEAR_STEPS {
            watch.check()?;
            let side = (0..graph.count()).flat_map(|node| {
                (values[node] * (SHIFT * graph.masses[node]) + graph.anchors[node]).to_array()
            });
            let solution = factor.solve(&side.collect::<Vec<f64>>())?;
            values = pairs(&solution.values);
            scale_components(&components, &graph.masses, &mut values);
        }
        Ok(values)
    }

    fn factored(&mut self, matrix: &SymmetricMatrix) -> Result<Cholesky, SolveError> {
        self.factorisations += 1;
        let symbolic = Symbolic::new(matrix, &self.ordering)?;
        Cholesky::factor(&symbolic, matrix)
    }

    fn value(&self, values: &[DVec2]) -> f64 {
        let penalties = values.iter().zip(&self.graph.masses);
        let penalties = penalties.map(|(x, mass)| mass * (x.length_squared() - 1.0).powi(2));
        self.graph.energy(values) + self.penalty * penalties.sum::<f64>()
    }

    fn gradient(&self, values: &[DVec2]) -> Vec<f64> {
        let of_node = |node: usize| {
            let (x, graph) = (values[node], self.graph);
            let form = x * graph.diagonal[node] - graph.pull(node, values);
            let excess = 2.0 * self.penalty * graph.masses[node] * (x.length_squared() - 1.0);
            (2.0 * (form + x * excess)).to_array()
        };
        (0..values.len()).flat_map(of_node).collect()
    }

    /// One Newton step with a line search; whether there was anything to gain.
    fn step(&mut self, values: &mut Vec<DVec2>, gradient: &[f64]) -> Result<bool, SolveError> {
        let exact = self.hessian_factor(values, false);
        let factor = match exact {
            Err(SolveError::NotPositiveDefinite { .. }) => self.hessian_factor(values, true)?,
            other => other?,
        };
        let half: Vec<f64> = gradient.iter().map(|g| -0.5 * g).collect();
        let direction = pairs(&factor.solve(&half)?.values);
        let slope: f64 = gradient
            .chunks_exact(2)
            .zip(&direction)
            .map(|(g, d)| DVec2::from_slice(g).dot(*d))
            .sum();
        let before = self.value(values);
        let mut length = 1.0;
        while length >= SHORTEST {
            let moved = values.iter().zip(&direction);
            let moved: Vec<DVec2> = moved.map(|(x, d)| *x + *d * length).collect();
            // Armijo's condition.
            if self.value(&moved) <= before + 1e-4 * length * slope {
                *values = moved;
                return Ok(true);
            }
            length *= 0.5;
        }
        Ok(false)
    }

    /// Half the Hessian, with the penalty's negative part left out where `convex`.
    fn hessian_factor(&mut self, values: &[DVec2], convex: bool) -> Result<Cholesky, SolveError> {
        let penalty = |node: usize| {
            let x = values[node];
            let excess = x.length_squared() - 1.0;
            let excess = if convex { excess.max(0.0) } else { excess };
            let weight = 2.0 * self.penalty * self.graph.masses[node];
            let slack = SHIFT * self.graph.masses[node];
            [
                weight * (excess + 2.0 * x.x * x.x) + slack,
                weight * 2.0 * x.x * x.y,
                weight * (excess + 2.0 * x.y * x.y) + slack,
            ]
        };
        let matrix = matrix(self.graph, penalty)?;
        self.factored(&matrix)
    }
}

/// The form's matrix over pairs of real numbers, plus a block `[xx, xy, yy]` for each node.
fn matrix(
    graph: &PhaseGraph,
    block: impl Fn(usize) -> [f64; 3],
) -> Result<SymmetricMatrix, SolveError> {
    let mut entries = Vec::new();
    for node in 0..graph.count() {
        let [xx, xy, yy] = block(node);
        let (x, y) = (2 * node, 2 * node + 1);
        entries.push((x, x, graph.diagonal[node] + xx));
        entries.push((y, x, xy));
        entries.push((y, y, graph.diagonal[node] + yy));
        for coupling in graph.couplings(node) {
            let other = coupling.node as usize;
            let (c, s) = (coupling.factor.x, coupling.factor.y);
            let sign = if coupling.is_mirrored { -1.0 } else { 1.0 };
            // Of each symmetric pair one triangle; of couplings to itself the half of both.
            if other < node {
                entries.push((x, 2 * other, -c));
                entries.push((x, 2 * other + 1, s * sign));
                entries.push((y, 2 * other, -s));
                entries.push((y, 2 * other + 1, -c * sign));
            } else if other == node {
                entries.push((x, x, -c));
                entries.push((y, x, -s));
                entries.push((y, y, -c * sign));
            }
        }
    }
    SymmetricMatrix::from_triplets(2 * graph.count(), entries)
}

fn pairs(numbers: &[f64]) -> Vec<DVec2> {
    numbers.chunks_exact(2).map(DVec2::from_slice).collect()
}

fn root_mean_square(numbers: &[f64]) -> f64 {
    let squares: f64 = numbers.iter().map(|x| x * x).sum();
    (squares / numbers.len().max(1) as f64).sqrt()
}

/// Scales the values of each component to mean square 1.
fn scale_components(components: &[u32], masses: &[f64], values: &mut [DVec2]) {
    let count = components
        .iter()
        .map(|&c| c as usize + 1)
        .max()
        .unwrap_or(0);
    let mut sums = vec![[0.0; 2]; count];
    for ((&component, mass), value) in components.iter().zip(masses).zip(&*values) {
        let sum = &mut sums[component as usize];
        sum[0] += mass * value.length_squared();
        sum[1] += mass;
    }
    for (&component, value) in components.iter().zip(values) {
        let [squares, mass] = sums[component as usize];
        if squares > 0.0 {
            *value *= (mass / squares).sqrt();
        }
    }
}
