//! Nested dissection by coordinates.
//!
//! George (1973): cut the graph in two by few vertices, eliminate both halves first and the
//! separator last, and so on within the halves. For a mesh the vertices' positions show where to
//! cut: across a principal direction of the part, near the middle, where the fewest edges cross.
//! Where positions do not help (coincident points, folded sheets), steps along edges from a far
//! vertex take their place. The separator is then made as small as possible near that cut (see
//! [`separator`](super::separator)). Parts of a few hundred vertices are ordered by approximate minimum
//! degree that knows of the vertices around them.
//!
//! On a surface mesh with n vertices this takes O(n log n), and so does the factor.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use glam::DVec3;

use super::cut::choose_cut;
use super::graph::{ABSENT, Graph};
use super::separator::{Side, separate};

/// Parts up to this size are ordered by minimum degree. Against 120 this costs two in a hundred of
/// fill and saves a quarter of the time.
const LEAF: usize = 400;

/// Parts from this size on are worth another thread.
const PARALLEL: usize = 20_000;

/// Layers of vertices on each side of the geometric cut in which the smallest separator is sought.
/// Each further layer lowers the fill by half a percent and costs as much in time.
const BAND_LAYERS: usize = 2;

/// The whole graph, its vertices sorted along a space-filling curve so that neighbours lie close
/// in memory.
struct Whole {
    graph: Graph,
    points: Vec<DVec3>,
}

/// A set of vertices cut out of the whole graph, ascending.
struct Part {
    /// Numbers in the whole graph.
    ids: Vec<u32>,
    graph: Graph,
}

/// The vertices of `graph` in elimination order. `points` lie in `-1..=1`.
pub(super) fn dissect(graph: &Graph, points: &[DVec3]) -> Vec<u32> {
    let (sparse, dense) = split_dense_vertices(graph);
    let along_curve = sorted_along_curve(sparse, points);
    let mut scratch = vec![ABSENT; graph.vertices()];
    let whole = Whole {
        graph: graph.induced(&along_curve, &mut scratch).sorted(),
        points: along_curve.iter().map(|&v| points[v as usize]).collect(),
    };
    let mut order = vec![0; along_curve.len()];
    let mut rest = order.as_mut_slice();
    for ids in whole.graph.components() {
        let (here, after) = rest.split_at_mut(ids.len());
        let graph = whole.graph.induced(&ids, &mut scratch);
        dissect_part(&whole, Part { ids, graph }, here);
        rest = after;
    }
    let in_curve = order.into_iter().map(|id| along_curve[id as usize]);
    in_curve.chain(dense).collect()
}

/// Vertices with so many neighbours that every cut would have to contain them go last, as in
/// approximate minimum degree.
fn split_dense_vertices(graph: &Graph) -> (Vec<u32>, Vec<u32>) {
    let limit = (10 * graph.vertices().isqrt()).max(16);
    (0..graph.vertices() as u32).partition(|&vertex| graph.neighbours(vertex).len() <= limit)
}

/// Sorts along the Morton curve, 21 bits of each coordinate; points are within `-1..=1`.
#[expect(clippy::cast_sign_loss, reason = "coordinates are at least -1")]
pub(super) fn sorted_along_curve(vertices: Vec<u32>, points: &[DVec3]) -> Vec<u32> {
    let spread = |value: f64| {
        // Two zero bits between any two bits.
        let mut bits = ((value + 1.0) * f64::from(1 << 20)) as u64 & 0x1f_ffff;
        bits = (bits | bits << 32) & 0x001f_0000_0000_ffff;
        bits = (bits | bits << 16) & 0x001f_0000_ff00_00ff;
        bits = (bits | bits << 8) & 0x100f_00f0_0f00_f00f;
        bits = (bits | bits << 4) & 0x10c3_0c30_c30c_30c3;
        (bits | bits << 2) & 0x1249_2492_4924_9249
    };
    let key = |vertex: u32| {
        let point = points[vertex as usize];
        (
            spread(point.x) | spread(point.y) << 1 | spread(point.z) << 2,
            vertex,
        )
    };
    let mut keyed: Vec<(u64, u32)> = vertices.into_iter().map(key).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, vertex)| vertex).collect()
}

