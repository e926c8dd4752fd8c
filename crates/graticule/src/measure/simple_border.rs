use glam::DVec2;
use rayon::prelude::*;

use super::islands::Islands;
use super::overlap::rounds;
use super::uv_map::{UvMap, orientation};
use crate::geometry::{Bounds, BoxTree};
use crate::mesh::HalfedgeId;
use crate::watch::{Stopped, Watch};

/// Whether the map is one island, every triangle counter-clockwise, whose boundary loops touch
/// neither themselves nor each other and of which one runs counter-clockwise (exact).
///
/// Then nothing overlaps. For where no triangle is turned over, as many triangles lie over a point
/// as its winding numbers in all loops sum to; in a loop that does not touch itself that is 0 or 1
/// if it runs counter-clockwise, 0 or −1 if clockwise.
///
/// Near-linear in the number of border edges where few of their boxes overlap, however long and
/// thin the triangles are.
pub(super) fn encloses_once(
    map: &UvMap<'_>,
    islands: &Islands,
    watch: &Watch,
) -> Result<bool, Stopped> {
    let mut faces = map.surface.mesh().faces();
    let is_upright = faces.all(|face| !map.is_known(face) || map.sign(face) == 1);
    // The turning of a loop that does not touch itself is 2π or −2π.
    let outer_loops = islands.loops.iter().filter(|border| border.turning > 0.0);
    if !is_upright || islands.all.len() != 1 || outer_loops.count() != 1 {
        return Ok(false);
    }
    Ok(!touches_itself(map, watch)?)
}

