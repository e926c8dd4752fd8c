use glam::{DVec2, DVec3};
use graticule_fixtures::{Fixture, Noise, cube, cylinder_patch, disk, grid, icosphere, torus};

use super::*;
use crate::mesh::{
    Element, FaceId, HalfedgeId, PerCorner, PerEdge, PerFace, Surface, Topology, VertexId,
};
use crate::periodic::{GridMap, QuarterTurn, Transition};
use crate::watch::Watch;

fn surface_of(fixture: &Fixture) -> Surface {
    Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
}

/// The map with these coordinates per corner; each transition is the best turn and shift for its
/// edge.
pub(crate) fn map_of(
    surface: &Surface,
    coordinates: impl Fn(HalfedgeId) -> DVec2,
    left_out: &[FaceId],
) -> GridMap {
    let mesh = surface.mesh();
    let coordinates = PerCorner::from_fn(mesh.halfedge_count(), coordinates);
    let transitions = PerCorner::from_fn(mesh.halfedge_count(), |halfedge: HalfedgeId| {
        let twin = mesh.twin(halfedge)?;
        if [halfedge, twin]
            .iter()
            .any(|h| left_out.contains(&h.face()))
        {
            return None;
        }
        let candidates = (0..4).map(|quarters| {
            let turn = QuarterTurn::of_quarters(quarters);
            let shift = coordinates[twin] - turn.apply(coordinates[halfedge.next()]);
            let [x, y] = shift.round().to_array();
            let step = Transition {
                turn,
                shift: [x as i32, y as i32],
            };
            let miss = step
                .apply(coordinates[halfedge])
                .distance(coordinates[twin.next()]);
            (
                miss + step
                    .apply(coordinates[halfedge.next()])
                    .distance(coordinates[twin]),
                step,
            )
        });
        candidates
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, step)| step)
    });
    // Inverse bit for bit, whichever turn won on an edge without length.
    let transitions = PerCorner::from_fn(mesh.halfedge_count(), |halfedge: HalfedgeId| match mesh
        .twin(halfedge)
    {
        Some(twin) if twin < halfedge => transitions[twin].map(Transition::inverse),
        _ => transitions[halfedge],
    });
    let marks = PerFace::from_fn(mesh.face_count(), |face| left_out.contains(&face));
    GridMap::new(mesh, coordinates, transitions, marks).unwrap()
}

fn flat_map(surface: &Surface, point: impl Fn(VertexId, DVec3) -> DVec2) -> GridMap {
    let mesh = surface.mesh();
    map_of(
        surface,
        |corner| point(mesh.origin(corner), surface.position(mesh.origin(corner))),
        &[],
    )
}

fn extract(surface: &Surface, map: &GridMap) -> Extraction {
    extract_polygons(surface, map, None, &Watch::new()).unwrap()
}

/// Vertices by valence, from 0.
fn valences(mesh: &PolygonMesh) -> Vec<usize> {
    let mut valence = vec![0; mesh.positions.len()];
    for &vertex in mesh.polygons.corner_vertices() {
        valence[vertex as usize] += 1;
    }
    let mut counts = vec![0; 12];
    for valence in valence {
        counts[valence] += 1;
    }
    counts
}

#[test]
fn a_square_with_whole_borders_gives_its_cells() {
    let surface = surface_of(&grid(2.0, 1.0, 7, 5));
    let map = flat_map(&surface, |_, p| p.truncate() * 4.0);
    let found = extract(&surface, &map);
    assert_eq!(
        (found.mesh.polygons.len(), found.mesh.quad_count()),
        (32, 32)
    );
    assert_eq!(found.mesh.positions.len(), 9 * 5);
    assert_eq!(
        (found.pruned_pieces, found.split_cells, found.folds),
        (0, 0, 0)
    );
    for (position, origin) in found.mesh.positions.iter().zip(&found.mesh.origins) {
        assert!((*position * 4.0 - (*position * 4.0).round()).length() < 1e-9);
        assert!(origin.position(&surface).distance(*position) < 1e-15);
    }
}

