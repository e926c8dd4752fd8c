//! `graticule demo` and `graticule cite`.

use crate::bench::{Bench, has_content};

#[test]
fn the_demo_needs_no_file_and_runs_the_commands_that_it_shows() {
    let bench = Bench::new();
    let run = bench.succeed("demo --cells 48 --quads 400 --rings 30 --output-folder out");
    for name in ["teapot", "charts", "quads", "mask", "flat"] {
        let mesh = format!("{name}.obj");
        assert!(has_content(&bench.path("out").join(&mesh)), "{mesh}");
        assert!(run.stdout.contains(&mesh), "{}", run.stdout);
    }
    for name in ["charts.png", "quads.png", "flat.png", "report.json"] {
        assert!(has_content(&bench.path("out").join(name)), "{name}");
    }
    let charts = bench.json("out/charts.json");
    assert_eq!(charts["result"]["atlas"]["flipped"], 0);
    assert_eq!(charts["result"]["euler_characteristic"], 0);
    let quads = bench.json("out/quads.json");
    assert_eq!(quads["measure"]["quads"]["polygons"]["triangles"], 0);
    assert_eq!(quads["measure"]["reference"]["topology_kept"], true);
    let flat = bench.json("out/flat.json");
    assert_eq!(flat["measure"]["faces"]["flipped"], 0);
    assert_eq!(flat["measure"]["islands"]["boundary_loops"], 4);
    let commands = bench.json("out/report.json");
    let commands = commands["result"]["commands"].as_array().unwrap();
    assert_eq!(commands.len(), 3);
    for command in commands {
        assert!(run.stderr.contains(command.as_str().unwrap()));
    }
}

#[test]
fn the_demo_stops_where_its_time_is_over() {
    let bench = Bench::new();
    let run = bench.run("demo --max-seconds 0.05 --output-folder out");
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("error: "), "{}", run.stderr);
    assert!(!has_content(&bench.path("out").join("report.json")));
}

#[test]
fn a_folder_that_cannot_be_made_is_told_first() {
    let bench = Bench::new();
    bench.write("file", "");
    bench.refuse(2, "demo --output-folder file/below");
}

#[test]
fn papers_are_printed_for_people_and_for_latex() {
    let bench = Bench::new();
    assert!(
        bench
            .succeed("cite")
            .stdout
            .contains("Intrinsic Parameterizations")
    );
    let bibtex = bench.succeed("cite flatten --style bibtex").stdout;
    assert!(
        bibtex.starts_with('@') && bibtex.contains("doi = {"),
        "{bibtex}"
    );
}
