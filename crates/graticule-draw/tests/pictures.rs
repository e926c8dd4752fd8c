//! Pictures as their readers see them: decoded pixels and parsed shapes.

use glam::{DVec2, DVec3};
use graticule::mesh::{Element, FaceId, PerCorner, PerFace, PerVertex, Surface};
use graticule_draw::{
    CheckerStyle, Color, ColorMap, ColorScale, DrawError, Eye, Figure, Frame, Layer, LayoutStyle,
    Legend, Lines, Paint, Panel, Picture, Points, Range, Shading, Squares, SurfaceStyle, Triangles,
    View, side_by_side, surface, uv_layout,
};
use graticule_fixtures::Fixture;

/// A decoded PNG file.
struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 3]>,
}

impl Image {
    fn of(picture: &Picture) -> Self {
        let file = picture.to_png();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&file))
            .read_info()
            .expect("a PNG header");
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        let frame = reader.next_frame(&mut bytes).expect("a PNG image");
        assert_eq!(frame.color_type, png::ColorType::Rgb);
        Self {
            width: frame.width,
            height: frame.height,
            pixels: bytes.chunks(3).map(|p| [p[0], p[1], p[2]]).collect(),
        }
    }

    fn at(&self, column: u32, row: u32) -> [u8; 3] {
        self.pixels[(row * self.width + column) as usize]
    }

    /// How many pixels have this colour.
    fn count(&self, color: Color) -> usize {
        let color = color.to_bytes();
        self.pixels.iter().filter(|&&pixel| pixel == color).count()
    }
}

fn surface_of(fixture: &Fixture) -> Surface {
    Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
}

/// Texture coordinates by a function of the position.
fn uvs_of(surface: &Surface, uv: impl Fn(DVec3) -> DVec2) -> PerCorner<DVec2> {
    let mesh = surface.mesh();
    PerCorner::from_fn(mesh.halfedge_count(), |corner| {
        uv(surface.position(mesh.origin(corner)))
    })
}

fn triangles(positions: Vec<DVec3>, colors: &[Color]) -> Triangles {
    let count = colors.len() as u32;
    Triangles {
        positions,
        triangles: (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        paint: Paint::PerFace(colors.to_vec()),
        checker: None,
        shading: Shading::Unlit,
    }
}

fn panel(eye: Eye, layer: impl Into<Layer>) -> Panel {
    Panel::new(eye, vec![layer.into()])
}

/// A small picture of one panel.
fn picture(panel: Panel) -> Picture {
    Picture::from(panel).with_size(120, 120).unwrap()
}

/// An image in an SVG file does not parse back to pixels here, but the file must be well-formed.
fn assert_well_formed(picture: &Picture) -> String {
    let svg = picture.to_svg();
    let document = roxmltree::Document::parse(&svg).expect("well-formed XML");
    assert_eq!(document.root_element().tag_name().name(), "svg");
    for node in document.descendants() {
        for attribute in node.attributes() {
            let value = attribute.value();
            let is_number = !value.starts_with("data:");
            assert!(!is_number || !(value.contains("NaN") || value.contains("inf")));
        }
    }
    svg
}

const RED: Color = Color::hex(0x00e0_2010);
const GREEN: Color = Color::hex(0x0010_c040);

fn big_triangle(z: f64) -> [DVec3; 3] {
    [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, z))
}

#[test]
fn a_triangle_has_its_colour_and_the_rest_is_background() {
    let layer = triangles(big_triangle(0.0).to_vec(), &[RED]);
    let image = Image::of(&picture(panel(Eye::Plane, layer)));
    assert_eq!([image.width, image.height], [120, 120]);
    assert_eq!(image.at(30, 90), RED.to_bytes());
    assert_eq!(image.at(90, 30), [255; 3]);
    let half = (120.0 - 2.0 * 0.9 * 8.0_f64).powi(2) / 2.0;
    let share = image.count(RED) as f64 / half;
    assert!((share - 1.0).abs() < 0.05, "half of the square: {share}");
}

