use glam::{DVec2, DVec3};
use graticule_fixtures::{Fixture, Noise, annulus, cube, grid, icosphere, torus};

use super::*;
use crate::mesh::{Attributes, CornerAttribute, Defects, NO_VALUE, PolygonLabels, Topology};

fn soup(positions: &[[f64; 3]], polygons: &[&[u32]]) -> PolygonSoup {
    PolygonSoup {
        positions: positions.iter().map(|&p| DVec3::from_array(p)).collect(),
        polygons: polygons.iter().copied().collect(),
        ..PolygonSoup::default()
    }
}

fn soup_of(fixture: &Fixture) -> PolygonSoup {
    PolygonSoup {
        positions: fixture.positions.clone(),
        polygons: fixture.triangles.iter().map(|t| &t[..]).collect(),
        ..PolygonSoup::default()
    }
}

/// Every triangle with vertices of its own.
fn unwelded(fixture: &Fixture) -> Fixture {
    let corners = fixture.triangles.iter().flatten();
    Fixture {
        positions: corners.map(|&v| fixture.positions[v as usize]).collect(),
        triangles: (0..fixture.triangles.len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
    }
}

fn repaired_with(soup: &PolygonSoup, options: &RepairOptions) -> Repaired {
    let repaired = repair(soup, options, &Watch::new()).unwrap();
    check_maps(soup, &repaired);
    repaired
}

fn repaired(soup: &PolygonSoup) -> Repaired {
    let repaired = repaired_with(soup, &RepairOptions::default());
    check_fixed_point(&repaired, Weld::Auto);
    repaired
}

fn refusal(soup: &PolygonSoup) -> RepairError {
    repair(soup, &RepairOptions::default(), &Watch::new()).unwrap_err()
}

/// Positions, corners and polygons come from where the maps say.
fn check_maps(soup: &PolygonSoup, repaired: &Repaired) {
    let mesh = repaired.surface.mesh();
    assert_eq!(repaired.vertex_sources.len(), mesh.vertex_count());
    assert_eq!(repaired.corner_sources.len(), mesh.halfedge_count());
    assert_eq!(repaired.face_polygons.len(), mesh.face_count());
    for vertex in mesh.vertices() {
        let source = repaired.vertex_sources[vertex] as usize;
        assert_eq!(repaired.surface.position(vertex), soup.positions[source]);
    }
    for corner in mesh.halfedges() {
        let source = repaired.corner_sources[corner] as usize;
        let vertex = soup.polygons.corner_vertices()[source] as usize;
        let gap = repaired.surface.position(mesh.origin(corner)) - soup.positions[vertex];
        let [low, high] = repaired.surface.bounding_box();
        assert!(gap.abs().max_element() <= 1e-9 * (high - low).max_element());
    }
    for corner in repaired.mesh_corners(soup) {
        assert!(corner == NO_VALUE || (corner as usize) < mesh.halfedge_count());
    }
    check_fixed_point(repaired, Weld::Never);
}

fn soup_of_surface(surface: &Surface) -> PolygonSoup {
    let mesh = surface.mesh();
    let triangles: Vec<_> = mesh
        .faces()
        .map(|f| mesh.triangle(f).map(|v| v.0))
        .collect();
    PolygonSoup {
        positions: surface.positions().as_slice().to_vec(),
        polygons: triangles.iter().map(|t| &t[..]).collect(),
        ..PolygonSoup::default()
    }
}

fn check_fixed_point(repaired: &Repaired, weld: Weld) {
    let again = soup_of_surface(&repaired.surface);
    let options = RepairOptions {
        weld,
        ..RepairOptions::default()
    };
    let twice = repair(&again, &options, &Watch::new()).unwrap();
    assert!(
        twice.changes.is_empty(),
        "repaired again: {}",
        twice.changes
    );
    assert_eq!(twice.surface, repaired.surface);
}

fn area(surface: &Surface) -> f64 {
    let triangles = surface
        .mesh()
        .faces()
        .map(|face| surface.corner_positions(face));
    triangles
        .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
        .sum()
}

fn volume(surface: &Surface) -> f64 {
    let triangles = surface
        .mesh()
        .faces()
        .map(|face| surface.corner_positions(face));
    triangles.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

fn total(repaired: &Repaired) -> crate::mesh::ComponentTopology {
    Topology::of(repaired.surface.mesh()).total
}

fn components(repaired: &Repaired) -> usize {
    Topology::of(repaired.surface.mesh()).components.len()
}

#[test]
fn a_sound_surface_is_left_as_it_is() {
    for fixture in [
        cube(),
        icosphere(2),
        torus(2.0, 0.5, 12, 6),
        annulus(1.0, 2.0, 9, 2),
    ] {
        let repaired = repaired(&soup_of(&fixture));
        assert!(repaired.changes.is_empty() && repaired.changes.sentences().is_empty());
        let expected = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        assert_eq!(repaired.surface, expected);
    }
}

#[test]
fn what_is_no_surface_is_refused_by_name() {
    assert_eq!(
        refusal(&PolygonSoup::default()),
        RepairError::NoFaces { vertices: 0 }
    );
    let points = soup(&[[0.0; 3], [1.0; 3]], &[]);
    assert_eq!(refusal(&points), RepairError::NoFaces { vertices: 2 });
    let mut damaged = soup_of(&cube());
    damaged.polygons.push(&[0, 1, 8]);
    let error = RepairError::IndexOutOfRange {
        polygon: 12,
        index: 8,
        vertices: 8,
    };
    assert_eq!(refusal(&damaged), error);
    assert_eq!(
        error.to_string(),
        "polygon 12: vertex index 8 is out of range (8 vertices)"
    );
    let point = soup(&[[1.0; 3]; 3], &[&[0, 1, 2]]);
    assert_eq!(refusal(&point), RepairError::ZeroExtent);
    let line = soup(&[[0.0; 3], [1.0; 3], [2.0; 3]], &[&[0, 1, 2]]);
    assert_eq!(refusal(&line), RepairError::NothingLeft);
    let lines = soup(&[[0.0; 3], [1.0; 3]], &[&[0, 1], &[0, 1, 0]]);
    assert_eq!(refusal(&lines), RepairError::NoUsableFaces { polygons: 2 });
    let huge = soup(&[[-f64::MAX; 3], [f64::MAX; 3], [0.0; 3]], &[&[0, 1, 2]]);
    assert!(matches!(refusal(&huge), RepairError::ExtentOverflow { .. }));
    let watch = Watch::new();
    watch.cancel_handle().cancel();
    let stopped = repair(&soup_of(&cube()), &RepairOptions::default(), &watch);
    assert!(matches!(stopped, Err(RepairError::Stopped(_))));
}

#[test]
fn nan_is_refused_where_used_and_dropped_where_not() {
    let mut damaged = soup_of(&grid(1.0, 1.0, 4, 4));
    damaged.positions.push(DVec3::NAN);
    let with_unused = repaired(&damaged);
    assert_eq!(with_unused.changes.unused_vertices_dropped.all(), [25]);
    damaged.positions[12].y = f64::NAN;
    assert!(matches!(
        refusal(&damaged),
        RepairError::NonFinitePosition { vertex: 12, .. }
    ));
    let options = RepairOptions {
        non_finite: NonFinite::DropPolygons,
        ..RepairOptions::default()
    };
    let dropped = repaired_with(&damaged, &options);
    assert!(!dropped.changes.non_finite_polygons_dropped.is_empty());
    assert_eq!(total(&dropped).boundary_loops, 2);
}

#[test]
fn repeated_corners_duplicates_and_short_polygons_go() {
    let mut damaged = soup_of(&cube());
    let first = damaged.polygons.vertices(0).to_vec();
    for extra in [
        &[0, 0, 1][..],
        &[2, 2, 2],
        &[0, 1],
        &[3],
        &first,
        &[first[2], first[1], first[0]],
    ] {
        damaged.polygons.push(extra);
    }
    let repaired = repaired(&damaged);
    assert_eq!(repaired.surface.mesh().face_count(), 12);
    assert_eq!(
        repaired.changes.collapsed_polygons_dropped.all(),
        [12, 13, 14, 15]
    );
    assert_eq!(repaired.changes.duplicate_polygons_dropped.all(), [16, 17]);
    assert!((volume(&repaired.surface) - 1.0).abs() < 1e-12);
    // The duplicates' corners follow the polygon that stays.
    let corners = repaired.mesh_corners(&damaged);
    let place = damaged.polygons.corner_range(16).start;
    assert_eq!(corners[place], corners[0]);
}

#[test]
fn a_sheet_folded_flat_becomes_a_single_sheet() {
    let folded = soup(
        &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]],
        &[&[0, 1, 2], &[0, 2, 1]],
    );
    let repaired = repaired(&folded);
    assert_eq!(repaired.surface.mesh().face_count(), 1);
    assert_eq!(repaired.changes.duplicate_polygons_dropped.all(), [1]);
}

