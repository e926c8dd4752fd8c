//! Densities of lines that vary over the surface.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::LN_2;

use super::PeriodicError;
use crate::field::PrincipalCurvature;
use crate::geometry::{IntrinsicTriangulation, cotangent_weights, normalized, vertex_areas};
use crate::mesh::{Element, PerVertex, Surface, VertexId};
use crate::solve::{ConjugateGradientOptions, Jacobi, SymmetricMatrix, conjugate_gradients};
use crate::watch::Watch;

/// How charts get smaller where a surface bends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvatureSizing {
    /// Length of a chart's side where the surface is flat, in the unit of the positions.
    pub chart_size: f64,
    /// The angle, in radians, by which the surface bends over a chart's side at most.
    pub angle: f64,
    /// Largest factor by which charts get smaller.
    pub range: f64,
}

/// The density of lines, for [`parameterize`](super::parameterize()), at which no chart's side bends
/// by more than an angle: 1 where the surface is flat, `|κ| h / angle` where it bends more, up to the
/// range.
///
/// Averaged over neighbourhoods half a chart wide, as each change of the density asks for lines that
/// end. Cost: linear.
///
/// # Errors
/// [`PeriodicError`]: an option or a count out of range.
pub fn curvature_density(
    surface: &Surface,
    curvatures: &PerVertex<PrincipalCurvature>,
    sizing: &CurvatureSizing,
    watch: &Watch,
) -> Result<PerVertex<f64>, PeriodicError> {
    let vertices = surface.mesh().vertex_count();
    sizing.check()?;
    if curvatures.len() != vertices {
        return Err(PeriodicError::VertexCount {
            what: "the curvature",
            given: curvatures.len(),
            vertices,
        });
    }
    let wanted = curvatures.map(|curvature| {
        let bend = curvature.largest() * sizing.chart_size;
        // What is not a number is no bend.
        libm::log((bend / sizing.angle).max(1.0).min(sizing.range))
    });
    let (unit_surface, similarity) = normalized(surface);
    let own = IntrinsicTriangulation::of(&unit_surface)?;
    let radius = libm::ldexp(0.5 * sizing.chart_size, similarity.exponent());
    let smooth = averaged(&own, &wanted, radius, watch)?;
    Ok(smooth.map(|&logarithm| libm::exp(logarithm)))
}

impl CurvatureSizing {
    fn check(&self) -> Result<(), PeriodicError> {
        let positive = f64::MIN_POSITIVE..=f64::MAX;
        let numbers = [
            ("chart size", self.chart_size, positive.clone()),
            ("angle", self.angle, positive),
            ("range", self.range, 1.0..=f64::MAX),
        ];
        let bad = numbers
            .into_iter()
            .find(|(_, x, allowed)| !allowed.contains(x));
        match bad {
            Some((name, value, _)) => Err(PeriodicError::Option {
                name,
                value,
                range: if name == "range" {
                    "1 and above"
                } else {
                    "above 0, finite"
                },
            }),
            None => Ok(()),
        }
    }
}

/// Values averaged over neighbourhoods of this radius: `(M + r² L) x = M values`, whose solution
/// never leaves the range of the values where no weight is negative.
fn averaged(
    triangulation: &IntrinsicTriangulation,
    values: &PerVertex<f64>,
    radius: f64,
    watch: &Watch,
) -> Result<PerVertex<f64>, PeriodicError> {
    let masses = vertex_areas(triangulation);
    let weights = cotangent_weights(triangulation)?;
    let pairs = weights.ends.iter().zip(&weights.weights);
    let edges = pairs.flat_map(|(ends, &weight)| {
        let [i, j] = ends.map(Element::index);
        let pull = radius * radius * weight.max(0.0);
        [(i, i, pull), (j, j, pull), (i, j, -pull)]
    });
    // A vertex of area 0 must not drop out.
    let mean = masses.iter().sum::<f64>() / masses.len() as f64;
    let masses = masses.map(|mass| mass.max(f64::EPSILON * mean));
    let own = masses
        .enumerate()
        .map(|(vertex, &mass)| (vertex.index(), vertex.index(), mass));
    let matrix = SymmetricMatrix::from_triplets(values.len(), edges.chain(own))?;
    let side: Vec<f64> = masses
        .iter()
        .zip(values)
        .map(|(mass, value)| mass * value)
        .collect();
    let options = ConjugateGradientOptions {
        start: Some(values.as_slice()),
        tolerance: AVERAGED,
        ..ConjugateGradientOptions::default()
    };
    let solution = conjugate_gradients(&matrix, &Jacobi::new(&matrix)?, &side, options, watch)?;
    Ok(PerVertex::new(solution.values))
}

/// Relative residual of an average: a density is no measure to more digits.
const AVERAGED: f64 = 1e-4;

/// Twice the density about these vertices, for half a chart, and less and less for another whole one.
pub(super) fn denser_about(
    triangulation: &IntrinsicTriangulation,
    density: &PerVertex<f64>,
    vertices: &[VertexId],
) -> PerVertex<f64> {
    // In charts from the nearest of them, as far as it matters.
    let mut distances = PerVertex::filled(density.len(), DENSER_REACH);
    let mut waiting = BinaryHeap::new();
    for &vertex in vertices {
        distances[vertex] = 0.0;
        waiting.push(Reverse((0_u64, vertex)));
    }
    while let Some(Reverse((bits, vertex))) = waiting.pop() {
        // An entry that a shorter way has overtaken.
        if distances[vertex].to_bits() != bits {
            continue;
        }
        for halfedge in triangulation
            .outgoing(vertex)
            .flat_map(|h| [h, h.previous()])
        {
            let [a, b] = triangulation.ends(halfedge);
            let other = if a == vertex { b } else { a };
            let length = triangulation.edge_length(triangulation.edge(halfedge));
            let there = distances[vertex] + length * density[vertex];
            if there < distances[other] {
                distances[other] = there;
                // Distances are not negative: their bits are in their order.
                waiting.push(Reverse((there.to_bits(), other)));
            }
        }
    }
    PerVertex::from_fn(density.len(), |vertex| {
        let logarithm = (DENSER_REACH - distances[vertex]).min(1.0) * LN_2;
        density[vertex] * libm::exp(logarithm)
    })
}

/// Distance in charts at which charts are no longer made smaller.
const DENSER_REACH: f64 = 1.5;
