use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use graticule_fixtures::icosphere;

use super::chart_map::lay_down;
use super::chart_map_assembly::Assembly;
use super::chart_map_squares::Layouted;
use super::layout_examples::{cube_net, torus_net};
use super::split::plan_charts;
use super::split_arcs::{finish_arcs, parameterize_arcs};
use super::*;
use crate::geometry::{face_areas, face_shapes};
use crate::measure::{measure_map, orientation};
use crate::mesh::{
    Element, FaceId, PerCorner, PerEdge, PerVertex, RefinedSurface, Surface, SurfacePoint, Topology,
};
use crate::watch::Watch;

/// A sphere whose charts are the triangles of an icosahedron: no net at all.
fn icosahedron_net(levels: u32) -> EmbeddedNet {
    let fixture = icosphere(levels);
    let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
    let mesh = surface.mesh();
    // Four triangles in the place of each one, level by level.
    let chart = |face: FaceId| face.index() >> (2 * levels);
    let edges = PerEdge::from_fn(mesh.edge_count(), |edge| {
        let side = mesh.edge_halfedge(edge);
        let twin = mesh.twin(side)?;
        (chart(side.face()) != chart(twin.face())).then_some(ArcKind::Line)
    });
    EmbeddedNet {
        nodes: PerVertex::filled(mesh.vertex_count(), false),
        coordinates: PerCorner::filled(mesh.halfedge_count(), None),
        edges,
        refined: RefinedSurface::whole(surface),
    }
}

/// The cube's net with a triangle of every second chart without coordinates.
fn cube_with_singularities(cells: u32) -> EmbeddedNet {
    let mut net = cube_net(cells);
    for face in (0..6).step_by(2) {
        let triangle = FaceId(face * 2 * cells * cells + cells);
        for corner in triangle.halfedges() {
            net.coordinates[corner] = None;
        }
    }
    net
}

fn maps(net: EmbeddedNet, options: ChartMapOptions) -> (Surface, ChartLayout, ChartMaps) {
    let input = net.refined.surface.clone();
    let layout = ChartLayout::new(net).unwrap();
    let maps = chart_maps(&input, &layout, &options, &Watch::new()).unwrap();
    (input, layout, maps)
}

/// What holds of all maps.
fn check(input: &Surface, maps: &ChartMaps) {
    let mesh = maps.surface().mesh();
    for face in mesh.faces() {
        let [a, b, c] = face.halfedges().map(|corner| maps.coordinates()[corner]);
        assert!(orientation(a, b, c) > 0, "{face} is flipped: {a} {b} {c}");
    }
    assert!(maps.largest_gap() < 1e-9, "{}", maps.largest_gap());
    let square_area: Vec<f64> = (0..maps.squares().len())
        .map(|square| {
            let faces = maps.faces_of(SquareId::from_index(square));
            let area = |face: FaceId| {
                let [a, b, c] = face.halfedges().map(|corner| maps.coordinates()[corner]);
                0.5 * (b - a).perp_dot(c - a)
            };
            faces.map(area).sum()
        })
        .collect();
    assert!(
        square_area.iter().all(|area| (area - 1.0).abs() < 1e-9),
        "{square_area:?}"
    );
    let mut rest = face_areas(&face_shapes(input));
    for (face, area) in face_areas(&face_shapes(maps.surface())).enumerate() {
        rest[maps.refined().face_origin[face]] -= area;
    }
    assert!(rest.iter().all(|rest| rest.abs() < 1e-9));
    for (vertex, point) in maps.refined().vertex_origin.enumerate() {
        let missed = point
            .position(input)
            .distance(maps.surface().position(vertex));
        assert!(missed < 1e-9, "{vertex} is {missed} beside its origin");
    }
    let [before, after] = [input, maps.surface()].map(|s| Topology::of(s.mesh()).total);
    assert_eq!(before.euler_characteristic, after.euler_characteristic);
    // Squares, their seams and what lies at their ends are a complex of the same surface.
    let mut ends = BTreeSet::new();
    for seam in maps.seams() {
        for end in [seam.vertices.first(), seam.vertices.last()] {
            ends.insert(*end.unwrap());
        }
    }
    let counts = [ends.len(), maps.seams().len(), maps.squares().len()];
    let [ends, seams, squares] = counts.map(|count| i64::try_from(count).unwrap());
    assert_eq!(ends - seams + squares, before.euler_characteristic);
}

