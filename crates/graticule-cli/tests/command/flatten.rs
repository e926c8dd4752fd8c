//! `graticule flatten`.

use graticule_fixtures::{annulus, bumpy_patch, cube, disk, grid, spherical_cap};

use crate::bench::Bench;

#[test]
fn every_method_lays_a_flat_patch_down_without_distortion_that_it_need_not_have() {
    let bench = Bench::with(&grid(2.0, 1.0, 8, 4));
    for method in ["natural", "spectral"] {
        bench.succeed(&format!(
            "flatten patch.obj -o out.obj --method {method} --report report.json"
        ));
        let report = bench.json("report.json");
        let mean = &report["measure"]["distortion"]["quasi_conformal_error"]["mean"];
        assert!(
            (mean.as_f64().unwrap() - 1.0).abs() < 1e-9,
            "{method}: {mean}"
        );
        assert!(report["result"]["residual"].as_f64().unwrap() < 1e-9);
    }
}

#[test]
fn positive_weights_on_a_convex_boundary_flip_nothing() {
    let bench = Bench::with(&bumpy_patch(12, 5));
    for options in [
        "--weights mean-value",
        "--weights uniform",
        "--weights mean-value --boundary square",
        "--weights uniform --boundary rectangle --aspect 3",
        "--intrinsic-delaunay",
    ] {
        bench.succeed(&format!(
            "flatten patch.obj -o out.obj --method fixed {options} --report report.json"
        ));
        let report = bench.json("report.json");
        assert_eq!(report["measure"]["faces"]["flipped"], 0, "{options}");
        assert_eq!(report["measure"]["bijective"], true, "{options}");
    }
}

#[test]
fn pins_and_corners_go_by_the_numbers_of_the_file() {
    // An unused vertex first: the surface numbers its vertices otherwise than the file.
    let bench = Bench::new();
    let mut disk = disk(2);
    disk.positions.insert(0, glam::DVec3::splat(7.0));
    for vertex in disk.triangles.as_flattened_mut() {
        *vertex += 1;
    }
    bench.write("patch.obj", &disk.to_obj());
    bench.succeed("flatten patch.obj -o out.obj --pin 8:0,0 --pin 14:5,0");
    let out = bench.read("out.obj");
    assert_near(uv_of_vertex(&out, 8), [0.0, 0.0]);
    assert_near(uv_of_vertex(&out, 14), [5.0, 0.0]);
    bench.succeed(
        "flatten patch.obj -o out.obj --method fixed --weights uniform --boundary square \
         --corner 8 --corner 11 --corner 14 --corner 17",
    );
    let out = bench.read("out.obj");
    assert_near(uv_of_vertex(&out, 8), [0.0, 0.0]);
    assert_near(uv_of_vertex(&out, 14), [1.0, 1.0]);
    let fact = bench.refuse(1, "flatten patch.obj -o no.obj --pin 0:0,0 --pin 8:1,0");
    assert!(fact.contains("vertex 0 "), "{fact}");
    let fact = bench.refuse(1, "flatten patch.obj -o no.obj --pin 99:0,0 --pin 8:1,0");
    assert!(fact.contains("99"), "{fact}");
    bench.refuse(
        1,
        "flatten patch.obj -o no.obj --method fixed --boundary square \
         --corner 1 --corner 11 --corner 14 --corner 17",
    );
}

fn assert_near(uv: [f64; 2], expected: [f64; 2]) {
    let distance = (uv[0] - expected[0]).hypot(uv[1] - expected[1]);
    assert!(distance < 1e-12, "{uv:?} is not {expected:?}");
}

/// The texture coordinates of a vertex, numbered from 0, in an OBJ text.
fn uv_of_vertex(text: &str, vertex: usize) -> [f64; 2] {
    let numbers = |line: &str| -> Vec<f64> {
        line.split(' ')
            .skip(1)
            .map(|word| word.parse().unwrap())
            .collect()
    };
    let uvs: Vec<Vec<f64>> = text
        .lines()
        .filter(|l| l.starts_with("vt "))
        .map(numbers)
        .collect();
    let start = format!("{}/", vertex + 1);
    let corners = text
        .lines()
        .filter(|l| l.starts_with("f "))
        .flat_map(|l| l.split(' ').skip(1));
    let corner = corners
        .into_iter()
        .find(|corner| corner.starts_with(&start))
        .unwrap();
    let index: usize = corner.split('/').nth(1).unwrap().parse().unwrap();
    [uvs[index - 1][0], uvs[index - 1][1]]
}

