use std::f64::consts::FRAC_PI_4;

use glam::{DVec2, DVec3};
use graticule_fixtures::{
    Fixture, Noise, QuadFixture, bumpy_patch, cube, grid, icosphere, quad_cube, quad_grid,
    quad_torus, torus,
};

use super::*;
use crate::geometry::{TriangleTree, dihedral_angles};
use crate::mesh::{FaceId, Polygons};
use crate::tolerance::LINE_CORNER_COSINE;

fn surface(fixture: Fixture) -> Surface {
    Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
}

/// A quad mesh on the closest points of a surface.
struct OnSurface {
    surface: Surface,
    features: Vec<EdgeId>,
    polygons: Polygons,
    feature_edges: Vec<[u32; 2]>,
    origins: Vec<SurfacePoint>,
}

impl OnSurface {
    fn new(surface: Surface, mesh: &QuadFixture) -> Self {
        let tree = TriangleTree::of_surface(&surface);
        let origins = mesh.positions.iter().map(|&p| tree.closest(p).unwrap());
        Self {
            origins: origins.collect(),
            polygons: mesh.quads.iter().map(|quad| &quad[..]).collect(),
            features: Vec::new(),
            feature_edges: Vec::new(),
            surface,
        }
    }

    fn shaped(&self, options: &ShapeOptions) -> Shaped {
        let net = Net {
            surface: &self.surface,
            features: &self.features,
            polygons: &self.polygons,
            feature_edges: &self.feature_edges,
        };
        shape(&net, &self.origins, options, &Watch::new()).unwrap()
    }

    fn positions(&self, origins: &[SurfacePoint]) -> Vec<DVec3> {
        origins
            .iter()
            .map(|origin| origin.position(&self.surface))
            .collect()
    }
}

fn jittered_sphere(jitter: f64) -> OnSurface {
    let mesh = quad_cube(8).map(|p| (p * FRAC_PI_4).map(libm::tan).normalize());
    OnSurface::new(surface(icosphere(4)), &mesh.jittered(jitter, 7))
}

fn is_near(x: f64, expected: f64) -> bool {
    (x - expected).abs() < 1e-12
}

fn jittered_box() -> OnSurface {
    let cells = 6;
    let mut noise = Noise::new(3);
    // Vertices on edges stay on their edge, those at corners in their corner.
    let mesh = quad_cube(cells).map(|p| {
        p.map(|x| {
            if is_near(x.abs(), 1.0) {
                x
            } else {
                x + 0.12 * noise.signed()
            }
        })
    });
    let shape = surface(cube().map(|p| 2.0 * p - 1.0).subdivided().subdivided());
    let angles = dihedral_angles(&shape);
    let mut on_surface = OnSurface::new(shape, &mesh);
    on_surface.features = angles
        .enumerate()
        .filter(|(_, angle)| **angle > 1.0)
        .map(|(edge, _)| edge)
        .collect();
    let sides = |p: DVec3| p.to_array().map(|x| is_near(x.abs(), 1.0));
    for quad in &mesh.quads {
        for (&a, &b) in quad.iter().zip(quad.iter().cycle().skip(1)) {
            let [first, second] = [a, b].map(|v| sides(mesh.positions[v as usize]));
            if (0..3).filter(|&axis| first[axis] && second[axis]).count() == 2 {
                on_surface.feature_edges.push([a, b]);
            }
        }
    }
    on_surface
}

#[test]
fn a_jittered_sphere_becomes_regular_again() {
    let shaped = jittered_sphere(0.06).shaped(&ShapeOptions::default());
    let ShapeReport { before, after, .. } = shaped.report;
    assert!(before.non_positive > 0 && after.non_positive == 0);
    assert!(after.least > 0.7 && after.mean > 0.95);
}

#[test]
fn inverted_quads_are_turned_back() {
    let shaped = jittered_sphere(0.11).shaped(&ShapeOptions::default());
    assert!(shaped.report.before.non_positive > 30);
    assert!(shaped.report.after.least > 0.2);
}

#[test]
fn a_jittered_torus_becomes_regular_again() {
    let shape = surface(torus(1.0, 0.4, 90, 45));
    let mesh = quad_torus(1.0, 0.4, 36, 16).jittered(0.05, 1);
    let on_surface = OnSurface::new(shape, &mesh);
    let report = on_surface.shaped(&ShapeOptions::default()).report;
    assert!(report.before.mean < 0.9);
    assert!(report.after.least > 0.8 && report.after.mean > 0.98);
}

#[test]
fn edges_and_corners_of_a_box_stay_where_they_are() {
    let on_surface = jittered_box();
    assert_eq!(on_surface.feature_edges.len(), 2 * 12 * 6);
    let shaped = on_surface.shaped(&ShapeOptions::default());
    assert!(shaped.report.after.least > 0.98);
    let [before, after] = [&on_surface.origins, &shaped.origins].map(|o| on_surface.positions(o));
    let on_faces = |p: DVec3| p.to_array().map(|x| is_near(x.abs(), 1.0));
    for (before, after) in before.into_iter().zip(after) {
        let kept = on_faces(before).into_iter().zip(on_faces(after));
        assert!(
            kept.into_iter().all(|(before, after)| after || !before),
            "{before} {after}"
        );
        if on_faces(before) == [true; 3] {
            assert_eq!(before, after);
        }
    }
}