const CUBE_QUADS: [[u32; 4]; 6] = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
];

fn cube_corner(corner: u32) -> DVec3 {
    let bit = |place: u32| f64::from((corner >> place) & 1);
    DVec3::new(bit(0), bit(1), bit(2))
}

/// Cubes at several places whose coinciding corners are one vertex.
fn joined_cubes(places: &[DVec3]) -> PolygonSoup {
    let mut result = PolygonSoup::default();
    for &place in places {
        let numbers: Vec<u32> = (0..8)
            .map(|corner| {
                let position = cube_corner(corner) + place;
                let known = result.positions.iter().position(|&p| p == position);
                known.unwrap_or_else(|| {
                    result.positions.push(position);
                    result.positions.len() - 1
                }) as u32
            })
            .collect();
        for quad in CUBE_QUADS {
            result
                .polygons
                .push(&quad.map(|corner| numbers[corner as usize]));
        }
    }
    result
}

#[test]
fn cubes_that_share_a_vertex_an_edge_or_a_wall_come_apart_closed() {
    let places = [
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(1.0, 0.0, 0.0),
    ];
    for (place, shared) in places.into_iter().zip([1, 2, 4]) {
        let joined = joined_cubes(&[DVec3::ZERO, place]);
        assert_eq!(joined.positions.len(), 16 - shared);
        let mut inside_out = joined.clone();
        let turned: Polygons = joined
            .polygons
            .iter()
            .map(reversed)
            .collect::<Vec<_>>()
            .to_polygons();
        inside_out.polygons = turned;
        for soup in [joined, inside_out] {
            let repaired = repaired(&soup);
            assert_eq!(components(&repaired), 2);
            assert_eq!(total(&repaired).boundary_loops, 0);
            assert_eq!(repaired.changes.vertices_split.count(), shared);
            assert!((volume(&repaired.surface) - 2.0).abs() < 1e-12);
        }
    }
}

