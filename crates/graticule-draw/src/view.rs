use glam::DVec3;
use graticule::mesh::Surface;

use crate::DrawError;

/// Three orthonormal directions that say how a surface is held before the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    right: DVec3,
    up: DVec3,
    toward: DVec3,
}

impl Frame {
    /// x to the right, y up, z toward the viewer.
    pub const PLANE: Self = Self {
        right: DVec3::X,
        up: DVec3::Y,
        toward: DVec3::Z,
    };

    /// The frame of a viewer who stands in `direction` from the surface and holds `up` upright;
    /// where `up` is zero or along `direction`, another direction is taken.
    ///
    /// # Errors
    /// [`DrawError::Direction`] if `direction` is zero or not finite.
    pub fn new(direction: DVec3, up: DVec3) -> Result<Self, DrawError> {
        let toward = unit(direction).ok_or(DrawError::Direction {
            direction: direction.to_array(),
        })?;
        let right = unit(up)
            .and_then(|up| unit_unless_small(up.cross(toward)))
            .unwrap_or_else(|| toward.any_orthonormal_vector());
        let up = toward.cross(right);
        Ok(Self { right, up, toward })
    }

    /// The coordinates of `vector`: to the right, up, toward the viewer.
    #[inline]
    #[must_use]
    pub fn coordinates(&self, vector: DVec3) -> DVec3 {
        DVec3::new(
            self.right.dot(vector),
            self.up.dot(vector),
            self.toward.dot(vector),
        )
    }

    /// The frame of a viewer who walks round by `azimuth` degrees to the right and `elevation`
    /// degrees up.
    #[must_use]
    fn turned(self, azimuth: f64, elevation: f64) -> Self {
        let (sin, cos) = libm::sincos(azimuth.to_radians());
        let right = self.right * cos - self.toward * sin;
        let toward = self.right * sin + self.toward * cos;
        let (sin, cos) = libm::sincos(elevation.to_radians());
        Self {
            right,
            up: self.up * cos - toward * sin,
            toward: self.up * sin + toward * cos,
        }
    }
}

/// From where a surface is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum View {
    /// Found from the surface: a patch faces the viewer; other surfaces are seen in three-quarter
    /// view from a little above, their longer side across. y is upright, or z for a surface that
    /// stands on the plane z = 0 and not on y = 0.
    #[default]
    Automatic,
    /// From this direction.
    From {
        /// From the surface to the viewer; any length.
        direction: DVec3,
        /// What is upright in the picture; any length.
        up: DVec3,
    },
}

impl View {
    /// The frame of this view of `surface`. Cost of the automatic view: one pass over the faces.
    ///
    /// # Errors
    /// [`DrawError::Direction`] for a direction that is zero or not finite.
    pub fn frame(&self, surface: &Surface) -> Result<Frame, DrawError> {
        match *self {
            Self::Automatic => Ok(automatic_frame(surface)),
            Self::From { direction, up } => Frame::new(direction, up),
        }
    }
}

/// Share of the area of an open surface that must remain when its normals are averaged for it to
/// count as a patch with a face: a hemisphere keeps a half, a full cylinder nothing.
const FACING_SHARE: f64 = 0.25;

/// Distance from a coordinate plane, over the largest extent, up to which a surface stands on it.
const STANDING: f64 = 1e-3;

/// The frame of a viewer before the surface, upright, who has not chosen a side yet.
fn standing_frame(surface: &Surface) -> Frame {
    let [low, high] = surface.bounding_box();
    let extent = (high - low).max_element();
    let stands = |low: f64, high: f64| low.abs() <= STANDING * extent && high > 0.05 * extent;
    if stands(low.z, high.z) && !stands(low.y, high.y) {
        return Frame {
            right: DVec3::X,
            up: DVec3::Z,
            toward: DVec3::NEG_Y,
        };
    }
    Frame::PLANE
}

fn automatic_frame(surface: &Surface) -> Frame {
    let exposure = Exposure::of(surface);
    let open = surface.mesh().boundary_loop_count() > 0;
    if open && exposure.mean_normal.length() > FACING_SHARE {
        patch_frame(surface, exposure.mean_normal)
    } else {
        body_frame(surface, &exposure)
    }
}

/// A patch is seen along its mean normal, a little from the side. One that lies nearly flat is
/// seen from below its upper edge, as one looks onto a ground plane.
fn patch_frame(surface: &Surface, normal: DVec3) -> Frame {
    let normal = normal.normalize_or(DVec3::Z);
    let standing = standing_frame(surface);
    let size = size_in(surface, &standing);
    // One that lies on its back or face is held with a much longer side across.
    let rise = standing.up.dot(normal);
    let up = if rise.abs() < 0.8 {
        standing.up
    } else if 1.5 * size.x >= size.z {
        -standing.toward * rise.signum()
    } else {
        standing.right
    };
    let frame = Frame::new(normal, up).unwrap_or(Frame::PLANE);
    let size = size_in(surface, &frame);
    if size.z < 1e-9 * size.max_element() {
        frame
    } else if size.z < 0.35 * size.x.min(size.y) {
        frame.turned(-15.0, -38.0)
    } else {
        frame.turned(20.0, 10.0)
    }
}