#[test]
fn the_boundary_stays_on_the_boundary() {
    let rectangle = surface(grid(2.0, 1.0, 24, 12));
    let mut noise = Noise::new(9);
    let mesh = quad_grid(DVec2::new(2.0, 1.0), 10, 5).map(|p| {
        let inside = |x: f64, most: f64| x > 0.0 && x < most;
        let mut moved = |x: f64, most| {
            if inside(x, most) {
                x + 0.06 * noise.signed()
            } else {
                x
            }
        };
        DVec3::new(moved(p.x, 2.0), moved(p.y, 1.0), 0.0)
    });
    let on_surface = OnSurface::new(rectangle, &mesh);
    let shaped = on_surface.shaped(&ShapeOptions::default());
    assert!(shaped.report.after.least > 0.99);
    for (before, after) in mesh
        .positions
        .iter()
        .zip(on_surface.positions(&shaped.origins))
    {
        for (axis, most) in [(0, 2.0), (1, 1.0)] {
            if is_near(before[axis], 0.0) || is_near(before[axis], most) {
                assert!(is_near(before[axis], after[axis]));
            }
        }
    }
}

#[test]
fn long_quads_stay_long() {
    let shape = surface(torus(1.0, 0.4, 90, 45));
    let on_surface = OnSurface::new(shape, &quad_torus(1.0, 0.4, 60, 8).jittered(0.01, 4));
    let proportion = |shaped: &Shaped| {
        let positions = on_surface.positions(&shaped.origins);
        let lengths = on_surface.polygons.iter().map(|quad| {
            let at = |k: usize| positions[quad[k] as usize];
            at(0).distance(at(1)) / at(1).distance(at(2))
        });
        lengths.sum::<f64>() / on_surface.polygons.len() as f64
    };
    let shaped = on_surface.shaped(&ShapeOptions::default());
    let expected = (8.0 / 60.0) / 0.4;
    assert!(
        (proportion(&shaped) / expected - 1.0).abs() < 0.1,
        "{}",
        proportion(&shaped)
    );
    assert!(shaped.report.after.mean > 0.99);
}

#[test]
fn the_least_scaled_jacobian_never_falls() {
    for seed in 0..6_u32 {
        let mesh = quad_cube(5)
            .map(DVec3::normalize)
            .jittered(0.02 * f64::from(seed), seed.into());
        let on_surface = OnSurface::new(surface(icosphere(3)), &mesh);
        for sweeps in [0, 1, 4] {
            let options = ShapeOptions {
                sweeps,
                ..ShapeOptions::default()
            };
            let ShapeReport { before, after, .. } = on_surface.shaped(&options).report;
            assert!(after.least >= before.least, "{before:?} {after:?}");
        }
    }
}

