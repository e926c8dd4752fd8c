//! What is written reads back the same, as far as the format holds it.

mod common;

use common::{assert_same, named_cubes, outlines, plain_cube, seamed_quads, single_precision};
use glam::{DVec2, DVec3};
use graticule::mesh::{CornerAttribute, PolygonLabels, PolygonSoup, Polygons};
use graticule_io::{Format, WriteError, WriteOptions, read_bytes, write_to, write_to_with};

fn written(soup: &PolygonSoup, format: Format, ascii: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_to_with(&mut bytes, soup, format, WriteOptions { ascii }).unwrap();
    bytes
}

fn reread(soup: &PolygonSoup, format: Format, ascii: bool) -> PolygonSoup {
    let file = read_bytes(&written(soup, format, ascii), None).unwrap();
    assert_eq!(file.format, format);
    assert_eq!(file.warnings, []);
    file.soup
}

#[test]
fn obj_keeps_everything_to_the_bit() {
    let soup = seamed_quads();
    assert_same(&soup, &reread(&soup, Format::Obj, false));
    let soup = named_cubes();
    assert_same(&soup, &reread(&soup, Format::Obj, false));
}

#[test]
fn ply_keeps_shape_colours_and_corner_coordinates_to_the_bit() {
    for ascii in [false, true] {
        let mut soup = seamed_quads();
        assert_same(&soup, &reread(&soup, Format::Ply, ascii));
        soup.attributes.vertex_colors.as_mut().unwrap()[0][0] = 0.123;
        assert_same(&soup, &reread(&soup, Format::Ply, ascii));
    }
}

#[test]
fn ply_uses_vertex_coordinates_where_no_vertex_has_two() {
    let mut soup = plain_cube();
    add_vertex_attributes(&mut soup);
    let bytes = written(&soup, Format::Ply, true);
    let text = String::from_utf8(bytes).unwrap();
    assert!(text.contains("property float s\nproperty float t\n") && !text.contains("texcoord"));
    assert_same(&soup, &reread(&soup, Format::Ply, true));
}

#[test]
fn off_keeps_shape_and_vertex_attributes_to_the_bit() {
    let mut soup = plain_cube();
    soup.positions[3] *= std::f64::consts::PI * 1e-200;
    assert_same(&soup, &reread(&soup, Format::Off, false));
    add_vertex_attributes(&mut soup);
    assert_same(&soup, &reread(&soup, Format::Off, false));
}

fn add_vertex_attributes(soup: &mut PolygonSoup) {
    let corners = soup.polygons.corner_vertices().to_vec();
    let count = soup.positions.len();
    soup.attributes.uv_sets = vec![CornerAttribute {
        name: String::new(),
        values: (0..count)
            .map(|k| DVec2::new(k as f64, 0.25 * k as f64))
            .collect(),
        corner_values: corners.clone(),
    }];
    soup.attributes.normals = Some(CornerAttribute {
        name: String::new(),
        values: (0..count)
            .map(|k| DVec3::new(k as f64, -0.5, 1.0))
            .collect(),
        corner_values: corners,
    });
    soup.attributes.vertex_colors = Some(vec![[0.2, 0.4, 1.0, 1.0]; count]);
}

#[test]
fn stl_keeps_triangles_in_single_precision() {
    let soup = single_precision(plain_cube());
    for ascii in [false, true] {
        let again = reread(&soup, Format::Stl, ascii);
        assert_eq!(outlines(&again), outlines(&soup));
        assert_eq!(again.positions.len(), soup.positions.len());
        // From then on nothing changes any more.
        assert_same(&again, &reread(&again, Format::Stl, ascii));
    }
}

