//! `graticule parameterize`.

use graticule_fixtures::{grid, icosphere, torus};
use serde_json::Value;

use crate::bench::{Bench, has_content};

#[test]
fn coordinates_of_a_sphere_are_written_with_all_that_is_singular() {
    let bench = Bench::with(&icosphere(4));
    bench.succeed(
        "parameterize patch.obj -o out.obj --chart-size 6 --integers integers.json --report \
         report.json --picture picture.png",
    );
    let result = &bench.json("report.json")["result"];
    assert_eq!(result["field_singular_faces"], 8);
    assert_eq!(result["inverted_faces"], 0);
    assert_eq!(result["field"]["euler_characteristic"], 2);
    assert!(has_content(&bench.path("picture.png")));
    let integers = bench.json("integers.json");
    let triangles = integers["triangles"].as_array().unwrap();
    assert_eq!(triangles.len(), 5120);
    let of_kind = |kind: &str| triangles.iter().filter(|t| t["kind"] == kind).count();
    assert_eq!(of_kind("field-singular"), 8);
    assert_eq!(
        of_kind("phase-singular") as u64,
        result["phase_singular_faces"].as_u64().unwrap()
    );
    let closed = triangles.iter().filter(|t| t["kind"] == "regular");
    let transitions = closed.flat_map(|t| t["transitions"].as_array().unwrap());
    assert!(transitions.filter(|t| t.is_array()).count() > 15_000);
    assert!(
        bench
            .read("out.obj")
            .lines()
            .any(|line| line.starts_with("vt "))
    );
}

#[test]
fn every_method_and_energy_covers_a_torus() {
    let bench = Bench::with(&torus(2.0, 0.7, 40, 16));
    for options in [
        "--method diffusion",
        "--method newton --energy edge",
        "--own-triangles --no-refine --no-untangle",
        "--chart-count 40 --curl-correction",
        "--chart-length 0.9 --boundary free --feature-angle 180",
    ] {
        bench.succeed(&format!(
            "parameterize patch.obj -o out.ply {options} --report report.json"
        ));
        let result = &bench.json("report.json")["result"];
        let share = result["singular_share"].as_f64().unwrap();
        assert!(share < 0.05, "{options}: {share}");
    }
    let energy = |options: &str| -> Value {
        bench.succeed(&format!(
            "parameterize patch.obj -o out.glb {options} --report r.json"
        ));
        bench.json("r.json")["result"]["minimization"].clone()
    };
    assert_eq!(energy("--seed 3"), energy("--seed 3 --threads 1"));
}

#[test]
fn a_rectangle_is_its_own_map() {
    let bench = Bench::with(&grid(3.0, 2.0, 12, 8));
    bench.succeed("parameterize patch.obj -o out.obj --chart-length 1 --report report.json");
    let result = &bench.json("report.json")["result"];
    assert_eq!(result["singular_share"], 0.0);
    assert!((result["distortion"]["stretch"].as_f64().unwrap() - 1.0).abs() < 1e-6);
    bench.succeed("measure out.obj --report measured.json");
    assert_eq!(
        bench.json("measured.json")["measure"]["faces"]["flipped"],
        0
    );
}

#[test]
fn numbers_out_of_range_are_told_before_any_work() {
    let bench = Bench::new();
    for options in [
        "--chart-size 0",
        "--chart-size nan",
        "--chart-count -3",
        "--chart-size 5 --chart-length 2",
        "--method magic",
        "--curl-range 3",
        "--chart-angle 0",
        "--chart-angle 40 --curvature-radius 0",
        "--relaxations 2 --no-refine",
        "--halvings 99",
    ] {
        let run = bench.run(&format!("parameterize none.obj -o out.obj {options}"));
        assert_eq!(run.code, 2, "{options}: {}", run.stderr);
    }
    assert_eq!(bench.run("parameterize none.obj -o out.stl").code, 2);
}

#[test]
fn charts_have_the_sizes_of_a_file_or_fewer_degrees() {
    let bench = Bench::with(&grid(3.0, 2.0, 12, 8));
    let charts = |options: &str| {
        bench.succeed(&format!(
            "parameterize patch.obj -o out.obj --chart-length 1 {options} --report report.json"
        ));
        let report = bench.json("report.json");
        assert_eq!(report["measure"]["faces"]["flipped"], 0);
        report["result"]["charts"].as_f64().unwrap()
    };
    let vertices = bench
        .read("patch.obj")
        .lines()
        .filter(|line| line.starts_with("v "))
        .count();
    bench.write("halves.txt", &"0.5\n".repeat(vertices));
    assert!((charts("--sizing halves.txt") - 24.0).abs() < 1e-6);
    // A plane does not bend.
    assert!((charts("--chart-angle 20") - 6.0).abs() < 1e-6);
    bench.write("short.txt", "1 1 1");
    bench.write("bad.txt", &"-1 ".repeat(vertices));
    for (sizing, fact) in [
        ("short.txt", "3 numbers"),
        ("bad.txt", "number 1 is -1"),
        ("none.txt", "none.txt"),
        ("colors", "no colours"),
    ] {
        let told = bench.refuse(
            1,
            &format!("parameterize patch.obj -o o.obj --sizing {sizing}"),
        );
        assert!(told.contains(fact), "{told}");
    }
}
