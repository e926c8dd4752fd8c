//! The files of `shared/meshes`, where they are at hand: each is read or refused as its README
//! says, within a second.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use graticule_io::{MeshFile, ReadError, read_file};

fn corpus() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/meshes");
    let folder = std::env::var_os("GRATICULE_CORPUS").map_or(beside, PathBuf::from);
    folder.is_dir().then_some(folder)
}

macro_rules! corpus_or_skip {
    () => {
        match corpus() {
            Some(folder) => folder,
            None => {
                #[allow(clippy::print_stderr)]
                {
                    eprintln!("skipped: no corpus");
                }
                return;
            }
        }
    };
}

fn read_in_time(path: &Path) -> Result<MeshFile, ReadError> {
    let start = Instant::now();
    let result = read_file(path);
    let taken = start.elapsed();
    assert!(
        taken < Duration::from_secs(1),
        "{} took {taken:?}",
        path.display()
    );
    result
}

/// The fields of a line of CSV in which fields may be quoted.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    for letter in line.chars() {
        match letter {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            _ => fields.last_mut().unwrap().push(letter),
        }
    }
    fields
}

/// Refused by the verdict, but only once the mesh is repaired: the files themselves are sound.
const SOUND_FILES: [&str; 2] = [
    "06_topology/klein_bottle.off",
    "07_degenerate/all_coincident.obj",
];

/// Part of the message where a file is refused, by file.
const REASONS: [(&str, &str); 34] = [
    ("01_empty/empty.obj", "the file is empty"),
    ("01_empty/comments_only.obj", "no faces"),
    ("01_empty/header_only.off", "counts are missing"),
    ("01_empty/header_only.ply", "end_header is missing"),
    ("01_empty/zero_counts.ply", "the mesh has no faces"),
    ("01_empty/points_only.obj", "point cloud"),
    (
        "01_empty/lines_only.obj",
        "no faces (2 line elements ignored)",
    ),
    ("02_truncated/binary.ply", "face 10"),
    (
        "02_truncated/half_line.obj",
        "line 209: a face with fewer than 3 corners",
    ),
    ("02_truncated/off.off", "face 9"),
    ("03_counts/stl_count_4billion.stl", "4294967295 facets"),
    (
        "03_counts/ply_face_bomb_binary.ply",
        "2000000000 rows of element face",
    ),
    ("03_counts/ply_list_bomb.ply", "face 0: 4294967280 entries"),
    ("03_counts/ply_negative_count.ply", "invalid count '-8'"),
    ("03_counts/off_bomb.off", "2147483647 vertices"),
    ("03_counts/off_polygon_bomb.off", "1000000000 corners"),
    (
        "04_indices/obj_out_of_range.obj",
        "line 21: vertex index 99 is out of range",
    ),
    (
        "04_indices/obj_negative_out_of_range.obj",
        "index -99 is out of range",
    ),
    (
        "04_indices/off_out_of_range.off",
        "face 11: vertex index 8 is out of range",
    ),
    (
        "04_indices/ply_negative_index.ply",
        "face 11: bad index '-1'",
    ),
    ("05_numbers/msvc_nan.obj", "line 8: bad number '1.#IND'"),
    ("05_numbers/decimal_comma.obj", "line 1: bad number '0,0'"),
    (
        "05_numbers/two_coordinates.obj",
        "line 8: a vertex needs 3 numbers, found 2",
    ),
    ("09_obj/utf16.obj", "UTF-16"),
    (
        "09_obj/freeform_only.obj",
        "free-form curves and surfaces are not supported",
    ),
    ("10_off/noff_n_dim.off", "nOFF"),
    ("11_ply/missing_z.ply", "vertex has no property z"),
    ("11_ply/unknown_type.ply", "unknown type 'quad'"),
    (
        "13_gltf/index_out_of_range.glb",
        "index 999 is out of range",
    ),
    (
        "13_gltf/accessor_beyond_buffer.gltf",
        "accessor 0: it needs 96000000 bytes",
    ),
    ("13_gltf/version1.glb", "glTF 1 is not supported"),
    ("13_gltf/not_json.gltf", "JSON error"),
    (
        "13_gltf/draco_required.gltf",
        "KHR_draco_mesh_compression is not supported",
    ),
    ("14_wrong_content/html_error_page.ply", "a web page"),
];

#[test]
fn hostile_files_are_read_or_refused_as_expected() {
    let folder = corpus_or_skip!().join("broken");
    let reasons: BTreeMap<_, _> = REASONS.into_iter().collect();
    let table = std::fs::read_to_string(folder.join("expected.csv")).unwrap();
    for line in table.lines().skip(1) {
        let [name, _, verdict, ..] = &fields(line)[..] else {
            panic!("{line}");
        };
        let result = read_in_time(&folder.join(name));
        let may_refuse = verdict.contains("refuse");
        let may_read = verdict != "refuse" || SOUND_FILES.contains(&name.as_str());
        match result {
            Ok(_) => assert!(may_read, "{name} was read"),
            Err(error) => {
                assert!(may_refuse, "{name}: {error}");
                let reason = reasons.get(name.as_str()).unwrap_or(&"");
                assert!(error.to_string().contains(reason), "{name}: {error}");
            }
        }
    }
}

