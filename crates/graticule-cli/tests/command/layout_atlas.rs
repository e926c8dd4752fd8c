//! The atlas that `graticule layout` writes.

use graticule::charts::TextureImage;
use graticule_fixtures::{Fixture, bumpy_patch, icosphere, torus};
use graticule_io::{ImageDepth, png_bytes, read_png};
use serde_json::Value;

use crate::bench::Bench;

fn atlas(bench: &Bench) -> Value {
    bench.json("report.json")["result"]["atlas"].clone()
}

#[test]
fn an_atlas_covers_each_surface_once_and_reloads() {
    for (shape, options) in [
        (icosphere(4), "--chart-size 6"),
        (
            torus(2.0, 0.7, 40, 16),
            "--chart-size 5 --padding 8 --resolution 512",
        ),
        (bumpy_patch(12, 3), "--chart-size 5 --relax 5"),
    ] {
        let bench = Bench::with(&shape);
        bench.succeed(&format!(
            "layout patch.obj -o out.obj {options} --report report.json"
        ));
        let report = bench.json("report.json");
        let atlas = &report["result"]["atlas"];
        assert_eq!(atlas["flipped"], 0);
        assert!(atlas["largest_gap"].as_f64().unwrap() < 1e-9);
        assert!(atlas["area_error"].as_f64().unwrap() < 1e-9);
        assert_eq!(report["measure"]["overlap"]["any"], false);
        assert_eq!(report["measure"]["faces"]["flipped"], 0);
        bench.succeed("measure out.obj --report again.json");
        let again = bench.json("again.json");
        assert_eq!(again["measure"]["bijective"], true);
        assert_eq!(again["measure"]["islands"]["count"], atlas["squares"]);
    }
}

#[test]
fn tiles_are_spread_and_numbers_told() {
    let bench = Bench::with(&icosphere(3));
    bench.succeed("layout patch.obj -o out.glb --udim 4 --chart-size 4 --report report.json");
    let tiles = atlas(&bench)["tiles"].as_u64().unwrap();
    assert!((2..=4).contains(&tiles), "{tiles}");
    bench.succeed("layout patch.obj -o out.obj --grid-seams --chart-size 4 --report report.json");
    assert_eq!(atlas(&bench)["texels_per_unit"], Value::Null);
    assert_eq!(atlas(&bench)["flipped"], 0);
}

/// A bench with a patch that has texture coordinates, and an image for it.
fn textured(shape: &Fixture) -> Bench {
    let bench = Bench::with(shape);
    bench.succeed("flatten patch.obj -o uv.obj");
    let pixels =
        (0..64 * 64_u16).map(|k| [f32::from(k % 64) / 63.0, f32::from(k / 64) / 63.0, 0.5, 1.0]);
    let image = TextureImage {
        width: 64,
        height: 64,
        pixels: pixels.collect(),
    };
    std::fs::write(
        bench.path("in.png"),
        png_bytes(&image, ImageDepth::Sixteen).unwrap(),
    )
    .unwrap();
    bench
}

#[test]
fn textures_and_geometry_images_are_written() {
    let bench = textured(&bumpy_patch(10, 1));
    std::fs::create_dir(bench.path("images")).unwrap();
    let atlas =
        "layout uv.obj -o out.obj --chart-size 5 --resolution 128 --padding 2 --report report.json";
    bench.succeed(&format!(
        "{atlas} --texture in.png color.png --normal-map in.png normals.png --geometry-images images \
         --geometry-side 5"
    ));
    for name in ["color.png", "normals.png"] {
        let bytes = std::fs::read(bench.path(name)).unwrap();
        let (image, depth) = read_png(&bytes).unwrap();
        assert_eq!(
            ([image.width, image.height], depth),
            ([128, 128], ImageDepth::Sixteen)
        );
        let covered = image.pixels.iter().filter(|pixel| pixel[3] > 0.0).count();
        assert!(covered > 64 * 64, "{covered}");
    }
    let squares = self::atlas(&bench)["squares"].as_u64().unwrap() as usize;
    let count = |ending: &str| {
        let files = std::fs::read_dir(bench.path("images")).unwrap();
        files
            .filter(|file| {
                file.as_ref()
                    .unwrap()
                    .path()
                    .to_string_lossy()
                    .ends_with(ending)
            })
            .count()
    };
    assert_eq!(
        [
            count("_positions.png"),
            count("_normals.png"),
            count(".json")
        ],
        [squares, squares, 1]
    );
    bench.succeed(&format!(
        "{atlas} --geometry-images images --geometry-format exr"
    ));
    assert_eq!(count(".exr"), 2 * squares);
}

#[test]
fn wrong_options_of_an_atlas_are_told_before_any_work() {
    let bench = Bench::with(&icosphere(1));
    for options in [
        "-o out.stl",
        "-o out.obj --resolution 0",
        "-o out.obj --udim 2 --texel-density 5",
        "-o out.obj --grid-seams --udim 2",
        "-o out.obj --texel-density=-1",
        "-o out.obj --texture missing.png new.png",
        "-o out.obj --geometry-images missing",
        "-o out.obj --geometry-side 1",
    ] {
        bench.misuse(&format!("layout patch.obj {options}"));
    }
    let fact = bench.refuse(1, "layout patch.obj -o out.obj --padding 4000");
    assert!(fact.contains("padding"), "{fact}");
}
