//! Flips, folds, islands and overlaps; brute force as the judge.

use std::f64::consts::TAU;

use super::*;
use crate::mesh::{FaceId, HalfedgeId, VertexId};

#[test]
fn boundary_loops_turn_by_the_euler_characteristic() {
    let surface = surface(&fixtures::annulus(0.3, 1.0, 40, 4));
    let measure = measured(
        &surface,
        &map_by(&surface, |p| flat(p) * DVec2::new(3.0, 1.0)),
    );
    let mut turning: Vec<f64> = measure
        .elements
        .boundary_loops
        .iter()
        .map(|border| border.turning)
        .collect();
    turning.sort_by(f64::total_cmp);
    assert_close(turning[0], -TAU, 1e-12);
    assert_close(turning[1], TAU, 1e-12);
    assert_eq!(measure.elements.islands[0].euler_characteristic, 0);
    assert_eq!(measure.islands.disks, 0);
}

#[test]
fn a_vertex_pulled_across_its_neighbours_flips_triangles_and_folds() {
    let surface = surface(&fixtures::grid(1.0, 1.0, 10, 10));
    let centre = VertexId(60);
    let mesh = surface.mesh();
    let uvs = PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
        let vertex = mesh.origin(corner);
        let shift = if vertex == centre { 0.15 } else { 0.0 };
        flat(surface.position(vertex)) + DVec2::X * shift
    });
    let measure = measured(&surface, &uvs);
    let flipped: Vec<FaceId> = mesh
        .faces()
        .filter(|&face| {
            let [a, b, c] = face.halfedges().map(|corner| uvs[corner]);
            (b - a).perp_dot(c - a) < 0.0
        })
        .collect();
    assert!(!flipped.is_empty());
    assert_eq!(measure.faces.flipped, flipped.len());
    assert!(
        flipped
            .iter()
            .all(|&face| measure.elements.distortion[face].flipped)
    );
    assert!(measure.islands.folded_vertices > 0);
    assert!(measure.overlap.any && !measure.bijective);
    assert!(measure.overlap.area_share > 0.0);
    assert_eq!(measure.overlap.boundary_crossings, 0);
}

#[test]
fn a_mirrored_island_is_told_apart_from_flipped_triangles() {
    let surface = surface(&fixtures::bumpy_patch(8, 4));
    let plain = measured(&surface, &map_by(&surface, flat));
    let mirrored = measured(&surface, &map_by(&surface, |p| DVec2::new(-p.x, p.y)));
    assert_same_figures(&plain, &mirrored, 1e-13, true);
    assert_eq!([plain.islands.mirrored, mirrored.islands.mirrored], [0, 1]);
    assert_eq!(mirrored.faces.flipped, 0);
    assert!(mirrored.bijective);
}

/// z ↦ z² on a ring: no triangle flipped, no vertex folded, everything covered twice.
#[test]
fn a_ring_wound_twice_overlaps_without_any_flip() {
    for (around, expected_crossings) in [(64, 0), (65, 1)] {
        let surface = surface(&fixtures::annulus(0.5, 1.0, around, 6));
        let square = |p: DVec3| DVec2::new(p.x * p.x - p.y * p.y, 2.0 * p.x * p.y);
        let measure = measured(&surface, &map_by(&surface, square));
        assert_eq!(
            [measure.faces.flipped, measure.islands.folded_vertices],
            [0, 0]
        );
        assert!(measure.overlap.any && !measure.bijective);
        assert!(measure.overlap.boundary_crossings >= expected_crossings);
        assert!(
            measure.overlap.area_share > 0.98,
            "{}",
            measure.overlap.area_share
        );
        assert!(measure.elements.overlapping_faces.is_some());
    }
}

/// z ↦ z² on a disk: the middle vertex, and it alone, is wound around twice.
#[test]
fn a_disk_wound_twice_is_folded_at_its_middle() {
    let surface = surface(&fixtures::disk(6));
    let square = |p: DVec3| DVec2::new(p.x * p.x - p.y * p.y, 2.0 * p.x * p.y);
    let measure = measured(&surface, &map_by(&surface, square));
    assert_eq!(measure.faces.flipped, 0);
    assert_eq!(measure.elements.folded_vertices, [VertexId(0)]);
    assert!(measure.overlap.any && !measure.bijective);
}

