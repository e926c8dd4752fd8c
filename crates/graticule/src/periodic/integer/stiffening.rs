//! Weights that keep a net from being squeezed where a field has no room for its lines.
//!
//! Least squares alone let triangles collapse, or flip, so that others get what they wish for; whole
//! numbers rounded there are those of a crumpled net. D. Bommes et al. (2009) count such triangles
//! more, round after round.

use glam::{DMat2, DVec2};

use super::IntegerGridError;
use super::energy::SideEnergy;
use super::form::Form;
use super::solver::{Parts, Solver};
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerFace, TriangleMesh};
use crate::watch::Watch;

/// Rounds at most; each costs a factorisation.
const MOST_ROUNDS: usize = 3;

/// Triangles squeezed to less than this share of their width count more.
const SQUEEZED: f64 = 0.7;

/// Stretches below this one count as it: a bound of the factors, about 90.
const LEAST_STRETCH: f64 = 0.15;

/// Has the solver count squeezed triangles more, as long as any is flipped while the whole unknowns
/// are real. Returns the weights that it has then.
pub(super) fn stiffen(
    solver: &mut Solver,
    parts: Parts<'_>,
    (rows, parameters): (&[Form], usize),
    watch: &Watch,
) -> Result<PerCorner<f64>, IntegerGridError> {
    let mesh = parts.mesh;
    let mut energy = parts.energy.clone();
    let mut factors = PerFace::filled(mesh.face_count(), 1.0);
    for _ in 0..MOST_ROUNDS {
        watch.check()?;
        let own = Parts {
            energy: &energy,
            ..parts
        };
        let Some(differences) = solver.relaxed(own, rows)? else {
            break;
        };
        let stretches = least_stretches(mesh, &energy, &differences);
        if stretches.iter().all(|&stretch| stretch > 0.0) {
            break;
        }
        // They never fall: else triangles are squeezed in every other round.
        factors = PerFace::from_fn(mesh.face_count(), |face: FaceId| {
            stiffness(stretches[face] / SQUEEZED).max(factors[face])
        });
        energy.weights = PerCorner::from_fn(mesh.halfedge_count(), |halfedge: HalfedgeId| {
            parts.energy.weights[halfedge] * factors[halfedge.face()]
        });
        let own = Parts {
            energy: &energy,
            ..parts
        };
        solver.reweigh(own, (rows, parameters), watch)?;
    }
    Ok(energy.weights)
}

/// The least factor by which each triangle is stretched, over the root of that of the whole area;
/// below 0 where it is flipped, and 1 where nothing is wished for.
fn least_stretches(
    mesh: &TriangleMesh,
    energy: &SideEnergy,
    differences: &PerCorner<DVec2>,
) -> PerFace<f64> {
    let sides = |of: &PerCorner<DVec2>, face: FaceId| {
        let [first, _, last] = face.halfedges();
        DMat2::from_cols(of[first], -of[last])
    };
    let area = |of| -> f64 { mesh.faces().map(|face| sides(of, face).determinant()).sum() };
    let scale = (area(differences) / area(&energy.wishes)).max(0.0).sqrt();
    PerFace::from_fn(mesh.face_count(), |face: FaceId| {
        let jacobian = sides(differences, face) * sides(&energy.wishes, face).inverse();
        let least = least_stretch(jacobian) / scale;
        if least.is_finite() { least } else { 1.0 }
    })
}

/// The lesser singular value, with the sign of the determinant.
fn least_stretch(jacobian: DMat2) -> f64 {
    let [x, y] = [jacobian.x_axis, jacobian.y_axis];
    let similar = DVec2::new(x.x + y.y, x.y - y.x).length();
    let mirrored = DVec2::new(x.x - y.y, x.y + y.x).length();
    0.5 * (similar - mirrored)
}

/// The weight with which the square of `stretch - 1` pulls as hard as the symmetric Dirichlet energy
/// does, over that of a stretch of 1; 1 for larger ones.
fn stiffness(stretch: f64) -> f64 {
    let stretch = stretch.max(LEAST_STRETCH);
    if stretch < 1.0 {
        (stretch - stretch.powi(-3)) / (stretch - 1.0) / 4.0
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_stretch_is_the_lesser_singular_value_and_negative_when_mirrored() {
        let turn = DMat2::from_angle(0.7);
        for (stretches, expected) in [([2.0, 0.5], 0.5), ([0.3, -4.0], -0.3), ([1.0, 1.0], 1.0)] {
            let jacobian = turn * DMat2::from_diagonal(stretches.into()) * DMat2::from_angle(-1.9);
            assert!((least_stretch(jacobian) - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn squeezed_triangles_are_stiffer_the_more_they_are_squeezed() {
        assert_eq!(stiffness(1.5).to_bits(), 1.0_f64.to_bits());
        assert!((stiffness(1.0 - 1e-9) - 1.0).abs() < 1e-6);
        let factors = [0.9, 0.6, 0.3, 0.15].map(stiffness);
        assert!(factors.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(stiffness(-3.0).to_bits(), stiffness(0.15).to_bits());
    }
}
