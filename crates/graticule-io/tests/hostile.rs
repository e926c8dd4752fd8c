//! Odd and broken files, each with what must come of it.
#![allow(clippy::float_cmp, reason = "numbers must arrive to the bit")]

use std::time::{Duration, Instant};

use graticule::Hint;
use graticule::mesh::PolygonSoup;
use graticule_io::{Format, MeshFile, ReadError, read_bytes};

fn read(text: impl AsRef<[u8]>, format: Format) -> MeshFile {
    read_bytes(text.as_ref(), Some(format)).unwrap()
}

fn refusal(text: impl AsRef<[u8]>, format: Format) -> String {
    let start = Instant::now();
    let error = read_bytes(text.as_ref(), Some(format)).unwrap_err();
    assert!(start.elapsed() < Duration::from_secs(1));
    assert!(
        error.hint().is_some() || matches!(error, ReadError::Io(_)),
        "{error}"
    );
    error.to_string()
}

fn counts(file: &MeshFile) -> (usize, usize) {
    (file.soup.positions.len(), file.soup.polygons.len())
}

fn polygons(soup: &PolygonSoup) -> Vec<&[u32]> {
    soup.polygons.iter().collect()
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn obj_line_ends_and_marks_do_not_matter() {
    let text = format!("# c\n{TRIANGLE}\n\tf 1 2\\\n 3");
    let expected = read(&text, Format::Obj).soup;
    for end in ["\r\n", "\r"] {
        let other = text.replace('\n', end);
        assert_eq!(read(&other, Format::Obj).soup, expected);
        assert_eq!(read(format!("\u{feff}{other}"), Format::Obj).soup, expected);
    }
}

#[test]
fn obj_errors_name_the_line_whatever_the_line_ends() {
    for end in ["\n", "\r\n", "\r"] {
        let text = format!("{TRIANGLE}# \\\n\nv 0 x 0\n").replace('\n', end);
        assert_eq!(refusal(text, Format::Obj), "OBJ, line 6: bad number 'x'");
    }
}

#[test]
fn obj_faces_may_stand_before_their_vertices_and_count_backward() {
    let file = read(format!("f 1 2 3\n{TRIANGLE}f -3 -2 -1\n"), Format::Obj);
    assert_eq!(polygons(&file.soup), [[0, 1, 2], [0, 1, 2]]);
    let error = refusal(format!("f 1 2 4\n{TRIANGLE}"), Format::Obj);
    assert_eq!(
        error,
        "OBJ, line 1: vertex index 4 is out of range (the file has 3)"
    );
    let error = refusal(format!("f -1 -2 -3\n{TRIANGLE}"), Format::Obj);
    assert_eq!(
        error,
        "OBJ, line 1: vertex index -1 is out of range (the file has 0)"
    );
}

#[test]
fn obj_values_belong_to_corners_and_may_be_missing() {
    let text = format!(
        "{TRIANGLE}vt .5\nvt 1 2 3\nvn 0 0 1\nf 1 2 3\nf 1/2 2//1 3/-2/-1\nf 1/9 2/1 3/1\n"
    );
    let file = read(text, Format::Obj);
    let uvs = &file.soup.attributes.uv_sets[0];
    let found: Vec<_> = (0..9)
        .map(|corner| uvs.get(corner).map(|uv| [uv.x, uv.y]))
        .collect();
    let [half, one] = [Some([0.5, 0.0]), Some([1.0, 2.0])];
    assert_eq!(found, [None, None, None, one, None, half, None, half, half]);
    let normals = file.soup.attributes.normals.as_ref().unwrap();
    assert_eq!(
        (0..9)
            .filter(|&corner| normals.get(corner).is_some())
            .collect::<Vec<_>>(),
        [4, 5]
    );
    assert_eq!(file.warnings[0].code, "missing-attributes");
    assert!(
        file.warnings[0]
            .message
            .starts_with("1 corners name texture coordinates")
    );
}

#[test]
fn obj_polylines_colours_and_weights_are_told_apart() {
    let text = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0 .5\nv 0 1 0 2.0\nl 1 2 3\nl -1 1\nl 2\nf 1 2 3\n";
    let file = read(text, Format::Obj);
    assert_eq!(file.soup.polylines, [vec![0, 1, 2], vec![2, 0]]);
    let colors = file.soup.attributes.vertex_colors.unwrap();
    assert_eq!(colors, [[1., 0., 0., 1.], [0., 1., 0., 0.5], [1.0; 4]]);
    assert_eq!(file.warnings[0].code, "weights-ignored");
    let error = refusal("v 0 0 0 1 1\n", Format::Obj);
    assert_eq!(
        error,
        "OBJ, line 1: a vertex needs 3, 4, 6 or 7 numbers, found 5"
    );
}

#[test]
fn obj_values_that_are_not_finite_are_named_or_dropped() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 nan\nvt nan 0\nvt 0 0\nf 1/1 2/2 3/2\n";
    let file = read(text, Format::Obj);
    assert!(file.soup.positions[2].z.is_nan());
    let codes: Vec<_> = file.warnings.iter().map(|warning| warning.code).collect();
    assert_eq!(codes, ["non-finite-positions", "non-finite-attributes"]);
    assert_eq!(file.soup.attributes.uv_sets[0].get(0), None);
    assert!(
        file.soup.attributes.uv_sets[0]
            .values
            .iter()
            .all(|uv| uv.is_finite())
    );
    assert!(refusal("v 1e999 0 0\n", Format::Obj).contains("bad number '1e999'"));
}