/// A strip rolled up past a full turn: the ends overlap, nothing else is wrong.
#[test]
fn a_strip_rolled_onto_itself_overlaps_and_its_boundary_crosses() {
    let surface = surface(&fixtures::grid(7.5, 0.4, 60, 3));
    let roll = |p: DVec3| {
        let (sin, cos) = p.x.sin_cos();
        DVec2::new(cos, sin) * (1.4 - p.y) + DVec2::X * 0.02 * p.x
    };
    let measure = measured(&surface, &map_by(&surface, roll));
    assert_eq!(
        [measure.faces.flipped, measure.islands.folded_vertices],
        [0, 0]
    );
    assert!(measure.overlap.boundary_crossings > 0);
    assert!(measure.overlap.any && !measure.bijective);
    // 1.22 of the turn lies twice, the second time 0.13 further out by the drift.
    assert!((0.1..0.19).contains(&measure.overlap.area_share));
    let covered = measure.packing.unwrap().covered_area;
    assert_close(
        measure.overlap.excess,
        measure.faces.uv_area / covered - 1.0,
        1e-4,
    );
    assert_close(measure.overlap.excess, measure.overlap.area_share, 1e-12);
}

/// Two unit squares of `n` × `n` cells, the second one's coordinates shifted.
fn two_squares(shift: DVec2) -> MapMeasure {
    let square = fixtures::grid(1.0, 1.0, 5, 5);
    let beside = square.clone().map(|p| p + DVec3::X * 10.0);
    let surface = surface(&square.joined(&beside));
    let place = |p: DVec3| {
        if p.x > 5.0 {
            flat(p) - DVec2::X * 10.0 + shift
        } else {
            flat(p)
        }
    };
    measured(&surface, &map_by(&surface, place))
}

#[test]
fn islands_that_overlap_are_found_and_their_share_is_measured() {
    let measure = two_squares(DVec2::new(0.5, 0.0));
    assert_eq!(measure.islands.count, 2);
    assert!(measure.overlap.any && !measure.bijective);
    assert_close(measure.overlap.area_share, 1.0 / 3.0, 1e-12);
    assert_close(measure.overlap.excess, 1.0 / 3.0, 1e-12);
    assert_close(measure.packing.unwrap().covered_area, 1.5, 1e-12);
    // One inside the other: no boundary edges cross.
    let stacked = two_squares(DVec2::ZERO);
    assert!(stacked.overlap.any && !stacked.bijective);
    assert_eq!(stacked.overlap.boundary_crossings, 0);
    assert_close(stacked.overlap.area_share, 1.0, 1e-12);
}

#[test]
fn islands_that_touch_do_not_overlap() {
    for shift in [
        DVec2::X,
        DVec2::ONE,
        DVec2::new(1.0, 0.3),
        DVec2::new(0.25, -1.0),
    ] {
        let measure = two_squares(shift);
        assert!(measure.bijective && !measure.overlap.any);
        assert!(measure.overlap.area_share.abs() <= 0.0);
        assert_eq!(measure.overlap.boundary_crossings, 0);
    }
    let almost = two_squares(DVec2::new(1.0_f64.next_down(), 0.0));
    assert!(almost.overlap.any && !almost.bijective);
    let packed = two_squares(DVec2::X).packing.unwrap();
    assert_close(packed.box_share, 1.0, 1e-12);
    assert_close(packed.square_share, 0.5, 1e-12);
    assert!(!packed.in_unit_square);
}

#[test]
fn an_island_inside_a_hole_of_another_does_not_overlap() {
    let ring = fixtures::annulus(0.5, 1.0, 32, 2);
    let inner = fixtures::disk(3).map(|p| p * 0.45 + DVec3::Z);
    let surface = surface(&ring.joined(&inner));
    let measure = measured(&surface, &map_by(&surface, flat));
    assert!(measure.bijective);
    let grown = map_by(&surface, |p| flat(p) * if p.z > 0.5 { 1.2 } else { 1.0 });
    let measure = measured(&surface, &grown);
    assert!(!measure.bijective && measure.overlap.any);
}

