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
    let mut text = String::from("v 7 7 7\n");
    let disk = disk(2);
    for p in &disk.positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &disk.triangles {
        text += &format!("f {} {} {}\n", a + 2, b + 2, c + 2);
    }
    bench.write("patch.obj", &text);
    bench.succeed("flatten patch.obj -o out.obj --pin 8:0,0 --pin 14:5,0");
    let out = bench.read("out.obj");
    assert_eq!(uv_of_vertex(&out, 8), [0.0, 0.0]);
    assert_eq!(uv_of_vertex(&out, 14), [5.0, 0.0]);
    bench.succeed(
        "flatten patch.obj -o out.obj --method fixed --weights uniform --boundary square \
         --corner 8 --corner 11 --corner 14 --corner 17",
    );
    let out = bench.read("out.obj");
    assert_eq!(uv_of_vertex(&out, 8), [0.0, 0.0]);
    assert_eq!(uv_of_vertex(&out, 14), [1.0, 1.0]);
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
    let kept = |text: &str| -> Vec<String> {
        let words = |line: &str| -> Vec<String> {
            line.split(' ')
                .map(|w| w.split('/').next().unwrap().to_owned())
                .collect()
        };
        let lines = text
            .lines()
            .filter(|line| !line.starts_with("vt ") && !line.starts_with('#'));
        lines.map(|line| words(line).join(" ")).collect()
    };
    assert_eq!(kept(&out), kept(text));
    assert_eq!(
        out.lines().filter(|line| line.starts_with("vt ")).count(),
        6
    );
}

#[test]
fn what_is_no_patch_is_refused_with_its_reason() {
    let bench = Bench::with(&cube().subdivided());
    let fact = bench.refuse(1, "flatten patch.obj -o out.obj");
    assert!(
        fact.contains("patch.obj") && fact.contains("closed"),
        "{fact}"
    );
    let bench = Bench::with(&disk(3).joined(&cube().subdivided()));
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
    assert_eq!(uv_of_vertex(&first, rim), uv_of_vertex(&second, rim));
    bench.refuse(
        1,
        "flatten patch.obj -o no.obj --method fixed --boundary given",
    );
}
