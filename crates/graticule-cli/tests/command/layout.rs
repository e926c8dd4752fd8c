//! `graticule layout`.

use graticule_fixtures::{cylinder_patch, icosphere, torus};

use crate::bench::{Bench, has_content};

#[test]
fn a_sphere_is_cut_into_charts_with_base_complex_picture_and_report() {
    let bench = Bench::with(&icosphere(4));
    bench.succeed(
        "layout patch.obj -o out.obj --chart-size 6 --base-complex base.obj --layout layout.json \
         --report report.json --picture picture.png",
    );
    let result = &bench.json("report.json")["result"];
    assert_eq!(result["euler_characteristic"], 2);
    assert_eq!(result["map"], "integer-grid");
    assert_eq!(result["singular_share"], 0.0);
    let charts = result["charts"].as_u64().unwrap();
    assert!(charts > 30, "{charts}");
    assert!(has_content(&bench.path("picture.png")));
    let count = |file: &str, word: &str| {
        let text = bench.read(file);
        text.lines().filter(|line| line.starts_with(word)).count() as u64
    };
    assert_eq!(count("base.obj", "f "), charts);
    assert_eq!(count("base.obj", "v "), result["nodes"].as_u64().unwrap());
    assert_eq!(
        count("out.obj", "f "),
        result["atlas"]["triangles"].as_u64().unwrap()
    );
    let layout = bench.json("layout.json");
    assert_eq!(layout["charts"].as_array().unwrap().len() as u64, charts);
    let beyond = layout["charts"][0]["beyond"].as_array().unwrap();
    assert!(beyond.iter().all(|arc| arc["chart"].is_u64()));
    bench.succeed("info base.obj --report base.json");
    assert_eq!(bench.json("base.json")["result"]["sound"], true);
}

#[test]
fn both_maps_and_every_size_lay_out_a_torus_and_a_tube() {
    for (shape, euler) in [
        (torus(2.0, 0.7, 40, 16), 0),
        (cylinder_patch(0.3, 3.0, 12, 30), 0),
    ] {
        let bench = Bench::with(&shape);
        for options in [
            "--map periodic",
            "--chart-count 12",
            "--chart-length 0.9 --curl-correction",
            "--chart-size 200",
        ] {
            bench.succeed(&format!(
                "layout patch.obj -o out.ply {options} --report report.json"
            ));
            let result = &bench.json("report.json")["result"];
            assert_eq!(result["euler_characteristic"], euler, "{options}");
        }
    }
}

#[test]
fn wrong_options_are_told_before_any_work() {
    let bench = Bench::with(&icosphere(1));
    for options in [
        "-o out.obj --chart-size 0",
        "-o out.obj --chart-size 5 --chart-count 10",
        "-o out.obj --map other",
        "-o out.obj --base-complex base.txt",
        "-o out.obj --layout out.obj",
        "-o out.txt",
    ] {
        bench.misuse(&format!("layout patch.obj {options}"));
    }
}