#[test]
fn lines_along_edges_and_through_vertices_are_no_trouble() {
    // Every vertex is a lattice point, every side of a cell an edge.
    let surface = surface_of(&grid(6.0, 4.0, 6, 4));
    let on_edges = flat_map(&surface, |_, p| p.truncate());
    assert_eq!(extract(&surface, &on_edges).mesh.quad_count(), 24);
    // Lines run along the diagonals too.
    let turned = flat_map(&surface, |_, p| DVec2::new(p.x + p.y, p.y - p.x));
    let found = extract(&surface, &turned);
    assert!(found.mesh.quad_count() >= 2 * 24 - 20);
    // Two triangles hold many cells.
    let large = surface_of(&grid(1.0, 1.0, 1, 1));
    let fine = flat_map(&large, |_, p| p.truncate() * 50.0);
    assert_eq!(extract(&large, &fine).mesh.quad_count(), 2500);
}

#[test]
fn a_border_that_no_line_follows_closes_the_cells_along_it() {
    let surface = surface_of(&disk(6));
    let map = flat_map(&surface, |_, p| {
        DVec2::from_angle(0.3).rotate(p.truncate() * 5.2)
    });
    let found = extract(&surface, &map);
    assert!(found.mesh.quad_count() > 50);
}

#[test]
fn shifts_at_the_seams_of_a_torus_leave_no_trace() {
    let fixture = torus(2.0, 0.7, 31, 13);
    let surface = surface_of(&fixture);
    let mesh = surface.mesh();
    let period = DVec2::new(24.0, 9.0);
    let angle = |corner: HalfedgeId| {
        let p = surface.position(mesh.origin(corner));
        let across = f64::atan2(p.z, p.truncate().length() - 2.0);
        DVec2::new(f64::atan2(p.y, p.x), across) / std::f64::consts::TAU * period
    };
    let map = map_of(
        &surface,
        |corner| {
            let first = angle(corner.face().halfedges()[0]);
            let mine = angle(corner);
            mine - ((mine - first) / period).round() * period + 0.37
        },
        &[],
    );
    let found = extract(&surface, &map);
    assert_eq!(found.mesh.quad_count(), 24 * 9);
    assert_eq!(valences(&found.mesh)[4], 24 * 9);
}

#[test]
fn an_open_tube_keeps_both_its_borders() {
    let fixture = cylinder_patch(1.0, 3.0, 17, 9);
    let surface = surface_of(&fixture);
    let mesh = surface.mesh();
    let angle = |corner: HalfedgeId| {
        let p = surface.position(mesh.origin(corner));
        let turn = f64::atan2(p.y, p.x) / std::f64::consts::TAU;
        DVec2::new(turn * 12.0, p.z * 2.1 + 0.2)
    };
    let map = map_of(
        &surface,
        |corner| {
            let (first, mine) = (angle(corner.face().halfedges()[0]), angle(corner));
            mine - DVec2::X * ((mine.x - first.x) / 12.0).round() * 12.0
        },
        &[],
    );
    assert!(extract(&surface, &map).mesh.quad_count() >= 12 * 6);
}

/// A cube with `n` × `n` cells on each side, as a map of its own subdivision.
fn cube_map(levels: u32, n: f64) -> (Surface, GridMap) {
    let mut fixture = cube();
    for _ in 0..levels {
        fixture = fixture.subdivided();
    }
    let surface = surface_of(&fixture);
    let mesh = surface.mesh();
    let middle: DVec3 = fixture.positions.iter().sum::<DVec3>() / fixture.positions.len() as f64;
    let half = (fixture.positions[0] - middle).abs().max_element();
    let map = map_of(
        &surface,
        |corner| {
            let [a, b, c] = surface.corner_positions(corner.face());
            let normal = (b - a).cross(c - a).normalize();
            let across = if normal.x.abs() > 0.5 {
                DVec3::Y
            } else {
                DVec3::X
            };
            let p = (surface.position(mesh.origin(corner)) - middle) / half;
            let up = normal.cross(across);
            DVec2::new(p.dot(across) + 1.0, p.dot(up) + 1.0) * n / 2.0
        },
        &[],
    );
    (surface, map)
}