#[test]
fn obj_words_without_end_are_refused_in_bounded_memory() {
    let long = "9".repeat(3_000_000);
    assert!(refusal(format!("v {long} 0 0\n"), Format::Obj).contains("a word of more than"));
    assert!(refusal(format!("{TRIANGLE}o {long}\n"), Format::Obj).contains("a word of more than"));
    let comment = read(format!("{TRIANGLE}# {long}\nf 1 2 3 # {long}"), Format::Obj);
    assert_eq!(counts(&comment), (3, 1));
}

#[test]
fn obj_keywords_that_are_unknown_are_counted_and_binary_is_refused() {
    let file = read(
        format!("{TRIANGLE}weird 1 2\nf 1 2 3\nweird\n"),
        Format::Obj,
    );
    let expected = "2 statements of an unknown kind were ignored; the first is 'weird' on line 4";
    assert_eq!(file.warnings[0].message, expected);
    let error = refusal(format!("{TRIANGLE}\0\0\0\nf 1 2 3\n"), Format::Obj);
    assert!(error.starts_with("OBJ, line 4: the byte 0x00"), "{error}");
}

const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

#[test]
fn off_headers_of_all_kinds_are_read() {
    let square = |header: &str| format!("{header}\n{SQUARE}3 0 1 2\n3 0 2 3\n");
    for header in [
        "OFF\n4 2 5",
        "OFF 4 2 5",
        "# c\nOFF # c\n\n4 2",
        "4 2 0",
        "OFF\n4\n2\n0",
    ] {
        assert_eq!(
            counts(&read(square(header), Format::Off)),
            (4, 2),
            "{header}"
        );
    }
    assert!(refusal(square("OFF BINARY\n4 2 0"), Format::Off).contains("binary variant"));
    assert!(refusal(square("OFF\n4 -2 0"), Format::Off).contains("invalid count '-2'"));
    assert!(refusal("OFF\n1 1 0\n", Format::Off).contains("room for"));
    assert!(refusal("OFF\n", Format::Off).contains("counts are missing"));
}

