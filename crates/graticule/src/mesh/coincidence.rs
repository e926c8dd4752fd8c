//! Vertices at one place, polygons over the same vertices.

use glam::DVec3;

use super::faces::Faces;
use super::gluing::NONE;

/// For each vertex the first one at exactly the same position; a vertex that is not finite or not
/// `used` stands alone.
///
/// Cost: O(n log n), whatever the positions: hashes are sorted, and equal hashes compared.
pub(super) fn first_at_same_position(positions: &[DVec3], used: &[bool]) -> Vec<u32> {
    let mut firsts: Vec<u32> = (0..positions.len() as u32).collect();
    let mut hashed: Vec<_> = positions
        .iter()
        .enumerate()
        .filter(|&(vertex, position)| used[vertex] && position.is_finite())
        .map(|(vertex, &position)| (hash(position_bits(position)), vertex as u32))
        .collect();
    hashed.sort_unstable();
    let key = |vertex: u32| position_bits(positions[vertex as usize]);
    for_each_equal(&mut hashed, key, |first, other| {
        firsts[other as usize] = first;
    });
    firsts
}

/// For each face the first one over the same vertices in whatever order, or [`NONE`] if it is the
/// first itself.
pub(super) fn first_over_same_vertices(faces: &impl Faces) -> Vec<u32> {
    let sorted = |face: u32| {
        let corners = faces.corners(face);
        let mut vertices: Vec<_> = corners.map(|corner| faces.origin(corner)).collect();
        vertices.sort_unstable();
        vertices
    };
    let sorted_hash = |face: u32| {
        let corners = faces.corners(face);
        if corners.len() == 3 {
            let first = corners.start;
            hash(sorted_triple(
                [0, 1, 2].map(|place| faces.origin(first + place)),
            ))
        } else {
            hash(sorted(face))
        }
    };
    let mut hashed: Vec<_> = (0..faces.face_count() as u32)
        .map(|face| (sorted_hash(face), face))
        .collect();
    hashed.sort_unstable();
    let mut firsts = vec![NONE; faces.face_count()];
    for_each_equal(&mut hashed, sorted, |first, other| {
        firsts[other as usize] = first;
    });
    firsts
}

/// Shows each element that equals an earlier one, with the first of its kind; `hashed` is sorted.
fn for_each_equal<K: Ord>(
    hashed: &mut [(u64, u32)],
    key: impl Fn(u32) -> K,
    mut show: impl FnMut(u32, u32),
) {
    for run in hashed.chunk_by_mut(|a, b| a.0 == b.0) {
        if run.len() < 2 {
            continue;
        }
        run.sort_by_cached_key(|&(_, element)| (key(element), element));
        let mut first = run[0].1;
        for &(_, element) in &run[1..] {
            if key(first) == key(element) {
                show(first, element);
            } else {
                first = element;
            }
        }
    }
}

fn sorted_triple([a, b, c]: [u32; 3]) -> [u32; 3] {
    let [a, b] = [a.min(b), a.max(b)];
    [a.min(c), a.max(b.min(c)), b.max(c)]
}

fn position_bits(position: DVec3) -> [u64; 3] {
    // Adding 0 turns -0 into 0.
    position
        .to_array()
        .map(|coordinate| (coordinate + 0.0).to_bits())
}

fn hash<T: Into<u64>>(words: impl IntoIterator<Item = T>) -> u64 {
    words
        .into_iter()
        .fold(0x9e37_79b9_7f4a_7c15, |state, word| {
            let mixed = (state ^ word.into()).wrapping_mul(0xff51_afd7_ed55_8ccd);
            mixed ^ (mixed >> 32)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::faces::PolygonFaces;

    #[test]
    fn the_first_vertex_at_a_position_stands_for_the_others() {
        let positions = [
            DVec3::X,
            DVec3::new(0.0, -0.0, 1.0),
            DVec3::X,
            DVec3::NAN,
            DVec3::NAN,
            DVec3::Z,
            DVec3::X,
        ];
        let firsts = first_at_same_position(&positions, &[true; 7]);
        assert_eq!(firsts, [0, 1, 0, 3, 4, 1, 0]);
        let unused = [false, true, true, true, true, false, true];
        assert_eq!(
            first_at_same_position(&positions, &unused),
            [0, 1, 2, 3, 4, 5, 2]
        );
    }

    #[test]
    fn faces_over_the_same_vertices_are_found_in_any_order() {
        let mut faces = PolygonFaces::with_capacity(4, 14);
        for face in [&[4, 1, 2][..], &[0, 1, 2, 3], &[2, 1, 4], &[1, 0, 2, 3]] {
            faces.push(face.iter().copied());
        }
        assert_eq!(first_over_same_vertices(&faces), [NONE, NONE, 0, 1]);
    }
}
