use std::ops::{Add, Mul, Sub};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::Carry;
use super::faces::Faces;
use crate::geometry::slide_within;
use crate::mesh::{CornerAttribute, HalfedgeId, NO_VALUE, PerEdge, Repaired, SurfacePoint};
use crate::tolerance;

/// Steps of the way from the middle of a polygon to a corner: few triangles are bent so much that
/// a straight way along them would lead astray.
const STEPS: u32 = 4;

/// Values that can be blended between corners.
pub(super) trait Blend:
    Copy + Send + Sync + PartialEq + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self>
{
    /// What a weighted mean is made to be.
    fn finished(self) -> Self;
    /// The size of a difference.
    fn size(self) -> f64;
}

impl Blend for DVec2 {
    fn finished(self) -> Self {
        self
    }

    fn size(self) -> f64 {
        self.abs().max_element()
    }
}

impl Blend for DVec3 {
    fn finished(self) -> Self {
        self.normalize_or_zero()
    }

    fn size(self) -> f64 {
        self.abs().max_element()
    }
}

/// An attribute of the input on the corners of its surface.
struct OnSurface<'a, T> {
    repaired: &'a Repaired,
    set: &'a CornerAttribute<T>,
    seams: PerEdge<bool>,
    has_seams: bool,
}

impl<'a, T: Blend> OnSurface<'a, T> {
    fn new(repaired: &'a Repaired, set: &'a CornerAttribute<T>) -> Self {
        let mesh = repaired.surface.mesh();
        let value = |corner: HalfedgeId| set.get(repaired.corner_sources[corner] as usize);
        let seams = PerEdge::from_fn(mesh.edge_count(), |edge| {
            let side = mesh.edge_halfedge(edge);
            mesh.twin(side).is_some_and(|twin| {
                value(side) != value(twin.next()) || value(side.next()) != value(twin)
            })
        });
        Self {
            has_seams: seams.iter().any(|&is_seam| is_seam),
            repaired,
            set,
            seams,
        }
    }

    /// The value at a point, blended within its triangle; `None` if a corner there has none.
    fn at(&self, point: SurfacePoint) -> Option<T> {
        let value = |corner| self.set.get(self.repaired.corner_sources[corner] as usize);
        let [Some(a), Some(b), Some(c)] = point.face.halfedges().map(value) else {
            return None;
        };
        Some(point.interpolate([a, b, c]).finished())
    }

    /// The value for a corner at `origin` of a polygon with this middle.
    fn at_corner(&self, middle: SurfacePoint, origin: SurfacePoint) -> Option<T> {
        if !self.has_seams {
            return self.at(origin);
        }
        let surface = &self.repaired.surface;
        let mesh = surface.mesh();
        let may_cross = |side: HalfedgeId| !self.seams[mesh.edge(side)];
        let [from, to] = [middle, origin].map(|point| point.position(surface));
        let mut point = middle;
        let mut is_held = false;
        for step in 1..=STEPS {
            let target = from.lerp(to, f64::from(step) / f64::from(STEPS));
            (point, is_held) = slide_within(surface, point, target, may_cross);
        }
        let gap = point.position(surface).distance(to);
        let arrived = gap <= tolerance::SAME_POINT * from.distance(to);
        // A way that ended short of the corner without a seam was led astray by the shape alone.
        self.at(if arrived || is_held { point } else { origin })
    }
}

/// The attribute at the corners of the new polygons.
pub(super) fn carry_corners<T: Blend>(
    carry: &Carry<'_>,
    faces: &Faces,
    set: &CornerAttribute<T>,
) -> CornerAttribute<T> {
    let on_surface = OnSurface::new(carry.repaired, set);
    let of_polygon = |polygon: usize| {
        let middle = faces.middle(polygon);
        let vertices = carry.polygons.vertices(polygon).iter();
        let value = |&vertex: &u32| on_surface.at_corner(middle?, carry.origins[vertex as usize]);
        vertices.map(value).collect::<Vec<_>>()
    };
    let polygons = (0..carry.polygons.len()).into_par_iter();
    let corners: Vec<Option<T>> = polygons.flat_map_iter(of_polygon).collect();
    share(&set.name, carry, &corners)
}

/// Gives corners at one vertex that differ by rounding only a common value.
fn share<T: Blend>(name: &str, carry: &Carry<'_>, corners: &[Option<T>]) -> CornerAttribute<T> {
    let largest = corners
        .iter()
        .flatten()
        .fold(0.0, |most: f64, value| most.max(value.size()));
    let near = tolerance::SAME_VALUE * largest;
    let mut values: Vec<T> = Vec::new();
    let mut known: Vec<Vec<u32>> = vec![Vec::new(); carry.origins.len()];
    let vertices = carry.polygons.corner_vertices();
    let corner_values = corners.iter().zip(vertices).map(|(corner, &vertex)| {
        let Some(value) = *corner else {
            return NO_VALUE;
        };
        let here = &mut known[vertex as usize];
        let is_same = |&&index: &&u32| (values[index as usize] - value).size() <= near;
        if let Some(&index) = here.iter().find(is_same) {
            return index;
        }
        here.push(values.len() as u32);
        values.push(value);
        values.len() as u32 - 1
    });
    let corner_values = corner_values.collect();
    CornerAttribute {
        name: name.into(),
        values,
        corner_values,
    }
}