#[test]
fn the_file_written_is_the_one_read_with_new_coordinates() {
    let bench = Bench::new();
    let text = "mtllib a.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 2 0 0.5 0 0 1\nv 0 1 0 1 1 1\n\
        v 1 1 0.25 0 0 0\nv 2 1 0 1 0 1\nv 5 5 5 0 0 0\ng left\nusemtl red\nf 1 2 5 4\ng right\n\
        usemtl blue\nf 2 3 6 5\n";
    bench.write("patch.obj", text);
    bench.succeed("flatten patch.obj -o out.obj");
    let out = bench.read("out.obj");
    let word = |word: &str| word.split('/').next().unwrap().to_owned();
    let words = |line: &str| line.split(' ').map(word).collect::<Vec<_>>().join(" ");
    let kept = |text: &str| -> Vec<String> {
        let lines = text
            .lines()
            .filter(|line| !line.starts_with("vt ") && !line.starts_with('#'));
        lines.map(words).collect()
    };
    assert_eq!(kept(&out), kept(text));
    assert_eq!(
        out.lines().filter(|line| line.starts_with("vt ")).count(),
        6
    );
}

#[test]
fn what_is_no_patch_is_refused_with_its_reason() {
    let bench = Bench::with(&cube());
    let fact = bench.refuse(1, "flatten patch.obj -o out.obj");
    assert!(
        fact.contains("patch.obj") && fact.contains("closed"),
        "{fact}"
    );
    let bench = Bench::with(&disk(3).joined(&cube()));
    let fact = bench.refuse(1, "flatten patch.obj -o out.obj");
    assert!(fact.contains("2 components"), "{fact}");
}

#[test]
fn one_of_several_components_can_be_flattened() {
    let bench = Bench::with(&cube().joined(&disk(3).map(|p| p + 3.0)));
    bench.succeed("flatten patch.obj -o out.obj --component 1 --report report.json");
    assert_eq!(bench.json("report.json")["result"]["vertices"], 37);
    let out = bench.read("out.obj");
    let faces = || out.lines().filter(|line| line.starts_with("f "));
    assert_eq!(faces().filter(|line| !line.contains('/')).count(), 12);
    assert_eq!(faces().filter(|line| line.contains('/')).count(), 54);
    bench.refuse(1, "flatten patch.obj -o no.obj --component 2");
}

#[test]
fn holes_are_kept_under_every_choice() {
    let bench = Bench::with(&annulus(0.4, 1.0, 24, 4));
    for options in [
        "natural",
        "spectral",
        "fixed --holes natural",
        "fixed --holes filled",
    ] {
        bench.succeed(&format!(
            "flatten patch.obj -o out.obj --method {options} --report report.json"
        ));
        let islands = &bench.json("report.json")["measure"]["islands"];
        assert_eq!(islands["boundary_loops"], 2, "{options}");
    }
}

#[test]
fn a_boundary_given_by_the_file_is_kept() {
    let bench = Bench::with(&spherical_cap(1.0, 5));
    bench.succeed("flatten patch.obj -o first.obj --method fixed --boundary square");
    bench.succeed(
        "flatten first.obj -o second.obj --method fixed --boundary given --weights mean-value \
         --report report.json",
    );
    assert_eq!(bench.json("report.json")["measure"]["faces"]["flipped"], 0);
    let first = bench.read("first.obj");
    let second = bench.read("second.obj");
    let rim = 1 + 3 * 5 * 4 + 7; // a vertex of the outermost ring
    assert_near(uv_of_vertex(&first, rim), uv_of_vertex(&second, rim));
    bench.refuse(
        1,
        "flatten patch.obj -o no.obj --method fixed --boundary given",
    );
}

