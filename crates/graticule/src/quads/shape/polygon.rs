use glam::DVec3;

/// The normal of a polygon, or that of the surface where the polygon is turned over or has none:
/// then its corners count as inverted.
pub(super) fn facing(normal: DVec3, of_surface: DVec3) -> DVec3 {
    if normal.dot(of_surface) > 0.0 || of_surface == DVec3::ZERO {
        normal
    } else {
        of_surface.normalize_or_zero()
    }
}

/// The sine of the angle at a corner, negative where the corner is inverted; 0 where a side has no
/// length.
pub(super) fn corner_sine([before, corner, after]: [DVec3; 3], normal: DVec3) -> f64 {
    let [out, back] = [after - corner, before - corner];
    let lengths = out.length() * back.length();
    if lengths > 0.0 {
        out.cross(back).dot(normal) / lengths
    } else {
        0.0
    }
}