#[test]
fn the_nearer_triangle_hides_the_other_from_either_side() {
    for colors in [[RED, GREEN], [GREEN, RED]] {
        let positions = [big_triangle(0.0), big_triangle(0.1)].concat();
        for (direction, seen) in [(DVec3::Z, colors[1]), (DVec3::NEG_Z, colors[0])] {
            let frame = Frame::new(direction, DVec3::Y).unwrap();
            for eye in [Eye::Orthographic(frame), Eye::Perspective(frame)] {
                let panel = panel(eye, triangles(positions.clone(), &colors));
                let image = Image::of(&picture(panel));
                assert!(image.count(seen) > 1000);
                let other = if seen == RED { GREEN } else { RED };
                assert!(image.count(other) < 400, "only a rim in perspective");
            }
        }
    }
}

#[test]
fn the_last_triangle_in_a_plane_is_on_top() {
    let positions = [big_triangle(1.0), big_triangle(0.0)].concat();
    let image = Image::of(&picture(panel(
        Eye::Plane,
        triangles(positions, &[RED, GREEN]),
    )));
    assert_eq!(image.count(RED), 0);
    assert!(image.count(GREEN) > 1000);
}

#[test]
fn the_ends_of_a_legend_have_the_ends_of_the_map() {
    for map in [ColorMap::Viridis, ColorMap::BlueRed, ColorMap::YellowRed] {
        let legend = Legend {
            title: "figure".into(),
            map,
            low: 0.0,
            high: 1.0,
            below: 0,
            above: 0,
            missing: 0,
        };
        let mut panel = Panel::new(Eye::Plane, Vec::new());
        panel.legend = Some(legend);
        let image = Image::of(&Picture::from(panel).with_size(400, 400).unwrap());
        let (low, high) = (map.at(0.0).to_bytes(), map.at(1.0).to_bytes());
        let row = (0..400)
            .find(|&row| (0..400).any(|column| image.at(column, row) == low))
            .expect("a bar");
        let bar: Vec<u32> = (0..400)
            .filter(|&column| image.at(column, row) != [255; 3])
            .collect();
        assert_eq!(image.at(bar[0], row), low);
        assert_eq!(image.at(*bar.last().unwrap(), row), high);
        assert!(bar.len() > 150);
    }
}

#[test]
fn a_legend_shows_missing_values_in_their_colour() {
    let square = surface_of(&graticule_fixtures::grid(1.0, 1.0, 2, 2));
    let values = PerFace::from_fn(8, |face| if face.0 < 4 { f64::NAN } else { 1.0 });
    let style = LayoutStyle {
        figure: Some(Figure::per_face("value", &values)),
        ..LayoutStyle::default()
    };
    let uvs = uvs_of(&square, DVec3::truncate);
    let panel = uv_layout(&square, &uvs, &style).unwrap();
    assert_eq!(panel.legend.as_ref().unwrap().missing, 4);
    let image = Image::of(&Picture::from(panel).with_size(407, 407).unwrap());
    let missing = Color::MISSING.to_bytes();
    let in_legend = (360..407).flat_map(|row| (300..407).map(move |column| (column, row)));
    let swatch = in_legend.filter(|&(column, row)| image.at(column, row) == missing);
    assert!(swatch.count() >= 36);
}

#[test]
fn a_checker_has_equal_shares_of_both_colours() {
    let square = surface_of(&graticule_fixtures::grid(1.0, 1.0, 7, 7));
    let uvs = uvs_of(&square, DVec3::truncate);
    let style = LayoutStyle {
        checker: Some(Squares::OfSide(0.1)),
        color: Color::WHITE,
        edges: false,
        boundary: false,
        ..LayoutStyle::default()
    };
    let panel = uv_layout(&square, &uvs, &style).unwrap();
    let image = Image::of(&Picture::from(panel).with_size(400, 400).unwrap());
    let dark = image.count(Color::CHECKER) as f64;
    let area = (400.0 - 2.0 * 0.9 * 400.0 / 46.0_f64).powi(2);
    assert!((dark / area - 0.5).abs() < 0.04, "{}", dark / area);
    // The square at the origin, below left, is light; the one beside it is dark.
    assert_eq!(image.at(20, 380), [255; 3]);
    assert_eq!(image.at(60, 380), Color::CHECKER.to_bytes());
}

#[test]
fn a_checker_too_fine_to_be_seen_is_an_even_grey() {
    let square = surface_of(&graticule_fixtures::grid(1.0, 1.0, 2, 2));
    let uvs = uvs_of(&square, DVec3::truncate);
    let style = LayoutStyle {
        checker: Some(Squares::OfSide(1e-5)),
        color: Color::WHITE,
        edges: false,
        ..LayoutStyle::default()
    };
    let image = Image::of(&picture(uv_layout(&square, &uvs, &style).unwrap()));
    let middle = Color::WHITE.mix(Color::CHECKER, 0.5).to_bytes();
    for column in 40..80 {
        let pixel = image.at(column, 60);
        assert!(
            (0..3).all(|k| pixel[k].abs_diff(middle[k]) <= 3),
            "{pixel:?}"
        );
    }
}