#[test]
fn off_vertices_may_have_weights_normals_colours_and_coordinates() {
    let text = "STCN4OFF\n3 1 0\n2 0 0 2 0 0 1 1 0 0 1 .5 .5\n4 0 0 2 0 0 1 0 1 0 1 0 0\n0 2 0 2 0 0 1 0 0 1 1 1 1\n3 0 1 2";
    let soup = read(text, Format::Off).soup;
    assert_eq!(soup.positions[1].to_array(), [2.0, 0.0, 0.0]);
    let attributes = soup.attributes;
    assert_eq!(attributes.normals.unwrap().get(0).unwrap().z, 1.0);
    assert_eq!(attributes.vertex_colors.unwrap()[1], [0., 1., 0., 1.]);
    assert_eq!(attributes.uv_sets[0].get(2).unwrap().to_array(), [1.0, 1.0]);
    assert!(refusal("4OFF\n1 1 0\n0 0 0 0\n1 0", Format::Off).contains("coordinate w is 0"));
}

#[test]
fn off_colours_may_have_three_parts_of_255_and_faces_colours_too() {
    let text = "COFF\n3 1 0\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 51\n3 0 1 2 255 0 0\n";
    let file = read(text, Format::Off);
    assert_eq!(
        file.soup.attributes.vertex_colors.unwrap()[2],
        [0., 0., 0.2, 1.]
    );
    assert_eq!(file.warnings[0].code, "face-colors-ignored");
    let crowded = format!("OFF\n4 2 0\n{SQUARE}3 0 1 2 3 0 2 3 9\n");
    assert!(refusal(crowded, Format::Off).contains("line 7: expected a face"));
}

#[test]
fn off_files_that_end_early_name_the_element() {
    let text = format!("OFF\n4 2 0\n{SQUARE}3 0 1 2\n3 0");
    assert_eq!(
        refusal(text, Format::Off),
        "OFF, face 1: 3 corners are claimed, but the rest of the file has room for 1 at most"
    );
    let text = "OFF\n2 1 0\n0 0 0 1 1 ";
    assert!(refusal(text, Format::Off).contains("vertex 1 is not complete"));
}

fn ply(vertex: &str, face: &str, body: &str) -> String {
    format!("ply\nformat ascii 1.0\n{vertex}\n{face}\nend_header\n{body}")
}

const XYZ: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z";
const FACE: &str = "element face 1\nproperty list uchar int vertex_index";

#[test]
fn ply_headers_tell_their_faults_by_line() {
    let refused = [
        (ply(XYZ, "element face x", ""), "line 7: invalid count 'x'"),
        (
            ply(XYZ, "property list uchar quad a", ""),
            "line 7: unknown type 'quad'",
        ),
        (
            ply("property float x", "", ""),
            "line 3: expected an element before",
        ),
        (
            ply(XYZ, &format!("{FACE}\nelement face 2"), ""),
            "line 9: expected an element of another name",
        ),
        (
            ply(XYZ, "elephant", ""),
            "line 7: expected a line of a PLY header, found 'elephant'",
        ),
        (
            ply("element vertex 3\nproperty list uchar float x", "", "0 0 0"),
            "no property x",
        ),
        (
            ply(XYZ, "element face 1\nproperty int a", "0 0 0 0 0 0 0 0 0 0"),
            "no property vertex_indices",
        ),
        (
            "ply\nend_header\n".to_owned(),
            "line 2: expected a format line",
        ),
        (
            "ply\nformat ascii 1.0\n".to_owned(),
            "end_header is missing",
        ),
    ];
    for (text, expected) in refused {
        let error = refusal(&text, Format::Ply);
        assert!(error.contains(expected), "{error} is not {expected}");
    }
}

#[test]
fn ply_counts_are_checked_before_any_memory_is_taken() {
    let huge = "element vertex 99999999999\nproperty float x\nproperty float y\nproperty float z";
    assert!(refusal(ply(huge, FACE, "0 0 0"), Format::Ply).contains("99999999999 rows"));
    let nothing = ply(
        XYZ,
        &format!("element void 18446744073709551615\n{FACE}"),
        "0 0 0 1 0 0 0 1 0 3 0 1 2",
    );
    assert_eq!(counts(&read(nothing, Format::Ply)), (3, 1));
    let body = "0 0 0 1 0 0 0 1 0 4000000000 0 1 2";
    assert!(refusal(ply(XYZ, FACE, body), Format::Ply).contains("4000000000 entries"));
    let body = "0 0 0 1 0 0 0 1 0 -1 0 1 2 0 0 0 0 0";
    assert!(refusal(ply(XYZ, FACE, body), Format::Ply).contains("invalid count '-1'"));
}

