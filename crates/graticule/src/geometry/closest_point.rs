//! The point of a surface closest to a point in space.
//!
//! [`TriangleTree`] finds it among all triangles; [`slide_towards`] walks from a point of the
//! surface to a nearer one as long as there is one, and so never leaps to another sheet.

use glam::DVec3;
use rayon::prelude::*;

use super::normals::unit_normal;
use super::{Bounds, BoxTree};
use crate::mesh::{Element, FaceId, HalfedgeId, Surface, SurfacePoint};

/// Triangles in space, arranged so that the closest point on any of them is found quickly.
///
/// The triangles need not hang together. Built in O(n log n), in parallel; a query takes O(log n)
/// for a point near the triangles. All answers are the same for any number of threads. Coordinates
/// from 1e-70 to 1e70.
#[derive(Clone, Debug)]
pub struct TriangleTree {
    triangles: Vec<[DVec3; 3]>,
    normals: Vec<DVec3>,
    tree: BoxTree<3>,
}

impl TriangleTree {
    /// A tree of these triangles, which must have finite corners.
    #[must_use]
    pub fn new(triangles: Vec<[DVec3; 3]>) -> Self {
        let boxes: Vec<_> = triangles
            .par_iter()
            .map(|corners| Bounds::<3>::around(corners))
            .collect();
        Self {
            normals: triangles.par_iter().copied().map(unit_normal).collect(),
            tree: BoxTree::new(&boxes),
            triangles,
        }
    }

    /// A tree of the triangles of a surface, under the same numbers.
    #[must_use]
    pub fn of_surface(surface: &Surface) -> Self {
        let faces = surface.mesh().faces();
        Self::new(faces.map(|face| surface.corner_positions(face)).collect())
    }

    /// The triangles.
    #[must_use]
    pub fn triangles(&self) -> &[[DVec3; 3]] {
        &self.triangles
    }

    /// The unit normal of each triangle; zero for one without area.
    #[must_use]
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// The point closest to `point` on any triangle; `None` without triangles.
    #[must_use]
    pub fn closest(&self, point: DVec3) -> Option<SurfacePoint> {
        self.closest_among(point, f64::INFINITY, |_| true)
    }

    /// The closest point within `reach` of `point` on a triangle that faces the same way as
    /// `normal`, which tells the two sides of a thin sheet apart; where there is none, the closest
    /// point on any triangle.
    #[must_use]
    pub fn closest_facing(&self, point: DVec3, normal: DVec3, reach: f64) -> Option<SurfacePoint> {
        let faces_alike = |triangle: usize| self.normals[triangle].dot(normal) > 0.0;
        // The limit is exclusive.
        let limit = (reach * reach).next_up();
        self.closest_among(point, limit, faces_alike)
            .or_else(|| self.closest(point))
    }

    fn closest_among(
        &self,
        point: DVec3,
        limit: f64,
        counts: impl Fn(usize) -> bool,
    ) -> Option<SurfacePoint> {
        let squared_distance = |triangle: usize| {
            if !counts(triangle) {
                return f64::INFINITY;
            }
            let corners = self.triangles[triangle];
            let place = closest_on_triangle(corners, point);
            weighted(corners, place).distance_squared(point)
        };
        let found = self.tree.nearest(point.into(), limit, squared_distance);
        found.map(|(triangle, _)| SurfacePoint {
            face: FaceId::from_index(triangle),
            barycentric: closest_on_triangle(self.triangles[triangle], point),
        })
    }
}

fn weighted([a, b, c]: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    a * u + b * v + c * w
}