#[test]
fn the_far_side_is_tinted() {
    let square = surface_of(&graticule_fixtures::grid(1.0, 1.0, 2, 2));
    let seen_from = |direction| {
        let style = SurfaceStyle {
            view: View::From {
                direction,
                up: DVec3::Y,
            },
            ..SurfaceStyle::default()
        };
        Image::of(&picture(surface(&square, &style).unwrap())).at(60, 60)
    };
    let (near, far) = (seen_from(DVec3::Z), seen_from(DVec3::NEG_Z));
    assert!(near[2] >= near[0], "clay is bluish: {near:?}");
    assert!(far[0] > far[2] + 30, "the far side is brown: {far:?}");
}

#[test]
fn a_flipped_triangle_is_red_and_counted() {
    let square = surface_of(&graticule_fixtures::grid(1.0, 1.0, 2, 2));
    let mut uvs = uvs_of(&square, DVec3::truncate);
    let image = |uvs: &PerCorner<DVec2>| {
        let panel = uv_layout(&square, uvs, &LayoutStyle::default()).unwrap();
        (panel.notes.clone(), Image::of(&picture(panel)))
    };
    let (notes, unflipped) = image(&uvs);
    assert!(notes.is_empty() && unflipped.count(Color::FLIPPED) == 0);
    let mirrored = uvs.as_slice()[..3].to_vec();
    uvs.as_mut_slice()[1] = mirrored[2];
    uvs.as_mut_slice()[2] = mirrored[1];
    let (notes, flipped) = image(&uvs);
    assert_eq!(notes, ["1 flipped triangle"]);
    assert!(flipped.count(Color::FLIPPED) > 300);
}

#[test]
fn overlapping_triangles_are_orange_and_counted() {
    let square = surface_of(&graticule_fixtures::grid(1.0, 1.0, 2, 2));
    let uvs = uvs_of(&square, DVec3::truncate);
    let overlapping = PerFace::from_fn(square.mesh().face_count(), |face: FaceId| face.0 < 2);
    let style = LayoutStyle {
        overlapping: Some(&overlapping),
        ..LayoutStyle::default()
    };
    let panel = uv_layout(&square, &uvs, &style).unwrap();
    assert_eq!(panel.notes, ["2 overlapping triangles"]);
    assert!(Image::of(&picture(panel)).count(Color::OVERLAPPING) > 300);
}

#[test]
fn a_checker_that_cuts_triangles_to_shreds_becomes_an_image_in_svg() {
    let square = surface_of(&graticule_fixtures::grid(1.0, 1.0, 20, 20));
    let uvs = uvs_of(&square, |p| p.truncate() * 400.0);
    let style = SurfaceStyle {
        checker: Some(CheckerStyle {
            uvs: &uvs,
            squares: Squares::OfSide(1.0),
        }),
        ..SurfaceStyle::default()
    };
    let svg = picture(surface(&square, &style).unwrap()).to_svg();
    assert!(
        svg.contains("<image ") && svg.len() < 2_000_000,
        "{}",
        svg.len()
    );
}

#[test]
fn lines_and_dots_behind_the_surface_are_hidden() {
    let sphere = surface_of(&graticule_fixtures::icosphere(4));
    let style = SurfaceStyle {
        view: View::From {
            direction: DVec3::Z,
            up: DVec3::Y,
        },
        ..SurfaceStyle::default()
    };
    let with_line = |z: f64| {
        let mut line = Lines::new(RED, 40.0);
        line.push([DVec3::new(-0.4, 0.0, z), DVec3::new(0.4, 0.0, z)]);
        let dot = Points {
            positions: vec![DVec3::new(0.0, 0.5, z)],
            color: GREEN,
            radius: 40.0,
            ring: false,
        };
        let panel = surface(&sphere, &style).unwrap();
        picture(panel.with_layer(line).with_layer(dot))
    };
    for (z, is_seen) in [(1.0, true), (-1.0, false)] {
        let picture = with_line(z);
        let image = Image::of(&picture);
        assert_eq!(image.count(RED) > 10, is_seen);
        assert_eq!(image.count(GREEN) > 3, is_seen);
        let svg = assert_well_formed(&picture);
        assert_eq!(svg.contains("#e02010"), is_seen);
        assert_eq!(svg.contains("<circle"), is_seen);
    }
}