#[test]
fn ply_indices_are_whole_and_in_range() {
    for (index, expected) in [
        ("3", "index 3 is out of range"),
        ("-1", "bad index '-1'"),
        ("0.5", "bad index '0.5'"),
    ] {
        let error = refusal(
            ply(XYZ, FACE, &format!("0 0 0 1 0 0 0 1 0 3 0 1 {index}")),
            Format::Ply,
        );
        assert!(
            error.contains("face 0") && error.contains(expected),
            "{error}"
        );
    }
}

#[test]
fn ply_strips_turn_every_other_triangle_and_restart() {
    let text = ply(
        XYZ,
        "element tristrips 1\nproperty list int int vertex_indices",
        "0 0 0 1 0 0 0 1 0 9 0 1 2 2 0 -1 2 1 0",
    );
    let file = read(text, Format::Ply);
    // 0 1 2 | 1 2 2 and 2 2 0 only steer | 2 1 0
    assert_eq!(polygons(&file.soup), [[0, 1, 2], [2, 1, 0]]);
}

#[test]
fn ply_attributes_are_found_under_their_names() {
    let vertex = "element vertex 3\nproperty float x\nproperty uchar red\nproperty float y\nproperty ushort green\nproperty float z\nproperty float blue\nproperty float texture_u\nproperty float texture_v";
    let face = "element face 1\nproperty int flags\nproperty list uchar float texcoord\nproperty list uchar int vertex_indices";
    let body =
        "0 255 0 65535 0 .5 1 2\n1 0 0 0 0 0 3 4\n0 0 1 0 0 0 5 6\n7 6 .1 .2 .3 .4 .5 .6 3 2 1 0\n";
    let attributes = read(ply(vertex, face, body), Format::Ply).soup.attributes;
    assert_eq!(attributes.vertex_colors.unwrap()[0], [1.0, 1.0, 0.5, 1.0]);
    assert_eq!(attributes.uv_sets[0].get(2).unwrap().to_array(), [0.5, 0.6]);
    assert_eq!(attributes.uv_sets[1].get(0).unwrap().to_array(), [5.0, 6.0]);
}

#[test]
fn ply_binary_bodies_may_begin_with_a_line_feed() {
    let header = "ply\rformat binary_little_endian 1.0\relement face 1\rproperty list uchar uchar vertex_indices\relement vertex 10\rproperty uchar x\rproperty uchar y\rproperty uchar z\rend_header\r";
    let mut bytes = header.as_bytes().to_vec();
    bytes.push(10);
    bytes.extend(0..10);
    bytes.extend([0; 30]);
    let file = read(&bytes, Format::Ply);
    assert_eq!(file.soup.polygons.vertices(0).len(), 10);
    bytes.pop();
    assert!(refusal(&bytes, Format::Ply).contains("10 rows of element vertex"));
}

#[test]
fn stl_text_is_read_whatever_its_case_and_layout() {
    let facet = "facet normal nan nan nan outer loop vertex 0 0 0 vertex 1 0 0 vertex -0 1 0 endloop endfacet\n";
    let text = format!(
        "solid a b\n{facet}endsolid a b\nSOLID c\n{}ENDSOLID",
        facet.to_uppercase()
    );
    let file = read(text, Format::Stl);
    assert_eq!(counts(&file), (3, 2));
    assert_eq!(file.soup.attributes.objects.unwrap().names, ["a b", "c"]);
    for (text, expected) in [
        (
            "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0",
            "line 4: unexpected end of file: facet 0",
        ),
        (
            "solid\nfacet normal 0 0 1\nvertex 0 0 0",
            "line 3: expected outer loop, found 'vertex'",
        ),
        (
            "solid\nfacet\nouter loop\nvertex 0 0 0\nendloop\nendfacet",
            "fewer than 3 corners (1)",
        ),
        ("solid\nhello", "line 2: expected facet, solid or endsolid"),
    ] {
        let error = refusal(text, Format::Stl);
        assert!(error.contains(expected), "{error} is not {expected}");
    }
}