use crate::mesh::Polygons;

fn reversed(polygon: &[u32]) -> Vec<u32> {
    polygon.iter().rev().copied().collect()
}

trait ToPolygons {
    fn to_polygons(&self) -> Polygons;
}

impl ToPolygons for Vec<Vec<u32>> {
    fn to_polygons(&self) -> Polygons {
        self.iter().map(|polygon| &polygon[..]).collect()
    }
}

#[test]
fn a_fin_is_cut_off_and_the_sheet_stays_whole() {
    // A grid with a triangle standing on an inner edge, and one on a chain of edges.
    let sheet = grid(1.0, 1.0, 6, 6);
    let mut finned = soup_of(&sheet);
    let tip = finned.positions.len() as u32;
    finned.positions.push(DVec3::new(0.5, 0.5, 1.0));
    for edge in [[22, 23], [23, 24], [24, 25]] {
        finned.polygons.push(&[edge[0], edge[1], tip]);
    }
    let repaired = repaired(&finned);
    assert_eq!(components(&repaired), 2);
    assert_eq!(repaired.changes.edges_split.count(), 3);
    let topology = Topology::of(repaired.surface.mesh());
    let sheet_part = topology.components[topology.largest_component()];
    assert_eq!([sheet_part.vertices, sheet_part.boundary_loops], [49, 1]);
}

