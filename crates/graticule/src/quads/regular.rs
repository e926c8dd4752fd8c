use glam::DVec3;

use super::complex::Complex;
use super::overlay::{ArcKind, Overlay, arc, twin};
use super::snap::{is_side_of_net, snap_to_lines};
use crate::tolerance::{ARC_HEIGHT, NO_ADVANCE, SIDE_HEIGHT, STRAIGHT_COSINE};

/// Arcs that [`make_regular`] drew together.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contracted {
    /// Between images of one lattice point.
    pub(super) folds: usize,
    /// Short ones to or along features and the boundary.
    pub(super) snapped: usize,
}

/// Makes of the net a mesh of polygons: takes folds out, draws crossings close to lines onto them,
/// joins arcs at nodes that only two of them meet, and sees to it that each polygon has three
/// corners or more and no two arcs have the same ends. `side` is the usual side of a cell.
pub(super) fn make_regular(complex: &mut Complex, overlay: &Overlay, side: f64) -> Contracted {
    let folds = draw_folds_together(complex, overlay);
    let snapped = snap_to_lines(complex, overlay, side);
    join_lone_pairs(complex, overlay);
    follow_borders(complex, overlay);
    make_distinct(complex);
    Contracted { folds, snapped }
}

/// Splits arcs until each cell has three sides or more and no two arcs have the same ends.
pub(super) fn make_distinct(complex: &mut Complex) {
    while split_repeated_arcs(complex) {}
}

/// Contracts arcs between two images of one lattice point: the map folds between them.
fn draw_folds_together(complex: &mut Complex, overlay: &Overlay) -> usize {
    glue_lenses(complex);
    let mut folds = 0;
    loop {
        let before = folds;
        for dart in (0..complex.dart_count()).step_by(2) {
            if is_fold(complex, overlay, dart)
                && !(is_held(complex, dart) && is_held(complex, twin(dart)))
                && can_contract(complex, dart)
            {
                let dart = if is_held(complex, twin(dart)) {
                    twin(dart)
                } else {
                    dart
                };
                let beside = [dart, twin(dart)].map(|dart| complex.next[dart as usize]);
                complex.contract(dart);
                folds += 1;
                for side in beside {
                    glue_lens(complex, side);
                }
            }
        }
        if folds == before {
            return folds;
        }
    }
}

fn is_fold(complex: &Complex, overlay: &Overlay, dart: u32) -> bool {
    let lattice = |dart: u32| overlay.lattice[complex.origin(dart) as usize];
    complex.is_alive(dart)
        && complex.kinds[arc(dart)] == ArcKind::Line
        && complex.advances[arc(dart)].abs() < NO_ADVANCE
        && lattice(dart)
        && lattice(twin(dart))
}

/// Whether the origin of a dart lies on the boundary or on a feature, and so keeps its place.
pub(super) fn is_held(complex: &Complex, dart: u32) -> bool {
    complex
        .around_node(dart)
        .any(|leaving| complex.kinds[arc(leaving)] >= ArcKind::Feature)
}

/// Whether the surface stays what it is when the ends of an arc become one: no cell and no node
/// other than those beside the arc touches both.
pub(super) fn can_contract(complex: &Complex, dart: u32) -> bool {
    let other = twin(dart);
    let around = |dart: u32| complex.around_node(dart);
    let touches_border = |dart: u32| around(dart).any(|leaving| complex.is_outside(leaving));
    let is_border = complex.kinds[arc(dart)] == ArcKind::Boundary;
    let least_sides = |side: u32| if complex.is_outside(side) { 4 } else { 3 };
    if complex.origin(dart) == complex.origin(other)
        || !is_border && touches_border(dart) && touches_border(other)
        || [dart, other]
            .iter()
            .any(|&side| complex.side_count(side) < least_sides(side))
    {
        return false;
    }
    let tip_is_loose = |side: u32| {
        let sides = [complex.previous[side as usize], complex.next[side as usize]];
        let [one, two] = sides.map(|side| complex.cells[twin(side) as usize]);
        complex.side_count(side) == 3 && one == two
    };
    if tip_is_loose(dart) || tip_is_loose(other) {
        return false;
    }
    let beside = [dart, other].map(|side| complex.cells[side as usize]);
    let cells: Vec<u32> = around(dart).map(|d| complex.cells[d as usize]).collect();
    let shared_cell = around(other)
        .map(|d| complex.cells[d as usize])
        .any(|cell| !beside.contains(&cell) && cells.contains(&cell));
    let tips: Vec<u32> = [dart, other]
        .into_iter()
        .filter(|&side| complex.side_count(side) == 3)
        .map(|side| complex.origin(complex.previous[side as usize]))
        .collect();
    let nodes: Vec<u32> = around(dart).map(|d| complex.destination(d)).collect();
    let far = around(other).skip(1).map(|d| complex.destination(d));
    let shared_node = far.filter(|node| nodes.contains(node) && !tips.contains(node));
    !shared_cell && shared_node.count() == 0
}

