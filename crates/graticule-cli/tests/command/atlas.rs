//! `graticule flatten --injective`, `--no-overlap`, `--cut`.

use graticule_fixtures::{bumpy_patch, cube, disk, icosphere, torus};

use crate::bench::Bench;

#[test]
fn a_patch_is_laid_down_without_flips_and_reported() {
    let bench = Bench::with(&bumpy_patch(10, 3));
    bench
        .succeed("flatten patch.obj -o out.obj --injective --report report.json --picture map.png");
    let report = bench.json("report.json");
    assert_eq!(report["measure"]["faces"]["flipped"], 0);
    let island = &report["result"]["islands"][0];
    assert_eq!(island["descent"]["converged"], true);
    let measured = report["measure"]["distortion"]["symmetric_dirichlet"]
        .as_f64()
        .unwrap();
    assert!((island["energy"].as_f64().unwrap() - measured).abs() < 1e-8);
    assert_eq!(report["measure"]["packing"]["in_unit_square"], true);
}

#[test]
fn closed_surfaces_are_cut_and_several_components_packed() {
    let bench = Bench::with(
        &torus(2.0, 0.5, 16, 8).joined(&disk(3).map(|p| p * 0.5 + glam::DVec3::Z * 4.0)),
    );
    bench.succeed("flatten patch.obj -o out.obj --cut --no-overlap --report report.json");
    let report = bench.json("report.json");
    assert_eq!(report["measure"]["bijective"], true);
    assert_eq!(report["measure"]["islands"]["count"], 2);
    assert!(report["result"]["seam"]["edges"].as_u64().unwrap() > 8);
    bench.succeed("flatten patch.obj -o one.obj --cut --component 0 --report one.json");
    let one = bench.json("one.json");
    assert_eq!(one["measure"]["islands"]["count"], 1);
    let closed = bench.refuse(1, "flatten patch.obj -o no.obj --injective");
    assert!(closed.contains("closed"), "{closed}");
}

#[test]
fn seams_come_from_lines_angles_and_texture_coordinates() {
    let bench = Bench::with(&cube());
    bench.succeed("flatten patch.obj -o out.obj --injective --seam-angle 45 --report report.json");
    assert_eq!(
        bench.json("report.json")["result"]["islands"]
            .as_array()
            .unwrap()
            .len(),
        6
    );
    bench.succeed("flatten out.obj -o again.obj --injective --seam uv --report again.json");
    assert_eq!(
        bench.json("again.json")["result"]["islands"]
            .as_array()
            .unwrap()
            .len(),
        6
    );
    let equator = icosphere(1);
    let text = equator.to_obj();
    bench.write("lines.obj", &format!("{text}l 1 2\n"));
    bench.succeed("flatten lines.obj -o out2.obj --cut --seam lines --report lines.json");
    let warnings = bench.json("lines.json")["warnings"].to_string();
    assert!(warnings.contains("lines-off-edges"), "{warnings}");
}

#[test]
fn polygons_are_not_cut_across() {
    let bench = Bench::new();
    let quads = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                 f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    bench.write("box.obj", quads);
    bench.succeed("flatten box.obj -o out.obj --cut --no-overlap");
    bench.succeed("measure out.obj --report report.json");
    assert_eq!(bench.json("report.json")["measure"]["bijective"], true);
    let out = bench.read("out.obj");
    assert_eq!(out.lines().filter(|line| line.starts_with("f ")).count(), 6);
}

#[test]
fn options_that_do_not_go_together_are_told_before_any_work() {
    let bench = Bench::with(&disk(2));
    for words in [
        "--injective --method spectral",
        "--seam uv",
        "--injective --seam-tips 3",
        "--cut --seam-factor 0.5",
        "--injective --margin nan",
        "--energy mips",
    ] {
        bench.refuse(2, &format!("flatten patch.obj -o out.obj {words}"));
    }
}