#[test]
fn cubes_and_grids_have_all_their_elements() {
    let folder = corpus_or_skip!().join("broken");
    let cube = [8, 12];
    let expected = [
        ("02_truncated/trailing_garbage.ply", cube),
        ("03_counts/stl_count_too_small.stl", cube),
        ("04_indices/obj_negative_ok.obj", cube),
        ("04_indices/obj_forward_reference.obj", cube),
        ("04_indices/obj_vt_out_of_range.obj", cube),
        ("05_numbers/fortran_exponent.off", cube),
        ("05_numbers/nan_unused_vertex.obj", [9, 12]),
        ("05_numbers/plus_signs_tabs.obj", cube),
        ("05_numbers/huge_1e30.off", [81, 128]),
        ("05_numbers/far_offset_1e7_double.ply", [81, 128]),
        ("05_numbers/mixed_scale.obj", [16, 24]),
        ("06_topology/isolated_vertices.obj", [18, 12]),
        ("06_topology/unwelded_soup.obj", [384, 128]),
        ("08_polygons/quads_only.obj", [8, 6]),
        ("08_polygons/two_gon.off", [8, 8]),
        ("08_polygons/polygon_2000_sides.off", [2000, 1]),
        ("09_obj/cr_only.obj", cube),
        ("09_obj/line_continuation.obj", cube),
        ("09_obj/no_final_newline.obj", cube),
        ("09_obj/non_utf8.obj", cube),
        ("09_obj/long_comment_1M.obj", cube),
        ("09_obj/long_face_line.obj", [50_000, 1]),
        ("09_obj/seam_uv.obj", [8, 6]),
        ("09_obj/vertex_colors.obj", cube),
        ("09_obj/w_coordinate.obj", cube),
        ("09_obj/vt_vn_groups_missing_mtl.obj", [8, 6]),
        ("10_off/4off.off", cube),
        ("10_off/coff.off", cube),
        ("10_off/comments_inline.off", cube),
        ("10_off/edge_count_missing.off", cube),
        ("10_off/no_magic.off", cube),
        ("10_off/noff.off", cube),
        ("10_off/numbers_across_lines.off", cube),
        ("10_off/stoff.off", cube),
        ("11_ply/big_endian.ply", cube),
        ("11_ply/cr_header_ascii.ply", cube),
        ("11_ply/extra_everything.ply", cube),
        ("11_ply/face_before_vertex.ply", cube),
        ("11_ply/mixed_tris_quads_binary.ply", [8, 9]),
        ("11_ply/tristrips.ply", [18, 16]),
        ("12_stl/binary_header_says_solid.stl", cube),
        ("12_stl/ascii_uppercase.stl", cube),
        ("12_stl/ascii_leading_blank_lines.stl", cube),
        ("12_stl/ascii_quad_loop.stl", [8, 6]),
        ("12_stl/nan_normals.stl", cube),
        ("13_gltf/ok.glb", cube),
        ("13_gltf/ok_data_uri.gltf", cube),
        ("13_gltf/no_indices.gltf", [6, 2]),
        ("13_gltf/scaled_node.gltf", cube),
        ("14_wrong_content/stl_named.obj", cube),
        ("14_wrong_content/ply_named.stl", cube),
    ];
    for (name, [vertices, faces]) in expected {
        let soup = read_in_time(&folder.join(name)).unwrap().soup;
        assert_eq!(
            (soup.positions.len(), soup.polygons.len()),
            (vertices, faces),
            "{name}"
        );
    }
}

#[test]
fn details_of_hostile_files_arrive() {
    let folder = corpus_or_skip!().join("broken");
    let read = |name: &str| read_in_time(&folder.join(name)).unwrap();
    let moved = read("13_gltf/scaled_node.gltf").soup;
    let x: Vec<f64> = moved.positions.iter().map(|position| position.x).collect();
    assert!(x.iter().all(|x| (10.0..=12.0).contains(x)) && x.contains(&12.0));
    let named = read("09_obj/vt_vn_groups_missing_mtl.obj").soup.attributes;
    assert_eq!(named.objects.unwrap().get(0), Some("Body"));
    assert_eq!(named.groups.unwrap().get(0), Some("top side"));
    assert_eq!(named.materials.unwrap().get(0), Some("stone"));
    assert_eq!(named.material_libraries, ["missing.mtl"]);
    let latin = read("09_obj/non_utf8.obj").soup.attributes;
    assert_eq!(latin.objects.unwrap().names, ["Größe"]);
    let fish = read("09_obj/unicode_Größe_模型_🐟.obj").soup.attributes;
    assert_eq!(fish.objects.unwrap().names, ["模型 🐟"]);
    let nan = read("05_numbers/nan_unused_vertex.obj");
    assert_eq!(nan.warnings[0].code, "non-finite-positions");
    let named_otherwise = read("14_wrong_content/ply_named.stl");
    assert_eq!(named_otherwise.warnings[0].code, "format-by-content");
}

/// File, vertices, faces of each row of a table in a README.
fn rows(readme: &str) -> Vec<(String, usize, usize)> {
    let is_number = |field: &&str| field.parse::<usize>().is_ok();
    let cells = readme
        .lines()
        .map(|line| line.split('|').map(str::trim).collect::<Vec<_>>());
    cells
        .filter(|cells| cells.len() > 6 && cells[3..6].iter().all(is_number))
        .map(|cells| {
            (
                cells[1].to_owned(),
                cells[4].parse().unwrap(),
                cells[5].parse().unwrap(),
            )
        })
        .collect()
}

#[test]
fn real_meshes_have_the_counts_of_their_table() {
    let folder = corpus_or_skip!().join("dev");
    let readme = std::fs::read_to_string(folder.join("README.md")).unwrap();
    let rows = rows(&readme);
    assert_eq!(rows.len(), 66);
    for (name, vertices, faces) in rows {
        let root = folder.join(&name);
        let path = if root.is_file() {
            root
        } else {
            folder.join("disks").join(&name)
        };
        let file = read_file(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        // The table counts the vertices of this one before its seams are joined.
        let vertices = if name == "duck.glb" {
            2399 - 291
        } else {
            vertices
        };
        let found = (file.soup.positions.len(), file.soup.polygons.len());
        assert_eq!(found, (vertices, faces), "{name}");
    }
}
