//! `graticule repair`.

use crate::bench::Bench;

/// Two triangles of a square, the second turned over, and a vertex without use.
const TURNED: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nf 1 2 3\nf 1 4 3\n";

#[test]
fn what_was_changed_is_told_and_the_result_is_sound() {
    let bench = Bench::new();
    bench.write("mesh.obj", TURNED);
    let run = bench.succeed("repair mesh.obj -o out.obj --report report.json");
    assert!(run.stderr.contains("turned"), "{}", run.stderr);
    let report = bench.json("report.json");
    assert_eq!(report["repair"]["changed"], true);
    assert_eq!(report["result"]["total"]["vertices"], 4);
    bench.succeed("info out.obj --report again.json");
    assert_eq!(bench.json("again.json")["result"]["sound"], true);
    bench.succeed("repair out.obj -o twice.obj --report twice.json");
    assert_eq!(bench.json("twice.json")["repair"]["changed"], false);
}

#[test]
fn every_format_that_is_written_reads_again() {
    let bench = Bench::new();
    bench.write("mesh.obj", TURNED);
    for extension in ["obj", "ply", "off", "stl", "glb"] {
        bench.succeed(&format!("repair mesh.obj -o out.{extension}"));
        bench.succeed(&format!("info out.{extension} --report report.json"));
        let report = bench.json("report.json");
        assert_eq!(report["input"]["format"], extension);
        assert_eq!(
            report["result"]["surface"]["total"]["faces"], 2,
            "{extension}"
        );
    }
}

#[test]
fn what_has_no_sound_answer_is_refused() {
    let bench = Bench::new();
    bench.write("flat.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n");
    bench.refuse(1, "repair flat.obj -o out.obj");
    bench.write("points.obj", "v 1 1 1\nv 1 2 1\n");
    bench.refuse(1, "repair points.obj -o out.obj");
}

#[test]
fn polygons_that_are_written_whole_are_not_said_to_be_cut() {
    let bench = Bench::new();
    bench.write(
        "quad.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n",
    );
    let run = bench.succeed("repair quad.obj -o out.obj");
    assert!(
        run.stderr.contains("nothing had to be changed"),
        "{}",
        run.stderr
    );
    assert!(bench.read("out.obj").contains("f 1 2 3 4"));
}

#[test]
fn a_text_file_stays_text() {
    let bench = Bench::new();
    bench.write("mesh.obj", TURNED);
    bench.succeed("repair mesh.obj -o binary.ply");
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nproperty float heat\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n0 0 0 7\n1 0 0 7\n0 1 0 7\n3 0 1 2\n";
    bench.write("text.ply", text);
    let run = bench.succeed("repair text.ply -o out.ply");
    assert!(bench.read("out.ply").contains("format ascii"));
    assert!(run.stderr.contains("heat"), "{}", run.stderr);
    bench.succeed("repair binary.ply -o out2.ply");
    let bytes = std::fs::read(bench.path("out2.ply")).unwrap();
    assert!(bytes.windows(13).any(|word| word == b"binary_little"));
}