#[test]
fn regular_charts_keep_the_coordinates_of_the_net() {
    for net in [cube_net(4), torus_net(5, 3, 3)] {
        let (input, layout, maps) = maps(net, ChartMapOptions::default());
        check(&input, &maps);
        assert_eq!(maps.counts().net, layout.charts().len());
        assert_eq!(
            maps.surface().mesh().face_count(),
            input.mesh().face_count()
        );
        assert!(
            maps.squares()
                .iter()
                .all(|square| (square.size - DVec2::ONE).length() < 1e-9)
        );
        for (face, &chart) in layout.chart_of().enumerate() {
            let square = maps
                .squares()
                .iter()
                .position(|s| s.chart == chart)
                .unwrap();
            let faces = maps.faces_of(SquareId::from_index(square));
            let place = |f: FaceId, c: usize| maps.coordinates()[f.halfedges()[c]];
            let net = face
                .halfedges()
                .map(|corner| layout.coordinates()[corner].unwrap());
            let found = |f: &FaceId| (0..3).all(|c| place(*f, c).distance(net[c]) < 1e-9);
            assert!(faces.into_iter().any(|f| found(&f)));
        }
    }
}

#[test]
fn charts_with_singularities_agree_with_their_neighbours() {
    let (input, _, maps) = maps(cube_with_singularities(6), ChartMapOptions::default());
    check(&input, &maps);
    let counts = maps.counts();
    assert_eq!(
        [counts.net, counts.mean_value, counts.split_charts],
        [3, 3, 0]
    );
}

#[test]
fn charts_whose_borders_are_evened_out_agree_with_their_neighbours() {
    let net = cube_with_singularities(6);
    let input = net.refined.surface.clone();
    let layout = ChartLayout::new(net).unwrap();
    let options = ChartMapOptions::default();
    let is_even = vec![true; layout.arcs().len()];
    let assembly = lay_down(&input, &layout, &options, &is_even, &Watch::new()).unwrap();
    let maps = assembly.unwrap().finish(&layout).unwrap();
    check(&input, &maps);
    assert!(maps.largest_gap() < 1e-9);
}

#[test]
fn charts_with_three_sides_become_three_squares() {
    for levels in [1, 2, 4] {
        let (input, _, maps) = maps(icosahedron_net(levels), ChartMapOptions::default());
        check(&input, &maps);
        let counts = maps.counts();
        assert_eq!(
            [counts.charts, counts.squares, counts.split_charts],
            [20, 60, 20]
        );
        // Each vertex of the icosahedron, middle of an edge and centre of a triangle is a corner.
        assert_eq!(maps.seams().len(), 2 * 30 + 3 * 20);
    }
}

#[test]
fn squares_of_one_triangle_have_about_the_same_share_of_it() {
    let (_, _, maps) = maps(icosahedron_net(3), ChartMapOptions::default());
    let areas = face_areas(&face_shapes(maps.surface()));
    let of_square = |square: usize| -> f64 {
        maps.faces_of(SquareId::from_index(square))
            .map(|face| areas[face])
            .sum()
    };
    let shares: Vec<f64> = (0..60).map(of_square).collect();
    let mean = shares.iter().sum::<f64>() / 60.0;
    assert!(
        shares.iter().all(|share| (share / mean - 1.0).abs() < 0.05),
        "{shares:?}"
    );
}

