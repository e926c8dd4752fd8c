use std::f64::consts::TAU;

use glam::DVec2;
use serde::Serialize;

use crate::geometry::{
    GeometryError, IntrinsicTriangulation, edge_cotangent_weights, vertex_areas,
};
use crate::mesh::{Element, PerEdge, PerVertex};

use super::phase_graph::{Link, NodeOrder, PhaseGraph};
use super::{EdgeSteps, QuarterTurn};

/// Which functional is minimised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum EnergyKind {
    /// The energies of the edges, each with the same weight ([PGP06] §2.3): it depends on the
    /// meshing.
    ///
    /// [PGP06]: crate::papers::PGP06
    Edge,
    /// The energy integrated over the triangles ([PGP06] Eqs. 15, 24): half-cotangent weights
    /// (erratum 4).
    ///
    /// [PGP06]: crate::papers::PGP06
    #[default]
    Triangle,
}

/// The weight of each edge's energy, without unit.
///
/// - [`EnergyKind::Edge`]: one half for each triangle of the edge, so that an edge inside has 1.
/// - [`EnergyKind::Triangle`]: `½ cot α` for each triangle, α the angle opposite to the edge. That is
///   [PGP06] Eq. 24 with the area that the print lost: `λᵢ A = ½ cot αᵢ` solves its system. Sums
///   that are negative count as 0: the sines and cosines only stand for angles where weights are
///   not negative. On an intrinsic Delaunay triangulation that concerns the boundary alone.
///
/// # Errors
/// [`GeometryError::DegenerateFace`] where a triangle has no area.
///
/// [PGP06]: crate::papers::PGP06
pub fn energy_weights(
    triangulation: &IntrinsicTriangulation,
    kind: EnergyKind,
) -> Result<PerEdge<f64>, GeometryError> {
    match kind {
        EnergyKind::Edge => {
            let weight = |edge| {
                if triangulation.is_boundary_edge(edge) {
                    0.5
                } else {
                    1.0
                }
            };
            Ok(PerEdge::new(triangulation.edges().map(weight).collect()))
        }
        EnergyKind::Triangle => {
            Ok(edge_cotangent_weights(triangulation)?.map(|weight| weight.max(0.0)))
        }
    }
}

/// The two unit vectors of a vertex, `U = (cos θ, sin θ)` and `V = (cos φ, sin φ)`.
pub type Phases = [DVec2; 2];

/// Sines and cosines in the frame of a neighbour across `turn` quarter turns: what coordinates
/// `R^-turn p` have.
///
/// [PGP06] Eq. 14's matrix with its signs mended (erratum 2): a quarter turn takes (θ, φ) to (−φ, θ)
/// and so (U, V) to (conj V, U).
///
/// [PGP06]: crate::papers::PGP06
#[must_use]
pub fn turned_phases([u, v]: Phases, turn: QuarterTurn) -> Phases {
    let conjugate = |z: DVec2| DVec2::new(z.x, -z.y);
    match turn.quarters() {
        0 => [u, v],
        1 => [v, conjugate(u)],
        2 => [conjugate(u), conjugate(v)],
        _ => [conjugate(v), u],
    }
}

/// The energy of an edge in sines and cosines ([PGP06] Eqs. 12, 14), from the phases of its origin
/// and its destination: `|U'ⱼ − e^iδ Uᵢ|² + |V'ⱼ − e^iδ⊥ Vᵢ|²`.
///
/// [PGP06]: crate::papers::PGP06
#[must_use]
pub fn edge_energy(step: super::EdgeStep, origin: Phases, destination: Phases) -> f64 {
    let wanted = [rotor(step.delta.x), rotor(step.delta.y)];
    let found = turned_phases(destination, step.turn);
    (0..2)
        .map(|k| found[k].distance_squared(wanted[k].rotate(origin[k])))
        .sum()
}

/// The energy of all edges, `Σ w F` ([PGP06] Eq. 15).
///
/// [PGP06]: crate::papers::PGP06
#[must_use]
pub fn total_energy(
    triangulation: &IntrinsicTriangulation,
    steps: &EdgeSteps,
    weights: &PerEdge<f64>,
    phases: &PerVertex<Phases>,
) -> f64 {
    let of_edge = |edge| {
        let [i, j] = triangulation.ends(triangulation.edge_halfedge(edge));
        weights[edge] * edge_energy(steps.of_edge(edge), phases[i], phases[j])
    };
    triangulation.edges().map(of_edge).sum()
}

/// The unit vector at `turns` of a whole turn.
pub(super) fn rotor(turns: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(TAU * turns);
    DVec2::new(cos, sin)
}

/// The energy as a quadratic form in one complex number per coordinate that is not fixed.
///
/// `fixed` tells for each vertex which of its two coordinates must be whole.
pub(super) fn phase_graph(
    triangulation: &IntrinsicTriangulation,
    steps: &EdgeSteps,
    weights: &PerEdge<f64>,
    fixed: &PerVertex<[bool; 2]>,
    order: &NodeOrder,
) -> PhaseGraph {
    let areas = vertex_areas(triangulation);
    let mean = areas.iter().sum::<f64>() / areas.len() as f64;
    let is_fixed = fixed.iter().flatten().copied().collect::<Vec<bool>>();
    let masses = areas.iter().flat_map(|area| {
        // A vertex of area 0 must not drop out.
        [(area / mean).max(f64::EPSILON); 2]
    });
    let links = triangulation.edges().flat_map(|edge| {
        let [i, j] = triangulation.ends(triangulation.edge_halfedge(edge));
        let step = steps.of_edge(edge);
        (0..2).map(move |coordinate| {
            let (there, is_mirrored) = partner(step.turn, coordinate);
            Link {
                ends: [2 * i.index() + coordinate, 2 * j.index() + there],
                is_mirrored,
                rotation: rotor(step.delta[coordinate]),
                weight: weights[edge],
            }
        })
    });
    PhaseGraph::new(&masses.collect::<Vec<f64>>(), &is_fixed, order, links)
}

/// Which coordinate of the destination continues a coordinate of the origin, and whether with the
/// opposite sign: the rows of `R^-turn`.
pub(super) fn partner(turn: QuarterTurn, coordinate: usize) -> (usize, bool) {
    let turns = turn.quarters() as usize;
    let there = (coordinate + turns) % 2;
    let is_mirrored = match turns {
        0 => false,
        1 => coordinate == 1,
        2 => true,
        _ => coordinate == 0,
    };
    (there, is_mirrored)
}
