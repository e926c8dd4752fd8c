//! `graticule remesh`.

use graticule_fixtures::{block_with_holes, cube, disk};

use crate::bench::{Bench, has_content};

#[test]
fn a_block_with_a_hole_becomes_quads_with_its_topology() {
    let bench = Bench::with(&block_with_holes(1).subdivided().subdivided());
    bench.succeed("remesh patch.obj -o out.obj --quads 400 --report report.json --picture out.png");
    let report = bench.json("report.json");
    assert_eq!(report["measure"]["reference"]["topology_kept"], true);
    let quads = report["result"]["quads"].as_f64().unwrap();
    assert!((quads - 400.0).abs() <= 0.1 * 400.0, "{quads}");
    assert_eq!(report["measure"]["quads"]["polygons"]["quad_share"], 1.0);
    assert!(has_content(&bench.path("out.png")));
    bench.succeed("measure out.obj --reference patch.obj");
}

#[test]
fn sides_have_the_length_asked_for() {
    let bench = Bench::with(&cube().subdivided().subdivided());
    bench.succeed("remesh patch.obj -o out.ply --edge-length 0.2 --dominant --report report.json");
    let report = bench.json("report.json");
    let mean = report["measure"]["quads"]["edge_length"]["mean"]
        .as_f64()
        .unwrap();
    assert!((0.15..0.25).contains(&mean), "{mean}");
}

#[test]
fn wrong_options_are_told_before_any_work() {
    let bench = Bench::with(&disk(3));
    for options in [
        "--quads 0",
        "--quads 100 --edge-length 1",
        "--pure --dominant",
        "--edge-length -1",
        "--adaptive 0.5",
        "--anisotropy nan",
        "--quads 100,0",
        "--quads 100,100",
    ] {
        let run = bench.run(&format!("remesh patch.obj -o out.obj {options}"));
        assert_eq!(run.code, 2, "{options}: {}", run.stderr);
        assert!(!bench.path("out.obj").exists(), "{options}");
    }
}

#[test]
fn several_numbers_make_several_files_and_each_is_told_of() {
    let bench = Bench::with(&block_with_holes(1).subdivided().subdivided());
    bench.succeed(
        "remesh patch.obj -o out.obj --quads 300,1200 --report report.json --picture o.png",
    );
    assert!(!bench.path("out.obj").exists());
    let report = bench.json("report.json");
    let levels = report["result"]["levels"].as_array().unwrap();
    assert_eq!(levels.len(), 2);
    for (level, asked) in levels.iter().zip([300.0, 1200.0]) {
        assert_eq!(level["asked"].as_f64(), Some(asked));
        assert_eq!(level["measure"]["reference"]["topology_kept"], true);
        let quads = level["result"]["quads"].as_f64().unwrap();
        assert!((quads - asked).abs() <= 0.1 * asked, "{quads}");
        bench.succeed(&format!("measure out-{asked}.obj --reference patch.obj"));
    }
    assert!(has_content(&bench.path("o.png")));
    let run = bench.run("remesh patch.obj -o - --format obj --quads 300,1200");
    assert_eq!(run.code, 2, "{}", run.stderr);
}

#[test]
fn sizes_of_a_file_are_followed() {
    let fixture = disk(12);
    let bench = Bench::with(&fixture);
    let sizes = fixture
        .positions
        .iter()
        .map(|p| if p.x > 0.0 { "2 " } else { "1 " });
    std::fs::write(bench.path("sizes.txt"), sizes.collect::<String>()).unwrap();
    bench.succeed(
        "remesh patch.obj -o out.obj --quads 300 --sizing sizes.txt --adaptive 2 --anisotropy 2",
    );
    std::fs::write(bench.path("few.txt"), "1 2 3").unwrap();
    let run = bench.run("remesh patch.obj -o few.obj --quads 300 --sizing few.txt");
    assert_eq!(run.code, 1, "{}", run.stderr);
}
