//! `graticule measure`.

use graticule_fixtures::{bumpy_patch, cube};

use crate::bench::Bench;

/// A unit square of two triangles with texture coordinates of twice the width.
const STRETCHED: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 2 0\nvt 2 1\nvt 0 1\n\
    f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";

#[test]
fn a_known_map_has_its_known_figures() {
    let bench = Bench::new();
    bench.write("mesh.obj", STRETCHED);
    let run = bench.succeed("measure mesh.obj --report report.json");
    assert!(
        run.stdout.contains("quasi-conformal error"),
        "{}",
        run.stdout
    );
    let measure = &bench.json("report.json")["measure"];
    let mean = measure["distortion"]["quasi_conformal_error"]["mean"]
        .as_f64()
        .unwrap();
    assert!((mean - 2.0).abs() < 1e-12);
    assert_eq!(measure["faces"]["flipped"], 0);
    assert_eq!(measure["bijective"], true);
}

#[test]
fn a_flip_is_counted() {
    let bench = Bench::new();
    // The fan's middle lies outside its rim in the map.
    bench.write(
        "mesh.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
         vt 0.5 -1\nf 1/1 2/2 5/5\nf 2/2 3/3 5/5\nf 3/3 4/4 5/5\nf 4/4 1/1 5/5\n",
    );
    bench.succeed("measure mesh.obj --report report.json");
    let measure = &bench.json("report.json")["measure"];
    assert_eq!(measure["faces"]["flipped"], 1);
    assert_eq!(measure["bijective"], false);
}

#[test]
fn a_flat_mesh_is_measured_against_its_reference() {
    let bench = Bench::with(&bumpy_patch(4, 1));
    let flat = bumpy_patch(4, 1).map(|p| glam::DVec3::new(p.x, p.y, 0.0));
    bench.write("flat.obj", &flat.to_obj());
    let fact = bench.refuse(1, "measure flat.obj");
    assert!(fact.contains("no texture coordinates"), "{fact}");
    bench.succeed("measure flat.obj --reference patch.obj --report report.json");
    let mean = &bench.json("report.json")["measure"]["distortion"]["quasi_conformal_error"]["mean"];
    assert!(mean.as_f64().unwrap() > 1.0);
    bench.write("cube.obj", &cube().to_obj());
    bench.refuse(1, "measure flat.obj --reference cube.obj");
}

#[test]
fn a_set_that_is_not_there_is_told() {
    let bench = Bench::new();
    bench.write("mesh.obj", STRETCHED);
    bench.succeed("measure mesh.obj --uv-set 0");
    bench.refuse(1, "measure mesh.obj --uv-set 1");
    bench.refuse(1, "measure mesh.obj --uv-set lightmap");
}

/// The cube of two by two quads a side, its middle vertices pushed in by `depth`.
fn quad_cube_obj(depth: f64) -> String {
    let cube = graticule_fixtures::quad_cube(2).map(|p| {
        if (p.abs().element_sum() - 1.0).abs() < 1e-12 {
            p * (1.0 - depth)
        } else {
            p
        }
    });
    let vertices = cube
        .positions
        .iter()
        .map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let quads = cube.quads.iter().map(|quad| {
        let [a, b, c, d] = quad.map(|vertex| vertex + 1);
        format!("f {a} {b} {c} {d}\n")
    });
    vertices.chain(quads).collect()
}

#[test]
fn quads_are_measured_and_held_against_a_reference() {
    let bench = Bench::with(&cube().map(|p| 2.0 * p - 1.0).subdivided().subdivided());
    bench.write("quads.obj", &quad_cube_obj(0.1));
    let run = bench.succeed(
        "measure quads.obj --reference patch.obj --report report.json --picture quads.png",
    );
    assert!(run.stdout.contains("scaled Jacobian"), "{}", run.stdout);
    let report = bench.json("report.json");
    assert_eq!(report["result"]["quads"], true);
    let quads = &report["measure"]["quads"];
    assert_eq!(quads["polygons"]["quads"], 24);
    assert_eq!(quads["valences"]["irregular"], 8);
    assert_eq!(quads["connections"]["euler_characteristic"], 2);
    assert!(quads["quality"]["scaled_jacobian"]["min"].as_f64().unwrap() > 0.9);
    let reference = &report["measure"]["reference"];
    assert_eq!(reference["topology_kept"], true);
    let largest = reference["distance"]["max"].as_f64().unwrap();
    // A tenth of half the side, and the diagonal is 2 √3.
    assert!(
        (2.5..=100.0 * 0.1 / 12.0_f64.sqrt()).contains(&largest),
        "{largest}"
    );
    assert_eq!(reference["sharp_edges"]["carried_share"], 1.0);
    assert!(crate::bench::has_content(&bench.path("quads.png")));
}

#[test]
fn quads_with_texture_coordinates_are_measured_both_ways() {
    let bench = Bench::new();
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 2 0\nvt 2 1\nvt 0 1\n\
        f 1/1 2/2 3/3 4/4\n";
    bench.write("mesh.obj", text);
    bench.succeed("measure mesh.obj --report report.json --picture both.svg");
    let measure = &bench.json("report.json")["measure"];
    assert_eq!(measure["bijective"], true);
    assert_eq!(measure["quads"]["polygons"]["quad_share"], 1.0);
    assert!(measure["reference"].is_null());
}

#[test]
fn triangles_are_measured_as_polygons_when_asked_for() {
    let bench = Bench::with(&cube());
    let fact = bench.refuse(1, "measure patch.obj");
    assert!(fact.contains("no texture coordinates"), "{fact}");
    bench.succeed("measure patch.obj --quads --report report.json");
    let quads = &bench.json("report.json")["measure"]["quads"];
    assert_eq!(quads["polygons"]["triangles"], 12);
    assert!(quads["quality"].is_null());
    bench.refuse(1, "measure patch.obj --quads --uv-set 0");
}