#[test]
fn size_and_number_of_threads_change_nothing() {
    let on_surface = jittered_sphere(0.05);
    let expected = on_surface.shaped(&ShapeOptions::default());
    let larger = on_surface
        .surface
        .positions()
        .map(|&p| p * 2.0_f64.powi(40));
    let larger = Surface::new(on_surface.surface.shared_mesh(), larger).unwrap();
    let larger = OnSurface {
        surface: larger,
        ..jittered_sphere(0.05)
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(3)
        .build()
        .unwrap();
    assert_eq!(
        pool.install(|| larger.shaped(&ShapeOptions::default())),
        expected
    );
}

#[test]
fn polygons_of_all_kinds_take_part() {
    // A triangle and a pentagon beside quads.
    let patch = surface(bumpy_patch(10, 2).map(|p| p * DVec3::new(1.0, 1.0, 0.2)));
    let points = [
        [-0.5, -0.5],
        [0.0, -0.5],
        [0.5, -0.5],
        [-0.5, 0.0],
        [0.1, 0.1],
        [0.5, 0.0],
        [-0.5, 0.5],
        [0.0, 0.5],
        [0.6, 0.5],
    ];
    let positions = points.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
    let mesh = QuadFixture {
        positions,
        quads: Vec::new(),
    };
    let mut on_surface = OnSurface::new(patch, &mesh);
    let polygons: [&[u32]; 4] = [&[0, 1, 4, 3], &[1, 2, 5, 8, 4], &[3, 4, 7, 6], &[4, 8, 7]];
    on_surface.polygons = polygons.into_iter().collect();
    let shaped = on_surface.shaped(&ShapeOptions::default());
    assert!(shaped.report.after.least >= shaped.report.before.least);
    assert_eq!(shaped.report.moved_vertices, 1);
}

#[test]
fn hostile_meshes_are_shaped_or_refused() {
    let shape = surface(icosphere(1));
    let point = SurfacePoint {
        face: FaceId(0),
        barycentric: [1.0, 0.0, 0.0],
    };
    let at = |face: u32| SurfacePoint {
        face: FaceId(face),
        ..point
    };
    // A fan three times over one edge, a quad of one point, an unknown vertex, a repeated one.
    let polygons: [&[u32]; 7] = [
        &[0, 1, 2, 3],
        &[0, 1, 4, 5],
        &[1, 0, 6, 7],
        &[2, 2, 2, 2],
        &[0, 1, 99, 3],
        &[3, 3, 1, 2],
        &[5],
    ];
    let polygons: Polygons = polygons.into_iter().collect();
    let origins: Vec<_> = [0, 1, 2, 3, 4, 5, 6, 6].map(at).into();
    let net = Net {
        surface: &shape,
        features: &[EdgeId(9999)],
        polygons: &polygons,
        feature_edges: &[[0, 400], [1, 1]],
    };
    let run = |origins: &[SurfacePoint]| shape_of(&net, origins);
    let shaped = run(&origins).unwrap();
    assert!(shaped.report.after.least.is_finite());
    assert!(matches!(
        run(&[at(999)]),
        Err(ShapeError::NoSuchFace {
            vertex: 0,
            face: 999,
            ..
        })
    ));
    let wrong = SurfacePoint {
        barycentric: [f64::NAN, 0.5, 0.5],
        ..point
    };
    assert!(matches!(
        run(&[point, wrong]),
        Err(ShapeError::Weights { vertex: 1, .. })
    ));
}

fn shape_of(net: &Net<'_>, origins: &[SurfacePoint]) -> Result<Shaped, ShapeError> {
    shape(net, origins, &ShapeOptions::default(), &Watch::new())
}

#[test]
fn a_stopped_watch_stops_the_shaping() {
    let on_surface = jittered_sphere(0.05);
    let watch = Watch::new();
    watch.cancel_handle().cancel();
    let net = Net {
        surface: &on_surface.surface,
        features: &[],
        polygons: &on_surface.polygons,
        feature_edges: &[],
    };
    let stopped = shape(&net, &on_surface.origins, &ShapeOptions::default(), &watch);
    assert_eq!(stopped, Err(ShapeError::Stopped(Stopped::Cancelled)));
}

#[test]
fn no_two_vertices_of_a_group_share_a_polygon() {
    let soup = crate::mesh::PolygonSoup {
        positions: quad_cube(4).positions,
        polygons: quad_cube(4).quads.iter().map(|quad| &quad[..]).collect(),
        ..crate::mesh::PolygonSoup::default()
    };
    let mesh = crate::mesh::PolygonConnectivity::of(&soup);
    let groups = colors::independent_groups(&mesh, |vertex| vertex != 5);
    let mut group_of = vec![usize::MAX; mesh.vertex_count()];
    for (number, group) in groups.iter().enumerate() {
        for &vertex in group {
            group_of[vertex as usize] = number;
        }
    }
    assert_eq!(
        group_of
            .iter()
            .filter(|&&group| group == usize::MAX)
            .count(),
        1
    );
    for polygon in 0..mesh.polygon_count() {
        let mut groups: Vec<_> = mesh
            .vertices(polygon)
            .iter()
            .map(|&v| group_of[v as usize])
            .collect();
        groups.sort_unstable();
        groups.dedup();
        assert_eq!(groups.len(), 4);
    }
}

#[test]
fn vertices_slide_along_a_line_and_stop_before_its_corner() {
    let square = surface(grid(1.0, 1.0, 4, 4));
    let lines = Lines::new(&square, &[], LINE_CORNER_COSINE);
    let tree = TriangleTree::of_surface(&square);
    let start = tree.closest(DVec3::new(0.1, 0.0, 0.0)).unwrap();
    let halfedge = lines.halfedge_at(&square, start).unwrap();
    let slide = |x: f64, y: f64| {
        let target = DVec3::new(x, y, 0.0);
        lines
            .slide_towards(&square, halfedge, target)
            .position(&square)
    };
    assert!(slide(0.8, 0.3).distance(DVec3::X * 0.8) < 1e-12);
    // On the corner itself there would be no way back.
    let stop = slide(1.4, 0.9);
    assert!(
        stop.y.abs() < 1e-12 && (0.99..1.0).contains(&stop.x),
        "{stop}"
    );
    let corner = tree.closest(DVec3::ZERO).unwrap();
    assert_eq!(lines.halfedge_at(&square, corner), None);
    let inside = tree.closest(DVec3::new(0.4, 0.45, 0.0)).unwrap();
    assert_eq!(lines.halfedge_at(&square, inside), None);
}

#[test]
fn proportions_that_do_not_go_with_right_angles_give_way() {
    // A square whose net is warped: its quads have the proportions of a net that is not orthogonal.
    let warp = |p: DVec3| {
        let [x, y] = [p.x, p.y].map(|t| libm::sin(std::f64::consts::TAU * t));
        p + DVec3::new(0.1, -0.1, 0.0) * x * y
    };
    let mesh = quad_grid(DVec2::ONE, 16, 16).map(warp);
    let net = OnSurface::new(surface(grid(1.0, 1.0, 32, 32)), &mesh);
    let report = net.shaped(&ShapeOptions::default()).report;
    assert!(report.before.mean < 0.9, "{report:?}");
    assert!(report.after.mean > 0.99, "{report:?}");
}
