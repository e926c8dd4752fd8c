use glam::DVec3;

use super::complex::Complex;
use super::overlay::{ArcKind, Overlay, arc, twin};
use super::regular::{can_contract, glue_lens, is_held};
use crate::tolerance::{NO_ADVANCE, SNAP_TO_LINE, STRAIGHT_COSINE};

/// Draws crossings of the net onto features and the boundary where they lie close beside them, and
/// puts places on such a line together that lie close to each other, so that no slivers are left
/// along lines that the map does not follow. Returns how many arcs were contracted.
///
/// `side` is the usual side of a cell. Ends of features, their junctions and sharp bends keep
/// their places, and so does everything that no short arc leads from. Sides of the net, from one
/// lattice point to the next, stay however short they are: the cells beside them are quads.
pub(super) fn snap_to_lines(complex: &mut Complex, overlay: &Overlay, side: f64) -> usize {
    let longest = SNAP_TO_LINE * side;
    let mut snapped = 0;
    loop {
        let mut short: Vec<(f64, u32)> = (0..complex.dart_count())
            .step_by(2)
            .filter(|&dart| complex.is_alive(dart) && !is_side_of_net(complex, overlay, dart))
            .map(|dart| (length(complex, overlay, dart), dart))
            .filter(|&(length, _)| length <= longest)
            .collect();
        short.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let before = snapped;
        for (_, dart) in short {
            if complex.is_alive(dart)
                && !is_side_of_net(complex, overlay, dart)
                && length(complex, overlay, dart) <= longest
                && let Some(dart) = towards_line(complex, overlay, dart)
                && can_contract(complex, dart)
            {
                let beside = [dart, twin(dart)].map(|dart| complex.next[dart as usize]);
                complex.contract(dart);
                snapped += 1;
                for side in beside {
                    glue_lens(complex, side);
                }
            }
        }
        if snapped == before {
            return snapped;
        }
    }
}

/// Whether an arc leads from one lattice point to another one.
pub(super) fn is_side_of_net(complex: &Complex, overlay: &Overlay, dart: u32) -> bool {
    let ends = [dart, twin(dart)].map(|dart| complex.origin(dart) as usize);
    ends.iter().all(|&end| overlay.lattice[end]) && complex.advances[arc(dart)].abs() > NO_ADVANCE
}

/// The length of an arc, or the distance of its ends where that is more.
fn length(complex: &Complex, overlay: &Overlay, dart: u32) -> f64 {
    let place = |node: u32| overlay.positions[node as usize];
    let even = dart & !1;
    let mut length = 0.0;
    let mut before = place(complex.origin(even));
    for &node in complex.path(arc(even)) {
        length += before.distance(place(node));
        before = place(node);
    }
    length + before.distance(place(complex.destination(even)))
}

/// The dart of the arc whose end may go over to its origin: from a place on a line to a crossing
/// beside it, or to another place of the same line.
fn towards_line(complex: &Complex, overlay: &Overlay, dart: u32) -> Option<u32> {
    let ways = [dart, twin(dart)];
    match complex.kinds[arc(dart)] {
        ArcKind::Line => {
            (ways.into_iter()).find(|&way| is_held(complex, way) && !is_held(complex, twin(way)))
        }
        ArcKind::Feature | ArcKind::Boundary => {
            (ways.into_iter()).find(|&way| passes_straight(complex, overlay, twin(way)))
        }
        ArcKind::Cut | ArcKind::Inner => None,
    }
}

/// Whether just one line passes the origin of a dart that runs along it, without a sharp bend.
fn passes_straight(complex: &Complex, overlay: &Overlay, dart: u32) -> bool {
    let held: Vec<u32> = (complex.around_node(dart))
        .filter(|&leaving| complex.kinds[arc(leaving)] >= ArcKind::Feature)
        .collect();
    let [one, other] = held[..] else {
        return false;
    };
    let [a, b] = [one, other].map(|dart| direction(complex, overlay, dart));
    complex.kinds[arc(one)] == complex.kinds[arc(other)] && -a.dot(b) > STRAIGHT_COSINE
}

/// The direction in which a dart leaves its origin.
fn direction(complex: &Complex, overlay: &Overlay, dart: u32) -> DVec3 {
    let path = complex.path(arc(dart));
    let next = if dart.is_multiple_of(2) {
        path.first()
    } else {
        path.last()
    };
    let next = next.map_or_else(|| complex.destination(dart), |&node| node);
    let [from, to] = [complex.origin(dart), next].map(|node| overlay.positions[node as usize]);
    (to - from).normalize_or_zero()
}