/// Whether two border edges have more in common than the vertex between them.
fn touches_itself(map: &UvMap<'_>, watch: &Watch) -> Result<bool, Stopped> {
    let edges: Vec<HalfedgeId> = map.border().collect();
    let boxes: Vec<_> = edges
        .iter()
        .map(|&edge| closed_box(map.image_of_side(edge)))
        .collect();
    let tree = BoxTree::new(&boxes);
    for round in rounds(tree.leaf_count()) {
        let touching = round.into_par_iter().map(|mut leaves| {
            watch.check()?;
            Ok(leaves.any(|leaf| leaf_touches(map, &tree, leaf, &edges)))
        });
        let touching: Vec<bool> = touching.collect::<Result<_, Stopped>>()?;
        if touching.contains(&true) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// A box a little larger than the segment: boxes of segments that touch overlap.
fn closed_box(ends: [DVec2; 2]) -> Bounds<2> {
    let Bounds { low, high } = Bounds::around(&ends);
    Bounds {
        low: low.map(f64::next_down),
        high: high.map(f64::next_up),
    }
}

fn leaf_touches(map: &UvMap<'_>, tree: &BoxTree<2>, leaf: usize, edges: &[HalfedgeId]) -> bool {
    let mut found = Vec::new();
    tree.overlapping_leaves(leaf, leaf, &mut found);
    tree.leaf(leaf).any(|i| {
        let edge = edges[tree.item(i)];
        let mut others = tree.overlapping(i, &found).filter(|&j| i < j);
        others.any(|j| touch(map, edge, edges[tree.item(j)]))
    })
}

fn touch(map: &UvMap<'_>, first: HalfedgeId, second: HalfedgeId) -> bool {
    let [a, b] = map.image_of_side(first);
    let [c, d] = map.image_of_side(second);
    let follows = map.next_on_border(first) == second;
    let precedes = map.next_on_border(second) == first;
    match (follows, precedes) {
        (true, true) => true,
        (true, false) => folds_back(a, b, d),
        (false, true) => folds_back(c, d, b),
        (false, false) => segments_touch([a, b], [c, d]),
    }
}

/// Whether the way from `a` over `b` to `d` turns back along itself.
fn folds_back(a: DVec2, b: DVec2, d: DVec2) -> bool {
    orientation(a, b, d) == 0 && is_before(a, b) == is_before(d, b)
}

/// Whether two segments, ends included, have a point in common.
fn segments_touch([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let sides = [
        orientation(a, b, c) * orientation(a, b, d),
        orientation(c, d, a) * orientation(c, d, b),
    ];
    let on_one_line = orientation(a, b, c) == 0 && orientation(a, b, d) == 0;
    if on_one_line {
        let [a, b] = in_order([a, b]);
        let [c, d] = in_order([c, d]);
        return !is_before(b, c) && !is_before(d, a);
    }
    sides.iter().all(|&side| side <= 0)
}

fn in_order([a, b]: [DVec2; 2]) -> [DVec2; 2] {
    if is_before(b, a) { [b, a] } else { [a, b] }
}

/// The order along any line.
fn is_before(a: DVec2, b: DVec2) -> bool {
    (a.x, a.y) < (b.x, b.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{PerCorner, Surface};
    use graticule_fixtures::{Fixture, annulus, disk, grid};

    /// Whether the map of a flat fixture by `place` encloses every point once at most.
    fn once(fixture: Fixture, place: impl Fn(DVec2) -> DVec2) -> bool {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let mesh = surface.mesh();
        let uvs = PerCorner::from_fn(mesh.halfedge_count(), |corner| {
            place(surface.position(mesh.origin(corner)).truncate())
        });
        let map = UvMap::new(&surface, |corner| Some(uvs[corner])).unwrap();
        let islands = Islands::find(&map);
        encloses_once(&map, &islands, &Watch::new()).unwrap()
    }

    /// The strip `0..=1` × `0..=1` wound around the origin by `angle`, from radius 1 to 2.
    fn wound(angle: f64, growth: f64) -> impl Fn(DVec2) -> DVec2 {
        move |p| {
            let (sin, cos) = libm::sincos(-angle * p.x);
            DVec2::new(cos, sin) * (1.0 + p.y + growth * p.x)
        }
    }

    #[test]
    fn disks_and_rings_as_they_lie_enclose_their_points_once() {
        assert!(once(disk(4), |p| p));
        assert!(once(annulus(0.5, 1.0, 20, 3), |p| p * 1e-3));
        assert!(once(grid(1.0, 1.0, 60, 2), wound(6.0, 0.0)));
        assert!(once(grid(1.0, 1.0, 99, 2), wound(12.0, 4.0)));
    }

    #[test]
    fn what_covers_points_twice_is_not_taken_for_simple() {
        assert!(!once(grid(1.0, 1.0, 99, 2), wound(9.0, 0.0)));
        assert!(!once(grid(1.0, 1.0, 99, 2), wound(12.0, 1.0)));
        let squared = |p: DVec2| DVec2::new(p.x * p.x - p.y * p.y, 2.0 * p.x * p.y);
        assert!(!once(annulus(0.5, 1.0, 40, 3), squared));
        assert!(!once(disk(3), |p| DVec2::new(-p.x, p.y)));
    }

    #[test]
    fn a_border_that_only_touches_itself_is_left_to_the_full_search() {
        let full_turn = std::f64::consts::TAU;
        let closed = |p: DVec2| {
            let x = if p.x > 0.999 { 0.0 } else { p.x };
            wound(full_turn, 0.0)(DVec2::new(x, p.y))
        };
        assert!(!once(grid(1.0, 1.0, 60, 2), closed));
    }

    #[test]
    fn segments_touch_by_one_point_or_by_a_piece_of_a_line() {
        let [o, x, y] = [DVec2::ZERO, DVec2::X, DVec2::Y];
        assert!(segments_touch([o, x], [x * 0.5, y]));
        assert!(segments_touch([o, x], [x, y]));
        assert!(segments_touch([o, x], [x * 2.0, x * 0.5]));
        assert!(!segments_touch([o, x], [x * 2.0, x * 3.0]));
        assert!(!segments_touch([o, x], [y, x + y]));
        assert!(!segments_touch([o, x], [DVec2::new(0.5, 1e-300), y]));
        assert!(folds_back(o, x, x * 0.5) && !folds_back(o, x, x * 2.0));
    }
}