/// A picture with everything in it.
fn full_picture(fixture: &Fixture) -> Picture {
    let patch = surface_of(fixture);
    let uvs = uvs_of(&patch, |p| DVec2::new(p.x + 0.3 * p.y, p.y));
    let waves = PerVertex::from_fn(patch.mesh().vertex_count(), |vertex| {
        (vertex.index() as f64).sin()
    });
    let numbers = PerFace::from_fn(patch.mesh().face_count(), |face| face.index() as f64);
    let checkered = SurfaceStyle {
        checker: Some(CheckerStyle::fitting(&uvs)),
        seams: Some(&uvs),
        edges: true,
        ..SurfaceStyle::default()
    };
    let figure = SurfaceStyle {
        figure: Some(Figure::per_vertex("wave < 1 & \"more\"\u{1}", &waves)),
        ..SurfaceStyle::default()
    };
    let layout = LayoutStyle {
        figure: Some(Figure::per_face("number", &numbers)),
        checker: Some(Squares::Fitting),
        ..LayoutStyle::default()
    };
    side_by_side(vec![
        surface(&patch, &checkered)
            .unwrap()
            .with_caption("<checker>"),
        surface(&patch, &figure).unwrap(),
        uv_layout(&patch, &uvs, &layout).unwrap(),
    ])
    .with_size(900, 340)
    .unwrap()
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    // Above and below the size from which an SVG embeds an image.
    for rings in [6, 30] {
        let fixture = graticule_fixtures::bumpy_patch(rings, 7);
        let draw = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| {
                let picture = full_picture(&fixture);
                (picture.to_png(), picture.to_svg())
            })
        };
        assert!(draw(1) == draw(2));
    }
}

#[test]
fn a_drawing_of_few_triangles_is_all_shapes_and_one_of_many_embeds_an_image() {
    for (rings, images) in [(6, 0), (30, 3)] {
        let picture = full_picture(&graticule_fixtures::bumpy_patch(rings, 7));
        let svg = assert_well_formed(&picture);
        let document = roxmltree::Document::parse(&svg).unwrap();
        let count = |name: &str| {
            let nodes = document.descendants();
            nodes
                .filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", name)))
                .count()
        };
        assert_eq!(count("image"), images);
        assert_eq!(count("polygon") > 300, images == 0);
        assert_eq!(count("linearGradient"), 2);
        assert!(count("path") >= 4 && count("text") >= 7);
    }
}

#[test]
fn scale_and_place_change_nothing() {
    let fixture = graticule_fixtures::bumpy_patch(8, 2);
    let image = |change: &dyn Fn(DVec3) -> DVec3| {
        let picture = full_picture(&fixture.clone().map(change));
        Image::of(&picture)
    };
    let original = image(&|p| p);
    let scaled = image(&|p| p * 2.0_f64.powi(40));
    assert!(original.pixels == scaled.pixels, "a power of two is exact");
    for scale in [1e-30, 1e30] {
        assert_alike(&original, &image(&|p| p * scale));
    }
    // A checker is fixed in texture space; a plain surface may lie anywhere.
    let plain = |shift: DVec3| {
        let patch = surface_of(&fixture.clone().map(|p| p + shift));
        Image::of(&picture(surface(&patch, &SurfaceStyle::default()).unwrap()))
    };
    assert_alike(&plain(DVec3::ZERO), &plain(DVec3::new(1e7, -1e7, 1e7)));
}

/// Rounding moves edges by less than a sample.
fn assert_alike(a: &Image, b: &Image) {
    let differs = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).any(|part| a[part].abs_diff(b[part]) > 40);
    let differing = a
        .pixels
        .iter()
        .zip(&b.pixels)
        .filter(|&pair| differs(pair))
        .count();
    assert!(differing < a.pixels.len() / 300, "{differing} pixels");
}