fn binary_stl(count: u32, facets: usize) -> Vec<u8> {
    let mut bytes = vec![b'x'; 80];
    bytes.extend(count.to_le_bytes());
    for facet in 0..facets {
        let mut numbers = [0_f32; 12];
        (numbers[3], numbers[7]) = (1.0, facet as f32);
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

#[test]
fn stl_counts_are_held_against_the_size() {
    assert_eq!(read(binary_stl(3, 3), Format::Obj).soup.polygons.len(), 3);
    let more = read(binary_stl(2, 3), Format::Stl);
    assert_eq!(
        (more.soup.polygons.len(), more.warnings[0].code),
        (3, "facet-count")
    );
    let mut ragged = binary_stl(2, 2);
    ragged.push(1);
    assert_eq!(read(&ragged, Format::Stl).soup.polygons.len(), 2);
    assert!(refusal(binary_stl(4, 3), Format::Stl).contains("4 facets are claimed"));
    assert!(refusal(binary_stl(0, 0), Format::Stl).contains("no faces"));
}

fn gltf(changes: impl FnOnce(&mut serde_json::Value)) -> String {
    // Three positions and three 16-bit indices.
    let mut data: Vec<u8> = [0_f32, 0., 0., 1., 0., 0., 0., 1., 0.]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    data.extend([0_u16, 1, 2].iter().flat_map(|index| index.to_le_bytes()));
    let uri = format!("data:application/octet-stream;base64,{}", encode(&data));
    let mut document = serde_json::json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 6 },
        ],
        "buffers": [{ "byteLength": 42, "uri": uri }],
    });
    changes(&mut document);
    document.to_string()
}

fn encode(data: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    assert!(data.len().is_multiple_of(3));
    let groups = data.chunks(3).flat_map(|group| {
        let bits = u32::from_be_bytes([0, group[0], group[1], group[2]]);
        [18, 12, 6, 0].map(|shift| char::from(LETTERS[(bits >> shift) as usize & 63]))
    });
    groups.collect()
}

#[test]
fn gltf_modes_and_transforms_are_applied() {
    let plain = read(gltf(|_| {}), Format::Gltf);
    assert_eq!(polygons(&plain.soup), [[0, 1, 2]]);
    let fan = read(
        gltf(|root| root["meshes"][0]["primitives"][0]["mode"] = 6.into()),
        Format::Gltf,
    );
    assert_eq!(polygons(&fan.soup), [[0, 1, 2]]);
    let mirrored = read(
        gltf(|root| root["nodes"][0]["scale"] = serde_json::json!([-1, 1, 1])),
        Format::Gltf,
    );
    assert_eq!(polygons(&mirrored.soup), [[0, 2, 1]]);
    assert_eq!(mirrored.soup.positions[1].x, -1.0);
    let lines = gltf(|root| {
        let primitives = &mut root["meshes"][0]["primitives"];
        let mut lines = primitives[0].clone();
        lines["mode"] = 2.into();
        primitives.as_array_mut().unwrap().push(lines);
    });
    assert_eq!(read(lines, Format::Gltf).soup.polylines, [vec![0, 1, 2, 0]]);
    let nested = gltf(|root| {
        root["nodes"] = serde_json::json!([
            { "children": [1], "translation": [1, 0, 0] },
            { "mesh": 0, "rotation": [0, 0, 0.707_106_77, 0.707_106_77] },
        ]);
    });
    let turned = read(nested, Format::Gltf).soup.positions[1];
    assert!((turned - glam::DVec3::new(1.0, 1.0, 0.0)).length() < 1e-7);
}

