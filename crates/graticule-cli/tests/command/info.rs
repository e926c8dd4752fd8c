//! `graticule info`.

use graticule_fixtures::{annulus, cube, disk};

use crate::bench::Bench;

#[test]
fn counts_topology_and_sizes_are_told() {
    let bench = Bench::with(&annulus(0.5, 1.0, 12, 2));
    let run = bench.succeed("info patch.obj --report report.json");
    assert!(run.stdout.contains("2 boundary loops"), "{}", run.stdout);
    let report = bench.json("report.json");
    assert_eq!(report["input"]["vertices"], 36);
    assert_eq!(report["input"]["format"], "obj");
    let surface = &report["result"]["surface"];
    assert_eq!(surface["components"], 1);
    assert_eq!(surface["total"]["genus"], 0);
    assert_eq!(surface["total"]["boundary_loops"], 2);
    assert_eq!(surface["total"]["euler_characteristic"], 0);
    let area = surface["area"].as_f64().unwrap();
    assert!((area / 2.25 - 1.0).abs() < 0.01, "{area}");
}

#[test]
fn several_components_are_listed() {
    let bench = Bench::with(&cube().joined(&disk(2)));
    let run = bench.succeed("info patch.obj");
    assert!(run.stdout.contains("component 0"), "{}", run.stdout);
    assert!(run.stdout.contains("component 1"), "{}", run.stdout);
}

#[test]
fn a_defective_mesh_is_told_of_and_is_no_failure() {
    let bench = Bench::new();
    bench.write("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let run = bench.succeed("info nan.obj --report report.json");
    assert!(run.stdout.contains("no surface"), "{}", run.stdout);
    let report = bench.json("report.json");
    assert_eq!(report["result"]["sound"], false);
    assert!(report["result"]["refusal"].is_string());
    assert!(report["result"]["surface"].is_null());
}

#[test]
fn what_cannot_be_read_names_file_and_place() {
    let bench = Bench::new();
    bench.write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n");
    let fact = bench.refuse(1, "info bad.obj");
    assert!(
        fact.contains("bad.obj") && fact.contains("line 4") && fact.contains("99"),
        "{fact}"
    );
    let fact = bench.refuse(1, "info missing.obj");
    assert!(fact.contains("missing.obj"), "{fact}");
}