/// Other surfaces stand upright; the wider side lies across, and the side with more area (more
/// detail) faces the viewer.
fn body_frame(surface: &Surface, exposure: &Exposure) -> Frame {
    let standing = standing_frame(surface);
    let size = size_in(surface, &standing);
    let front = if size.x >= size.z {
        standing.toward
    } else {
        standing.right
    };
    // A clear majority only: on symmetric surfaces the two are equal up to how they are meshed.
    let front = if exposure.facing(front) < 0.98 * exposure.facing(-front) {
        -front
    } else {
        front
    };
    let frame = Frame::new(front, standing.up).unwrap_or(standing);
    let lies_flat = size.y < 0.4 * size.x.max(size.z);
    frame.turned(30.0, if lies_flat { 35.0 } else { 18.0 })
}

/// Extents of the surface along the directions of `frame`, in units of its largest coordinate
/// extent.
fn size_in(surface: &Surface, frame: &Frame) -> DVec3 {
    let [low, high] = surface.bounding_box();
    let extent = (high - low).max_element();
    let [low, high] = surface
        .positions()
        .iter()
        .map(|&p| frame.coordinates((p - low) / extent))
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[a, b], p| {
            [a.min(p), b.max(p)]
        });
    high - low
}

/// How much of a surface faces where.
struct Exposure {
    /// Mean of the unit normals by area; zero for closed surfaces.
    mean_normal: DVec3,
    /// Area that faces along each axis, and against it.
    along: DVec3,
    against: DVec3,
}

impl Exposure {
    fn of(surface: &Surface) -> Self {
        let [low, high] = surface.bounding_box();
        let extent = (high - low).max_element();
        let mut total = 0.0;
        let mut result = Self {
            mean_normal: DVec3::ZERO,
            along: DVec3::ZERO,
            against: DVec3::ZERO,
        };
        for face in surface.mesh().faces() {
            let [a, b, c] = surface.corner_positions(face).map(|p| (p - low) / extent);
            let normal = (b - a).cross(c - a);
            let area = normal.length();
            result.mean_normal += normal;
            for axis in 0..3 {
                if normal[axis] < 0.0 {
                    result.against[axis] += area;
                } else {
                    result.along[axis] += area;
                }
            }
            total += area;
        }
        if total > 0.0 {
            result.mean_normal /= total;
        }
        result
    }

    /// Area that faces into a direction, which is that of an axis or its opposite.
    fn facing(&self, direction: DVec3) -> f64 {
        let [along, against] = [self.along, self.against];
        along.dot(direction.max(DVec3::ZERO)) + against.dot((-direction).max(DVec3::ZERO))
    }
}

/// The direction of a vector of any finite length above zero.
fn unit(vector: DVec3) -> Option<DVec3> {
    let largest = vector.abs().max_element();
    if largest > 0.0 && vector.is_finite() {
        // A subnormal length makes the quotient inexact, never zero.
        (vector / largest).try_normalize()
    } else {
        None
    }
}

/// The direction of a cross product of unit vectors, unless they are so nearly parallel that it is
/// rounding.
fn unit_unless_small(cross: DVec3) -> Option<DVec3> {
    (cross.length() > 1e-6).then(|| cross.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_orthonormal(frame: &Frame) {
        for axis in [frame.right, frame.up, frame.toward] {
            assert!((axis.length() - 1.0).abs() < 1e-12);
        }
        assert!(frame.right.cross(frame.up).dot(frame.toward) > 1.0 - 1e-12);
    }

    #[test]
    fn a_frame_is_orthonormal_whatever_the_directions() {
        for direction in [
            DVec3::Z,
            DVec3::new(1e-300, 0.0, 2e-300),
            DVec3::splat(1e300),
        ] {
            for up in [DVec3::Y, DVec3::Z, DVec3::ZERO, DVec3::NAN] {
                assert_orthonormal(&Frame::new(direction, up).unwrap());
            }
        }
        let turned = Frame::PLANE.turned(33.0, -12.0);
        assert_orthonormal(&turned);
        assert!(turned.toward.x > 0.0 && turned.toward.y < 0.0);
    }

    #[test]
    fn a_direction_of_zero_is_refused() {
        for direction in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert!(matches!(
                Frame::new(direction, DVec3::Y),
                Err(DrawError::Direction { .. })
            ));
        }
    }

    #[test]
    fn a_patch_faces_the_viewer_whichever_way_it_lies() {
        let cap = graticule_fixtures::spherical_cap(1.2, 6);
        for turn in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y] {
            let rotation = glam::DQuat::from_rotation_arc(DVec3::Z, turn);
            let positions = cap.positions.iter().map(|&p| rotation * p).collect();
            let surface = Surface::from_triangles(positions, &cap.triangles).unwrap();
            let frame = View::Automatic.frame(&surface).unwrap();
            assert!(frame.toward.dot(turn) > 0.7, "{turn}");
        }
    }

    #[test]
    fn what_stands_on_the_plane_z_0_is_held_upright() {
        let tower = graticule_fixtures::cylinder_closed(1.0, 3.0, 12, 4);
        let up = |change: fn(DVec3) -> DVec3| {
            let tower = tower.clone().map(change);
            let surface = Surface::from_triangles(tower.positions, &tower.triangles).unwrap();
            let frame = View::Automatic.frame(&surface).unwrap();
            [DVec3::Y, DVec3::Z].map(|axis| frame.coordinates(axis).y > 0.9)
        };
        assert_eq!(up(|p| p), [false, true]);
        assert_eq!(up(|p| DVec3::new(p.x, p.z, -p.y)), [true, false]);
        assert_eq!(up(|p| p - DVec3::Z * 1.5), [true, false]);
    }
}