#[test]
fn a_charts_own_corners_are_kept_when_the_net_is() {
    let options = ChartMapOptions {
        keep_net: true,
        ..ChartMapOptions::default()
    };
    let (input, _, cube) = maps(cube_with_singularities(4), options);
    check(&input, &cube);
    assert_eq!(cube.counts().keep_net, 6);
    assert!(
        cube.squares()
            .iter()
            .all(|s| (s.size - DVec2::ONE).length() < 1e-9)
    );
    let (input, _, sphere) = maps(icosahedron_net(2), options);
    check(&input, &sphere);
    assert!(
        sphere
            .squares()
            .iter()
            .all(|s| s.keeps_net && s.size == DVec2::splat(0.5))
    );
}

#[test]
fn charts_between_closer_lines_keep_the_net_too() {
    let mut net = cube_net(4);
    net.coordinates = net.coordinates.map(|place| place.map(|place| place / 4.0));
    for corner in FaceId(4).halfedges() {
        net.coordinates[corner] = None;
    }
    let options = ChartMapOptions {
        keep_net: true,
        ..ChartMapOptions::default()
    };
    let (input, _, cube) = maps(net, options);
    check(&input, &cube);
    let quarter = DVec2::splat(0.25);
    assert!(
        cube.squares()
            .iter()
            .all(|square| square.size == quarter && square.keeps_net)
    );
    let atlas = chart_atlas(&cube, &Arrangement::Net, &Watch::new()).unwrap();
    assert!(
        atlas
            .placements
            .iter()
            .all(|place| place.size == DVec2::ONE)
    );
}

#[test]
fn a_chart_that_would_need_too_many_squares_to_keep_the_net_does_not_keep_it() {
    let squares = |length: f64| {
        let mut net = cube_net(4);
        let of_face = 2 * 4 * 4;
        // One chart without coordinates, next to one whose side is so many spacings long.
        for corner in (2 * of_face..3 * of_face).flat_map(|face| FaceId(face).halfedges()) {
            net.coordinates[corner] = net.coordinates[corner].map(|place| place * length);
        }
        for corner in FaceId(4).halfedges() {
            net.coordinates[corner] = None;
        }
        let options = ChartMapOptions {
            keep_net: true,
            improvement_steps: 0,
            ..ChartMapOptions::default()
        };
        let (input, layout, maps) = maps(net, options);
        check(&input, &maps);
        let chart = layout.chart_of()[FaceId(4)];
        let of_chart = maps.squares().iter().filter(|square| square.chart == chart);
        (
            of_chart.clone().count(),
            of_chart.filter(|s| s.keeps_net).count(),
        )
    };
    assert_eq!(squares(30.0), (33, 33));
    assert_eq!(squares(70.0), (1, 0));
}

#[test]
fn relaxation_lowers_the_kink_across_seams_and_flips_nothing() {
    let kink = |rounds: u32| {
        let options = ChartMapOptions {
            relaxation_rounds: rounds,
            improvement_steps: 0,
            ..ChartMapOptions::default()
        };
        let mut net = icosahedron_net(3);
        // A shear makes lengths along arcs a poor parameter.
        let shear = |p: DVec3| DVec3::new(p.x + 0.8 * p.z, p.y, p.z * (1.0 + 0.5 * p.x));
        let moved = net.refined.surface.positions().map(|&p| shear(p));
        net.refined.surface = Surface::new(net.refined.surface.shared_mesh(), moved).unwrap();
        let (input, _, maps) = maps(net, options);
        check(&input, &maps);
        let mesh = maps.surface().mesh();
        let mut jumps = 0.0;
        for seam in maps.seams() {
            let [Some(left), Some(right)] = seam.sides else {
                continue;
            };
            for &vertex in &seam.vertices[1..seam.vertices.len() - 1] {
                // What the parameter misses the mean of its neighbours by.
                let mut sum = DVec2::ZERO;
                for corner in mesh.outgoing(vertex) {
                    let side = if maps.square_of()[corner.face()] == left.square {
                        left
                    } else {
                        right
                    };
                    let here = side.share(maps.coordinates()[corner]);
                    for other in [corner.next(), corner.previous()] {
                        let there = side.share(maps.coordinates()[other]);
                        sum += DVec2::new(there - here, 1.0);
                    }
                }
                jumps += (sum.x / sum.y).abs();
            }
        }
        jumps
    };
    let [before, after] = [kink(0), kink(30)];
    assert!(after < 0.8 * before, "{after} after, {before} before");
}