#[test]
fn gltf_documents_that_lie_are_refused() {
    type Change = fn(&mut serde_json::Value);
    let lies: [(Change, &str); 12] = [
        (
            |root| root["accessors"][0]["count"] = 4.into(),
            "accessor 0: it needs 48 bytes",
        ),
        (
            |root| root["accessors"][0]["count"] = u64::MAX.into(),
            "accessor 0: it needs",
        ),
        (
            |root| root["accessors"][0]["byteOffset"] = u64::MAX.into(),
            "accessor 0: it needs",
        ),
        (
            |root| root["bufferViews"][0]["byteOffset"] = u64::MAX.into(),
            "accessor 0: it needs",
        ),
        (
            |root| root["bufferViews"][0]["byteStride"] = 4_000_000_000_u64.into(),
            "accessor 0: it needs",
        ),
        (
            |root| root["accessors"][1]["count"] = 2.into(),
            "2 indices do not make whole triangles",
        ),
        (
            |root| root["accessors"][1]["componentType"] = 5126.into(),
            "accessor 1: it needs 12 bytes",
        ),
        (
            |root| root["meshes"][0]["primitives"][0]["indices"] = 7.into(),
            "names accessor 7",
        ),
        (
            |root| root["nodes"][0]["mesh"] = 7.into(),
            "node 0: it names mesh 7",
        ),
        (|root| root["scene"] = 3.into(), "it names scene 3"),
        (
            |root| root["buffers"][0]["uri"] = "x.bin".into(),
            "cannot be found from bytes alone",
        ),
        (
            |root| root["nodes"][0]["children"] = serde_json::json!([0]),
            "node 0: the node is reached twice",
        ),
    ];
    for (lie, expected) in lies {
        let error = refusal(gltf(lie), Format::Gltf);
        assert!(error.contains(expected), "{error} is not {expected}");
    }
}

#[test]
fn gltf_instances_cannot_blow_a_file_up() {
    let instances = |count: usize| {
        gltf(move |root| {
            root["nodes"] = vec![serde_json::json!({ "mesh": 0 }); count].into();
            root["scenes"][0]["nodes"] = (0..count).collect::<Vec<_>>().into();
        })
    };
    assert_eq!(
        read(instances(1000), Format::Gltf).soup.polygons.len(),
        1000
    );
    let bomb = gltf(|root| {
        let primitive = root["meshes"][0]["primitives"][0].clone();
        root["meshes"][0]["primitives"] = vec![primitive; 1000].into();
        root["nodes"] = vec![serde_json::json!({ "mesh": 0 }); 1000].into();
        root["scenes"][0]["nodes"] = (0..1000).collect::<Vec<_>>().into();
    });
    assert!(refusal(bomb, Format::Gltf).contains("its instances have more than"));
}

#[test]
fn gltf_sparse_values_replace_others() {
    let sparse = gltf(|root| {
        root["accessors"][0]["sparse"] = serde_json::json!({
            "count": 1,
            "indices": { "bufferView": 1, "byteOffset": 4, "componentType": 5123 },
            "values": { "bufferView": 0, "byteOffset": 12 },
        });
    });
    // Vertex 2 gets the position of vertex 1.
    let file = read(sparse, Format::Gltf);
    assert_eq!(polygons(&file.soup), [[0, 1, 1]]);
}

#[test]
fn one_huge_polygon_and_many_values_at_one_vertex_take_linear_time() {
    let start = Instant::now();
    let mut text = TRIANGLE.to_owned();
    text.push_str(&"vt 0 0\n".repeat(1000));
    text.push('f');
    text.push_str(&" 1/1000 2/1 3".repeat(100_000));
    assert_eq!(
        read(text, Format::Obj).soup.polygons.vertices(0).len(),
        300_000
    );
    let face = "element face 20000\nproperty list uchar int vertex_index\nproperty list uchar float texcoord";
    let rows: String = (0..20_000)
        .map(|k| format!("3 0 1 2 6 {k} 0 {k} 1 {k} 2\n"))
        .collect::<Vec<_>>()
        .concat();
    let text = ply(XYZ, face, &format!("0 0 0 1 0 0 0 1 0\n{rows}"));
    assert_eq!(
        read(text, Format::Ply).soup.attributes.uv_sets[0]
            .values
            .len(),
        60_000
    );
    assert!(start.elapsed() < Duration::from_secs(2));
}