#[test]
fn gltf_keeps_seams_names_and_colours_in_single_precision() {
    for format in [Format::Glb, Format::Gltf] {
        let soup = single_precision(plain_cube());
        assert_same(&soup, &reread(&soup, format, false));
        let mut soup = single_precision(named_cubes());
        soup.attributes.groups = None;
        soup.attributes.smoothing_groups = None;
        soup.attributes.material_libraries.clear();
        let again = reread(&soup, format, false);
        assert_eq!(sorted_triangles(&again), sorted_triangles(&soup));
        // Triangles of one material stand together; with that nothing changes any more.
        assert_same(&again, &reread(&again, format, false));
        assert_eq!(again.positions, soup.positions);
        assert_eq!(again.attributes.uv_sets[1].name, "TEXCOORD_1");
    }
}

/// Triangles with all that belongs to them, in an order of their own.
fn sorted_triangles(soup: &PolygonSoup) -> Vec<String> {
    let attributes = &soup.attributes;
    let triangle = |polygon: usize| {
        let corners = soup.polygons.corner_range(polygon);
        let sets = attributes
            .uv_sets
            .iter()
            .map(|set| corners.clone().map(|k| set.get(k)).collect());
        let uvs: Vec<Vec<_>> = sets.collect();
        let normals: Vec<_> = corners
            .map(|k| attributes.normals.as_ref().unwrap().get(k))
            .collect();
        let name = |labels: &Option<PolygonLabels>| {
            labels.as_ref().unwrap().get(polygon).map(str::to_owned)
        };
        let names = [name(&attributes.objects), name(&attributes.materials)];
        format!(
            "{:?} {uvs:?} {normals:?} {names:?}",
            soup.polygons.vertices(polygon)
        )
    };
    let mut triangles: Vec<_> = (0..soup.polygons.len()).map(triangle).collect();
    triangles.sort();
    triangles
}

#[test]
fn gltf_joins_a_surface_again_that_its_seams_have_split() {
    let soup = single_precision(seamed_quads());
    let again = reread(&soup, Format::Glb, false);
    assert_eq!(again.positions, soup.positions);
    assert_eq!(again.polygons.len(), 2 * soup.polygons.len());
    assert_eq!(again.polylines, soup.polylines);
    let corner = |soup: &PolygonSoup, corner: usize| {
        let vertex = soup.polygons.corner_vertices()[corner];
        (
            vertex,
            soup.attributes.uv_sets[0]
                .get(corner)
                .map(|uv| uv.to_array()),
        )
    };
    // Each corner of a triangle is a corner of the quadrilateral that it is part of.
    for triangle in 0..again.polygons.len() {
        let whole = soup
            .polygons
            .corner_range(triangle / 2)
            .map(|k| corner(&soup, k));
        let whole: Vec<_> = whole.collect();
        for k in again.polygons.corner_range(triangle) {
            assert!(whole.contains(&corner(&again, k)));
        }
    }
}

#[test]
fn concave_polygons_keep_their_area_as_triangles() {
    let dart = [[0., 0.], [4., 0.], [4., 4.], [2., 1.], [0., 4.]];
    let soup = PolygonSoup {
        positions: dart.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec(),
        polygons: [&[0, 1, 2, 3, 4][..]].into_iter().collect(),
        ..PolygonSoup::default()
    };
    for format in [Format::Stl, Format::Glb] {
        let again = reread(&soup, format, false);
        let areas = again.polygons.iter().map(|corners| {
            let [a, b, c] = [0, 1, 2].map(|k| again.positions[corners[k] as usize]);
            (b - a).cross(c - a).z / 2.0
        });
        let areas: Vec<f64> = areas.collect();
        assert!(areas.iter().all(|&area| area > 0.0), "{format}: {areas:?}");
        assert!((areas.iter().sum::<f64>() - 10.0).abs() < 1e-12, "{format}");
    }
}

