use std::ops::ControlFlow;

use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

use super::draft::Draft;
use crate::mesh::gluing::NONE;
use crate::mesh::measures::Bounds;
use crate::mesh::point_tree::PointTree;
use crate::mesh::polygon::reciprocal_power_of_two;

/// For each closed component the largest of those around it that lie in no other, or [`NONE`].
///
/// A component lies inside another if a ray from one of its vertices crosses the other an odd
/// number of times; crossings are decided exactly. The vertex is the one farthest along the ray,
/// so that the ray never meets its own component.
pub(super) fn outermost_containers(
    draft: &Draft,
    components: &[u32],
    is_closed: &[bool],
    bounds: &[Bounds],
) -> Vec<u32> {
    let mut outermost = vec![NONE; is_closed.len()];
    if is_closed.iter().filter(|closed| **closed).count() < 2 {
        return outermost;
    }
    let mut crossings = find_crossings(draft, components, is_closed);
    crossings.sort_unstable();
    let mut inside: Vec<_> = crossings
        .chunk_by(|a, b| a == b)
        .filter(|same| same.len() % 2 == 1)
        .map(|same| same[0])
        .collect();
    let mut is_inside = vec![false; is_closed.len()];
    for &[component, _] in &inside {
        is_inside[component as usize] = true;
    }
    inside.retain(|&[_, container]| !is_inside[container as usize]);
    let extent = |component: u32| bounds[component as usize].extent();
    for [component, container] in inside {
        let best = &mut outermost[component as usize];
        if *best == NONE || extent(container) > extent(*best) {
            *best = container;
        }
    }
    outermost
}

/// A pair (component, other component) for each crossing of the one's ray with the other.
fn find_crossings(draft: &Draft, components: &[u32], is_closed: &[bool]) -> Vec<[u32; 2]> {
    // Scaled exactly, so that the products in the predicates stay finite.
    let largest = draft.positions.iter().map(|p| p.abs().max_element());
    let scale = reciprocal_power_of_two(largest.fold(0.0, f64::max));
    let place = |vertex: u32| draft.positions[vertex as usize] * scale;
    let is_closed = |face: u32| is_closed[components[face as usize] as usize];
    let mut starts: Vec<Option<DVec3>> = vec![None; components.len()];
    for face in (0..components.len() as u32).filter(|&face| is_closed(face)) {
        for vertex in draft.triangles[face as usize] {
            let point = place(vertex);
            let start = &mut starts[components[face as usize] as usize];
            if start.is_none_or(|start| later(point, start)) {
                *start = Some(point);
            }
        }
    }
    let (owners, points): (Vec<_>, Vec<_>) = (0_u32..)
        .zip(starts)
        .filter_map(|(component, start)| start.map(|start| (component, start)))
        .unzip();
    let tree = PointTree::new(points);
    let mut crossings = Vec::new();
    for face in (0..components.len() as u32).filter(|&face| is_closed(face)) {
        let corners = draft.triangles[face as usize].map(place);
        for point in rays_through(&tree, corners) {
            let pair = [owners[point as usize], components[face as usize]];
            if pair[0] != pair[1] {
                crossings.push(pair);
            }
        }
    }
    crossings
}

fn later(point: DVec3, other: DVec3) -> bool {
    let orders = (0..3).map(|axis| point[axis].total_cmp(&other[axis]));
    orders
        .fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
        .is_gt()
}

/// The points whose ray along +x passes through the triangle.
fn rays_through(tree: &PointTree, corners: [DVec3; 3]) -> Vec<u32> {
    let [a, b, c] = corners;
    let [low, high] = [a.min(b).min(c), a.max(b).max(c)];
    let mut found = Vec::new();
    tree.search::<()>(
        |box_low, box_high| {
            let across = box_low.y <= high.y && box_high.y >= low.y;
            across && box_low.z <= high.z && box_high.z >= low.z && box_low.x <= high.x
        },
        |point| {
            if ray_crosses(tree.point(point), corners) {
                found.push(point);
            }
            ControlFlow::Continue(())
        },
    );
    found
}

fn ray_crosses(start: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let turns = [[a, b], [b, c], [c, a]].map(|[from, to]| side_of_edge(start, from, to));
    if turns[0] == 0 || turns[0] != turns[1] || turns[1] != turns[2] {
        return false;
    }
    let [a, b, c, start] = [a, b, c, start].map(|DVec3 { x, y, z }| Coord3D { x, y, z });
    // Positive if `start` lies below the plane, from where the triangle turns counter-clockwise.
    let below = orient3d(a, b, c, start);
    if turns[0] > 0 {
        below > 0.0
    } else {
        below < 0.0
    }
}

/// On which side of an edge the ray passes, seen along it; a ray through the edge itself counts as
/// moved a little along y, and much less along z, the same for all edges.
fn side_of_edge(start: DVec3, from: DVec3, to: DVec3) -> i8 {
    let flat = |point: DVec3| Coord {
        x: point.y,
        y: point.z,
    };
    let sign = |value: f64| i8::from(value > 0.0) - i8::from(value < 0.0);
    let exact = sign(orient2d(flat(from), flat(to), flat(start)));
    let along_y = sign(from.z - to.z);
    let along_z = sign(to.y - from.y);
    [exact, along_y, along_z]
        .into_iter()
        .find(|&side| side != 0)
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_through_edges_and_corners_crosses_a_closed_surface_once_on_its_way_out() {
        let cube = graticule_fixtures::cube();
        for y in [0.25, 0.5, 1.0] {
            for z in [0.25, 0.5, 1.0] {
                let crossings = |x: f64| {
                    let start = DVec3::new(x, y, z);
                    let corners = |t: &[u32; 3]| t.map(|v| cube.positions[v as usize]);
                    let crossed = |t: &&[u32; 3]| ray_crosses(start, corners(t));
                    cube.triangles.iter().filter(crossed).count()
                };
                // Points at y = 1 or z = 1 count as moved outside.
                let expected = usize::from(y < 1.0 && z < 1.0);
                assert_eq!(crossings(0.5), expected);
                assert_eq!(crossings(-1.0), 2 * expected);
                assert_eq!(crossings(2.0), 0);
            }
        }
    }
}