fn dissect_part(whole: &Whole, part: Part, order: &mut [u32]) {
    if part.ids.len() <= LEAF {
        order_leaf(&whole.graph, &part, order);
        return;
    }
    let mut sides = choose_cut(&part.graph, |v| whole.points[part.ids[v as usize] as usize]);
    separate(&part.graph, &mut sides, BAND_LAYERS);
    let ([left, right], separator) = split(&part, &sides);
    drop(part);
    let (left_order, rest) = order.split_at_mut(left.ids.len());
    let (right_order, separator_order) = rest.split_at_mut(right.ids.len());
    separator_order.copy_from_slice(&separator);
    if left.ids.len().min(right.ids.len()) >= PARALLEL {
        rayon::join(
            || dissect_part(whole, left, left_order),
            || dissect_part(whole, right, right_order),
        );
    } else {
        dissect_part(whole, left, left_order);
        dissect_part(whole, right, right_order);
    }
}

/// The parts on both sides, and the vertices of the separator.
fn split(part: &Part, sides: &[Side]) -> ([Part; 2], Vec<u32>) {
    let mut ids = [Vec::new(), Vec::new(), Vec::new()];
    let mut numbers = vec![0_u32; sides.len()];
    for ((&id, &side), number) in part.ids.iter().zip(sides).zip(&mut numbers) {
        *number = ids[side as usize].len() as u32;
        ids[side as usize].push(id);
    }
    let [left, right, separator] = ids;
    let mut halves = [left, right].map(|ids| Part {
        graph: Graph::with_capacity(ids.len(), part.graph.neighbours.len()),
        ids,
    });
    for (vertex, &side) in (0..).zip(sides) {
        if side == Side::Separator {
            continue;
        }
        let Graph { starts, neighbours } = &mut halves[side as usize].graph;
        for &neighbour in part.graph.neighbours(vertex) {
            // No edge joins left and right.
            if sides[neighbour as usize] == side {
                neighbours.push(numbers[neighbour as usize]);
            }
        }
        starts.push(neighbours.len() as u32);
    }
    (halves, separator)
}

/// Orders a small part by minimum degree, with the vertices around it, which are eliminated later,
/// in the picture (a "halo": Pellegrini, Roman and Amestoy 2000). Four in a hundred less fill.
fn order_leaf(whole: &Graph, part: &Part, order: &mut [u32]) {
    let inside = part.ids.len() as u32;
    let mut edges = Vec::with_capacity(4 * part.graph.neighbours.len());
    let mut halo: Vec<(u32, u32)> = Vec::new();
    for (local, &id) in (0..).zip(&part.ids) {
        let inner = part.graph.neighbours(local);
        edges.extend(inner.iter().filter(|&&n| n < local).map(|&n| [n, local]));
        if inner.len() < whole.neighbours(id).len() {
            let around = whole.neighbours(id).iter();
            let around = around.filter(|neighbour| part.ids.binary_search(neighbour).is_err());
            halo.extend(around.map(|&neighbour| (neighbour, local)));
        }
    }
    halo.sort_unstable();
    let mut count = inside;
    for same in halo.chunk_by(|a, b| a.0 == b.0) {
        edges.extend(same.iter().map(|&(_, local)| [local, count]));
        count += 1;
    }
    // Joined with each other, the outer vertices have the largest degrees and come last.
    for outer in inside..count {
        edges.extend((inside..outer).map(|other| [other, outer]));
    }
    let graph = Graph::from_edges(count as usize, edges.into_iter());
    let inner = minimum_degree(&graph).into_iter().filter(|&v| v < inside);
    for (place, local) in order.iter_mut().zip(inner) {
        *place = part.ids[local as usize];
    }
}

/// Approximate minimum degree, by `faer`.
pub(super) fn minimum_degree(graph: &Graph) -> Vec<u32> {
    let count = graph.vertices();
    let mut order: Vec<u32> = (0..count as u32).collect();
    if graph.neighbours.is_empty() {
        return order;
    }
    let entries = graph.neighbours.len();
    let mut memory = MemBuffer::new(amd::order_scratch::<u32>(count, entries));
    let pattern =
        SymbolicSparseColMatRef::new_checked(count, count, &graph.starts, None, &graph.neighbours);
    let done = amd::order(
        &mut order,
        &mut vec![0; count],
        pattern,
        amd::Control::default(),
        MemStack::new(&mut memory),
    );
    if done.is_err() {
        // Only where entry counts overflow 32 bits; `order` may be half-written then.
        return (0..count as u32).collect();
    }
    order
}
