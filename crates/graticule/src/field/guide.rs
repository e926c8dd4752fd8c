use glam::DVec3;

use super::curl::turns_to_triangle;
use super::tangent::TangentPlanes;
use super::{FieldError, Guidance, Strength, Symmetry};
use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{Element, FaceId, Surface, VertexId};
use crate::tolerance::GUIDE_SLANT;

/// A direction that the field should have somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guide {
    /// Where.
    pub place: GuidePlace,
    /// The direction in space, of any length but zero; its part along the surface counts.
    pub direction: DVec3,
    /// How strongly the field is held to it.
    pub strength: Strength,
}

/// Where a guide is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuidePlace {
    /// At a vertex.
    Vertex(VertexId),
    /// In a triangle: at its three vertices.
    Face(FaceId),
}

impl Guidance {
    /// Asks the field to follow guides, one after the other. `triangulation` must have the
    /// triangles of `surface`.
    ///
    /// # Errors
    /// [`FieldError::NoSuchElement`], [`FieldError::Guide`].
    pub fn follow_guides(
        &mut self,
        surface: &Surface,
        triangulation: &IntrinsicTriangulation,
        guides: &[Guide],
    ) -> Result<(), FieldError> {
        if guides.is_empty() {
            return Ok(());
        }
        let planes = TangentPlanes::of(surface, triangulation);
        for (number, guide) in guides.iter().enumerate() {
            check(number, guide, surface)?;
            let angles = match guide.place {
                GuidePlace::Vertex(vertex) => {
                    at_vertex(self.symmetry(), guide.direction, vertex, &planes)
                }
                GuidePlace::Face(face) => in_face(guide.direction, face, surface, triangulation),
            };
            if angles.is_empty() {
                let what = "a direction at a right angle to the surface";
                return Err(fault(number, what, &guide.direction));
            }
            for (vertex, angle) in angles {
                self.follow(vertex, angle, guide.strength);
            }
        }
        Ok(())
    }
}

fn check(number: usize, guide: &Guide, surface: &Surface) -> Result<(), FieldError> {
    let mesh = surface.mesh();
    let (kind, index, count) = match guide.place {
        GuidePlace::Vertex(vertex) => ("vertex", vertex.index(), mesh.vertex_count()),
        GuidePlace::Face(face) => ("face", face.index(), mesh.face_count()),
    };
    if index >= count {
        return Err(FieldError::NoSuchElement {
            guide: number,
            kind,
            number: index as u32,
            count,
        });
    }
    match guide.strength {
        Strength::Soft(weight) if !(weight > 0.0 && weight.is_finite()) => Err(fault(
            number,
            "a weight that is no positive number",
            &weight,
        )),
        _ if unit(guide.direction).is_none() => {
            let what = "a direction that is zero or not finite";
            Err(fault(number, what, &guide.direction))
        }
        _ => Ok(()),
    }
}

fn fault(guide: usize, what: &'static str, value: &dyn std::fmt::Display) -> FieldError {
    FieldError::Guide {
        guide,
        what,
        value: value.to_string(),
    }
}

/// The unit vector, also of vectors whose squares overflow or vanish.
fn unit(vector: DVec3) -> Option<DVec3> {
    (vector / vector.abs().max_element()).try_normalize()
}

/// The vertex with the direction as an angle; nothing if it is across the surface.
pub(super) fn at_vertex(
    symmetry: Symmetry,
    direction: DVec3,
    vertex: VertexId,
    planes: &TangentPlanes<'_>,
) -> Vec<(VertexId, f64)> {
    let along = unit(direction).map(|direction| planes.frames[vertex].project(direction));
    let along = along.filter(|along| along.length() > GUIDE_SLANT);
    let angle = along.map(|along| {
        let in_frame = libm::atan2(along.y, along.x);
        (vertex, planes.on_surface(symmetry, vertex, in_frame))
    });
    angle.into_iter().collect()
}

/// The three vertices of a triangle with the direction as an angle at each.
fn in_face(
    direction: DVec3,
    face: FaceId,
    surface: &Surface,
    triangulation: &IntrinsicTriangulation,
) -> Vec<(VertexId, f64)> {
    let [a, b, c] = surface.corner_positions(face);
    let frame = unit(b - a).and_then(|x| {
        let y = unit(c - a).and_then(|side| (side - x * x.dot(side)).try_normalize())?;
        Some([x, y])
    });
    let (Some([x, y]), Some(direction)) = (frame, unit(direction)) else {
        return Vec::new();
    };
    let (x, y) = (x.dot(direction), y.dot(direction));
    if x.hypot(y) <= GUIDE_SLANT {
        return Vec::new();
    }
    let heading = libm::atan2(y, x);
    let corners = surface.mesh().triangle(face).into_iter();
    let turns = turns_to_triangle(triangulation, face);
    corners
        .zip(turns)
        .map(|(vertex, turn)| (vertex, heading - turn))
        .collect()
}