#[test]
fn mixes_weights_and_functionals_end_in_a_map_with_its_story() {
    let bench = Bench::with(&bumpy_patch(9, 5));
    for options in [
        "fixed --weights authalic",
        "fixed --lambda 1 --mu 0.5 --boundary square",
        "optimal --functional area",
        "optimal --functional stretch",
        "boundary-optimal --functional symmetric-dirichlet --boundary natural",
        "boundary-optimal --steps 3 --lambda 1 --mu 1",
        "target",
        "target --extension conjugate --intrinsic-delaunay",
    ] {
        bench.succeed(&format!(
            "flatten patch.obj -o out.obj --method {options} --report report.json --picture out.png"
        ));
        let result = &bench.json("report.json")["result"];
        assert!(result["residual"].as_f64().unwrap() < 1e-9, "{options}");
        let history = result["descent"]["history"].as_array();
        for steps in history.into_iter().flat_map(|history| history.windows(2)) {
            assert!(steps[1]["value"].as_f64() < steps[0]["value"].as_f64());
        }
        assert_eq!(options.contains("boundary-optimal"), history.is_some());
        assert_eq!(
            options.starts_with("optimal"),
            result["near_optimal"]["lambda"].is_number()
        );
        assert_eq!(
            options.starts_with("target"),
            result["target"]["closing_change"].is_number()
        );
    }
}

#[test]
fn constraints_go_by_the_numbers_of_the_file() {
    let bench = Bench::with(&disk(4));
    let inside = "--constraint 0:0.1,0.2 --constraint 1*0.5+2*0.5:0.3,0.25";
    for method in ["natural", "fixed", "fixed --weights authalic"] {
        bench.succeed(&format!(
            "flatten patch.obj -o out.obj --method {method} {inside} --report report.json"
        ));
        let out = bench.read("out.obj");
        assert_near(uv_of_vertex(&out, 0), [0.1, 0.2]);
        let [a, b] = [1, 2].map(|vertex| uv_of_vertex(&out, vertex));
        assert_near(
            [f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1])],
            [0.3, 0.25],
        );
        let told = &bench.json("report.json")["result"]["constraints"];
        assert_eq!(told["count"], 2);
    }
    bench.succeed("flatten patch.obj -o out.obj --method fixed --line 20:29:-0.4,0:0.4,0");
    bench.succeed(&format!(
        "flatten patch.obj -o out.obj --method natural {inside} --soft 2"
    ));
    let fact = bench.refuse(
        1,
        "flatten patch.obj -o no.obj --method fixed --constraint 0:0,0 --constraint 0:1,1",
    );
    assert!(fact.contains("constraint 1"), "{fact}");
    let fact = bench.refuse(
        1,
        "flatten patch.obj -o no.obj --method fixed --constraint 0*0.5+30*0.5:0,0",
    );
    assert!(fact.contains("[0, 30]"), "{fact}");
}

#[test]
fn told_angles_and_cones_shape_the_map() {
    let bench = Bench::with(&disk(5));
    // The outermost ring of 30 begins with vertex 61.
    let corners = [61, 69, 76, 84]
        .map(|v| format!("--target-angle {v}:90"))
        .join(" ");
    bench.succeed(&format!(
        "flatten patch.obj -o out.obj --method target {corners}"
    ));
    let out = bench.read("out.obj");
    let [a, b, c] = [61, 64, 69].map(|v| uv_of_vertex(&out, v));
    let turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    assert!(turn.abs() < 1e-10, "{turn:e}");
    bench.succeed("flatten patch.obj -o out.obj --method target --cone 0:180 --report report.json");
    let report = bench.json("report.json");
    assert!(
        report["result"]["target"]["vertices_added"]
            .as_u64()
            .unwrap()
            > 3
    );
    assert_eq!(report["measure"]["islands"]["count"], 1);
    assert!(
        report["measure"]["islands"]["seam_length"]
            .as_f64()
            .unwrap()
            > 0.5
    );
    bench.refuse(
        1,
        "flatten patch.obj -o no.obj --method target --cone 61:180",
    );
    bench.refuse(
        1,
        "flatten patch.obj -o no.obj --method target --target-angle 0:90",
    );
    let quads = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0 2 0\nv 1 2 0\nv 2 2 0\n\
        f 1 2 5 4\nf 2 3 6 5\nf 4 5 8 7\nf 5 6 9 8\n";
    bench.write("quads.obj", quads);
    bench.succeed("flatten quads.obj -o out.obj --method target --cone 4:300 --report report.json");
    // Along an edge of the quads, over the root of the area; a diagonal is longer.
    let seam = bench.json("report.json")["measure"]["islands"]["seam_length"].clone();
    assert!((seam.as_f64().unwrap() - 0.5).abs() < 1e-9, "{seam}");
    assert_eq!(bench.read("out.obj").matches("\nf ").count(), 4);
}