#[test]
fn a_cube_gives_quads_with_eight_vertices_of_valence_three() {
    for (levels, n) in [(0, 1_u8), (0, 3), (2, 3), (3, 5)] {
        let (surface, map) = cube_map(levels, f64::from(n));
        let found = extract(&surface, &map);
        let quads = 6 * usize::from(n * n);
        assert_eq!(
            (found.mesh.polygons.len(), found.mesh.quad_count()),
            (quads, quads)
        );
        assert_eq!(valences(&found.mesh)[3], 8);
        let finer = map.subdivided(surface.mesh(), 2).unwrap();
        assert_eq!(extract(&surface, &finer).mesh.quad_count(), 4 * quads);
    }
}

/// A flat disk mapped to a cone with `quarters` quarters of the plane round `centre`.
fn cone(rings: u32, quarters: f64, centre: DVec2, left_out: &[FaceId]) -> (Surface, GridMap) {
    let surface = surface_of(&disk(rings));
    let mesh = surface.mesh();
    let turn = std::f64::consts::FRAC_PI_2 * quarters;
    let angle = |vertex: VertexId| {
        let p = surface.position(vertex);
        f64::atan2(p.y, p.x) * quarters / 4.0
    };
    let map = map_of(
        &surface,
        |corner| {
            let vertices = corner.face().halfedges().map(|h| mesh.origin(h));
            let first = vertices.into_iter().find(|&v| v != VertexId(0)).unwrap();
            let mine = angle(mesh.origin(corner));
            let mine = mine - ((mine - angle(first)) / turn).round() * turn;
            let radius = surface.position(mesh.origin(corner)).length() * 4.3;
            centre + DVec2::from_angle(mine) * radius
        },
        left_out,
    );
    (surface, map)
}

#[test]
fn a_quarter_turn_at_a_lattice_point_gives_an_irregular_vertex() {
    for quarters in [3_u8, 5, 6] {
        let (surface, map) = cone(9, f64::from(quarters), DVec2::ZERO, &[]);
        let found = extract(&surface, &map);
        let inner = found
            .mesh
            .origins
            .iter()
            .position(|origin| origin.position(&surface).length() < 1e-12);
        let at = found.mesh.polygons.corner_vertices().iter();
        let valence = at.filter(|&&vertex| Some(vertex as usize) == inner).count();
        assert_eq!(valence, usize::from(quarters));
    }
}

#[test]
fn a_turn_between_lattice_points_gives_one_irregular_polygon() {
    let (surface, map) = cone(9, 3.0, DVec2::splat(0.5), &[]);
    let found = extract(&surface, &map);
    let polygon = (0..found.mesh.polygons.len()).find(|&polygon| {
        let vertices = found.mesh.polygons.vertices(polygon).iter();
        let sum: DVec3 = vertices.map(|&v| found.mesh.positions[v as usize]).sum();
        sum.length() < 1e-6
    });
    assert_eq!(found.mesh.polygons.vertices(polygon.unwrap()).len(), 3);
}

#[test]
fn what_is_left_out_is_closed() {
    for quarters in [3.0, 5.0] {
        for centre in [DVec2::ZERO, DVec2::splat(0.5), DVec2::new(3.0, 1.0)] {
            let left_out: Vec<FaceId> = (0..6).map(FaceId::from_index).collect();
            let (surface, map) = cone(9, quarters, centre, &left_out);
            let found = extract(&surface, &map);
            assert!(found.mesh.quad_count() > 20, "{}", found.mesh.quad_count());
        }
    }
    // A map with nothing but holes still covers the surface.
    let sphere = surface_of(&icosphere(2));
    let all: Vec<FaceId> = sphere.mesh().faces().collect();
    let map = map_of(&sphere, |_| DVec2::ZERO, &all);
    let found = extract(&sphere, &map);
    assert!(found.mesh.polygons.len() >= 4 && found.split_cells > 0);
}

#[test]
fn coordinates_that_collapse_or_flip_keep_the_topology() {
    let surface = surface_of(&icosphere(3));
    for seed in 0..20 {
        let mut noise = Noise::new(seed);
        let rough: Vec<DVec2> = (0..surface.mesh().vertex_count())
            .map(|_| DVec2::new(noise.signed(), noise.signed()))
            .collect();
        // The plane's coordinates of a sphere: one side of it lies upside down on the other.
        for amplitude in [0.0, 0.3, 3.0] {
            let map = flat_map(&surface, |vertex, p| {
                p.truncate() * 5.0 + rough[vertex.index()] * amplitude
            });
            extract(&surface, &map);
            // Whole coordinates everywhere: many triangles without area, on lines and points.
            let whole = flat_map(&surface, |vertex, p| {
                (p.truncate() * 2.0 + rough[vertex.index()] * amplitude).round()
            });
            extract(&surface, &whole);
        }
    }
}