#[test]
fn collapsed_triangles_are_counted_and_left_out() {
    let surface = surface(&fixtures::grid(1.0, 1.0, 4, 4));
    let mesh = surface.mesh();
    let collapse = |depth: f64| {
        PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
            let vertex = mesh.origin(corner);
            let p = flat(surface.position(vertex));
            // The vertex (1/4, 1/4) moves to its neighbour (0, 1/4), up to `depth`.
            if vertex == VertexId(6) {
                DVec2::new(depth, p.y)
            } else {
                p
            }
        })
    };
    let onto = measured(&surface, &collapse(0.0));
    assert!(onto.faces.zero_uv_area > 0);
    assert_eq!(onto.faces.degenerate, onto.faces.zero_uv_area);
    assert_eq!(onto.faces.left_out, onto.faces.degenerate);
    assert_close(
        onto.faces.left_out_area_share,
        onto.faces.left_out as f64 / 32.0,
        1e-12,
    );
    assert!(!onto.bijective);
    // Next to nothing, of the right sign: left out of the figures, and still one to one.
    let near = measured(&surface, &collapse(1e-14));
    assert_eq!(near.faces.degenerate, onto.faces.degenerate);
    assert_eq!(near.faces.zero_uv_area, 0);
    assert!(near.bijective);
    assert!(near.distortion.unwrap().linf_stretch < 10.0);
}

#[test]
fn every_triangle_an_island_of_its_own_is_bijective_if_none_overlap() {
    let fixture = fixtures::disk(8);
    let surface = surface(&fixture);
    // Each triangle shrunk to its middle by an exact factor.
    let mesh = surface.mesh();
    let uvs = PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
        let [a, b, c] = surface.corner_positions(corner.face()).map(flat);
        let own = flat(surface.position(mesh.origin(corner)));
        0.5 * own + 0.5 * (a + b + c) / 3.0
    });
    let measure = measured(&surface, &uvs);
    assert!(measure.bijective);
    assert_eq!(measure.islands.count, mesh.face_count());
    assert_eq!(measure.islands.disks, mesh.face_count());
    assert_isometric(&measure, 1e-12);
}

/// The area that two triangles share, by clipping one with the sides of the other.
fn common_area(first: [DVec2; 3], second: [DVec2; 3]) -> f64 {
    let area = |polygon: &[DVec2]| {
        let next = polygon.iter().cycle().skip(1);
        polygon
            .iter()
            .zip(next)
            .map(|(a, b)| a.perp_dot(*b))
            .sum::<f64>()
            / 2.0
    };
    let turned = |[a, b, c]: [DVec2; 3]| {
        if area(&[a, b, c]) < 0.0 {
            [a, c, b]
        } else {
            [a, b, c]
        }
    };
    let mut polygon = turned(first).to_vec();
    let clip = turned(second);
    for side in 0..3 {
        let (from, to) = (clip[side], clip[(side + 1) % 3]);
        let height = |p: DVec2| (to - from).perp_dot(p - from);
        let mut clipped = Vec::new();
        for (index, &a) in polygon.iter().enumerate() {
            let b = polygon[(index + 1) % polygon.len()];
            if height(a) >= 0.0 {
                clipped.push(a);
            }
            if height(a) * height(b) < 0.0 {
                clipped.push(a + (b - a) * height(a) / (height(a) - height(b)));
            }
        }
        polygon = clipped;
    }
    area(&polygon)
}

