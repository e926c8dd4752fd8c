//! Least squares conformal maps built from scratch: one complex equation for each triangle, solved
//! densely (B. Lévy et al. 2002, Eq. 3). Shares no code with the library's quadratic form.

use faer::linalg::solvers::SolveLstsq;
use faer::{Mat, c64};
use glam::{DVec2, DVec3};
use graticule_fixtures::Fixture;

/// The least squares solution with two vertices at given places.
pub(crate) fn least_squares_map(fixture: &Fixture, pins: [(u32, DVec2); 2]) -> Vec<DVec2> {
    let vertices = fixture.positions.len();
    let free: Vec<u32> = (0..vertices as u32)
        .filter(|vertex| pins.iter().all(|(pin, _)| pin != vertex))
        .collect();
    let column = |vertex: u32| free.binary_search(&vertex).ok();
    let mut matrix = Mat::<c64>::zeros(fixture.triangles.len(), free.len());
    let mut right_side = Mat::<c64>::zeros(fixture.triangles.len(), 1);
    for (row, triangle) in fixture.triangles.iter().enumerate() {
        let corners = triangle.map(|vertex| fixture.positions[vertex as usize]);
        for (vertex, coefficient) in triangle.iter().zip(coefficients(corners)) {
            if let Some(column) = column(*vertex) {
                matrix[(row, column)] = coefficient;
            } else {
                let (_, place) = pins.iter().find(|(pin, _)| pin == vertex).unwrap();
                right_side[(row, 0)] -= coefficient * c64::new(place.x, place.y);
            }
        }
    }
    let solution = matrix.qr().solve_lstsq(&right_side);
    let place = |vertex: u32| match column(vertex) {
        Some(column) => DVec2::new(solution[(column, 0)].re, solution[(column, 0)].im),
        None => pins.iter().find(|(pin, _)| *pin == vertex).unwrap().1,
    };
    (0..vertices as u32).map(place).collect()
}

/// The opposite sides in the triangle's own plane, over the root of twice its area doubled.
fn coefficients([a, b, c]: [DVec3; 3]) -> [c64; 3] {
    let x = (b - a).normalize();
    let normal = (b - a).cross(c - a);
    let y = normal.normalize().cross(x);
    let local = |p: DVec3| c64::new((p - a).dot(x), (p - a).dot(y));
    let weight = 1.0 / (2.0 * normal.length()).sqrt();
    let [a, b, c] = [a, b, c].map(local);
    [(c - b) * weight, (a - c) * weight, (b - a) * weight]
}