#[test]
fn three_faces_at_an_edge_become_manifold() {
    let fan = soup(
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [0., -1., 0.2],
            [0.2, 0., 1.],
        ],
        &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]],
    );
    let repaired = repaired(&fan);
    assert_eq!(repaired.surface.mesh().face_count(), 3);
    assert_eq!(repaired.changes.edges_split.all(), [[0, 1]]);
    assert_eq!(repaired.changes.vertices_split.all(), [0, 1]);
}

#[test]
fn a_checkerboard_comes_apart_into_its_squares() {
    let mut board = PolygonSoup::default();
    for i in 0..9 {
        for j in 0..9 {
            board
                .positions
                .push(DVec3::new(f64::from(i), f64::from(j), 0.0));
        }
    }
    for i in 0..8_u32 {
        for j in (0..8).filter(|j| (i + j) % 2 == 0) {
            let v = 9 * i + j;
            board.polygons.push(&[v, v + 9, v + 10]);
            board.polygons.push(&[v, v + 10, v + 1]);
        }
    }
    let repaired = repaired(&board);
    assert_eq!(components(&repaired), 32);
    assert_eq!(repaired.changes.vertices_split.count(), 49);
}

#[test]
fn orientation_is_made_consistent_and_outward() {
    let mut mixed = soup_of(&grid(1.0, 1.0, 8, 8));
    let turned = |(i, polygon): (usize, &[u32])| match i % 3 {
        0 => reversed(polygon),
        _ => polygon.to_vec(),
    };
    mixed.polygons = mixed
        .polygons
        .iter()
        .enumerate()
        .map(turned)
        .collect::<Vec<_>>()
        .to_polygons();
    let fixed = repaired(&mixed);
    assert_eq!(fixed.changes.polygons_turned.count(), 43);
    let up = fixed.surface.mesh().faces().all(|face| {
        let [a, b, c] = fixed.surface.corner_positions(face);
        (b - a).cross(c - a).z > 0.0
    });
    assert!(up);
    for scale in [-660, -40, 0, 40, 300] {
        let scaled = icosphere(1).map(|p| p * 2.0_f64.powi(scale));
        let mut inward = soup_of(&scaled);
        inward.polygons = inward
            .polygons
            .iter()
            .map(reversed)
            .collect::<Vec<_>>()
            .to_polygons();
        let outward = repaired(&inward);
        assert_eq!(outward.changes.components_turned.all(), [0]);
        assert!(outward.changes.polygons_turned.is_empty());
        let corners = outward.surface.corner_positions(crate::mesh::FaceId(0));
        let [a, b, c] = corners.map(|p| p * 2.0_f64.powi(-scale));
        assert!((b - a).cross(c - a).dot(a) > 0.0);
    }
}

#[test]
fn a_cavity_stays_a_cavity_and_turns_with_what_is_around_it() {
    let outer = icosphere(2);
    let mut inner = icosphere(1).map(|p| p * 0.3 + DVec3::new(0.1, 0.2, 0.0));
    let beside = icosphere(1).map(|p| p + DVec3::X * 5.0);
    inner.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let hollow = outer.joined(&inner).joined(&beside);
    let kept = repaired(&soup_of(&hollow));
    assert!(kept.changes.is_empty());
    assert_eq!(kept.changes.cavities.all(), [320]);
    let mut inside_out = hollow.clone();
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let turned = repaired(&soup_of(&inside_out));
    assert_eq!(turned.changes.components_turned.all(), [0, 320, 400]);
    assert!((volume(&turned.surface) - volume(&kept.surface)).abs() < 1e-12);
}

