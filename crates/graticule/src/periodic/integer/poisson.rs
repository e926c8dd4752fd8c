//! Coordinates with the gradients wished for, once turns and shifts are known.

use glam::DVec2;

use super::energy::{NormalEquations, side_weights};
use super::unknowns::turned;
use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{
    Element, FaceId, HalfedgeId, PerCorner, PerFace, PerVertex, TriangleMesh, VertexId,
};
use crate::periodic::Transition;
use crate::solve::{DirichletSystem, Placement, SolveError};

/// What a map is to be, before its coordinates are known.
#[derive(Clone, Copy, Debug)]
pub struct NetPlan<'a> {
    /// How the coordinates of a vertex become those of each of its corners.
    pub corners: &'a PerCorner<Transition>,
    /// The difference of coordinates wished along each halfedge, in its own triangle.
    pub wishes: &'a PerCorner<DVec2>,
    /// Triangles that do not count.
    pub left_out: &'a PerFace<bool>,
    /// Coordinates (0 or 1) of vertices that are given.
    pub given: &'a [(VertexId, usize, f64)],
}

/// The coordinates of the vertices with which the map is as close to the wishes as can be:
/// the least `Σ w |p(j) - p(i) - wish|²` over the sides of all triangles, with cotangent weights;
/// in other words the gradients differ least from those wished for, in the mean over the area.
///
/// Where nothing given fixes a coordinate of a part of the surface, one vertex there is held at 0.
/// Vertices of no triangle that counts get 0.
///
/// Cost: one factorisation of a real matrix with two unknowns per vertex and, as turns only exchange
/// them, no more entries than two Laplacians.
///
/// # Errors
/// [`SolveError`]; what is given twice, or is not there, is [`SolveError::BadFixedUnknown`].
pub fn poisson_net(
    mesh: &TriangleMesh,
    positions: &PerVertex<glam::DVec3>,
    triangulation: &IntrinsicTriangulation,
    plan: &NetPlan<'_>,
) -> Result<PerVertex<DVec2>, SolveError> {
    let weights = side_weights(triangulation);
    let mut equations = NormalEquations::new(2 * mesh.vertex_count());
    for face in plan.faces(mesh) {
        for halfedge in face.halfedges() {
            for coordinate in 0..2 {
                let [(from, start), (to, end)] =
                    [halfedge, halfedge.next()].map(|corner| plan.term(mesh, corner, coordinate));
                let terms = [(to.unknown, to.sign), (from.unknown, -from.sign)];
                let wish = plan.wishes[halfedge][coordinate] - end + start;
                equations.add(weights[halfedge], terms, wish);
            }
        }
    }
    let (matrix, loads) = equations.finish()?;
    let mut fixed: Vec<(usize, f64)> = plan
        .given
        .iter()
        .map(|&(vertex, coordinate, value)| (2 * vertex.index() + coordinate, value))
        .collect();
    fixed.extend(
        plan.loose(mesh, &fixed)
            .into_iter()
            .map(|unknown| (unknown, 0.0)),
    );
    let (unknowns, values): (Vec<usize>, Vec<f64>) = fixed.into_iter().unzip();
    let placement = Placement::at(positions.as_slice()).with_block(2);
    let system = DirichletSystem::new(&matrix, &unknowns, placement)?;
    let solution = system.solve_with_loads(&values, &loads)?;
    Ok(PerVertex::from_fn(
        mesh.vertex_count(),
        |vertex: VertexId| {
            let first = 2 * vertex.index();
            DVec2::new(solution.values[first], solution.values[first + 1])
        },
    ))
}

/// An unknown with a sign.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Term {
    unknown: u32,
    sign: f64,
}

impl NetPlan<'_> {
    fn faces(&self, mesh: &TriangleMesh) -> impl Iterator<Item = FaceId> + '_ {
        mesh.faces().filter(|&face| !self.left_out[face])
    }

    /// A coordinate of a corner: an unknown of its vertex, and a number that is added.
    fn term(&self, mesh: &TriangleMesh, corner: HalfedgeId, coordinate: usize) -> (Term, f64) {
        let Transition { turn, shift } = self.corners[corner];
        let (which, sign) = turned(turn, coordinate);
        let term = Term {
            unknown: 2 * mesh.origin(corner).0 + which as u32,
            sign: sign as f64,
        };
        (term, f64::from(shift[coordinate]))
    }

    /// One unknown of each set that hangs together by differences and that nothing determines:
    /// none of it is given, and none equals minus itself.
    fn loose(&self, mesh: &TriangleMesh, given: &[(usize, f64)]) -> Vec<usize> {
        let mut signs: Vec<Option<f64>> = vec![None; 2 * mesh.vertex_count()];
        let mut is_given = vec![false; signs.len()];
        for &(unknown, _) in given {
            is_given[unknown.min(2 * mesh.vertex_count() - 1)] = true;
        }
        let mut loose = Vec::new();
        for start in 0..signs.len() {
            if signs[start].is_some() {
                continue;
            }
            signs[start] = Some(1.0);
            let mut is_determined = is_given[start];
            let mut pending = vec![start];
            while let Some(unknown) = pending.pop() {
                let own = signs[unknown].unwrap_or(1.0);
                for (other, relative) in self.beside(mesh, unknown) {
                    match signs[other] {
                        None => {
                            signs[other] = Some(own * relative);
                            is_determined |= is_given[other];
                            pending.push(other);
                        }
                        Some(sign) => is_determined |= sign * own * relative < 0.0,
                    }
                }
            }
            if !is_determined {
                loose.push(start);
            }
        }
        loose
    }

    /// The unknowns that a triangle sets in relation to this one, with the sign of the relation.
    fn beside(&self, mesh: &TriangleMesh, unknown: usize) -> Vec<(usize, f64)> {
        let vertex = VertexId::from_index(unknown / 2);
        let mut found = Vec::new();
        let corners = mesh.outgoing(vertex);
        for corner in corners.filter(|corner| !self.left_out[corner.face()]) {
            for coordinate in 0..2 {
                let (own, _) = self.term(mesh, corner, coordinate);
                if own.unknown as usize != unknown {
                    continue;
                }
                for other in [corner.next(), corner.previous()] {
                    let (term, _) = self.term(mesh, other, coordinate);
                    found.push((term.unknown as usize, own.sign * term.sign));
                }
            }
        }
        found
    }
}
