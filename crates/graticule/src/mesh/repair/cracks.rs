//! Closes cracks: holes without width between a triangle and vertices that lie in the middle of its
//! side (*T-junctions*). The triangle is cut at these vertices; nothing moves.

use std::collections::HashSet;

use super::RepairChanges;
use super::draft::Draft;
use crate::mesh::HalfedgeId;
use crate::mesh::faces::Faces;
use crate::mesh::gluing::NONE;
use crate::mesh::measures::{face_shape, length};
use crate::tolerance::{CRACK_WIDTH, NO_AREA_HEIGHT};

/// How often cracks are looked for: a triangle can have one at each of its sides.
const ROUNDS: usize = 3;

/// Closes the cracks of an oriented manifold draft; returns whether there were any.
pub(super) fn close_cracks(draft: &mut Draft, changes: &mut RepairChanges) -> bool {
    let before = changes.cracks_closed.count();
    for _ in 0..ROUNDS {
        let cracks: Vec<Vec<u32>> = (boundary_loops(draft).into_iter())
            .filter_map(|hole| as_crack(draft, hole))
            .collect();
        if cracks.is_empty() || !close(draft, &cracks, changes) {
            break;
        }
        restore_order(draft);
    }
    changes.cracks_closed.count() > before
}

/// Puts triangles in the order of their polygons again.
fn restore_order(draft: &mut Draft) {
    let mut order: Vec<usize> = (0..draft.triangles.len()).collect();
    order.sort_by_key(|&triangle| draft.polygons[triangle]);
    draft.triangles = order.iter().map(|&t| draft.triangles[t]).collect();
    draft.corner_sources = order.iter().map(|&t| draft.corner_sources[t]).collect();
    draft.polygons = order.iter().map(|&t| draft.polygons[t]).collect();
}

/// The sides without another along each boundary loop.
fn boundary_loops(draft: &Draft) -> Vec<Vec<u32>> {
    let twins = draft.twins();
    let faces = draft.faces();
    // Of a manifold one such side leaves each vertex at most.
    let mut leaving = vec![NONE; draft.positions.len()];
    let open = (0..twins.len() as u32).filter(|&side| twins[side as usize] == NONE);
    for side in open.clone() {
        leaving[faces.origin(side) as usize] = side;
    }
    let mut loops = Vec::new();
    for start in open {
        let mut hole = Vec::new();
        let mut vertex = faces.origin(start) as usize;
        while leaving[vertex] != NONE {
            let side = std::mem::replace(&mut leaving[vertex], NONE);
            hole.push(side);
            vertex = faces.destination(side) as usize;
        }
        if !hole.is_empty() {
            loops.push(hole);
        }
    }
    loops
}

/// The sides of a hole from its longest one on, if all others lie along that.
fn as_crack(draft: &Draft, mut hole: Vec<u32>) -> Option<Vec<u32>> {
    let faces = draft.faces();
    let place = |vertex: u32| draft.positions[vertex as usize];
    let lengths: Vec<f64> = (hole.iter())
        .map(|&side| length(place(faces.destination(side)) - place(faces.origin(side))))
        .collect();
    let longest = (0..hole.len()).max_by(|&a, &b| lengths[a].total_cmp(&lengths[b]))?;
    let others = lengths.iter().sum::<f64>() - lengths[longest];
    if hole.len() < 3 || others > (1.0 + CRACK_WIDTH) * lengths[longest] {
        return None;
    }
    hole.rotate_left(longest);
    let ends = [faces.origin(hole[0]), faces.destination(hole[0])].map(place);
    let is_along = |&side: &u32| {
        let corners = [ends[0], ends[1], place(faces.origin(side))];
        face_shape(corners.into_iter()).height <= CRACK_WIDTH
    };
    hole[2..].iter().all(is_along).then_some(hole)
}

/// Closes those that can be without an edge made twice; returns whether there were any.
fn close(draft: &mut Draft, cracks: &[Vec<u32>], changes: &mut RepairChanges) -> bool {
    let count = draft.triangles.len();
    let sides = 0..3 * count as u32;
    let mut edges: HashSet<[u32; 2]> = sides.map(|side| draft.faces().edge(side)).collect();
    let mut is_cut = vec![false; count];
    for crack in cracks {
        let triangle = crack[0] as usize / 3;
        let pieces = pieces(crack);
        if is_cut[triangle] || !is_sound(draft, triangle, &pieces) {
            continue;
        }
        let apex = draft.faces().origin(HalfedgeId(crack[0]).previous().0);
        let spokes = (crack[2..].iter()).map(|&side| {
            let vertex = draft.faces().origin(side);
            [vertex.min(apex), vertex.max(apex)]
        });
        let spokes: Vec<[u32; 2]> = spokes.collect();
        // A sliver that stands alone is one with its own corner as the apex.
        let is_taken = |spoke: &[u32; 2]| spoke[0] == spoke[1] || edges.contains(spoke);
        if spokes.iter().any(is_taken) {
            continue;
        }
        edges.extend(spokes);
        changes.cracks_closed.push(draft.source_edge(crack[0]));
        is_cut[triangle] = true;
        put(draft, triangle, &pieces);
    }
    is_cut.contains(&true)
}

/// The triangle at the long side of a crack, cut at the vertices along it: the corners, by sides that
/// leave their vertices.
fn pieces(crack: &[u32]) -> Vec<[u32; 3]> {
    let side = HalfedgeId(crack[0]);
    let mut along = vec![side.0];
    along.extend(crack[2..].iter().rev());
    along.push(side.next().0);
    let apex = side.previous().0;
    along
        .windows(2)
        .map(|pair| [pair[0], pair[1], apex])
        .collect()
}

/// Whether no piece is turned over, and the triangle has an area to be cut.
fn is_sound(draft: &Draft, triangle: usize, pieces: &[[u32; 3]]) -> bool {
    let place = |side: u32| draft.positions[draft.faces().origin(side) as usize];
    let normal = |corners: [u32; 3]| {
        let [a, b, c] = corners.map(place);
        (b - a).cross(c - a)
    };
    let first = 3 * triangle as u32;
    let whole = [first, first + 1, first + 2];
    let shape = face_shape(whole.map(place).into_iter());
    let is_turned = |piece: &[u32; 3]| normal(*piece).dot(normal(whole)) < 0.0;
    shape.height > NO_AREA_HEIGHT && !pieces.iter().any(is_turned)
}

fn put(draft: &mut Draft, triangle: usize, pieces: &[[u32; 3]]) {
    let polygon = draft.polygons[triangle];
    let vertices = |side: u32| draft.triangles.as_flattened()[side as usize];
    let sources = |side: u32| draft.corner_sources.as_flattened()[side as usize];
    let made: Vec<_> = (pieces.iter())
        .map(|piece| (piece.map(vertices), piece.map(sources)))
        .collect();
    for (place, (vertices, sources)) in made.into_iter().enumerate() {
        if place == 0 {
            draft.triangles[triangle] = vertices;
            draft.corner_sources[triangle] = sources;
        } else {
            draft.triangles.push(vertices);
            draft.corner_sources.push(sources);
            draft.polygons.push(polygon);
        }
    }
}