/// A strip of quads closed with a half turn.
fn moebius(length: u32) -> PolygonSoup {
    let mut strip = PolygonSoup::default();
    for i in 0..length {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(length);
        for side in [-0.3, 0.3] {
            let radius = 1.0 + side * (angle / 2.0).cos();
            let height = side * (angle / 2.0).sin();
            strip.positions.push(DVec3::new(
                radius * angle.cos(),
                radius * angle.sin(),
                height,
            ));
        }
        let [a, b] = [2 * i, 2 * i + 1];
        let [c, d] = if i + 1 == length {
            [1, 0]
        } else {
            [a + 2, b + 2]
        };
        strip.polygons.push(&[a, c, d, b]);
    }
    strip
}

#[test]
fn a_moebius_strip_is_refused_or_cut_open() {
    let strip = moebius(20);
    assert!(matches!(refusal(&strip), RepairError::NonOrientable { .. }));
    let options = RepairOptions {
        non_orientable: NonOrientable::CutOpen,
        ..RepairOptions::default()
    };
    let cut = repaired_with(&strip, &options);
    assert!(total(&cut).is_disk());
    assert!((area(&cut.surface) - area_of_soup(&strip)).abs() < 1e-9);
    assert_eq!(cut.changes.edges_cut.count(), 1);
}

fn area_of_soup(soup: &PolygonSoup) -> f64 {
    let triangle = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length() / 2.0;
    let polygon = |vertices: &[u32]| -> f64 {
        let positions: Vec<_> = vertices
            .iter()
            .map(|&v| soup.positions[v as usize])
            .collect();
        let triangles = crate::mesh::triangulate_polygon(&positions).into_iter();
        triangles
            .map(|t| triangle(t.map(|corner| positions[corner as usize])))
            .sum()
    };
    soup.polygons.iter().map(polygon).sum()
}

#[test]
fn a_klein_bottle_is_refused_or_cut_open() {
    let [around, along] = [12_u32, 10_u32];
    let mut bottle = PolygonSoup::default();
    for i in 0..along {
        for j in 0..around {
            let [u, v] = [(i, along), (j, around)]
                .map(|(k, n)| std::f64::consts::TAU * f64::from(k) / f64::from(n));
            let w = (u / 2.0).cos() * v.sin() - (u / 2.0).sin() * (2.0 * v).sin();
            let height = (u / 2.0).sin() * v.sin() + (u / 2.0).cos() * (2.0 * v).sin();
            bottle
                .positions
                .push(DVec3::new((3.0 + w) * u.cos(), (3.0 + w) * u.sin(), height));
            let vertex = |i: u32, j: u32| match i == along {
                true => (around - j % around) % around,
                false => i * around + j % around,
            };
            bottle.polygons.push(&[
                vertex(i, j),
                vertex(i + 1, j),
                vertex(i + 1, j + 1),
                vertex(i, j + 1),
            ]);
        }
    }
    assert!(matches!(
        refusal(&bottle),
        RepairError::NonOrientable { .. }
    ));
    let options = RepairOptions {
        non_orientable: NonOrientable::CutOpen,
        ..RepairOptions::default()
    };
    let cut = repaired_with(&bottle, &options);
    assert_eq!([total(&cut).boundary_loops, total(&cut).genus], [2, 0]);
}

#[test]
fn triangles_with_vertices_of_their_own_are_welded() {
    for fixture in [grid(1.0, 1.0, 8, 8), icosphere(2), torus(2.0, 0.5, 12, 6)] {
        let welded = repaired(&soup_of(&unwelded(&fixture)));
        let expected = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let expected = Topology::of(expected.mesh());
        assert_eq!(
            Topology::of(welded.surface.mesh()).components,
            expected.components
        );
        assert!(!welded.changes.vertices_welded.is_empty());
    }
    let options = RepairOptions {
        weld: Weld::Never,
        ..RepairOptions::default()
    };
    let soup = soup_of(&unwelded(&cube()));
    let apart = repair(&soup, &options, &Watch::new()).unwrap();
    assert_eq!(components(&apart), 12);
}