#[test]
fn degenerate_input_is_drawn_or_refused() {
    let needle = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-300, 0.0)];
    let line = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
    let large = big_triangle(0.0).map(|p| p * 1e150);
    for positions in [big_triangle(0.0), needle, line, large] {
        let one = Surface::from_triangles(positions.to_vec(), &[[0, 1, 2]]).unwrap();
        for smooth in [true, false] {
            let style = SurfaceStyle {
                smooth,
                edges: true,
                ..SurfaceStyle::default()
            };
            let picture = picture(surface(&one, &style).unwrap());
            assert!(Image::of(&picture).pixels.len() == 120 * 120);
            assert_well_formed(&picture);
        }
    }
    let one = Surface::from_triangles(big_triangle(0.0).to_vec(), &[[0, 1, 2]]).unwrap();
    let layout =
        |uvs: [DVec2; 3]| uv_layout(&one, &PerCorner::new(uvs.to_vec()), &LayoutStyle::default());
    let zero = layout([DVec2::ONE; 3]);
    assert!(matches!(zero, Err(DrawError::ZeroExtent { .. })));
    let missing = layout([DVec2::NAN, DVec2::X, DVec2::Y]);
    assert!(matches!(
        missing,
        Err(DrawError::NoCoordinates { faces: 1 })
    ));
    let thin = layout([DVec2::ZERO, DVec2::X, DVec2::X * 3.0]).unwrap();
    assert_well_formed(&picture(thin));
}

#[test]
fn triangles_without_coordinates_are_left_out_of_the_layout_and_grey_on_the_surface() {
    let square = surface_of(&graticule_fixtures::grid(1.0, 1.0, 4, 4));
    let mut uvs = uvs_of(&square, DVec3::truncate);
    uvs.as_mut_slice()[3..9].fill(DVec2::splat(f64::INFINITY));
    let layout = uv_layout(&square, &uvs, &LayoutStyle::default()).unwrap();
    assert_eq!(layout.notes, ["2 triangles without coordinates"]);
    assert_well_formed(&picture(layout));
    let style = SurfaceStyle {
        checker: Some(CheckerStyle::fitting(&uvs)),
        seams: Some(&uvs),
        ..SurfaceStyle::default()
    };
    let panel = surface(&square, &style).unwrap();
    let Layer::Triangles(triangles) = &panel.layers[0] else {
        panic!("the first layer of a surface is its triangles")
    };
    let corners = &triangles.checker.as_ref().unwrap().corners;
    let missing = corners.iter().filter(|face| face[0][0].is_nan()).count();
    assert_eq!(missing, 2);
    assert_well_formed(&picture(panel));
}

#[test]
fn values_of_all_kinds_have_colours() {
    let square = surface_of(&graticule_fixtures::grid(1.0, 1.0, 2, 2));
    let values = PerFace::new(vec![
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        f64::MIN,
        0.0,
        1.0,
        -1e-320,
    ]);
    for range in [Range::Robust, Range::Full, Range::Fixed(0.0, f64::NAN)] {
        for middle in [None, Some(0.5), Some(f64::NAN)] {
            let scale = ColorScale {
                map: ColorMap::Viridis,
                range,
                middle,
                least_range: 0.0,
            };
            let style = SurfaceStyle {
                figure: Some(Figure::per_face("value", &values).with_scale(scale)),
                ..SurfaceStyle::default()
            };
            let picture = picture(surface(&square, &style).unwrap());
            assert_well_formed(&picture);
            assert!(Image::of(&picture).pixels.len() == 120 * 120);
        }
    }
    let short = PerFace::new(vec![1.0]);
    let style = SurfaceStyle {
        figure: Some(Figure::per_face("value", &short)),
        ..SurfaceStyle::default()
    };
    assert!(matches!(
        surface(&square, &style),
        Err(DrawError::ValueCount {
            expected: 8,
            given: 1,
            ..
        })
    ));
}

#[test]
fn a_picture_of_nothing_and_of_impossible_size() {
    let nothing = side_by_side(Vec::new());
    assert_eq!(Image::of(&nothing).width, 800);
    for (width, height) in [(0, 10), (100, 1_000_000)] {
        let refused = nothing.clone().with_size(width, height);
        assert!(matches!(refused, Err(DrawError::PictureSize { .. })));
    }
    let rows = side_by_side(vec![
        panel(
            Eye::Plane,
            triangles(big_triangle(0.0).to_vec(), &[RED])
        );
        5
    ])
    .with_columns(2);
    assert_eq!(rows.size(), [1600, 2400]);
}
