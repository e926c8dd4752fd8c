//! `graticule demo` and `graticule cite`.

use crate::bench::{Bench, has_content};

#[test]
fn the_demo_needs_no_file_and_writes_mesh_picture_and_report() {
    let bench = Bench::new();
    let run = bench.succeed("demo --rings 30 --output-folder out");
    for name in ["mask.obj", "demo.png", "report.json"] {
        assert!(has_content(&bench.path("out").join(name)), "{name}");
        assert!(run.stdout.contains(name), "{}", run.stdout);
    }
    let report = bench.json("out/report.json");
    assert_eq!(report["measure"]["faces"]["flipped"], 0);
    assert_eq!(report["measure"]["islands"]["boundary_loops"], 4);
    bench.succeed("measure out/mask.obj");
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