/// A cube on one face of which the vertices are drawn together in the middle of each side and of the
/// face, as no net would have them.
fn squeezed_cube() -> EmbeddedNet {
    let mut net = cube_net(8);
    let drawn = |&p: &DVec3| {
        let far = p.z.to_bits() == 1.0_f64.to_bits();
        let place = DVec3::new(p.x.powi(7), p.y.powi(7), p.z);
        if far { place } else { p }
    };
    let moved = net.refined.surface.positions().map(drawn);
    net.refined.surface = Surface::new(net.refined.surface.shared_mesh(), moved).unwrap();
    net
}

#[test]
fn charts_that_the_net_squeezes_are_laid_anew() {
    for keep_net in [false, true] {
        let options = ChartMapOptions {
            keep_net,
            ..ChartMapOptions::default()
        };
        let (input, _, maps) = maps(squeezed_cube(), options);
        check(&input, &maps);
        let counts = maps.counts();
        assert_eq!([counts.keep_net, counts.squares], [6, 6]);
        // The face itself, and those beside it, whose arcs it shares.
        assert!(counts.mean_value >= 1 && counts.net >= 1, "{counts:?}");
        let atlas = chart_atlas(&maps, &Arrangement::default(), &Watch::new()).unwrap();
        let measure = measure_map(maps.surface(), &atlas.corner_uv, &Watch::new()).unwrap();
        let energy = measure.distortion.unwrap().symmetric_dirichlet.unwrap();
        assert!(energy < 5.5, "{energy}");
    }
}

#[test]
fn charts_that_cannot_be_split_go_onto_one_square_each() {
    let net = icosahedron_net(3);
    let input = net.refined.surface.clone();
    let layout = ChartLayout::new(net).unwrap();
    let mut arcs = parameterize_arcs(&layout, &vec![false; layout.arcs().len()]);
    let plans = plan_charts(&layout, &mut arcs, false);
    let shared = finish_arcs(&mut arcs, &layout);
    let layouted = Layouted::new(&input, &layout, &arcs, 5);
    let watch = Watch::new();
    let mut assembly = Assembly::new(shared as usize);
    for (index, plan) in plans.iter().enumerate() {
        let chart = ChartId::from_index(index);
        let outlined = layouted.outlined(chart, plan).unwrap();
        // Every second chart is split: neighbours agree all the same.
        let squares = match index % 2 {
            0 => vec![outlined.unsplit(0.5, &watch).unwrap()],
            _ => layouted.squares(chart, plan, &watch).unwrap(),
        };
        assembly.add(chart, squares, plan);
    }
    assembly.warn(&watch);
    let maps = assembly.finish(&layout).unwrap();
    check(&input, &maps);
    let counts = maps.counts();
    assert_eq!([counts.squares, counts.split_charts], [10 + 30, 10]);
    assert_eq!(watch.warnings()[0].code, "charts-not-split");
}

#[test]
fn a_chart_with_a_deep_finger_has_no_flip() {
    // One face of a cube grows a finger three thousand times as long as it is wide: rounding
    // leaves its tip no room in a square.
    let net = cube_with_finger(28, 0.002, 12.0);
    let watch = Watch::new();
    let input = net.refined.surface.clone();
    let layout = ChartLayout::new(net).unwrap();
    let maps = chart_maps(&input, &layout, &ChartMapOptions::default(), &watch).unwrap();
    check(&input, &maps);
    assert_eq!([maps.counts().mean_value, maps.counts().uniform], [5, 1]);
    assert_eq!(watch.warnings()[0].code, "chart-map-fallback");
}

