//! The built-in surface of `graticule demo`: a theatre mask with open eyes and mouth.
//!
//! It has what makes flattening worth a picture: strong curvature of both signs (nose, sockets,
//! lips), one outer boundary and three holes. Angles and exponentials come from `libm`, so that
//! every machine gets the same bytes.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use graticule::mesh::{MeshError, Surface, TriangleMesh, VertexId};

/// Rounds of smoothing that even out the triangles around the holes.
const SMOOTHING_ROUNDS: usize = 30;

/// Half the width of the mask over half its height.
const WIDTH: f64 = 0.76;

/// An opening: an ellipse in the plane that the mask is lifted from.
struct Opening {
    center: DVec2,
    radii: DVec2,
}

/// The eyes and the mouth.
const OPENINGS: [Opening; 3] = [
    Opening {
        center: DVec2::new(-0.3, 0.2),
        radii: DVec2::new(0.14, 0.075),
    },
    Opening {
        center: DVec2::new(0.3, 0.2),
        radii: DVec2::new(0.14, 0.075),
    },
    Opening {
        center: DVec2::new(0.0, -0.47),
        radii: DVec2::new(0.21, 0.045),
    },
];

/// A smooth hill on the mask: height, centre, half-widths.
struct Hill(f64, DVec2, DVec2);

/// The features, those off the middle on the right side only: the left one mirrors it.
const HILLS: [Hill; 9] = [
    Hill(0.20, DVec2::new(0.0, -0.10), DVec2::new(0.085, 0.13)), // tip of the nose
    Hill(0.11, DVec2::new(0.0, 0.16), DVec2::new(0.07, 0.22)),   // bridge of the nose
    Hill(0.06, DVec2::new(0.09, -0.16), DVec2::new(0.05, 0.05)), // nostrils
    Hill(-0.15, DVec2::new(0.3, 0.2), DVec2::new(0.19, 0.12)),   // sockets
    Hill(0.10, DVec2::new(0.3, 0.40), DVec2::new(0.22, 0.065)),  // brows
    Hill(0.10, DVec2::new(0.42, -0.14), DVec2::new(0.15, 0.13)), // cheeks
    Hill(0.075, DVec2::new(0.0, -0.385), DVec2::new(0.20, 0.045)), // upper lip
    Hill(0.085, DVec2::new(0.0, -0.565), DVec2::new(0.17, 0.05)), // lower lip
    Hill(0.12, DVec2::new(0.0, -0.80), DVec2::new(0.17, 0.10)),  // chin
];

/// The mask from `rings` rings of triangles, about `6 rings²` of them.
pub(crate) fn mask(rings: u32) -> Result<Surface, MeshError> {
    let (points, triangles) = with_openings(&disk(rings));
    let mesh = TriangleMesh::new(points.len(), &triangles)?;
    let points = smoothed(&mesh, points);
    let positions = points.iter().map(|&p| lifted(p)).collect();
    Surface::from_triangles(positions, &triangles)
}

/// A mesh of the plane.
type Plane = (Vec<DVec2>, Vec<[u32; 3]>);

/// The disk of the mask's outline from rings around a middle vertex; ring `k` has `6k` vertices.
fn disk(rings: u32) -> Plane {
    let vertex = |ring: u32, step: u32| match ring {
        0 => 0,
        _ => 1 + 3 * ring * (ring - 1) + step % (6 * ring),
    };
    let mut points = vec![DVec2::ZERO];
    let mut triangles = Vec::new();
    for ring in 1..=rings {
        let radius = f64::from(ring) / f64::from(rings);
        for step in 0..6 * ring {
            let (sin, cos) = libm::sincos(TAU * f64::from(step) / f64::from(6 * ring));
            points.push(DVec2::new(WIDTH * cos, sin) * radius);
            let (sector, within) = (step / ring, step % ring);
            let inside = vertex(ring - 1, sector * (ring - 1) + within);
            triangles.push([inside, vertex(ring, step), vertex(ring, step + 1)]);
            if within + 1 < ring {
                let next = vertex(ring - 1, sector * (ring - 1) + within + 1);
                triangles.push([inside, vertex(ring, step + 1), next]);
            }
        }
    }
    (points, triangles)
}

impl Opening {
    /// Below 1 inside the opening, 1 on its rim.
    fn level(&self, point: DVec2) -> f64 {
        ((point - self.center) / self.radii).length()
    }

