use crate::mesh::coincidence::first_over_same_vertices;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::faces::Faces;
use crate::mesh::gluing::{EdgeUses, NONE};

/// For each face the one that makes it surplus, or `None`; empty if there is no surplus face.
///
/// Of the faces over the same vertices the first stays. So does the first one that faces the
/// opposite way, if both belong to a wall between two solids, or to a flap that is folded out of
/// one: a connected set of such pairs with an even number of other faces along every edge, none
/// along some of a flap's rim. With one face of it only, a crowded edge would have no way to tell
/// which of its faces go together. Elsewhere two faces back to back are one sheet given twice.
pub(super) fn find_surplus(faces: &impl Faces) -> Vec<Option<u32>> {
    let firsts = first_over_same_vertices(faces);
    if firsts.iter().all(|&first| first == NONE) {
        return Vec::new();
    }
    let is_surplus = |&first: &u32| (first != NONE).then_some(first);
    let mut surplus: Vec<_> = firsts.iter().map(is_surplus).collect();
    let backs = find_backs(faces, &firsts);
    for (first, back) in walls(faces, &backs, &surplus) {
        debug_assert_eq!(firsts[back as usize], first);
        surplus[back as usize] = None;
    }
    surplus
}

/// For each first face the first one back to back with it, or [`NONE`].
fn find_backs(faces: &impl Faces, firsts: &[u32]) -> Vec<u32> {
    let mut backs = vec![NONE; firsts.len()];
    for (face, &first) in (0_u32..).zip(firsts) {
        if first != NONE && backs[first as usize] == NONE && back_to_back(faces, first, face) {
            backs[first as usize] = face;
        }
    }
    backs
}

/// Whether one face has the corners of the other in the opposite order.
fn back_to_back(faces: &impl Faces, first: u32, face: u32) -> bool {
    let [corners, others] = [faces.corners(first), faces.corners(face)];
    let start = faces.origin(corners.start);
    let Some(turn) = others.clone().find(|&corner| faces.origin(corner) == start) else {
        return false;
    };
    let backward = (others.start..=turn)
        .rev()
        .chain((turn + 1..others.end).rev());
    corners
        .zip(backward)
        .all(|(a, b)| faces.origin(a) == faces.origin(b))
}

/// The pairs back to back that belong to walls and flaps.
fn walls(faces: &impl Faces, backs: &[u32], surplus: &[Option<u32>]) -> Vec<(u32, u32)> {
    let vertices = (0..faces.corner_count() as u32).map(|corner| faces.origin(corner));
    let uses = EdgeUses::of(
        faces,
        vertices.max().map_or(0, |vertex| vertex as usize + 1),
    );
    let mut sets = DisjointSets::new(backs.len());
    let mut is_sheet = vec![false; backs.len()];
    let mut meets_others = vec![false; backs.len()];
    let is_pair = |face: u32| backs[face as usize] != NONE;
    let mut rims = Vec::new();
    for group in uses.iter() {
        let here = || group.iter().map(|&side| faces.face(side));
        let others = here()
            .filter(|&f| surplus[f as usize].is_none() && !is_pair(f))
            .count();
        let mut pairs = here().filter(|&face| is_pair(face));
        let Some(first) = pairs.next() else { continue };
        for other in pairs {
            sets.join(first, other);
        }
        rims.push((first, others));
    }
    for (face, others) in rims {
        let set = sets.find(face) as usize;
        meets_others[set] |= others > 0;
        is_sheet[set] |= others % 2 == 1;
    }
    let pairs = (0_u32..).zip(backs).filter(|&(_, &back)| back != NONE);
    pairs
        .map(|(first, &back)| (first, back))
        .filter(|&(first, _)| {
            let set = sets.find(first) as usize;
            meets_others[set] && !is_sheet[set]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::faces::TriangleFaces;

    fn surplus(triangles: &[[u32; 3]]) -> Vec<Option<u32>> {
        find_surplus(&TriangleFaces(triangles))
    }

    #[test]
    fn a_sheet_given_twice_becomes_one() {
        assert_eq!(surplus(&[[0, 1, 2], [0, 2, 1]]), [None, Some(0)]);
        let doubled = [[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]];
        assert_eq!(surplus(&doubled), [None, None, Some(0), Some(1)]);
        assert!(surplus(&[[0, 1, 2], [0, 2, 3]]).is_empty());
    }

    #[test]
    fn a_wall_between_two_solids_stays_on_both_sides() {
        // Two tetrahedra on both sides of the triangle 0 1 2.
        let solids = [
            [0, 1, 2],
            [1, 0, 3],
            [2, 1, 3],
            [0, 2, 3],
            [2, 1, 0],
            [0, 1, 4],
            [1, 2, 4],
            [2, 0, 4],
        ];
        assert_eq!(surplus(&solids), [None; 8]);
    }

    #[test]
    fn a_flap_folded_out_of_a_solid_stays_on_both_sides_and_one_on_a_sheet_does_not() {
        let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let flap = [[0, 1, 4], [1, 0, 4]];
        assert_eq!(surplus(&[&tetrahedron[..], &flap].concat()), [None; 6]);
        let at_an_open_edge = [&tetrahedron[1..], &flap].concat();
        assert_eq!(surplus(&at_an_open_edge), [None, None, None, None, Some(3)]);
    }

    #[test]
    fn the_same_face_twice_is_surplus_even_on_a_solid() {
        let solid = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 2]];
        assert_eq!(surplus(&solid), [None, None, None, None, Some(0)]);
    }
}
