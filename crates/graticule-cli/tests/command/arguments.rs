//! Wrong arguments end with code 2 before anything is read or written.

use crate::bench::Bench;

#[test]
fn outputs_that_cannot_be_written_are_told_before_the_input_is_read() {
    let bench = Bench::new();
    // There is no patch.obj: reading it would end with code 1.
    let fact = bench.refuse(2, "flatten patch.obj -o no/such/folder/out.obj");
    assert!(fact.contains("no/such/folder"), "{fact}");
    bench.refuse(2, "flatten patch.obj -o .");
    bench.refuse(
        2,
        "flatten patch.obj -o out.obj --report nowhere/report.json",
    );
    bench.refuse(
        2,
        "flatten patch.obj -o out.obj --picture nowhere/picture.png",
    );
}

#[test]
fn unknown_endings_are_told_before_the_input_is_read() {
    let bench = Bench::new();
    bench.refuse(2, "flatten patch.obj -o out.xyz");
    bench.refuse(2, "flatten patch.obj -o out");
    bench.refuse(2, "flatten patch.obj -o out.gltf");
    bench.refuse(2, "flatten patch.obj -o -");
    bench.refuse(2, "flatten patch.obj -o out.stl");
    bench.refuse(2, "flatten patch.obj -o out.obj --picture picture.jpg");
    bench.refuse(2, "repair patch.obj -o out.xyz");
}

#[test]
fn one_file_cannot_be_two_outputs() {
    let bench = Bench::new();
    bench.refuse(2, "flatten patch.obj -o out.obj --report out.obj");
    bench.refuse(2, "flatten patch.obj -o - --format obj --json");
}

#[test]
fn options_that_do_not_go_together_are_told() {
    let bench = Bench::new();
    for options in [
        "--pin 0:0,0",
        "--method spectral --pin 0:0,0 --pin 1:1,0",
        "--weights uniform",
        "--method fixed --corner 1 --corner 2",
        "--method fixed --corner 1 --corner 2 --corner 3 --corner 4",
        "--method fixed --boundary circle --aspect 2",
        "--method fixed --weights uniform --intrinsic-delaunay",
        "--method fixed --holes fixed",
        "--pin 3:0,0 --pin 3:1,0",
        "--pin 3:0,1 --pin 4:0,1",
        "--method fixed --boundary square --corner 1 --corner 2 --corner 1 --corner 4",
        "--method fixed --boundary rectangle --aspect 0",
        "--method fixed --boundary rectangle --aspect -2",
        "--method fixed --boundary rectangle --aspect 1e7",
        "--method fixed --boundary rectangle --aspect nan",
    ] {
        bench.refuse(2, &format!("flatten patch.obj -o out.obj {options}"));
    }
    bench.refuse(2, "cite --picture papers.png");
}

#[test]
fn words_that_are_not_understood_end_with_code_2() {
    let bench = Bench::new();
    for words in [
        "",
        "fly",
        "info",
        "info a.obj --frobnicate",
        "flatten a.obj",
        "flatten a.obj -o b.obj --method magic",
        "flatten a.obj -o b.obj --pin 1,2",
        "info a.obj --threads 0",
        "info a.obj --max-seconds -1",
    ] {
        let run = bench.run(words);
        assert_eq!(run.code, 2, "{words}");
        assert_eq!(run.stdout, "", "{words}");
        assert!(!run.stderr.is_empty(), "{words}");
    }
}

#[test]
fn help_and_version_go_to_standard_output() {
    let bench = Bench::new();
    let help = bench.succeed("--help");
    for command in ["demo", "info", "repair", "flatten", "measure", "cite"] {
        assert!(help.stdout.contains(command));
        assert!(
            bench
                .succeed(&format!("{command} --help"))
                .stdout
                .contains("Usage")
        );
    }
    let version = bench.succeed("--version");
    assert!(version.stdout.starts_with("graticule "));
    assert_eq!(help.stderr + &version.stderr, "");
}
