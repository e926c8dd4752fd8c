//! The natural conformal map of patches so thin that the conformal form has lost all its digits.
//!
//! The form is a sum of squares, one for each triangle. A strip of length L and width h bends in
//! its plane almost without energy: the form's smallest eigenvalues are some (h/L)⁴ of its largest.
//! The triangles' own equations have the square root of that.

use faer::c64;

use crate::geometry::TriangleShape;
use crate::mesh::{Element, VertexId};
use crate::solve::LeastSquares;
use crate::watch::Watch;

use super::FlattenError;
use super::conformal::{ConformalForm, PinnedSolution, refined};
use super::domain::Domain;

/// Vertices up to which the factorisation is worth its time, which grows with their square on a
/// strip: some ten seconds.
pub(super) const MOST_VERTICES: usize = 60_000;

/// The map of least conformal energy with these vertices at these places, as
/// [`PinnedForm`](super::conformal::PinnedForm) makes it.
///
/// Cost: a sparse orthogonal factorisation, several times that of the form.
pub(super) fn pinned_map(
    domain: &Domain,
    pins: [(VertexId, c64); 2],
    watch: &Watch,
) -> Result<PinnedSolution, FlattenError> {
    let _stage = watch.stage("least squares");
    let equations: Vec<_> = domain.triangles().map(Equation::of).collect();
    let vertices = domain.mesh.vertex_count();
    let free = FreeVertices::new(vertices, pins.map(|(vertex, _)| vertex));
    let entries = equations.iter().enumerate().flat_map(|(row, equation)| {
        let terms = equation.terms().into_iter();
        terms.map(move |(vertex, factor)| (row, vertex, factor))
    });
    let entries =
        entries.filter_map(|(row, vertex, factor)| Some((row, free.column(vertex)?, factor)));
    let entries: Vec<_> = entries.collect();
    let system = LeastSquares::new(equations.len(), vertices - 2, &entries)?;
    watch.check()?;
    let mut positions = vec![c64::ZERO; vertices];
    for (vertex, place) in pins {
        positions[vertex.index()] = place;
    }
    refined(&mut positions, watch, |positions| {
        let missing: Vec<_> = equations.iter().map(|e| -e.value(positions)).collect();
        Ok(free.spread(&system.solve(&missing)?))
    })?;
    let form = ConformalForm::of(domain)?;
    let residual = form.residual(&positions, pins.map(|(vertex, _)| vertex))?;
    Ok(PinnedSolution {
        positions,
        residual,
    })
}

/// `Σ eⱼ zⱼ = 0` for the corners of a triangle, `eⱼ` the side opposite to corner `j` over the root
/// of twice the area: its square is the conformal energy up to a factor that is the same for all.
struct Equation {
    corners: [usize; 3],
    /// The factors of corners 1 and 2; that of corner 0 is minus their sum.
    factors: [c64; 2],
}

impl Equation {
    fn of((shape, corners): (&TriangleShape, [VertexId; 3])) -> Self {
        // Corner 0 at the origin, corner 1 on the real axis.
        let base = shape.length(0);
        let apex = c64::new(shape.dot(0), shape.double_area()) / base;
        let root = shape.double_area().sqrt();
        Self {
            corners: corners.map(Element::index),
            factors: [-apex / root, c64::new(base / root, 0.0)],
        }
    }

    fn terms(&self) -> [(usize, c64); 3] {
        let ([a, b, c], [at_b, at_c]) = (self.corners, self.factors);
        [(a, -at_b - at_c), (b, at_b), (c, at_c)]
    }

    /// The left side, from differences of positions.
    fn value(&self, z: &[c64]) -> c64 {
        let ([a, b, c], [at_b, at_c]) = (self.corners, self.factors);
        at_b * (z[b] - z[a]) + at_c * (z[c] - z[a])
    }
}

/// The vertices but for the pins, in order.
struct FreeVertices {
    vertices: usize,
    pins: [usize; 2],
}

impl FreeVertices {
    fn new(vertices: usize, pins: [VertexId; 2]) -> Self {
        let [a, b] = pins.map(Element::index);
        let pins = [a.min(b), a.max(b)];
        Self { vertices, pins }
    }

    fn column(&self, vertex: usize) -> Option<usize> {
        let [first, second] = self.pins;
        let before = usize::from(vertex > first) + usize::from(vertex > second);
        (vertex != first && vertex != second).then(|| vertex - before)
    }

    /// Values of the free vertices as values of all, 0 at the pins.
    fn spread(&self, values: &[c64]) -> Vec<c64> {
        let value = |vertex| {
            self.column(vertex)
                .map_or(c64::ZERO, |column| values[column])
        };
        (0..self.vertices).map(value).collect()
    }
}