/// A cube without coordinates, on one face of which stands a finger of half this width.
fn cube_with_finger(cells: u32, inner: f64, length: f64) -> EmbeddedNet {
    let mut net = cube_net(cells);
    let grown = |&p: &DVec3| {
        let across = DVec2::new(p.x, p.y);
        let place = across.abs().max_element();
        if p.z < 1.0 || place > 0.9 {
            return p;
        }
        let height = 1.0 + length * (0.9 - place) / 0.9;
        (across / place.max(1e-9) * inner.min(place)).extend(height)
    };
    let moved = net.refined.surface.positions().map(grown);
    net.refined.surface = Surface::new(net.refined.surface.shared_mesh(), moved).unwrap();
    net.coordinates = PerCorner::filled(net.coordinates.len(), None);
    net
}

#[test]
fn a_finger_is_less_distorted_after_a_descent() {
    let energy = |steps: u32| {
        let options = ChartMapOptions {
            improvement_steps: steps,
            ..ChartMapOptions::default()
        };
        let (input, _, maps) = maps(cube_with_finger(12, 0.3, 2.0), options);
        check(&input, &maps);
        let atlas = chart_atlas(&maps, &Arrangement::default(), &Watch::new()).unwrap();
        let measure = measure_map(maps.surface(), &atlas.corner_uv, &Watch::new()).unwrap();
        measure.distortion.unwrap().symmetric_dirichlet.unwrap()
    };
    let [plain, improved] = [0, 20].map(energy);
    assert!(improved < 0.8 * plain, "{improved} {plain}");
}

#[test]
fn packed_squares_fill_the_tile_and_keep_their_padding() {
    let (_, _, maps) = maps(torus_net(5, 5, 2), ChartMapOptions::default());
    let arrangement = Arrangement::Packed {
        resolution: 500,
        padding: 10,
        tiles: Tiles::AtMost(1),
    };
    let atlas = chart_atlas(&maps, &arrangement, &Watch::new()).unwrap();
    assert_eq!(atlas.flipped, 0);
    assert!(atlas.covered > 0.6, "{}", atlas.covered);
    for (index, a) in atlas.placements.iter().enumerate() {
        let far = a.origin + a.size;
        assert!(a.origin.min_element() > 0.0099 && far.max_element() < 0.9901);
        for b in &atlas.placements[..index] {
            let apart = (a.origin - b.origin - b.size).max(b.origin - a.origin - a.size);
            assert!(apart.max_element() > 10.0 / 500.0 - 1e-12);
        }
    }
}

#[test]
fn tiles_are_added_until_the_density_is_met() {
    let (input, _, maps) = maps(cube_net(3), ChartMapOptions::default());
    let area: f64 = face_areas(&face_shapes(&input)).iter().sum();
    let side = (area / 6.0).sqrt();
    let arrangement = |density: f64| Arrangement::Packed {
        resolution: 512,
        padding: 0,
        tiles: Tiles::Density(density),
    };
    let atlas = |density: f64| chart_atlas(&maps, &arrangement(density), &Watch::new()).unwrap();
    assert_eq!(atlas(100.0 / side).tiles, 1);
    let six = atlas(500.0 / side);
    assert_eq!(six.tiles, 6);
    assert!((six.density.unwrap() * side - 512.0).abs() < 1e-6);
    assert_eq!(six.udim(SquareId(5)), 1006);
    let shares = six.placements.iter().map(|p| p.origin.x.floor());
    let last = shares.max_by(f64::total_cmp).unwrap();
    assert_eq!(last.to_bits(), 5.0_f64.to_bits());
}

#[test]
fn on_the_net_squares_meet_by_quarter_turns_and_whole_shifts() {
    for net in [
        cube_with_singularities(4),
        icosahedron_net(2),
        torus_net(4, 3, 2),
        squeezed_cube(),
    ] {
        let options = ChartMapOptions {
            keep_net: true,
            ..ChartMapOptions::default()
        };
        let (_, _, maps) = maps(net, options);
        let atlas = chart_atlas(&maps, &Arrangement::Net, &Watch::new()).unwrap();
        assert_eq!(atlas.flipped, 0);
        let mesh = maps.surface().mesh();
        for edge in mesh.edges() {
            let side = mesh.edge_halfedge(edge);
            let Some(twin) = mesh.twin(side) else {
                continue;
            };
            let at = |corner| atlas.corner_uv[corner];
            let here = [at(side), at(side.next())];
            let there = [at(twin.next()), at(twin)];
            let turned = (0..4).any(|quarters| {
                let turn = crate::periodic::QuarterTurn::of_quarters(quarters);
                let shifts = [0, 1].map(|k| here[k] - turn.apply(there[k]));
                shifts
                    .iter()
                    .all(|shift| shift.distance(shift.round()) < 1e-9)
                    && shifts[0].distance(shifts[1]) < 1e-9
            });
            assert!(turned, "{edge}: {here:?} {there:?}");
        }
    }
}

