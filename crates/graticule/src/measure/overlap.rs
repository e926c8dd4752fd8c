use std::ops::Range;

use glam::DVec2;
use rayon::prelude::*;

use super::MeasureError;
use super::islands::Islands;
use super::simple_border;
use super::uv_map::{UvMap, orientation};
use crate::geometry::{Bounds, BoxTree};
use crate::mesh::{FaceId, PerFace};
use crate::watch::{Stopped, Watch};

/// Leaves of the tree that one task searches.
const LEAVES_PER_TASK: usize = 16;
/// Most tasks between two looks at what was found so far.
const TASKS_PER_ROUND: usize = 64;

/// Crossings at which counting stops: a map with this many has no more to say.
pub(super) const CROSSING_LIMIT: u64 = 100_000;

/// Pairs of border edges that cross in the interior of both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Crossings {
    pub(super) count: u64,
    pub(super) complete: bool,
}

impl Crossings {
    pub(super) const NONE: Self = Self {
        count: 0,
        complete: true,
    };
}

/// Counts the pairs of border edges whose interiors meet in one point (exact).
///
/// Edges that touch, at their ends or along a line, do not cross. Near-linear in the number of
/// edges where few of their boxes overlap.
pub(super) fn count_crossings(map: &UvMap<'_>, watch: &Watch) -> Result<Crossings, MeasureError> {
    let _stage = watch.stage("boundary crossings");
    let (segments, copies) = distinct_segments(map);
    let boxes: Vec<_> = segments
        .iter()
        .map(|ends| Bounds::<2>::around(ends))
        .collect();
    let tree = BoxTree::new(&boxes);
    let mut count = 0;
    for round in rounds(tree.leaf_count()) {
        let counts = round.into_par_iter().map(|leaves| {
            let counts = leaves.map(|leaf| {
                watch.check()?;
                Ok(crossings_of_leaf(&tree, leaf, &segments, &copies))
            });
            counts.sum::<Result<u64, Stopped>>()
        });
        count += counts.sum::<Result<u64, Stopped>>()?;
        if count > CROSSING_LIMIT {
            return Ok(Crossings {
                count: CROSSING_LIMIT,
                complete: false,
            });
        }
    }
    let complete = true;
    Ok(Crossings { count, complete })
}

/// The segments along borders, and how many border edges lie on each.
///
/// Islands stacked exactly on each other would make a quadratic number of pairs that touch
/// everywhere and cross nowhere.
fn distinct_segments(map: &UvMap<'_>) -> (Vec<[DVec2; 2]>, Vec<u64>) {
    let is_before = |a: DVec2, b: DVec2| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).is_lt();
    let segments: Vec<_> = map
        .border()
        .map(|halfedge| map.image_of_side(halfedge).map(|p| p + DVec2::ZERO)) // -0 becomes 0
        .filter(|[a, b]| a != b)
        .map(|[a, b]| if is_before(a, b) { [a, b] } else { [b, a] })
        .collect();
    let mut order: Vec<(u64, u32)> = segments
        .par_iter()
        .enumerate()
        .map(|(index, segment)| (mixed_bits(segment), index as u32))
        .collect();
    order.par_sort_unstable();
    let segment = |entry: &(u64, u32)| segments[entry.1 as usize];
    let runs = order.chunk_by(|a, b| a.0 == b.0 && segment(a) == segment(b));
    runs.map(|run| (segment(&run[0]), run.len() as u64)).unzip()
}

