use glam::DVec3;

/// The scaled Jacobian of a quad, in `-1.0..=1.0`: the least sine of a corner's angle, seen along
/// the normal of the quad's two bimedians; negative where a corner is inverted, 1 for a rectangle.
///
/// 0 where a side has no length or the bimedians are parallel. Sides from 1e-70 to 1e70.
#[must_use]
pub fn scaled_jacobian(corners: [DVec3; 4]) -> f64 {
    let [a, b, c, d] = corners;
    // The bimedians' cross product is twice that of the diagonals.
    let normal = (c - a).cross(d - b).normalize_or_zero();
    let sides = [b - a, c - b, d - c, a - d].map(DVec3::normalize_or_zero);
    let sine = |corner: usize| sides[(corner + 3) % 4].cross(sides[corner]).dot(normal);
    (0..4).map(sine).fold(f64::INFINITY, f64::min)
}