#[test]
fn files_of_other_kinds_are_told_by_name() {
    let kinds: [(&[u8], &str); 8] = [
        (b"\x1f\x8b\x08\0\0\0\0\0\0\x03abc", "gzip"),
        (b"PK\x03\x04\x14\0\0\0", "ZIP"),
        (b"BZh91AY&SY", "bzip2"),
        (
            b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n",
            "Git LFS",
        ),
        (b"\n <!doctype HTML><html></html>", "web page"),
        (b"BLENDER-v300", "Blender"),
        (b"Kaydara FBX Binary  \0", "FBX"),
        (b"\x28\xb5\x2f\xfd\x24\x03\x19", "zstd"),
    ];
    for (bytes, name) in kinds {
        for format in [Format::Obj, Format::Stl, Format::Glb] {
            let error = refusal(bytes, format);
            assert!(error.contains(name), "{error}");
        }
    }
}

#[test]
fn obj_indices_beyond_any_count_are_refused_by_their_line() {
    for index in ["4294967296", "-4294967296", "99999999999999999999", "0"] {
        let error = refusal(format!("{TRIANGLE}f 1 2 {index}\n"), Format::Obj);
        assert!(error.starts_with("OBJ, line 4: "), "{error}");
    }
    let far = read(format!("{TRIANGLE}f 1/4294967296 2 3\n"), Format::Obj);
    assert_eq!(far.warnings[0].code, "missing-attributes");
}

#[test]
fn obj_polygons_may_repeat_vertices_and_have_a_thousand_corners() {
    let corners = " 1 2 3".repeat(333) + " 1";
    let file = read(format!("{TRIANGLE}f 1 1 2 3 2\nf{corners}\n"), Format::Obj);
    let lengths: Vec<usize> = file.soup.polygons.iter().map(<[u32]>::len).collect();
    assert_eq!(lengths, [5, 1000]);
    let lines = refusal(format!("{TRIANGLE}l 1 2\nl 2 3\n"), Format::Obj);
    assert!(lines.contains("2 line elements"), "{lines}");
}

#[test]
fn ply_lists_of_vertices_are_read_over() {
    let vertex = format!("{XYZ}\nproperty list uchar float weights");
    let body = "0 0 0 2 5 6\n1 0 0 0\n0 1 0 1 7\n3 0 1 2\n";
    assert_eq!(counts(&read(ply(&vertex, FACE, body), Format::Ply)), (3, 1));
}

#[test]
fn gltf_indices_of_one_byte_and_interleaved_values_are_read() {
    let narrow = gltf(|root| {
        // The low bytes of the first 16-bit index, and the two behind.
        root["accessors"][1]["componentType"] = 5121.into();
        root["accessors"][1]["count"] = 3.into();
    });
    assert_eq!(polygons(&read(narrow, Format::Gltf).soup), [[0, 0, 1]]);
    let interleaved = gltf(|root| {
        root["bufferViews"][0]["byteStride"] = 12.into();
        root["accessors"][0]["byteOffset"] = 0.into();
        root["meshes"][0]["primitives"][0]["targets"] = serde_json::json!([{ "POSITION": 0 }]);
    });
    let file = read(interleaved, Format::Gltf);
    assert_eq!(counts(&file), (3, 1));
    assert!(file.warnings[0].message.contains("morph targets"));
}

#[test]
fn gltf_compression_is_refused_by_its_name() {
    for extension in ["KHR_draco_mesh_compression", "EXT_meshopt_compression"] {
        let packed = gltf(|root| root["extensionsRequired"] = serde_json::json!([extension]));
        assert!(refusal(packed, Format::Gltf).contains(extension));
    }
}

#[test]
fn binary_stl_cut_short_anywhere_is_refused() {
    let whole = binary_stl(2, 2);
    for length in 0..whole.len() {
        let cut = read_bytes(&whole[..length], Some(Format::Stl));
        assert!(cut.is_err(), "{length}");
    }
}