#[test]
fn a_few_flipped_triangles_cost_no_quad() {
    let fixture = grid(1.0, 1.0, 40, 40);
    let surface = surface_of(&fixture);
    let mesh = surface.mesh();
    for seed in 0..10 {
        let mut noise = Noise::new(seed);
        let shifts: Vec<DVec2> = mesh
            .vertices()
            .map(|vertex| {
                let p = surface.position(vertex).truncate();
                let inner = (p - 0.5).abs().max_element() < 0.42 && noise.unit() < 0.1;
                let shift = DVec2::new(noise.signed(), noise.signed()) * 0.6;
                if inner { shift } else { DVec2::ZERO }
            })
            .collect();
        let map = flat_map(&surface, |vertex, p| {
            p.truncate() * 13.0 + shifts[vertex.index()]
        });
        let flipped = mesh.faces().filter(|&face| {
            let [a, b, c] = map.face_coordinates(face);
            (b - a).perp_dot(c - a) < 0.0
        });
        assert!(flipped.count() > 10);
        let found = extract(&surface, &map);
        assert_eq!(
            found.mesh.quad_count(),
            169,
            "seed {seed}: {:?}",
            valences(&found.mesh)
        );
        assert_eq!(found.mesh.polygons.len(), 169);
        assert!(found.folds > 0);
    }
}

#[test]
fn a_thin_limb_does_not_vanish() {
    // A long ellipsoid that a net much wider than it passes by.
    let surface = surface_of(&icosphere(4).map(|p| DVec3::new(p.x * 0.05, p.y * 0.05, p.z)));
    let map = flat_map(&surface, |_, p| DVec2::new(p.x + 0.5, p.z * 0.3 + 0.5));
    let found = extract(&surface, &map);
    let [low, high] = [f64::min, f64::max].map(|choose: fn(f64, f64) -> f64| {
        found.mesh.positions.iter().map(|p| p.z).fold(0.0, choose)
    });
    assert!(low < -0.5 && high > 0.5, "{low} {high}");
    assert_eq!(found.mesh.topology().unwrap().total.euler_characteristic, 2);
}

#[test]
fn crossings_close_to_the_boundary_are_drawn_onto_it() {
    // A fifth and a tenth of a cell are left over on two sides.
    let surface = surface_of(&grid(2.0, 1.0, 8, 5));
    let map = flat_map(&surface, |_, p| p.truncate() * 8.1);
    let found = extract(&surface, &map);
    assert_eq!(found.mesh.quad_count(), 16 * 8);
    assert_eq!(found.mesh.polygons.len(), 16 * 8);
    assert!(found.snapped > 0);
    let exact = flat_map(&surface, |_, p| p.truncate() * 8.0);
    assert_eq!(extract(&surface, &exact).snapped, 0);
}

#[test]
fn narrow_quads_between_lines_of_the_net_stay_quads() {
    // Lines bunched up between two features: a quarter as far apart there as elsewhere.
    let surface = surface_of(&grid(2.0, 2.0, 40, 20));
    let mesh = surface.mesh();
    let bunched = |x: f64| 8.0 * x + 24.0 * (x - 0.75).clamp(0.0, 0.5);
    let map = flat_map(&surface, |_, p| DVec2::new(bunched(p.x), 8.0 * p.y));
    let is_side = |x: f64| (x - 0.75).abs() < 1e-9 || (x - 1.25).abs() < 1e-9;
    let features = PerEdge::from_fn(mesh.edge_count(), |edge| {
        let ends = mesh
            .ends(mesh.edge_halfedge(edge))
            .map(|v| surface.position(v).x);
        is_side(ends[0]) && (ends[0] - ends[1]).abs() < 1e-9
    });
    let found = extract_polygons(&surface, &map, Some(&features), &Watch::new()).unwrap();
    assert_eq!(found.snapped, 0);
    assert_eq!(found.mesh.quad_count(), found.mesh.polygons.len());
    let cells = bunched(2.0).round() * 16.0;
    assert!((found.mesh.polygons.len() as f64 - cells).abs() < 0.5);
}

