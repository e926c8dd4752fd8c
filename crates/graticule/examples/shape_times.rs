//! Time and outcome of shaping and comparing quad meshes of known surfaces:
//! `cargo run --release --example shape_times`.
#![allow(clippy::print_stdout)] // its whole purpose

use std::time::Instant;

use graticule::geometry::TriangleTree;
use graticule::measure::{compare_to_reference, measure_quads};
use graticule::mesh::{PolygonSoup, Polygons, Surface, SurfacePoint};
use graticule::quads::{Net, ShapeOptions, shape};
use graticule::watch::Watch;
use graticule_fixtures::{Fixture, QuadFixture, icosphere, quad_cube, quad_torus, torus};

fn main() {
    let sphere = quad_cube(41).map(glam::DVec3::normalize);
    report("sphere", icosphere(6), &sphere, 0.008);
    report("tangled sphere", icosphere(6), &sphere, 0.02);
    let quads = quad_torus(1.0, 0.4, 160, 64);
    report("torus", torus(1.0, 0.4, 320, 160), &quads, 0.012);
}

/// Shapes a mesh of the surface whose vertices were moved at random by up to `jitter`.
fn report(name: &str, surface: Fixture, mesh: &QuadFixture, jitter: f64) {
    let surface =
        Surface::from_triangles(surface.positions, &surface.triangles).expect("a fixture is sound");
    let triangles = surface.mesh().face_count();
    println!(
        "{name}: {} quads on {triangles} triangles",
        mesh.quads.len()
    );
    let start = Instant::now();
    let tree = TriangleTree::of_surface(&surface);
    println!("  tree       {:.3} s", start.elapsed().as_secs_f64());
    let jittered = mesh.clone().jittered(jitter, 1);
    let closest = jittered.positions.iter().filter_map(|&p| tree.closest(p));
    let origins: Vec<SurfacePoint> = closest.collect();
    let polygons: Polygons = mesh.quads.iter().map(|quad| &quad[..]).collect();
    let net = Net {
        surface: &surface,
        features: &[],
        polygons: &polygons,
        feature_edges: &[],
    };
    let start = Instant::now();
    let shaped = shape(&net, &origins, &ShapeOptions::default(), &Watch::new())
        .expect("points of the surface");
    println!("  shape      {:.3} s", start.elapsed().as_secs_f64());
    println!("  {:?}", shaped.report);
    let soup = PolygonSoup {
        positions: shaped
            .origins
            .iter()
            .map(|origin| origin.position(&surface))
            .collect(),
        polygons,
        ..PolygonSoup::default()
    };
    let start = Instant::now();
    let measure = measure_quads(&soup, &Watch::new()).expect("ordinary sizes");
    println!("  measure    {:.3} s", start.elapsed().as_secs_f64());
    println!("  {:?}", measure.quality);
    let start = Instant::now();
    let compared = compare_to_reference(&soup, &surface, &Watch::new()).expect("ordinary sizes");
    println!("  comparison {:.3} s", start.elapsed().as_secs_f64());
    println!("  {:?}", compared.distance);
}