/// A cylinder around z cut open along a line, optionally with texture coordinates per vertex.
fn cut_cylinder(textured: bool) -> PolygonSoup {
    let around = 12_u32;
    let mut soup = PolygonSoup::default();
    let mut uvs = Vec::new();
    for i in 0..=around {
        // Exactly the same positions at both ends.
        let angle = std::f64::consts::TAU * f64::from(i % around) / f64::from(around);
        for z in [0.0, 1.0, 2.0] {
            soup.positions.push(DVec3::new(angle.cos(), angle.sin(), z));
            uvs.push(DVec2::new(f64::from(i), z));
        }
    }
    for i in 0..around {
        for j in 0..2 {
            let v = 3 * i + j;
            soup.polygons.push(&[v, v + 3, v + 4, v + 1]);
        }
    }
    if textured {
        soup.attributes.uv_sets.push(CornerAttribute {
            name: String::new(),
            values: uvs,
            corner_values: soup.polygons.corner_vertices().to_vec(),
        });
    }
    soup
}

#[test]
fn a_cut_stays_open_but_a_texture_seam_closes() {
    let cut = repaired(&cut_cylinder(false));
    assert!(total(&cut).is_disk());
    assert_eq!(cut.changes.seams_left_open.count(), 2);
    let seam = repaired(&cut_cylinder(true));
    assert_eq!(
        [total(&seam).boundary_loops, total(&seam).vertices],
        [2, 36]
    );
    let options = RepairOptions {
        weld: Weld::Always,
        ..RepairOptions::default()
    };
    let closed = repaired_with(&cut_cylinder(false), &options);
    assert_eq!(total(&closed).boundary_loops, 2);
}

#[test]
fn polygons_are_cut_and_come_back_whole() {
    let mut quads = joined_cubes(&[DVec3::ZERO]);
    let corners = quads.polygons.corner_count() as u32;
    let uvs = (0..corners).map(|corner| DVec2::splat(f64::from(corner)));
    quads.attributes = Attributes {
        uv_sets: vec![CornerAttribute {
            name: "uv".into(),
            values: uvs.collect(),
            corner_values: (0..corners).collect(),
        }],
        materials: Some(PolygonLabels {
            names: vec!["wood".into()],
            polygon_names: vec![0, NO_VALUE, 0, 0, 0, 0],
        }),
        ..Attributes::default()
    };
    let whole = repaired(&quads);
    assert_eq!(whole.surface.mesh().face_count(), 12);
    assert_eq!(whole.changes.polygons_triangulated, 6);
    assert_eq!(whole.to_soup(&quads), quads);
    assert!(
        whole
            .mesh_corners(&quads)
            .iter()
            .all(|&corner| corner != NO_VALUE)
    );
    // One polygon inside out: it comes back turned, with its own attributes.
    let mut turned = quads.clone();
    turned.polygons = quads
        .polygons
        .iter()
        .enumerate()
        .map(|(i, polygon)| {
            if i == 2 {
                reversed(polygon)
            } else {
                polygon.to_vec()
            }
        })
        .collect::<Vec<_>>()
        .to_polygons();
    let back = repaired(&turned).to_soup(&turned);
    assert_eq!(back.polygons.len(), 6);
    let same_corner = |corner: usize| turned.attributes.uv_sets[0].get(corner);
    for corner in turned.polygons.corner_range(2) {
        let vertex = turned.polygons.corner_vertices()[corner];
        let there = back
            .polygons
            .corner_range(2)
            .find(|&c| back.polygons.corner_vertices()[c] == vertex);
        assert_eq!(
            back.attributes.uv_sets[0].get(there.unwrap()),
            same_corner(corner)
        );
    }
}