#[test]
fn options_of_other_methods_are_refused_before_any_work() {
    let bench = Bench::with(&disk(2));
    for options in [
        "--lambda 1",
        "--method fixed --lambda 0 --mu 0",
        "--method fixed --lambda 1 --weights uniform",
        "--method fixed --functional area",
        "--method fixed --boundary natural",
        "--method optimal --weights uniform",
        "--method optimal --steps 3",
        "--method spectral --constraint 0:0,0",
        "--constraint 0:0,0 --pin 1:0,0 --pin 2:1,0",
        "--soft 1",
        "--constraint 0:0,0 --soft 0",
        "--cone 0:90",
        "--method target --target-scale 7:1 --target-angle 8:90",
        "--method natural --extension conjugate",
    ] {
        bench.refuse(2, &format!("flatten patch.obj -o no.obj {options}"));
    }
}

#[test]
fn the_report_tells_the_options_in_force() {
    let bench = Bench::with(&disk(3));
    bench.succeed("flatten patch.obj -o out.obj --method fixed --report report.json --threads 2");
    let options = &bench.json("report.json")["options"];
    assert_eq!(options["weights"], "cotangent");
    assert_eq!(options["boundary"], "circle");
    assert_eq!(options["holes"], "filled");
    assert_eq!(options["scale"], "unit-square");
    assert_eq!(options["threads"], 2);
}

#[test]
fn what_is_measured_is_what_the_file_holds() {
    let bench = Bench::with(&bumpy_patch(8, 2));
    let ways = ["glb", "obj", "ply"].map(|extension| [extension, ""]);
    for [extension, method] in ways.into_iter().chain([["glb", " --injective"]]) {
        bench.succeed(&format!(
            "flatten patch.obj -o out.{extension} --report made.json{method}"
        ));
        bench.succeed(&format!(
            "measure out.{extension} --reference patch.obj --report read.json"
        ));
        let [made, read] = ["made.json", "read.json"]
            .map(|name| bench.json(name)["measure"]["packing"]["bounding_box"].clone());
        assert_eq!(made, read, "{extension}{method}");
    }
}

#[test]
fn a_map_that_overlaps_itself_is_told_with_a_way_out() {
    // A flat strip wound up twice: without curvature, so that the map is the strip itself.
    let bench = Bench::with(&grid(1.0, 1.0, 96, 2).map(|p| {
        let (sin, cos) = (-4.0 * std::f64::consts::PI * p.x).sin_cos();
        glam::DVec3::new(cos * (1.0 + p.y), sin * (1.0 + p.y), 0.3 * p.x)
    }));
    let run = bench.succeed("flatten patch.obj -o out.obj --report report.json --picture p.png");
    assert!(run.stderr.contains("--no-overlap"), "{}", run.stderr);
    let report = bench.json("report.json");
    assert_eq!(report["warnings"][0]["code"], "overlap");
    assert_eq!(report["measure"]["faces"]["flipped"], 0);
    bench.succeed(
        "flatten patch.obj -o out.obj --method fixed --weights mean-value --report r.json",
    );
    assert_eq!(bench.json("r.json")["measure"]["overlap"]["any"], false);
}

#[test]
fn errors_name_the_vertices_of_the_file() {
    // The first vertex is unused, so that the surface numbers one less.
    let bench = Bench::new();
    bench.write(
        "patch.obj",
        "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
         f 2/1 3/2 4/3\nf 2/1 4/3 5\n",
    );
    let fact = bench.refuse(
        1,
        "flatten patch.obj -o out.obj --method fixed --boundary given",
    );
    assert!(fact.contains("vertex 4 of the file"), "{fact}");
    bench.write(
        "twice.obj",
        "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0 2\n\
         f 2/1 3/2 4/3\nf 2/5 4/3 5/4\n",
    );
    let run = bench.succeed("flatten twice.obj -o out.obj --method fixed --boundary given");
    assert!(
        run.stderr.contains("several texture coordinates: 1"),
        "{}",
        run.stderr
    );
}