#[test]
fn decisions_on_random_maps_agree_with_brute_force() {
    let mut bijective = 0;
    for seed in 0..300 {
        let (surface, uvs) = random_map(seed, 0.3 * (seed % 10) as f64 / 10.0);
        let measure = measured(&surface, &uvs);
        let faces: Vec<FaceId> = surface.mesh().faces().collect();
        let images = |face: FaceId| face.halfedges().map(|corner| uvs[corner]);
        let doubled = |face: FaceId| {
            let [a, b, c] = images(face);
            (b - a).perp_dot(c - a)
        };
        let overlap = faces.iter().any(|&a| {
            let others = faces.iter().filter(|&&b| b > a);
            others
                .copied()
                .any(|b| common_area(images(a), images(b)) > 1e-13)
        });
        assert_eq!(measure.overlap.any, overlap, "seed {seed}");
        let sound = faces.iter().all(|&face| doubled(face) > 1e-15);
        assert_eq!(measure.bijective, sound && !overlap, "seed {seed}");
        if let Some([a, b]) = measure.elements.overlapping_faces {
            assert!(common_area(images(a), images(b)) > 0.0);
        }
        bijective += usize::from(measure.bijective);
    }
    assert!(
        (30..270).contains(&bijective),
        "{bijective} of 300 are bijective"
    );
}

#[test]
fn crossings_on_random_maps_agree_with_brute_force() {
    for seed in 0..60 {
        let (surface, uvs) = random_map(seed, 0.6);
        let mesh = surface.mesh();
        let border: Vec<[DVec2; 2]> = mesh
            .halfedges()
            .filter(|&halfedge| mesh.twin(halfedge).is_none())
            .map(|halfedge| [uvs[halfedge], uvs[halfedge.next()]])
            .collect();
        let side = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
        let strictly = |x: f64, y: f64| x.abs() > 1e-14 && y.abs() > 1e-14 && x * y < 0.0;
        let mut count = 0;
        for (index, &[a, b]) in border.iter().enumerate() {
            for &[c, d] in &border[index + 1..] {
                let cross = strictly(side(a, b, c), side(a, b, d))
                    && strictly(side(c, d, a), side(c, d, b));
                count += u64::from(cross);
            }
        }
        let measure = measured(&surface, &uvs);
        assert_eq!(measure.overlap.boundary_crossings, count, "seed {seed}");
    }
}

#[test]
fn the_overlapping_area_of_two_islands_agrees_with_clipping() {
    let mut noise = Noise::new(9);
    for _ in 0..20 {
        let mut corner = || DVec2::new(noise.unit(), noise.unit());
        let [first, second] = [
            [corner(), corner(), corner()],
            [corner(), corner(), corner()],
        ];
        let positions = (0..6).map(|k| DVec3::new(f64::from(k % 3), f64::from(k / 2), 0.0));
        let surface = Surface::from_triangles(positions.collect(), &[[0, 1, 2], [3, 4, 5]]);
        let uvs = PerCorner::new([first, second].concat());
        let measure = measured(&surface.unwrap(), &uvs);
        let common = common_area(first, second);
        let covered = measure.faces.uv_area - common;
        assert!((measure.overlap.area_share - common / covered).abs() < 1e-4);
        assert_close(measure.packing.unwrap().covered_area, covered, 1e-4);
    }
}

#[test]
fn the_overlapping_triangles_are_those_that_brute_force_finds() {
    let two = fixtures::grid(1.0, 1.0, 9, 9);
    let surface = surface(&two.clone().joined(&two.map(|p| p + DVec3::Z)));
    let uvs = map_by(&surface, |p| {
        flat(p) + DVec2::new(0.713, 0.127) * p.z + DVec2::new(0.0, 0.3 * p.x * p.z)
    });
    let images: Vec<[DVec2; 3]> = surface
        .mesh()
        .faces()
        .map(|face| face.halfedges().map(|corner| uvs[corner]))
        .collect();
    let found = overlapping_faces(&surface, &uvs, &Watch::new()).unwrap();
    for (face, image) in images.iter().enumerate() {
        let mut others = images
            .iter()
            .enumerate()
            .filter(|&(other, _)| other != face);
        let expected = others.any(|(_, other)| overlap::interiors_meet(image, other));
        assert_eq!(found.as_slice()[face], expected, "{face}");
    }
    let count = found.iter().filter(|&&overlaps| overlaps).count();
    assert!((20..300).contains(&count), "{count}");
}