/// A number that is the same for equal segments, and for others hardly ever. That two different
/// ones separate equal ones would cost time, nothing else.
fn mixed_bits([a, b]: &[DVec2; 2]) -> u64 {
    [a.x, a.y, b.x, b.y].iter().fold(0, |bits, coordinate| {
        let mixed = (bits ^ coordinate.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ (mixed >> 29)
    })
}

/// The leaves in runs for one task each, a round of tasks at a time; the first rounds are short,
/// so that a search which soon finds enough soon ends.
pub(super) fn rounds(leaf_count: usize) -> impl Iterator<Item = Vec<Range<usize>>> {
    let task_count = leaf_count.div_ceil(LEAVES_PER_TASK);
    let mut done = 0;
    std::iter::from_fn(move || {
        let tasks = done..(done + (done + 1).min(TASKS_PER_ROUND)).min(task_count);
        done = tasks.end;
        let leaves = |task: usize| {
            let first = LEAVES_PER_TASK * task;
            first..(first + LEAVES_PER_TASK).min(leaf_count)
        };
        (!tasks.is_empty()).then(|| tasks.map(leaves).collect())
    })
}

/// Crossings of segments in the leaf with each other and with those in later leaves; few more
/// than the limit are counted.
fn crossings_of_leaf(
    tree: &BoxTree<2>,
    leaf: usize,
    segments: &[[DVec2; 2]],
    copies: &[u64],
) -> u64 {
    let mut count = 0;
    let mut found = Vec::new();
    tree.overlapping_leaves(leaf, leaf, &mut found);
    for i in tree.leaf(leaf) {
        let first = tree.item(i);
        for j in tree.overlapping(i, &found).filter(|&j| i < j) {
            let second = tree.item(j);
            if cross(segments[first], segments[second]) {
                count += copies[first] * copies[second];
            }
            if count > CROSSING_LIMIT {
                return count;
            }
        }
    }
    count
}

/// Whether the interiors of two segments meet in exactly one point.
fn cross([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    orientation(a, b, c) * orientation(a, b, d) < 0
        && orientation(c, d, a) * orientation(c, d, b) < 0
}

/// Two triangles whose images share more than boundary points, if there are any (exact).
///
/// A border that encloses every point once answers for all triangles. Otherwise, where the map is
/// one to one around every inner point, only triangles on a border are compared
/// with all others. For there the number of triangles over a point changes only across borders;
/// a region covered twice ends somewhere along a border edge, and the triangle at that edge is one
/// of those that cover it.
pub(super) fn find_overlap(
    map: &UvMap<'_>,
    islands: &Islands,
    watch: &Watch,
) -> Result<Option<[FaceId; 2]>, MeasureError> {
    let _stage = watch.stage("overlapping triangles");
    if simple_border::encloses_once(map, islands, watch)? {
        return Ok(None);
    }
    let search = Search::new(map, is_locally_injective(map, islands)).for_one_of_each_pair();
    for round in rounds(search.tree.leaf_count()) {
        let found = round.into_par_iter().find_map_first(|mut leaves| {
            leaves.find_map(|leaf| match watch.check() {
                Ok(()) => search.overlap_in(leaf).map(Ok),
                Err(stopped) => Some(Err(stopped)),
            })
        });
        if let Some(found) = found {
            return Ok(Some(found?));
        }
    }
    Ok(None)
}

/// All triangles that share more than boundary points with another one (exact).
pub(super) fn overlapping(map: &UvMap<'_>, watch: &Watch) -> Result<PerFace<bool>, MeasureError> {
    let _stage = watch.stage("all overlapping triangles");
    let search = Search::new(map, false);
    let leaves = (0..search.tree.leaf_count()).into_par_iter();
    let found = leaves.map(|leaf| {
        watch.check()?;
        Ok(search.overlaps_in(leaf).collect::<Vec<_>>())
    });
    let found = found.collect::<Result<Vec<_>, Stopped>>()?;
    let mut overlapping = PerFace::filled(map.face_count(), false);
    for [face, _] in found.into_iter().flatten() {
        overlapping[face] = true;
    }
    Ok(overlapping)
}

/// Whether no inner point of an island is covered twice by the triangles around it.
pub(super) fn is_locally_injective(map: &UvMap<'_>, islands: &Islands) -> bool {
    islands.folded_vertices.is_empty()
        && islands.all.iter().all(|island| island.flipped == 0)
        && map.has_area_everywhere()
}

struct Search<'a> {
    map: &'a UvMap<'a>,
    tree: BoxTree<2>,
    faces: Vec<FaceId>,
    border_only: bool,
    /// Whether an overlap need be found from one of its two triangles only.
    once: bool,
}

impl<'a> Search<'a> {
    fn new(map: &'a UvMap<'a>, border_only: bool) -> Self {
        let faces = map.surface.mesh().faces();
        let faces: Vec<FaceId> = faces.filter(|&face| map.sign(face) != 0).collect();
        let boxes: Vec<_> = faces
            .par_iter()
            .map(|&face| Bounds::<2>::around(&map.images(face)))
            .collect();
        Self {
            map,
            tree: BoxTree::new(&boxes),
            faces,
            border_only,
            once: false,
        }
    }

    /// The same search, each pair looked at once where both its triangles are sought.
    fn for_one_of_each_pair(self) -> Self {
        let once = (0..self.faces.len()).all(|rank| self.is_sought(rank));
        Self { once, ..self }
    }

    /// The first overlap of a triangle in the leaf with any other.
    fn overlap_in(&self, leaf: usize) -> Option<[FaceId; 2]> {
        let [a, b] = self.overlaps_in(leaf).next()?;
        Some([a.min(b), a.max(b)])
    }

    /// Each triangle sought in the leaf that overlaps another one, with one such.
    fn overlaps_in(&self, leaf: usize) -> impl Iterator<Item = [FaceId; 2]> {
        let mut found = Vec::new();
        let sought: Vec<_> = self
            .tree
            .leaf(leaf)
            .filter(|&rank| self.is_sought(rank))
            .collect();
        if !sought.is_empty() {
            let first = if self.once { leaf } else { 0 };
            self.tree.overlapping_leaves(leaf, first, &mut found);
        }
        sought.into_iter().filter_map(move |i| {
            let triangle = self.image(i);
            let wanted = |&j: &usize| if self.once { i < j } else { i != j };
            let mut others = self.tree.overlapping(i, &found).filter(wanted);
            let meeting = others.find(|&j| interiors_meet(&triangle, &self.image(j)))?;
            Some([i, meeting].map(|rank| self.faces[self.tree.item(rank)]))
        })
    }

    fn is_sought(&self, rank: usize) -> bool {
        let face = self.faces[self.tree.item(rank)];
        !self.border_only
            || face
                .halfedges()
                .iter()
                .any(|&side| self.map.is_border(side))
    }

    /// The image of the triangle at a rank, turned counter-clockwise.
    fn image(&self, rank: usize) -> [DVec2; 3] {
        let face = self.faces[self.tree.item(rank)];
        let [a, b, c] = self.map.images(face);
        if self.map.sign(face) > 0 {
            [a, b, c]
        } else {
            [a, c, b]
        }
    }
}

/// Whether two counter-clockwise triangles share more than boundary points: no side of either has
/// the other triangle wholly to its right. Exact.
pub(super) fn interiors_meet(first: &[DVec2; 3], second: &[DVec2; 3]) -> bool {
    !is_separated(first, second) && !is_separated(second, first)
}

fn is_separated(triangle: &[DVec2; 3], other: &[DVec2; 3]) -> bool {
    (0..3).any(|side| {
        let (from, to) = (triangle[side], triangle[(side + 1) % 3]);
        other.iter().all(|&point| orientation(from, to, point) <= 0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: [DVec2; 3] = [DVec2::ZERO, DVec2::X, DVec2::Y];

    fn moved(triangle: [DVec2; 3], by: DVec2) -> [DVec2; 3] {
        triangle.map(|p| p + by)
    }

    #[test]
    fn triangles_that_share_an_edge_a_corner_or_a_piece_of_an_edge_do_not_meet() {
        assert!(!interiors_meet(&A, &[DVec2::X, DVec2::ONE, DVec2::Y]));
        assert!(!interiors_meet(&A, &moved(A, DVec2::X)));
        assert!(!interiors_meet(&A, &moved(A, DVec2::new(0.25, -1.0))));
        assert!(!interiors_meet(&A, &moved(A, DVec2::splat(3.0))));
    }

    #[test]
    fn triangles_meet_by_the_smallest_amount_that_can_be_written() {
        let touching = [DVec2::new(0.5, 0.5), DVec2::ONE, DVec2::new(0.0, 1.0)];
        assert!(!interiors_meet(&A, &touching));
        let inside = DVec2::new(0.5, 0.5_f64.next_down());
        assert!(interiors_meet(
            &A,
            &[inside, DVec2::ONE, DVec2::new(0.0, 1.0)]
        ));
        assert!(interiors_meet(&A, &A));
        assert!(interiors_meet(&A, &A.map(|p| DVec2::splat(0.1) + p * 0.1)));
    }

    #[test]
    fn only_a_crossing_in_the_interior_of_both_segments_counts() {
        let [o, x, y] = [DVec2::ZERO, DVec2::X, DVec2::Y];
        assert!(cross([o, DVec2::ONE], [x, y]));
        assert!(!cross([o, x], [x, y]));
        assert!(!cross([o, x * 2.0], [x, y]));
        assert!(!cross([o, x * 2.0], [x, x * 3.0]));
    }
}
