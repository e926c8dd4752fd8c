//! Sizes that a remesh has enough digits for.

use glam::DVec3;

use super::RemeshError;
use crate::mesh::{PerComponent, Surface, Topology};
use crate::tolerance::{LEAST_COMPONENT_EXTENT, MEASURABLE_EXTENTS};

/// Refuses surfaces whose squared lengths overflow or vanish, and those with a component that is
/// next to a point beside the whole.
pub(super) fn check_extents(surface: &Surface) -> Result<(), RemeshError> {
    let whole = extent(surface.bounding_box());
    if whole > 0.0 && !MEASURABLE_EXTENTS.contains(&whole) {
        return Err(RemeshError::Extent { extent: whole });
    }
    let mesh = surface.mesh();
    let topology = Topology::of(mesh);
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let mut boxes = PerComponent::filled(topology.components.len(), nothing);
    for face in mesh.faces() {
        let [low, high] = &mut boxes[topology.face_components[face]];
        for corner in surface.corner_positions(face) {
            (*low, *high) = (low.min(corner), high.max(corner));
        }
    }
    for face in mesh.faces() {
        let share = extent(boxes[topology.face_components[face]]) / whole;
        if share < LEAST_COMPONENT_EXTENT {
            return Err(RemeshError::TinyComponent { face, share });
        }
    }
    Ok(())
}

fn extent([low, high]: [DVec3; 2]) -> f64 {
    (high - low).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::{Fixture, cube};

    fn checked(fixture: Fixture) -> Result<(), RemeshError> {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        check_extents(&surface)
    }

    #[test]
    fn surfaces_beyond_what_can_be_squared_are_refused() {
        assert!(checked(cube()).is_ok());
        let tiny = checked(cube().map(|p| p * 1e-200));
        assert!(matches!(tiny, Err(RemeshError::Extent { .. })));
    }

    #[test]
    fn a_component_next_to_a_point_is_named() {
        let with = |scale: f64| checked(cube().joined(&cube().map(|p| p * scale)));
        assert!(with(1e-9).is_ok());
        let Err(RemeshError::TinyComponent { face, share }) = with(1e-16) else {
            panic!("it was not refused");
        };
        assert_eq!(face.0, 12);
        assert!(share < 1e-15);
    }
}
