//! `graticule field`.

use std::fmt::Write;

use graticule_fixtures::{annulus, block_with_holes, cube, disk, icosphere};
use serde_json::Value;

use crate::bench::{Bench, has_content};

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap();
    list.iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn the_field_of_a_closed_surface_sums_to_its_euler_characteristic() {
    let bench = Bench::with(&block_with_holes(1).subdivided());
    for symmetry in [1, 2, 4] {
        bench.succeed(&format!(
            "field patch.obj -o out.json --symmetry {symmetry} --report report.json"
        ));
        let result = &bench.json("report.json")["result"];
        assert_eq!(result["euler_characteristic"], 0);
        let field = bench.json("out.json");
        assert_eq!(field["symmetry"], symmetry);
        let singularities = field["singularities"].as_array().unwrap();
        let sum: f64 = singularities
            .iter()
            .map(|s| s["index"].as_f64().unwrap())
            .sum();
        assert!(sum.abs() < 1e-9, "{sum}");
        assert_eq!(result["singular"], field["singularities"]);
    }
}

#[test]
fn directions_go_by_the_vertices_of_the_file() {
    // An unused vertex first: the surface numbers its vertices otherwise than the file.
    let bench = Bench::new();
    let mut text = String::from("v 7 7 7\n");
    let disk = disk(4);
    for p in &disk.positions {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for [a, b, c] in &disk.triangles {
        writeln!(text, "f {} {} {}", a + 2, b + 2, c + 2).unwrap();
    }
    bench.write("patch.obj", &text);
    bench.write(
        "guides.json",
        r#"[{"vertex": 1, "direction": [3, 4, 1], "weight": null}]"#,
    );
    bench.succeed("field patch.obj -o out.json --guide guides.json --boundary free --symmetry 2");
    let field = bench.json("out.json");
    let directions = field["directions"].as_array().unwrap();
    assert_eq!(directions.len(), disk.positions.len() + 1);
    assert!(directions[0].is_null() && field["normals"][0].is_null());
    for direction in &directions[1..] {
        let d = numbers(direction);
        assert!((d[0] * 4.0 - d[1] * 3.0).abs() < 1e-2, "{d:?}");
    }
}

#[test]
fn guides_of_polygons_and_soft_ones_are_followed() {
    let bench = Bench::with(&disk(4));
    bench.write(
        "guides.json",
        r#"[{"face": 3, "direction": [1, 1, 0], "weight": 50}]"#,
    );
    bench.succeed("field patch.obj -o out.json --guide guides.json --boundary free --symmetry 2");
    for direction in bench.json("out.json")["directions"].as_array().unwrap() {
        let d = numbers(direction);
        assert!((d[0] - d[1]).abs() < 1e-2, "{d:?}");
    }
}

#[test]
fn guides_that_fit_nothing_are_refused_by_number() {
    let bench = Bench::with(&disk(3));
    for (guides, word) in [
        ("[{\"vertex\": 99, \"direction\": [1, 0, 0]}]", "vertex 99"),
        ("[{\"face\": 99, \"direction\": [1, 0, 0]}]", "face 99"),
        ("[{\"face\": 0, \"direction\": [0, 0, 1]}]", "guide 0"),
        ("[{\"vertex\": 0, \"direction\": [0, 0, 0]}]", "guide 0"),
        (
            "[{\"vertex\": 0, \"direction\": [1, 0, 0], \"weight\": -1}]",
            "guide 0",
        ),
        ("[{\"direction\": [1, 0, 0]}]", "guide 0"),
        (
            "[{\"vertex\": 0, \"face\": 0, \"direction\": [1, 0, 0]}]",
            "guide 0",
        ),
        ("[{\"vertex\": 0, \"direction\": [1, 0]}]", "guides.json"),
        (
            "[{\"vertex\": 0, \"direction\": [1, 0, 0], \"wieght\": 1}]",
            "wieght",
        ),
        ("nonsense", "guides.json"),
    ] {
        bench.write("guides.json", guides);
        let fact = bench.refuse(1, "field patch.obj -o out.json --guide guides.json");
        assert!(fact.contains(word), "{guides}: {fact}");
    }
    let fact = bench.refuse(1, "field patch.obj -o out.json --guide missing.json");
    assert!(fact.contains("missing.json"), "{fact}");
}

#[test]
fn wrong_arguments_are_told_before_any_work() {
    let bench = Bench::new();
    for words in [
        "-o out.stl",
        "-o out",
        "-o - --json",
        "-o no/out.json",
        "-o out.json --report out.json",
    ] {
        bench.refuse(2, &format!("field missing.obj {words}"));
    }
    for words in [
        "--symmetry 3",
        "--smoothing 1",
        "--feature-angle 0",
        "--cancel -1",
        "--curl-range 2",
        "--singularity 7",
        "--singularity 7:x",
        "--move-singularity 7:0.5",
        "--singularity 7:1 --move-singularity 7:8",
        "--singularity 7:1 --singularities list.json",
        "--cancel-length -1",
        "--draw lines",
        "--curl-correction --curl-range 0.5",
    ] {
        let run = bench.run(&format!("field missing.obj -o out.json {words}"));
        assert_eq!(run.code, 2, "{words}: {}", run.stderr);
    }
}

#[test]
fn curl_is_corrected_and_drawn() {
    let bench = Bench::with(&annulus(0.3, 1.0, 48, 10));
    bench.succeed(
        "field patch.obj -o out.json --curl-correction --curl-range 8 --picture field.png \
         --report report.json",
    );
    let curl = &bench.json("report.json")["result"]["curl"];
    let figure = |key: &str| curl[key].as_f64().unwrap();
    assert!(figure("curl_after") < 0.2 * figure("curl_before"), "{curl}");
    let scale = numbers(&bench.json("out.json")["scale"]);
    // The radii of a ring diverge like the radius.
    let positions = annulus(0.3, 1.0, 48, 10).positions;
    let products: Vec<f64> = positions
        .iter()
        .zip(&scale)
        .map(|(p, v)| p.length() * v)
        .collect();
    for product in &products {
        assert!((product / products[0] - 1.0).abs() < 0.1, "{product}");
    }
    assert!(has_content(&bench.path("field.png")));
    bench.succeed("field patch.obj -o out.json --picture field.svg");
    assert!(bench.read("field.svg").starts_with("<svg"));
}

#[test]
fn lines_are_written_over_the_mesh() {
    let bench = Bench::with(&disk(3));
    let vertices = disk(3).positions.len();
    let triangles = disk(3).triangles.len();
    for (symmetry, lines) in [(1, 1), (2, 1), (4, 2)] {
        bench.succeed(&format!("field patch.obj -o out.obj --symmetry {symmetry}"));
        let out = bench.read("out.obj");
        let count = |key: &str| out.lines().filter(|line| line.starts_with(key)).count();
        assert_eq!(count("l "), lines * vertices);
        assert_eq!(count("f "), triangles);
    }
}

#[test]
fn lines_of_the_file_are_followed() {
    // A square of four triangles round vertex 5, with a line along a diagonal.
    let square = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n\
        f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    let bench = Bench::new();
    bench.write("plain.obj", square);
    bench.write("lined.obj", &format!("{square}l 1 5 3\nl 1 3\n"));
    let along = |name: &str| {
        bench.succeed(&format!(
            "field {name}.obj -o out.json --report report.json"
        ));
        let d = numbers(&bench.json("out.json")["directions"][4]);
        d[0].abs().max(d[1].abs())
    };
    assert!((along("plain") - 1.0).abs() < 1e-6);
    let cosine = along("lined");
    assert!((cosine - 0.5_f64.sqrt()).abs() < 1e-6, "{cosine}");
    assert_eq!(bench.json("report.json")["result"]["feature_edges"], 2);
}

#[test]
fn a_box_keeps_its_edges_and_a_field_can_go_to_standard_output() {
    let bench = Bench::with(&cube().subdivided().subdivided());
    let run = bench.succeed("field patch.obj -o - --report report.json");
    let field: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(field["singularities"].as_array().unwrap().len(), 8);
    assert!(run.stderr.contains("8 of +0.25"), "{}", run.stderr);
    let result = &bench.json("report.json")["result"];
    assert_eq!(result["feature_edges"], 48);
    assert_eq!(result["fixed_vertices"], 36);
    bench.succeed("field patch.obj -o out.json --feature-angle 180 --report report.json");
    assert_eq!(bench.json("report.json")["result"]["feature_edges"], 0);
}

#[test]
fn threads_change_no_byte_and_the_seed_decides_where_nothing_guides() {
    let bench = Bench::with(&icosphere(3));
    let field = |options: &str| {
        bench.succeed(&format!(
            "field patch.obj -o out.json --curvature-radius 0 {options}"
        ));
        bench.read("out.json")
    };
    assert_eq!(field("--threads 1"), field("--threads 2"));
    assert_ne!(field("--seed 1"), field("--seed 2"));
}

#[test]
fn singularities_are_where_they_were_prescribed() {
    let bench = Bench::with(&icosphere(3));
    let wanted = [7, 150, 300, 450, 600, 750, 900, 1050];
    let words: Vec<String> = (wanted.iter())
        .map(|polygon| format!("--singularity {polygon}:0.25"))
        .collect();
    bench.succeed(&format!("field patch.obj -o out.json {}", words.join(" ")));
    let found = || -> Vec<u64> {
        let field = bench.json("out.json");
        let singular = field["singularities"].as_array().unwrap();
        assert!(singular.iter().all(|s| s["index"] == 0.25));
        (singular.iter())
            .map(|s| s["polygon"].as_u64().unwrap())
            .collect()
    };
    assert_eq!(found(), wanted);
    let list: Vec<String> = (wanted.iter())
        .map(|polygon| format!("{{\"polygon\": {polygon}, \"index\": 0.25}}"))
        .collect();
    bench.write("list.json", &format!("[{}]", list.join(",")));
    bench.succeed("field patch.obj -o out.json --singularities list.json");
    assert_eq!(found(), wanted);
    bench.succeed("field patch.obj -o out.json");
    let from = found()[0];
    bench.succeed(&format!(
        "field patch.obj -o out.json --move-singularity {from}:{}",
        from ^ 1
    ));
    assert!(!found().contains(&from) && found().contains(&(from ^ 1)));
    for (words, fact) in [
        ("--singularity 7:0.25", "must sum to 2"),
        ("--singularity 99999:2", "polygon 99999"),
        ("--move-singularity 99999:1", "polygon 99999"),
        ("--singularities missing.json", "missing.json"),
    ] {
        let told = bench.refuse(1, &format!("field patch.obj -o out.json {words}"));
        assert!(told.contains(fact), "{words}: {told}");
    }
    let told = bench.refuse(2, "field patch.obj -o out.json --singularity 7:0.1");
    assert!(told.contains("multiple"), "{told}");
}

#[test]
fn strokes_guide_from_json_and_from_obj() {
    let bench = Bench::with(&disk(8));
    bench.write(
        "guides.json",
        r#"[{"stroke": [[-1, -0.5, 0], [1, 0.5, 0]]}]"#,
    );
    bench.write("guides.obj", "v -1 -0.5 0\nv 1 0.5 0\nl 1 2\n");
    for guides in ["guides.json", "guides.obj"] {
        bench.succeed(&format!(
            "field patch.obj -o out.json --guide {guides} --boundary free --symmetry 2"
        ));
        for direction in bench.json("out.json")["directions"].as_array().unwrap() {
            let d = numbers(direction);
            assert!((d[0] - 2.0 * d[1]).abs() < 2e-2, "{d:?}");
        }
    }
    bench.write("far.json", r#"[{"stroke": [[90, 0, 0], [91, 0, 0]]}]"#);
    let told = bench.refuse(1, "field patch.obj -o out.json --guide far.json");
    assert!(told.contains("stroke 0"), "{told}");
    bench.write("none.obj", "v 0 0 0\n");
    let told = bench.refuse(1, "field patch.obj -o out.json --guide none.obj");
    assert!(told.contains("no lines"), "{told}");
}

#[test]
fn a_ply_file_has_the_directions_as_properties() {
    let bench = Bench::with(&annulus(0.3, 1.0, 24, 6));
    bench.succeed("field patch.obj -o out.ply --curl-correction");
    let bytes = std::fs::read(bench.path("out.ply")).unwrap();
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let header = String::from_utf8(bytes[..start].to_vec()).unwrap();
    assert!(header.contains("property double dx") && header.contains("property double scale"));
    let annulus = annulus(0.3, 1.0, 24, 6);
    let (vertices, triangles) = (annulus.positions.len(), annulus.triangles.len());
    assert_eq!(
        bytes.len() - start,
        vertices * 10 * 8 + triangles * (4 + 12 + 8)
    );
    // Others read it as the same mesh.
    bench.succeed("info out.ply --report info.json");
    let input = &bench.json("info.json")["input"];
    assert_eq!(input["vertices"], vertices, "{input}");
}

#[test]
fn what_is_no_part_of_the_surface_hinders_no_output() {
    let bench = Bench::new();
    bench.write(
        "spare.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\nf 1 3 4\n",
    );
    bench.write(
        "two.off",
        "OFF\n4 3 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n2 0 1\n",
    );
    for (mesh, name) in [
        ("two.off", "out.obj"),
        ("two.off", "out.ply"),
        ("spare.obj", "out.json"),
        ("spare.obj", "out.ply"),
        ("spare.obj", "out.obj"),
    ] {
        bench.succeed(&format!("field {mesh} -o {name}"));
    }
    assert!(!bench.read("out.obj").contains("NaN"));
    bench.succeed("info out.ply");
}