#[test]
fn a_feature_that_ends_between_lattice_points_marks_the_sides_that_it_covers() {
    // It runs along a line from 0 to 1.13, 0.52 of the fifth side, or to 1.1, 0.4 of it.
    for (end, sides) in [(1.13, 5), (1.1, 4)] {
        let columns = grid(2.0, 1.0, 200, 4);
        let surface = surface_of(&columns);
        let mesh = surface.mesh();
        let map = flat_map(&surface, |_, p| p.truncate() * 4.0);
        let features = PerEdge::from_fn(mesh.edge_count(), |edge| {
            let ends = mesh
                .ends(mesh.edge_halfedge(edge))
                .map(|v| surface.position(v));
            ends.iter()
                .all(|p| (p.y - 0.5).abs() < 1e-9 && p.x < end + 1e-9)
        });
        let found = extract_polygons(&surface, &map, Some(&features), &Watch::new()).unwrap();
        assert_eq!(found.mesh.feature_edges.len(), sides);
        assert_eq!(found.mesh.quad_count(), 8 * 4);
    }
}

#[test]
fn a_bend_of_the_boundary_inside_a_side_of_the_net_leaves_quads() {
    // A regular octagon as a square: at every other corner a side of the net bends by 45°.
    for (lines, polygons) in [(1.0, 1), (2.0, 4)] {
        let octagon: Vec<DVec3> = (0..8)
            .map(|corner| {
                DVec3::from((
                    DVec2::from_angle(f64::from(corner) * 0.25 * std::f64::consts::PI),
                    0.0,
                ))
            })
            .chain([DVec3::ZERO])
            .collect();
        let triangles: Vec<[u32; 3]> = (0..8).map(|corner| [8, corner, (corner + 1) % 8]).collect();
        let surface = Surface::from_triangles(octagon, &triangles).unwrap();
        let square = |index: usize| match index {
            8 => DVec2::ZERO,
            _ => [
                DVec2::new(1.0, 0.0),
                DVec2::ONE,
                DVec2::new(0.0, 1.0),
                DVec2::new(-1.0, 1.0),
                DVec2::new(-1.0, 0.0),
                DVec2::new(-1.0, -1.0),
                DVec2::new(0.0, -1.0),
                DVec2::new(1.0, -1.0),
            ][index],
        };
        let map = flat_map(&surface, |v, _| (square(v.index()) + 1.0) * 0.5 * lines);
        let found = extract(&surface, &map);
        assert_eq!(found.mesh.quad_count(), polygons);
        assert_eq!(found.mesh.polygons.len(), polygons);
    }
}

#[test]
fn the_nearest_line_is_drawn_onto_a_feature_that_no_line_follows() {
    let surface = surface_of(&grid(2.0, 1.0, 8, 5));
    let mesh = surface.mesh();
    // The feature runs along x = 3.3 in coordinates, straight through all cells.
    let map = flat_map(&surface, |_, p| DVec2::new(p.x * 4.4, p.y * 4.0));
    let sharp = PerEdge::from_fn(mesh.edge_count(), |edge| {
        let ends = mesh.ends(mesh.edge_halfedge(edge));
        ends.iter()
            .all(|&vertex| (surface.position(vertex).x - 0.75).abs() < 1e-9)
    });
    let found = extract_polygons(&surface, &map, Some(&sharp), &Watch::new()).unwrap();
    assert_eq!(found.mesh.polygons.len(), found.mesh.quad_count());
    assert_eq!(found.mesh.feature_edges.len(), 4);
    let length: f64 = (found.mesh.feature_edges.iter())
        .map(|&[a, b]| found.mesh.positions[a as usize].distance(found.mesh.positions[b as usize]))
        .sum();
    assert!((length - 1.0).abs() < 1e-9, "{length}");
}

