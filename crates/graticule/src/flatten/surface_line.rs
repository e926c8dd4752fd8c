//! Lines over a patch that are to become straight: [DMA02] §4.1 constrains them by their end points
//! and by where they cross edges.
//!
//! [DMA02]: crate::papers::DMA02

use glam::{DVec2, DVec3};

use crate::mesh::{FaceId, HalfedgeId, SurfacePoint, TriangleMesh};

use super::{FlattenError, Patch, PointConstraint, Strength};

/// The points of a line over the patch: its ends and where it crosses edges, in order.
///
/// The line is the section of the patch with a plane through both points and along the mean of the
/// normals there; of several sections the shortest.
///
/// Cost: linear in the triangles crossed.
///
/// # Errors
/// [`FlattenError::NoLine`] where no such section joins the points.
pub fn surface_line(
    patch: &Patch,
    from: SurfacePoint,
    to: SurfacePoint,
) -> Result<Vec<SurfacePoint>, FlattenError> {
    let surface = patch.unit_surface();
    let [start, end] = [from, to].map(|point| point.position(surface));
    let normal = |face: FaceId| {
        let [a, b, c] = surface.corner_positions(face);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let section = Section {
        patch,
        start,
        across: (end - start).cross(normal(from.face) + normal(to.face)),
    };
    let no_line = FlattenError::NoLine {
        from: from.face,
        to: to.face,
    };
    if section.across == DVec3::ZERO {
        return Err(no_line);
    }
    let ends = faces_at(patch.mesh(), to);
    let mut best: Option<(f64, Vec<SurfacePoint>)> = None;
    for face in faces_at(patch.mesh(), from) {
        for exit in face.halfedges() {
            let Some(crossings) = section.walk(exit, &ends) else {
                continue;
            };
            let line: Vec<_> = std::iter::once(from).chain(crossings).chain([to]).collect();
            let length = lengths(patch, &line).iter().sum();
            if best.as_ref().is_none_or(|(least, _)| length < *least) {
                best = Some((length, line));
            }
        }
        if ends.contains(&face) {
            return Ok(vec![from, to]);
        }
    }
    best.map(|(_, line)| line).ok_or(no_line)
}

/// Constraints that lay a [`surface_line`] on the straight line between two places, its points as
/// far along it as they are along the line over the patch.
///
/// # Errors
/// As [`surface_line`].
pub fn line_constraints(
    patch: &Patch,
    ends: [SurfacePoint; 2],
    places: [DVec2; 2],
    strength: Strength,
) -> Result<Vec<PointConstraint>, FlattenError> {
    let line = surface_line(patch, ends[0], ends[1])?;
    let lengths = lengths(patch, &line);
    let total: f64 = lengths.iter().sum();
    let mut walked = 0.0;
    let mut constraints = Vec::with_capacity(line.len());
    for (place, &point) in line.iter().enumerate() {
        let share = if total > 0.0 { walked / total } else { 0.0 };
        constraints.push(PointConstraint {
            point,
            place: places[0].lerp(places[1], share),
            strength,
        });
        walked += lengths.get(place).copied().unwrap_or(0.0);
    }
    // Exactly there, without the rounding of the sum.
    if let Some(last) = constraints.last_mut() {
        last.place = places[1];
    }
    Ok(constraints)
}

/// The distances from each point of a line to the next, in unit lengths.
fn lengths(patch: &Patch, line: &[SurfacePoint]) -> Vec<f64> {
    let position = |point: &SurfacePoint| point.position(patch.unit_surface());
    let steps = line.windows(2);
    steps
        .map(|pair| position(&pair[0]).distance(position(&pair[1])))
        .collect()
}

/// The triangles that a point lies in or on the border of.
fn faces_at(mesh: &TriangleMesh, point: SurfacePoint) -> Vec<FaceId> {
    let corners = point.face.halfedges();
    let touched: Vec<usize> = (0..3).filter(|&k| point.barycentric[k] != 0.0).collect();
    match touched[..] {
        [corner] => {
            let vertex = mesh.origin(corners[corner]);
            mesh.outgoing(vertex).map(HalfedgeId::face).collect()
        }
        [one, other] => {
            let side = corners[if other == (one + 1) % 3 { one } else { other }];
            let twin = mesh.twin(side).map(HalfedgeId::face);
            std::iter::once(point.face).chain(twin).collect()
        }
        _ => vec![point.face],
    }
}

/// A plane through the patch.
struct Section<'a> {
    patch: &'a Patch,
    start: DVec3,
    across: DVec3,
}

impl Section<'_> {
    fn side(&self, halfedge: HalfedgeId) -> f64 {
        let mesh = self.patch.mesh();
        let position = self.patch.unit_surface().position(mesh.origin(halfedge));
        (position - self.start).dot(self.across)
    }

    /// Where the plane crosses a side of a triangle; a vertex in the plane counts as above it, so
    /// that a triangle has either two crossed sides or none.
    fn crossing(&self, halfedge: HalfedgeId) -> Option<SurfacePoint> {
        let [from, to] = [halfedge, halfedge.next()].map(|h| self.side(h));
        if (from >= 0.0) == (to >= 0.0) {
            return None;
        }
        Some(SurfacePoint::on_halfedge(halfedge, from / (from - to)))
    }

    /// The crossings from the side `exit` of the first triangle on, up to one of the triangles
    /// `ends`.
    fn walk(&self, mut exit: HalfedgeId, ends: &[FaceId]) -> Option<Vec<SurfacePoint>> {
        let mesh = self.patch.mesh();
        let mut points = vec![self.crossing(exit)?];
        // A section that comes back to its start has visited no triangle twice before.
        for _ in 0..mesh.face_count() {
            let entry = mesh.twin(exit)?;
            if ends.contains(&entry.face()) {
                return Some(points);
            }
            let others = [entry.next(), entry.previous()];
            let (next, point) = others
                .into_iter()
                .find_map(|side| Some((side, self.crossing(side)?)))?;
            points.push(point);
            exit = next;
        }
        None
    }
}