    /// The point of the rim in the direction of `point` from the centre.
    fn rim(&self, point: DVec2) -> DVec2 {
        self.center + (point - self.center) / self.level(point)
    }
}

/// The opening nearest to a point.
fn nearest_opening(point: DVec2) -> &'static Opening {
    let [mut nearest, rest @ ..] = OPENINGS.each_ref();
    for opening in rest {
        if opening.level(point) < nearest.level(point) {
            nearest = opening;
        }
    }
    nearest
}

/// The mesh without the triangles that reach into an opening, vertices numbered anew.
fn with_openings((points, triangles): &Plane) -> Plane {
    let outside = |&vertex: &u32| {
        let point = points[vertex as usize];
        nearest_opening(point).level(point) >= 1.0
    };
    let mut kept = Vec::new();
    let mut new_numbers = vec![None; points.len()];
    let mut number = |vertex: u32| {
        *new_numbers[vertex as usize].get_or_insert_with(|| {
            kept.push(points[vertex as usize]);
            kept.len() as u32 - 1
        })
    };
    let triangles = triangles
        .iter()
        .filter(|triangle| triangle.iter().all(outside))
        .map(|triangle| triangle.map(&mut number))
        .collect();
    (kept, triangles)
}

/// Vertices around the openings moved onto their rims, the others evened out between them.
fn smoothed(mesh: &TriangleMesh, mut points: Vec<DVec2>) -> Vec<DVec2> {
    for _ in 0..SMOOTHING_ROUNDS {
        points = mesh
            .vertices()
            .map(|vertex| relaxed(mesh, &points, vertex))
            .collect();
    }
    points
}

/// Where smoothing moves a vertex: the mean of its neighbours, on the rim that it belongs to.
fn relaxed(mesh: &TriangleMesh, points: &[DVec2], vertex: VertexId) -> DVec2 {
    let at = |vertex: VertexId| points[vertex.0 as usize];
    let mean = |ends: &[VertexId]| ends.iter().map(|&v| at(v)).sum::<DVec2>() / ends.len() as f64;
    let neighbors: Vec<VertexId> = mesh.neighbors(vertex).collect();
    let is_outline = (at(vertex) / DVec2::new(WIDTH, 1.0)).length() > 0.97;
    match neighbors[..] {
        _ if !mesh.is_boundary_vertex(vertex) => mean(&neighbors),
        [next, .., previous] if !is_outline => {
            nearest_opening(at(vertex)).rim(mean(&[next, previous]))
        }
        _ => at(vertex),
    }
}

/// The point of the mask above a point of the plane.
fn lifted(point: DVec2) -> DVec3 {
    let radius = (point / DVec2::new(WIDTH, 1.0)).length();
    let shell = 0.62 * (1.0 - 0.8 * radius * radius).sqrt();
    let hills: f64 = HILLS.iter().map(|hill| hill.height(point)).sum();
    point.extend(shell + hills)
}

impl Hill {
    /// Its height above a point, mirrored hills included.
    fn height(&self, point: DVec2) -> f64 {
        let Self(height, center, widths) = *self;
        let bell = |x: f64| {
            let offset = (DVec2::new(x, point.y) - center) / widths;
            height * libm::exp(-offset.length_squared())
        };
        if center.x == 0.0 {
            bell(point.x)
        } else {
            bell(point.x) + bell(-point.x)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mask_is_one_patch_with_three_holes_and_faces_its_viewer() {
        let surface = mask(40).unwrap();
        let mesh = surface.mesh();
        let characteristic =
            mesh.vertex_count() as i64 - mesh.edge_count() as i64 + mesh.face_count() as i64;
        assert_eq!(characteristic, 1 - 3);
        for face in mesh.faces() {
            let [a, b, c] = surface.corner_positions(face);
            assert!((b - a).cross(c - a).z > 0.0, "{face} is seen from behind");
        }
    }

    #[test]
    fn every_opening_has_a_smooth_rim() {
        let surface = mask(40).unwrap();
        let mesh = surface.mesh();
        let mut on_rims = 0;
        for vertex in mesh.vertices().filter(|&v| mesh.is_boundary_vertex(v)) {
            let point = surface.position(vertex).truncate();
            let level = nearest_opening(point).level(point);
            let outline = (point / DVec2::new(WIDTH, 1.0)).length();
            assert!((level - 1.0).abs() < 1e-9 || (outline - 1.0).abs() < 1e-9);
            on_rims += usize::from(level < 1.5);
        }
        assert!(on_rims > 30);
    }
}