#[test]
fn a_result_goes_back_onto_the_polygons_of_the_soup() {
    let quads = joined_cubes(&[DVec3::ZERO]);
    let repaired = repaired(&quads);
    let mesh = repaired.surface.mesh();
    let places = PerCorner::from_fn(mesh.halfedge_count(), |corner| {
        repaired.surface.position(mesh.origin(corner))
    });
    let attribute = repaired.to_soup_corners(&quads, "place", &places);
    for (corner, &vertex) in quads.polygons.corner_vertices().iter().enumerate() {
        assert_eq!(
            attribute.get(corner),
            Some(quads.positions[vertex as usize])
        );
    }
}

#[test]
fn quads_that_share_two_opposite_corners_stay_manifold() {
    // Two quads around vertex 3, which has no other neighbours than 0 and 2.
    let doublet = soup(
        &[
            [0., 0., 0.],
            [1., -2., 0.],
            [2., 0., 0.],
            [1., 0.5, 0.],
            [1., 2., 0.],
        ],
        &[&[0, 1, 2, 3], &[0, 3, 2, 4]],
    );
    let repaired = repaired(&doublet);
    assert!(repaired.changes.vertices_split.is_empty());
    assert!(total(&repaired).is_disk());
}

#[test]
fn a_cap_inside_the_surface_goes_by_an_exchange() {
    let cap = soup(
        &[
            [0., 0., 0.],
            [2., 0., 0.],
            [1., 1., 0.],
            [1., -1., 0.],
            [1., 0., 0.],
        ],
        &[&[0, 4, 2], &[4, 1, 2], &[0, 1, 4], &[1, 0, 3]],
    );
    let repaired = repaired(&cap);
    assert!(total(&repaired).is_disk());
    assert_eq!(total(&repaired).vertices, 5);
    assert_eq!(repaired.changes.edges_exchanged.all(), [2]);
    assert!((area(&repaired.surface) - 2.0).abs() < 1e-12);
    assert!(
        repaired
            .mesh_corners(&cap)
            .iter()
            .all(|&corner| corner != NO_VALUE)
    );
}

#[test]
fn a_cap_at_the_boundary_is_dropped() {
    let mut capped = soup_of(&grid(1.0, 1.0, 8, 8));
    capped.positions.push(DVec3::new(0.5, 0.0, 0.0));
    capped.polygons.push(&[0, 8, 81]);
    let dropped = repaired(&capped);
    assert_eq!(dropped.changes.zero_area_dropped.all(), [128]);
    assert!(total(&dropped).is_disk());
    // A cap that closes a T-junction with the boundary.
    let strip = soup(
        &[
            [0., 0., 0.],
            [2., 0., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [2., 1., 0.],
        ],
        &[&[0, 1, 2], &[0, 2, 3], &[2, 1, 4], &[2, 4, 3]],
    );
    let dropped = repaired(&strip);
    assert_eq!(dropped.changes.zero_area_dropped.all(), [0]);
    assert_eq!(dropped.surface.mesh().face_count(), 3);
    assert!(total(&dropped).is_disk());
}

#[test]
fn an_edge_without_length_is_collapsed() {
    let mut pinched = soup_of(&grid(1.0, 1.0, 8, 8));
    pinched.positions[40] = pinched.positions[41];
    let repaired = repaired(&pinched);
    assert_eq!(repaired.changes.edges_collapsed.all(), [[40, 41]]);
    assert_eq!(total(&repaired).vertices, 80);
    assert!(total(&repaired).is_disk());
    assert!((area(&repaired.surface) - 1.0).abs() < 0.1);
    assert!(
        repaired
            .mesh_corners(&pinched)
            .iter()
            .all(|&corner| corner != NO_VALUE)
    );
}

#[test]
fn many_points_on_one_line_leave_no_flat_triangle() {
    // A long edge against a chain of collinear points, filled with caps.
    let count = 20_u32;
    let mut filled = PolygonSoup::default();
    filled
        .positions
        .extend((0..=count).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)));
    filled
        .positions
        .extend([DVec3::new(10.0, 9.0, 0.0), DVec3::new(10.0, -9.0, 0.0)]);
    for i in 0..count {
        filled.polygons.push(&[i, i + 1, count + 1]);
    }
    filled.polygons.push(&[count, 0, count + 2]);
    for i in 1..count {
        filled.polygons.push(&[0, i + 1, i]);
    }
    let repaired = repaired(&filled);
    assert!(total(&repaired).is_disk());
    assert!((area(&repaired.surface) - 180.0).abs() < 1e-9);
    let defects = Defects::find(&soup_of_surface(&repaired.surface));
    assert!(defects.zero_area.is_empty() && defects.is_sound());
}