#[test]
fn on_the_net_squares_whose_sizes_are_off_by_rounding_do_not_overlap() {
    let (_, _, mut maps) = maps(torus_net(5, 3, 3), ChartMapOptions::default());
    for (square, part) in maps
        .squares
        .iter_mut()
        .zip([1.0, -1.0, 3.0].into_iter().cycle())
    {
        square.size += part * 1e-12;
    }
    let atlas = chart_atlas(&maps, &Arrangement::Net, &Watch::new()).unwrap();
    for (index, a) in atlas.placements.iter().enumerate() {
        assert_eq!(a.size, a.size.round());
        for b in &atlas.placements[..index] {
            let apart = (a.origin - b.origin - b.size).max(b.origin - a.origin - a.size);
            assert!(apart.max_element() >= 0.0, "{a:?} {b:?}");
        }
    }
}

#[test]
fn bad_arrangements_are_refused_with_a_number() {
    let (_, _, maps) = maps(cube_net(2), ChartMapOptions::default());
    let refused = |resolution, padding, tiles| {
        let arrangement = Arrangement::Packed {
            resolution,
            padding,
            tiles,
        };
        chart_atlas(&maps, &arrangement, &Watch::new()).unwrap_err()
    };
    let crowded = refused(16, 8, Tiles::AtMost(1));
    assert!(matches!(
        crowded,
        ChartAtlasError::Padding { padding: 8, .. }
    ));
    assert!(matches!(
        refused(0, 0, Tiles::AtMost(1)),
        ChartAtlasError::BadNumber { .. }
    ));
    assert!(matches!(
        refused(16, 0, Tiles::AtMost(0)),
        ChartAtlasError::BadNumber { .. }
    ));
    assert!(matches!(
        refused(16, 0, Tiles::Density(f64::NAN)),
        ChartAtlasError::BadNumber { .. }
    ));
}

#[test]
#[expect(clippy::cast_sign_loss, reason = "a place in an image")]
fn geometry_images_of_neighbours_share_their_borders_and_lie_on_the_surface() {
    let (_, _, maps) = maps(icosahedron_net(3), ChartMapOptions::default());
    let images = geometry_images(&maps, 9, &Watch::new()).unwrap();
    assert_eq!(images.len(), maps.squares().len());
    let at = |side: SeamSide, step: u32| {
        let place = side.place(f64::from(step) / 8.0) * 8.0;
        let index = (8.0 - place.y.round()) * 9.0 + place.x.round();
        let image = &images[side.square.index()];
        (
            image.positions[index as usize],
            image.normals[index as usize],
        )
    };
    for seam in maps.seams() {
        let [Some(left), Some(right)] = seam.sides else {
            panic!("the sphere is closed")
        };
        for step in 0..=8 {
            let [(p, n), (q, m)] = [left, right].map(|side| at(side, step));
            assert!(p.distance(q) < 1e-9 && n.distance(m) < 1e-9, "{p} {q}");
            // Both are means along edges of up to 0.15, the normal of corners on such edges too.
            assert!(
                (p.length() - 1.0).abs() < 0.01 && n.dot(p.normalize()) > 0.995,
                "{p} {n}"
            );
        }
    }
}

/// The input's own coordinates: the first two of space, halved.
fn from_space(input: &Surface) -> PerCorner<Option<DVec2>> {
    let mesh = input.mesh();
    PerCorner::from_fn(mesh.halfedge_count(), |corner| {
        let p = input.position(mesh.origin(corner));
        Some(DVec2::new(p.x, p.y) * 0.25 + 0.5)
    })
}