/// The barycentric coordinates of the point of a triangle closest to `point`, by the regions of
/// its corners, sides and inside (C. Ericson, *Real-Time Collision Detection*, 2005, §5.1.5).
pub(crate) fn closest_on_triangle([a, b, c]: [DVec3; 3], point: DVec3) -> [f64; 3] {
    let [ab, ac] = [b - a, c - a];
    let [from_a, from_b, from_c] = [point - a, point - b, point - c];
    let [along_ab, along_ac] = [ab.dot(from_a), ac.dot(from_a)];
    if along_ab <= 0.0 && along_ac <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let [b_along_ab, b_along_ac] = [ab.dot(from_b), ac.dot(from_b)];
    if b_along_ab >= 0.0 && b_along_ac <= b_along_ab {
        return [0.0, 1.0, 0.0];
    }
    let [c_along_ab, c_along_ac] = [ab.dot(from_c), ac.dot(from_c)];
    if c_along_ac >= 0.0 && c_along_ab <= c_along_ac {
        return [0.0, 0.0, 1.0];
    }
    let for_c = along_ab * b_along_ac - b_along_ab * along_ac;
    // Without the last condition a side without length would answer for the others.
    if for_c <= 0.0 && along_ab >= 0.0 && b_along_ab <= 0.0 && along_ab > b_along_ab {
        let share = part(along_ab, -b_along_ab);
        return [1.0 - share, share, 0.0];
    }
    let for_b = c_along_ab * along_ac - along_ab * c_along_ac;
    if for_b <= 0.0 && along_ac >= 0.0 && c_along_ac <= 0.0 {
        let share = part(along_ac, -c_along_ac);
        return [1.0 - share, 0.0, share];
    }
    let for_a = b_along_ab * c_along_ac - c_along_ab * b_along_ac;
    let [towards_c, towards_b] = [b_along_ac - b_along_ab, c_along_ab - c_along_ac];
    if for_a <= 0.0 && towards_c >= 0.0 && towards_b >= 0.0 {
        let share = part(towards_c, towards_b);
        return [0.0, 1.0 - share, share];
    }
    let sum = for_a + for_b + for_c;
    let [b, c] = [for_b / sum, for_c / sum];
    [(1.0 - b - c).max(0.0), b, c]
}

/// The share of `first` in the sum of two numbers that are not negative; 0 where both vanish.
fn part(first: f64, second: f64) -> f64 {
    first / (first + second).max(f64::MIN_POSITIVE)
}