#[test]
fn two_cubes_of_very_different_size_stay_two_cubes() {
    let small = cube().map(|p| p * 1e-8);
    let large = cube().map(|p| (p + DVec3::ONE) * 1e8);
    let repaired = repaired(&soup_of(&small.joined(&large)));
    assert!(repaired.changes.is_empty());
    assert_eq!(components(&repaired), 2);
}

#[test]
fn scaling_by_powers_of_two_and_far_offsets_change_nothing() {
    let mut noise = Noise::new(11);
    let mut soup = random_soup(&mut noise, 30, 60);
    let expected = repair(&soup, &RepairOptions::default(), &Watch::new()).unwrap();
    for exponent in [-400, -40, 40, 400] {
        let mut scaled = soup.clone();
        for position in &mut scaled.positions {
            *position *= 2.0_f64.powi(exponent);
        }
        let result = repair(&scaled, &RepairOptions::default(), &Watch::new()).unwrap();
        assert_eq!(result.changes, expected.changes);
        assert_eq!(result.surface.mesh(), expected.surface.mesh());
    }
    for position in &mut soup.positions {
        *position = *position * 0.01 + DVec3::splat(1e7);
    }
    repaired(&soup_of(
        &grid(0.01, 0.01, 8, 8).map(|p| p + DVec3::splat(1e7)),
    ));
    let _ = repaired(&soup);
}

/// Triangles and quads over few vertices, many of them at the same places: everything is wrong.
fn random_soup(noise: &mut Noise, vertices: usize, polygons: usize) -> PolygonSoup {
    let mut soup = PolygonSoup::default();
    for _ in 0..vertices {
        let mut coordinate = || f64::from(noise.below(4) as u32);
        soup.positions
            .push(DVec3::new(coordinate(), coordinate(), coordinate()));
    }
    for _ in 0..polygons {
        let corners = 2 + noise.below(5);
        let polygon: Vec<_> = (0..corners).map(|_| noise.below(vertices) as u32).collect();
        soup.polygons.push(&polygon);
    }
    soup
}

fn check_random(soup: &PolygonSoup, options: &RepairOptions) {
    let _ = Defects::find(soup).findings();
    match repair(soup, options, &Watch::new()) {
        Err(error) => assert!(!matches!(error, RepairError::Mesh(_)), "{error}"),
        Ok(repaired) => {
            let topology = Topology::of(repaired.surface.mesh());
            for component in &topology.components {
                let expected = 2 - 2 * component.genus as i64 - component.boundary_loops as i64;
                assert_eq!(component.euler_characteristic, expected);
            }
            if options.weld != Weld::Always {
                check_maps(soup, &repaired);
            }
            let whole = repaired.to_soup(soup);
            assert!(whole.polygons.len() <= repaired.surface.mesh().face_count());
        }
    }
}

#[test]
fn random_soups_end_in_a_surface_or_a_named_refusal() {
    let cut_open = |weld| RepairOptions {
        weld,
        non_orientable: NonOrientable::CutOpen,
        ..RepairOptions::default()
    };
    for seed in 0..1500 {
        let mut noise = Noise::new(seed);
        let vertices = 4 + noise.below(20);
        let polygons = 1 + noise.below(30);
        let soup = random_soup(&mut noise, vertices, polygons);
        check_random(&soup, &RepairOptions::default());
        check_random(&soup, &cut_open(Weld::Auto));
        check_random(&soup, &cut_open(Weld::Always));
        check_random(&soup, &cut_open(Weld::Never));
    }
}