fn glue_lenses(complex: &mut Complex) {
    for dart in 0..complex.dart_count() {
        glue_lens(complex, dart);
    }
}

/// Makes one arc of the two round a cell with two sides.
pub(super) fn glue_lens(complex: &mut Complex, dart: u32) {
    if !complex.is_alive(dart) || complex.is_outside(dart) || complex.side_count(dart) != 2 {
        return;
    }
    let mut sides = [dart, complex.next[dart as usize]];
    sides.sort_by_key(|&side| complex.kinds[arc(side)]);
    let [less, more] = sides;
    let beyond = sides.map(|side| complex.cells[twin(side) as usize]);
    if beyond[0] == beyond[1]
        || sides
            .iter()
            .any(|&side| beyond.contains(&complex.cells[side as usize]))
    {
        return;
    }
    complex.remove(twin(less));
    // What was beyond may be a lens now too.
    glue_lens(complex, more);
}

/// Joins the two arcs at nodes where no third ends: straight ones become one arc; two cells with four
/// sides that meet along both become one cell.
fn join_lone_pairs(complex: &mut Complex, overlay: &Overlay) {
    for dart in 0..complex.dart_count() {
        if !complex.is_alive(dart) || complex.around_node(dart).count() != 2 {
            continue;
        }
        let before = complex.previous[dart as usize];
        let [last, next] = [complex.origin(before), complex.destination(dart)];
        if last == next || complex.kinds[arc(before)] != complex.kinds[arc(dart)] {
            continue;
        }
        let sides = [dart, twin(dart)].map(|side| {
            if complex.is_outside(side) {
                usize::MAX
            } else {
                complex.side_count(side)
            }
        });
        let joined = complex
            .around_node(before)
            .any(|d| complex.destination(d) == next);
        let place = |node: u32| overlay.positions[node as usize];
        let [a, b, c] = [last, complex.origin(dart), next].map(place);
        let straight = (b - a).normalize_or_zero().dot((c - b).normalize_or_zero());
        if straight > STRAIGHT_COSINE && sides[0].min(sides[1]) > 3 && !joined {
            complex.dissolve(dart);
        } else if sides == [4, 4]
            && complex.cells[dart as usize] != complex.cells[twin(dart) as usize]
        {
            let opposite = |side: u32| {
                let after = complex.next[side as usize];
                complex.destination(after)
            };
            if opposite(dart) != opposite(twin(before)) {
                complex.dissolve(dart);
                complex.remove(before);
            }
        }
    }
}

/// Splits arcs along the boundary and features that leave the straight line between their ends.
fn follow_borders(complex: &mut Complex, overlay: &Overlay) {
    let mut dart = 0;
    while dart < complex.dart_count() {
        let held = matches!(
            complex.kinds[arc(dart)],
            ArcKind::Boundary | ArcKind::Feature
        );
        if held
            && complex.is_alive(dart)
            && let Some(place) = bend(complex, overlay, dart)
        {
            complex.split(arc(dart), place);
        } else {
            dart += 2;
        }
    }
}

/// The place on the path of an arc that is farthest from the line between its ends, if it is too
/// far.
fn bend(complex: &Complex, overlay: &Overlay, dart: u32) -> Option<usize> {
    let place = |node: u32| overlay.positions[node as usize];
    let [from, to] = [complex.origin(dart), complex.destination(dart)].map(place);
    let chord = to - from;
    let direction = chord.normalize_or_zero();
    let height = |point: DVec3| {
        let along = (point - from).dot(direction).clamp(0.0, chord.length());
        (point - from - direction * along).length()
    };
    let heights = (complex.path(arc(dart)).iter()).map(|&node| height(place(node)));
    let farthest = heights.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let most = if is_side_of_net(complex, overlay, dart) {
        SIDE_HEIGHT
    } else {
        ARC_HEIGHT
    };
    (farthest.1 > most * chord.length()).then_some(farthest.0)
}

/// Splits loops, and all but one of the arcs with the same ends. Returns whether there were any.
///
/// An arc without nodes inside is straight in one triangle; two such with the same ends cannot be.
fn split_repeated_arcs(complex: &mut Complex) -> bool {
    let mut ends: Vec<([u32; 2], usize, usize)> = (0..complex.dart_count())
        .step_by(2)
        .filter(|&dart| complex.is_alive(dart))
        .map(|dart| {
            let [from, to] = [complex.origin(dart), complex.destination(dart)];
            let nodes = complex.path(arc(dart)).len();
            ([from.min(to), from.max(to)], nodes, arc(dart))
        })
        .collect();
    ends.sort_unstable();
    let mut split = false;
    for group in ends.chunk_by(|a, b| a.0 == b.0) {
        let kept = usize::from(group[0].0[0] != group[0].0[1]);
        for &(_, nodes, arc) in group.iter().skip(kept) {
            if nodes > 0 {
                complex.split(arc, nodes / 2);
                split = true;
            }
        }
    }
    split
}