/// How far along the segment, in `0.0..=1.0`, its point closest to `point` lies.
pub(crate) fn closest_on_segment([from, to]: [DVec3; 2], point: DVec3) -> f64 {
    let along = to - from;
    let share = (point - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
    share.clamp(0.0, 1.0)
}

/// The point of the surface that is reached from `start` by walking across sides and corners to
/// ever nearer triangles: no triangle beside it is nearer to `target`.
///
/// The way leads over neighbours only, so that the point stays on the sheet it was on. Cost: a few
/// triangles for each one walked over.
pub(crate) fn slide_towards(surface: &Surface, start: SurfacePoint, target: DVec3) -> SurfacePoint {
    slide_within(surface, start, target, |_| true).0
}

/// As [`slide_towards`], but only across those sides that `may_cross` lets pass; also whether a
/// side that may not be crossed is where the way ended.
pub(crate) fn slide_within(
    surface: &Surface,
    start: SurfacePoint,
    target: DVec3,
    may_cross: impl Fn(HalfedgeId) -> bool,
) -> (SurfacePoint, bool) {
    let on_face = |face: FaceId| {
        let corners = surface.corner_positions(face);
        let barycentric = closest_on_triangle(corners, target);
        let distance = weighted(corners, barycentric).distance_squared(target);
        (SurfacePoint { face, barycentric }, distance)
    };
    let (mut here, mut least) = on_face(start.face);
    loop {
        let mut nearest = None;
        let is_held = show_faces_at(surface, here, &may_cross, |face| {
            let (point, distance) = on_face(face);
            if distance < least {
                least = distance;
                nearest = Some(point);
            }
        });
        match nearest {
            Some(point) => here = point,
            None => return (here, is_held),
        }
    }
}

/// Shows the other triangles that a point of a side or corner belongs to, as far as they are
/// reached around it; returns whether a side that may not be crossed kept any away.
fn show_faces_at(
    surface: &Surface,
    point: SurfacePoint,
    may_cross: impl Fn(HalfedgeId) -> bool,
    mut show: impl FnMut(FaceId),
) -> bool {
    let mesh = surface.mesh();
    let sides = point.face.halfedges();
    let is_zero = point.barycentric.map(|weight| weight <= 0.0);
    let mut is_held = false;
    let mut beyond = |side: HalfedgeId| {
        let twin = mesh.twin(side)?;
        let passes = may_cross(side);
        is_held |= !passes;
        passes.then_some(twin)
    };
    if let Some(corner) = (0..3).find(|&k| is_zero[(k + 1) % 3] && is_zero[(k + 2) % 3]) {
        let mut around = sides[corner];
        while let Some(left) = beyond(around.previous()).filter(|left| left.face() != point.face) {
            show(left.face());
            around = left;
        }
        let went_round = mesh
            .turn_left(around)
            .is_some_and(|left| left.face() == point.face);
        let mut around = sides[corner];
        while !went_round && let Some(twin) = beyond(around) {
            show(twin.face());
            around = twin.next();
        }
    } else if let Some(side) = (0..3).find(|&k| is_zero[(k + 2) % 3])
        && let Some(twin) = beyond(sides[side])
    {
        show(twin.face());
    }
    is_held
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::{Fixture, Noise, bumpy_patch, grid, icosphere, torus};

    fn surface(fixture: Fixture) -> Surface {
        Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
    }

    fn random_point(noise: &mut Noise) -> DVec3 {
        DVec3::new(noise.signed(), noise.signed(), noise.signed())
    }

    /// By minimising over a fine grid of the triangle, then over ever smaller ones around the best.
    fn closest_by_search([a, b, c]: [DVec3; 3], point: DVec3) -> f64 {
        let at = |v: f64, w: f64| a + (b - a) * v + (c - a) * w;
        let (mut best, mut step) = ([0.3, 0.3], 0.5);
        while step > 1e-12 {
            let around = (-4..=4).flat_map(|i| (-4..=4).map(move |j| (i, j)));
            let candidates = around.map(|(i, j)| {
                let v = (best[0] + f64::from(i) * step / 4.0).clamp(0.0, 1.0);
                let w = (best[1] + f64::from(j) * step / 4.0).clamp(0.0, 1.0 - v);
                [v, w]
            });
            let distance = |&[v, w]: &[f64; 2]| at(v, w).distance(point);
            best = candidates
                .min_by(|x, y| distance(x).total_cmp(&distance(y)))
                .unwrap();
            step *= 0.7;
        }
        at(best[0], best[1]).distance(point)
    }

    #[test]
    fn the_closest_point_of_a_triangle_is_as_near_as_a_search_finds() {
        let mut noise = Noise::new(1);
        for round in 0..300 {
            let mut corners = [0; 3].map(|_| random_point(&mut noise));
            if round % 3 == 0 {
                // A needle.
                corners[2] = corners[0] + (corners[1] - corners[0]) * 0.7 + corners[2] * 1e-7;
            }
            let point = random_point(&mut noise) * 2.0;
            let place = closest_on_triangle(corners, point);
            assert!(place.iter().all(|weight| (0.0..=1.0).contains(weight)));
            let distance = weighted(corners, place).distance(point);
            assert!(distance <= closest_by_search(corners, point) + 1e-9);
        }
    }

    #[test]
    fn triangles_without_area_have_closest_points_too() {
        let [a, b] = [DVec3::ZERO, DVec3::X];
        for corners in [[a, a, a], [a, a, b], [a, b, b], [a, b, a], [a, b, b * 0.5]] {
            let place = closest_on_triangle(corners, DVec3::new(0.25, 1.0, 0.0));
            let expected = if corners[1..].contains(&b) {
                1.0
            } else {
                1.0625_f64.sqrt()
            };
            let distance = weighted(corners, place).distance(DVec3::new(0.25, 1.0, 0.0));
            assert!(
                (distance - expected).abs() < 1e-12,
                "{corners:?}: {place:?}"
            );
        }
    }

    #[test]
    fn the_tree_finds_what_looking_at_every_triangle_finds() {
        let surface = surface(torus(1.0, 0.4, 24, 12));
        let tree = TriangleTree::of_surface(&surface);
        let mut noise = Noise::new(2);
        for _ in 0..200 {
            let point = random_point(&mut noise) * 2.0;
            let found = tree.closest(point).unwrap().position(&surface);
            let distances = surface.mesh().faces().map(|face| {
                let corners = surface.corner_positions(face);
                weighted(corners, closest_on_triangle(corners, point)).distance(point)
            });
            let least = distances.fold(f64::INFINITY, f64::min);
            assert!((found.distance(point) - least).abs() < 1e-14);
        }
        assert_eq!(TriangleTree::new(Vec::new()).closest(DVec3::ZERO), None);
    }

    #[test]
    fn the_normal_tells_the_sides_of_a_sheet_apart() {
        let sheet = |z: f64, turned: bool| {
            let [a, b, c] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, z));
            if turned { [a, c, b] } else { [a, b, c] }
        };
        let tree = TriangleTree::new(vec![sheet(0.0, true), sheet(0.01, false)]);
        let point = DVec3::new(0.2, 0.2, 0.008);
        let face = |normal: DVec3, reach: f64| {
            let found = tree.closest_facing(point, normal, reach);
            found.unwrap().face
        };
        assert_eq!(face(DVec3::Z, 1.0), FaceId(1));
        assert_eq!(face(-DVec3::Z, 1.0), FaceId(0));
        assert_eq!(face(-DVec3::Z, 0.001), FaceId(1));
    }

    #[test]
    fn sliding_reaches_the_closest_point_of_a_smooth_surface() {
        let surface = surface(icosphere(4));
        let tree = TriangleTree::of_surface(&surface);
        let mut noise = Noise::new(4);
        for face in surface.mesh().faces().step_by(37) {
            let start = SurfacePoint {
                face,
                barycentric: [1.0 / 3.0; 3],
            };
            // Outside, where a convex shape has no other nearest point.
            let moved = start.position(&surface) + random_point(&mut noise) * 0.5;
            let target = moved.normalize() * 1.3;
            let reached = slide_towards(&surface, start, target).position(&surface);
            let closest = tree.closest(target).unwrap().position(&surface);
            assert!((reached.distance(target) - closest.distance(target)).abs() < 1e-12);
        }
    }

    #[test]
    fn sliding_is_held_by_sides_that_may_not_be_crossed() {
        let surface = surface(grid(2.0, 1.0, 8, 4));
        let mesh = surface.mesh();
        let on_wall = |vertex| (surface.position(vertex).x - 1.0).abs() < 1e-12;
        let is_wall = |side: HalfedgeId| mesh.ends(side).into_iter().all(on_wall);
        let start = TriangleTree::of_surface(&surface).closest(DVec3::new(0.3, 0.4, 0.0));
        for y in [0.4, 0.5, 0.55] {
            let target = DVec3::new(1.7, y, 0.1);
            let (point, is_held) = slide_within(&surface, start.unwrap(), target, |s| !is_wall(s));
            assert!(is_held);
            assert!(point.position(&surface).distance(DVec3::new(1.0, y, 0.0)) < 1e-12);
            let free = slide_within(&surface, start.unwrap(), target, |_| true);
            assert!(free.0.position(&surface).distance(DVec3::new(1.7, y, 0.0)) < 1e-12);
            assert!(!free.1);
        }
    }

    #[test]
    fn sliding_stops_at_the_boundary() {
        let surface = surface(bumpy_patch(8, 3));
        let start = SurfacePoint {
            face: FaceId(0),
            barycentric: [1.0 / 3.0; 3],
        };
        let reached = slide_towards(&surface, start, DVec3::X * 50.0);
        let mesh = surface.mesh();
        let sides = reached.face.halfedges();
        assert!(
            sides
                .iter()
                .any(|&side| mesh.is_boundary_vertex(mesh.origin(side)))
        );
    }
}
