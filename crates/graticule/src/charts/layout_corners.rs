use std::f64::consts::FRAC_PI_4;

use glam::DVec2;

use super::arcs::TracedArcs;
use super::nodes::{ArcGraph, dividing_places};
use super::{Chart, ChartKind, EmbeddedNet};
use crate::geometry::TriangleShape;
use crate::mesh::{HalfedgeId, VertexId};

/// The widest angle inside a chart at which a node is a corner: halfway from square to straight.
pub(super) const WIDEST_CORNER: f64 = 3.0 * FRAC_PI_4;

/// Corners that a chart with less than three is given.
const CORNERS: usize = 4;

/// The chart inside a border: its sides run from corner to corner.
pub(super) fn chart_sides(
    net: &EmbeddedNet,
    graph: &ArcGraph<'_>,
    traced: &TracedArcs,
    border: &[HalfedgeId],
) -> Chart {
    let mesh = net.refined.surface.mesh();
    let places: Vec<usize> = (0..border.len())
        .filter(|&place| graph.is_node(mesh.origin(border[place])))
        .collect();
    let before = |place: usize| border[(place + border.len() - 1) % border.len()];
    let is_corner = |place: usize| inner_angle(net, before(place), border[place]) < WIDEST_CORNER;
    let mut corners: Vec<usize> = places.iter().copied().filter(|&p| is_corner(p)).collect();
    if corners.len() < 3 {
        add_corners(net, border, &places, &mut corners);
    }
    let sides: Vec<_> = (0..corners.len())
        .map(|side| {
            let [from, to] = [corners[side], corners[(side + 1) % corners.len()]];
            let passed = places_between(&places, from, to);
            passed
                .filter_map(|place| traced.along(mesh, border[place]))
                .collect()
        })
        .collect();
    let kind = if sides.len() == 4 {
        ChartKind::Singular
    } else {
        ChartKind::Polygonal
    };
    Chart { sides, kind }
}

/// The places of nodes from one on, round to before another.
fn places_between(places: &[usize], from: usize, to: usize) -> impl Iterator<Item = usize> {
    let start = places.partition_point(|&place| place < from);
    let length = places.len();
    (0..length)
        .map(move |step| places[(start + step) % length])
        .enumerate()
        .take_while(move |&(step, place)| step == 0 || place != to)
        .map(|(_, place)| place)
}

/// The angle inside the chart between a halfedge of its border and the next one.
fn inner_angle(net: &EmbeddedNet, incoming: HalfedgeId, outgoing: HalfedgeId) -> f64 {
    let mesh = net.refined.surface.mesh();
    let mut corner = outgoing;
    let mut angle = corner_angle(net, corner);
    while corner.previous() != incoming {
        let Some(left) = mesh.turn_left(corner) else {
            break;
        };
        corner = left;
        angle += corner_angle(net, corner);
    }
    angle
}

/// The angle of a corner in coordinates, or in space where there are none.
pub(super) fn corner_angle(net: &EmbeddedNet, corner: HalfedgeId) -> f64 {
    let flat = [corner, corner.next(), corner.previous()].map(|c| net.coordinates[c]);
    if let [Some(apex), Some(next), Some(last)] = flat {
        (next - apex).angle_to(last - apex).abs()
    } else {
        let shape =
            TriangleShape::from_positions(net.refined.surface.corner_positions(corner.face()));
        shape.angle(corner.side())
    }
}

/// Makes nodes near the middles of the longest sides corners too.
fn add_corners(
    net: &EmbeddedNet,
    border: &[HalfedgeId],
    places: &[usize],
    corners: &mut Vec<usize>,
) {
    let mesh = net.refined.surface.mesh();
    let vertex = |place: usize| mesh.origin(border[place]);
    if corners.is_empty() {
        corners.extend(places.first());
    }
    while corners.len() < CORNERS.min(places.len()) {
        let mut best: Option<(f64, usize)> = None;
        for (index, &from) in corners.iter().enumerate() {
            let to = corners[(index + 1) % corners.len()];
            let side: Vec<usize> = places_between(places, from, to).chain([to]).collect();
            let nodes: Vec<VertexId> = side.iter().map(|&place| vertex(place)).collect();
            let middle =
                (nodes.len() > 2).then(|| dividing_places(&net.refined.surface, &nodes, 2));
            if let Some(&[middle]) = middle.as_deref() {
                let length = polyline_length(net, &nodes);
                if best.is_none_or(|(longest, _)| length > longest) {
                    best = Some((length, side[middle]));
                }
            }
        }
        let Some((_, place)) = best else { break };
        corners.push(place);
        corners.sort_unstable();
    }
}

fn polyline_length(net: &EmbeddedNet, vertices: &[VertexId]) -> f64 {
    let pairs = vertices.windows(2);
    pairs
        .map(|pair| {
            net.refined
                .surface
                .position(pair[0])
                .distance(net.refined.surface.position(pair[1]))
        })
        .sum()
}

/// Twice the signed area of a triangle of the plane, with the exact sign.
pub(super) fn orientation([a, b, c]: [DVec2; 3]) -> f64 {
    let [a, b, c] = [a, b, c].map(|DVec2 { x, y }| robust::Coord { x, y });
    robust::orient2d(a, b, c)
}