#[test]
#[expect(clippy::cast_sign_loss, reason = "a place in an image")]
fn a_texture_has_the_same_colours_at_the_same_points_of_the_surface() {
    let (input, _, maps) = maps(cube_with_singularities(4), ChartMapOptions::default());
    let arrangement = Arrangement::Packed {
        resolution: 64,
        padding: 2,
        tiles: Tiles::AtMost(1),
    };
    let atlas = chart_atlas(&maps, &arrangement, &Watch::new()).unwrap();
    let uvs = from_space(&input);
    // Red grows with u, green with v.
    let pixel = |i: u32| {
        [
            (i % 128) as f32 / 127.0,
            1.0 - (i / 128) as f32 / 127.0,
            0.0,
            1.0,
        ]
    };
    let image = TextureImage {
        width: 128,
        height: 128,
        pixels: (0..128 * 128).map(pixel).collect(),
    };
    let source = SourceTexture {
        input: &input,
        uvs: &uvs,
        image: &image,
        kind: TextureKind::Data,
    };
    let tile = only_tile(&maps, &atlas, &source, 64);
    let mesh = maps.surface().mesh();
    for face in mesh.faces() {
        let corners = face.halfedges();
        let middle: DVec2 = corners.iter().map(|&c| atlas.corner_uv[c]).sum::<DVec2>() / 3.0;
        let [x, y] = (DVec2::new(middle.x, 1.0 - middle.y) * 64.0)
            .to_array()
            .map(|p| p as usize);
        let found = tile.pixels[y * 64 + x];
        let middle = SurfacePoint {
            face,
            barycentric: [1.0 / 3.0; 3],
        };
        let point = maps.refined().to_original(input.mesh(), middle).unwrap();
        let p = point.position(&input);
        for (part, expected) in found.iter().zip([p.x * 0.25 + 0.5, p.y * 0.25 + 0.5]) {
            assert!((f64::from(*part) - expected).abs() < 0.04, "{found:?} {p}");
        }
    }
}

fn only_tile(
    maps: &ChartMaps,
    atlas: &ChartAtlas,
    source: &SourceTexture<'_>,
    resolution: u32,
) -> TextureImage {
    let bleed = 1;
    let options = TextureOptions { resolution, bleed };
    let tiles = transfer_texture(maps, atlas, source, &options, &Watch::new()).unwrap();
    <[TextureImage; 1]>::try_from(tiles)
        .map(|[tile]| tile)
        .unwrap()
}

#[test]
fn normals_along_the_surface_stay_so_and_turn_with_the_atlas() {
    let (input, _, maps) = maps(cube_net(2), ChartMapOptions::default());
    let atlas = chart_atlas(&maps, &Arrangement::default(), &Watch::new()).unwrap();
    let mesh = input.mesh();
    // Coordinates along each face of the cube, as its chart has them, a quarter turned.
    let (_, layout, _) = self::maps(cube_net(2), ChartMapOptions::default());
    let uvs = PerCorner::from_fn(mesh.halfedge_count(), |corner| {
        layout.coordinates()[corner].map(|place| place.perp() + DVec2::X)
    });
    let image = TextureImage {
        width: 1,
        height: 1,
        pixels: vec![[0.8, 0.5, 0.9, 1.0]],
    };
    let source = SourceTexture {
        input: &input,
        uvs: &uvs,
        image: &image,
        kind: TextureKind::TangentNormals,
    };
    let tile = only_tile(&maps, &atlas, &source, 32);
    let covered = tile.pixels.iter().filter(|pixel| pixel[3] > 0.0);
    // The texture's first direction is the chart's second, backwards or not.
    let is_turned = |p: &&[f32; 4]| (p[0] - 0.5).abs() < 1e-4 && (p[1] - 0.5).abs() > 0.29;
    assert!(covered.clone().count() > 500 && covered.clone().all(|p| is_turned(&p)));
}