#[test]
fn what_a_format_cannot_hold_is_told() {
    let mut soup = named_cubes();
    soup.positions.push(DVec3::ONE / 3.0);
    soup.polylines = vec![vec![0, 1]];
    let codes = |format| {
        let losses = write_to(&mut Vec::new(), &soup, format).unwrap();
        losses
            .into_iter()
            .map(|loss| loss.message)
            .collect::<Vec<_>>()
            .join("\n")
    };
    let obj = codes(Format::Obj);
    assert_eq!(
        obj,
        "OBJ cannot hold 1 more sets of texture coordinates: left out"
    );
    let stl = codes(Format::Stl);
    for lost in [
        "objects",
        "materials",
        "groups",
        "texture",
        "polylines",
        "without faces",
        "rounded",
    ] {
        assert!(stl.contains(lost), "{lost} in {stl}");
    }
    let glb = codes(Format::Glb);
    assert!(
        glb.contains("smoothing groups") && glb.contains("objects that share"),
        "{glb}"
    );
}

#[test]
fn meshes_that_make_unreadable_files_are_refused_by_element() {
    let write = |soup: &PolygonSoup, format| write_to(&mut Vec::new(), soup, format).unwrap_err();
    let mut soup = plain_cube();
    soup.positions[5].y = f64::NAN;
    for format in Format::ALL {
        assert!(matches!(
            write(&soup, format),
            WriteError::NonFinitePosition { vertex: 5, .. }
        ));
    }
    soup.positions[5].y = 1e39;
    assert!(matches!(
        write(&soup, Format::Glb),
        WriteError::OutOfRange { vertex: 5, .. }
    ));
    assert_same(&soup, &reread(&soup, Format::Ply, false));
    soup.polygons.push(&[0, 1]);
    let error = write(&soup, Format::Obj);
    assert_eq!(
        error.to_string(),
        "OBJ cannot hold polygon 12 with 2 corners"
    );
    soup.polygons.push(&[0, 1, 99]);
    let error = write(&soup, Format::Ply);
    assert_eq!(
        error.to_string(),
        "polygon 13: vertex index 99 is out of range (8 vertices)"
    );
}

#[test]
fn polygons_of_one_and_many_corners_survive_where_the_format_has_them() {
    let many: Vec<u32> = (0..300).collect();
    let soup = PolygonSoup {
        positions: (0..300)
            .map(|k| DVec3::new(f64::from(k), f64::from(k % 7), 0.1))
            .collect(),
        polygons: [&[0, 1, 2][..], &[], &[5], &[6, 7], &many]
            .into_iter()
            .collect(),
        ..PolygonSoup::default()
    };
    for format in [Format::Ply, Format::Off] {
        assert_same(&soup, &reread(&soup, format, false));
    }
}

#[test]
fn names_that_would_break_a_line_do_not() {
    let mut soup = plain_cube();
    soup.attributes.groups = Some(PolygonLabels {
        names: vec!["a\nv 1 2 3\\".to_owned(), "\\".to_owned()],
        polygon_names: (0..12).map(|k| k % 2).collect(),
    });
    let mut bytes = Vec::new();
    let losses = write_to(&mut bytes, &soup, Format::Obj).unwrap();
    assert_eq!(losses[0].code, "names-changed");
    let again = read_bytes(&bytes, None).unwrap().soup;
    assert_eq!(again.positions, soup.positions);
    assert_eq!(again.attributes.groups.unwrap().names, ["a_v 1 2 3_", "_"]);
}

#[test]
fn writing_twice_gives_the_same_bytes() {
    for soup in [seamed_quads(), named_cubes()] {
        for format in Format::ALL {
            assert_eq!(written(&soup, format, false), written(&soup, format, false));
        }
    }
}

#[test]
fn an_empty_list_of_polygons_is_written_but_not_read() {
    let soup = PolygonSoup {
        polygons: Polygons::default(),
        ..plain_cube()
    };
    let mut bytes = Vec::new();
    write_to(&mut bytes, &soup, Format::Ply).unwrap();
    let error = read_bytes(&bytes, None).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the mesh has no faces: a point cloud of 8 vertices"
    );
}