#[test]
fn a_fold_at_the_boundary_of_the_map_leaves_no_inverted_quad() {
    // The last column of triangles lies folded back on the one before.
    let surface = surface_of(&grid(2.0, 1.0, 16, 8));
    for back in [0.2, 0.45, 0.7] {
        let map = flat_map(&surface, |_, p| {
            let x = if p.x > 1.99 {
                1.875 - back * 0.125
            } else {
                p.x
            };
            DVec2::new(x, p.y) * 8.0
        });
        let found = extract(&surface, &map);
        let (pure, _) = pure_quads(&found.mesh, &surface, &[]);
        pure.check(&surface).unwrap();
        let net = Net {
            surface: &surface,
            features: &[],
            polygons: &pure.polygons,
            feature_edges: &[],
        };
        let watch = Watch::new();
        let shaped = shape(&net, &pure.origins, &ShapeOptions::default(), &watch).unwrap();
        assert!(
            shaped.report.after.least > 0.2,
            "{back}: {:?}",
            shaped.report
        );
    }
}

#[test]
fn features_become_chains_of_edges() {
    let surface = surface_of(&grid(2.0, 1.0, 8, 5));
    let mesh = surface.mesh();
    let map = flat_map(&surface, |_, p| p.truncate() * 3.3 + 0.1);
    let sharp = PerEdge::from_fn(mesh.edge_count(), |edge| {
        let ends = mesh.ends(mesh.edge_halfedge(edge));
        ends.iter()
            .all(|&vertex| (surface.position(vertex).x - 0.75).abs() < 1e-9)
    });
    let found = extract_polygons(&surface, &map, Some(&sharp), &Watch::new()).unwrap();
    let length: f64 = (found.mesh.feature_edges.iter())
        .map(|&[a, b]| found.mesh.positions[a as usize].distance(found.mesh.positions[b as usize]))
        .sum();
    assert!((length - 1.0).abs() < 1e-9, "{length}");
}

#[test]
fn a_line_that_ends_at_a_hole_is_taken_back_to_the_last_crossing() {
    let surface = surface_of(&disk(12));
    let mesh = surface.mesh();
    let hole: Vec<FaceId> = (mesh.outgoing(VertexId(0)).map(HalfedgeId::face)).collect();
    let turns = |vertex: VertexId| {
        let p = surface.position(vertex);
        f64::atan2(p.y, p.x) / std::f64::consts::TAU
    };
    // One more line on one side than on the other.
    let map = map_of(
        &surface,
        |corner| {
            let first = turns(mesh.origin(corner.face().halfedges()[0]));
            let mine = turns(mesh.origin(corner));
            let gained = mine - (mine - first).round();
            surface.position(mesh.origin(corner)).truncate() * 4.2 + DVec2::new(gained, 0.13)
        },
        &hole,
    );
    let found = extract(&surface, &map);
    assert!(found.pruned_pieces > 0);
    let sizes = (0..found.mesh.polygons.len()).map(|p| found.mesh.polygons.vertices(p));
    let inner = sizes.filter(|vertices| {
        let far = vertices
            .iter()
            .map(|&v| found.mesh.positions[v as usize].length());
        far.fold(0.0, f64::max) < 0.6
    });
    let odd: Vec<usize> = inner.map(<[u32]>::len).filter(|&size| size != 4).collect();
    assert_eq!(odd.len(), 1, "{odd:?}");
}

#[test]
fn every_surface_keeps_its_topology_under_random_maps() {
    let shapes = [
        torus(2.0, 0.7, 12, 8),
        disk(4),
        cube().subdivided(),
        icosphere(1),
    ];
    for (number, fixture) in shapes.iter().enumerate() {
        let surface = surface_of(fixture);
        for seed in 0..30 {
            let mut noise = Noise::new(seed);
            let points: Vec<DVec2> = (0..surface.mesh().vertex_count())
                .map(|_| DVec2::new(noise.signed(), noise.signed()) * 2.5)
                .collect();
            let left_out: Vec<FaceId> = (surface.mesh().faces())
                .filter(|_| noise.unit() < 0.05)
                .collect();
            let mesh = surface.mesh();
            let map = map_of(&surface, |c| points[mesh.origin(c).index()], &left_out);
            let found = extract_polygons(&surface, &map, None, &Watch::new());
            let found = found.unwrap_or_else(|error| panic!("{number} {seed}: {error}"));
            let expected = Topology::of(mesh).total.euler_characteristic;
            assert_eq!(
                found.mesh.topology().unwrap().total.euler_characteristic,
                expected
            );
        }
    }
}
