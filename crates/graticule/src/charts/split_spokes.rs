//! A chart cut from its centre to the middles of its sides.

use glam::DVec2;

use super::split_mesh::{ChartDisk, next, previous};
use crate::measure::orientation;
use crate::mesh::DisjointSets;

/// Lines from the centre of a polygon to vertices of its border, along edges of the triangles.
pub(super) struct Spokes {
    /// For each spoke the vertices from the centre to the border.
    pub(super) paths: Vec<Vec<u32>>,
    /// The triangles between the spokes: entry `k` ends before spoke `k` and begins at the one before.
    pub(super) sectors: Vec<Vec<u32>>,
}

/// Cuts a disk along the lines from the centre of a regular polygon to vertices of its border, given
/// its map onto the polygon round the origin. The triangles that the lines cross are split.
///
/// The lines are straight on the polygon, so that they stay inside the chart and meet in the centre
/// alone, whatever its shape. `None` if double precision leads a line astray.
pub(super) fn cut_spokes(
    disk: &mut ChartDisk,
    uvs: &mut Vec<DVec2>,
    ends: &[u32],
) -> Option<Spokes> {
    let centre = insert_centre(disk, uvs)?;
    let paths = ends.iter().map(|&end| walk(disk, uvs, centre, end));
    let paths: Vec<Vec<u32>> = paths.collect::<Option<_>>()?;
    let sectors = separate(disk, &paths)?;
    Some(Spokes { paths, sectors })
}

/// Makes the origin a vertex; returns it.
fn insert_centre(disk: &mut ChartDisk, uvs: &mut Vec<DVec2>) -> Option<u32> {
    let (triangle, signs) = disk.locate(uvs, DVec2::ZERO)?;
    let corners = disk.triangles[triangle as usize].map(|vertex| uvs[vertex as usize]);
    let on_line = |k: usize| signs[k] == 0;
    let leaving = match (0..3).filter(|&k| on_line(k)).collect::<Vec<_>>()[..] {
        [] => {
            let areas = [0, 1, 2].map(|k| corners[(k + 1) % 3].perp_dot(corners[(k + 2) % 3]));
            let sum: f64 = areas.iter().sum();
            disk.split_inside(triangle, areas.map(|area| area / sum))
        }
        [side] => {
            let [from, to] = [side, (side + 1) % 3].map(|k| corners[k].length());
            disk.split_inner_edge(3 * triangle + side as u32, from / (from + to))
        }
        // The sides that meet in the corner that it is.
        [first, second, ..] => {
            let corner = if second == first + 1 { second } else { first };
            return Some(disk.triangles[triangle as usize][corner]);
        }
    };
    uvs.push(DVec2::ZERO);
    Some(disk.origin(leaving))
}

/// Goes straight from the centre to a vertex of the border; returns the vertices passed.
fn walk(disk: &mut ChartDisk, uvs: &mut Vec<DVec2>, centre: u32, end: u32) -> Option<Vec<u32>> {
    let target = uvs[end as usize];
    let mut path = vec![centre];
    let mut leaving = leaving_halfedge(disk, centre)?;
    // Each step passes a triangle, of which a step makes two more at most.
    let most_steps = 4 * disk.triangles.len();
    while path.len() < most_steps {
        match step(disk, uvs, leaving, &path, end)? {
            Step::To(halfedge) => {
                path.push(disk.destination(halfedge));
                if disk.destination(halfedge) == end {
                    return Some(path);
                }
                leaving = next(halfedge);
            }
            Step::Across(side) => {
                let twin = disk.twin(side)?;
                let ends = [side, twin].map(|h| uvs[disk.origin(h) as usize]);
                let distances = ends.map(|place| target.perp_dot(place).abs());
                let share = distances[0] / (distances[0] + distances[1]);
                leaving = disk.split_inner_edge(side, share);
                uvs.push(ends[0].lerp(ends[1], share));
                path.push(disk.origin(leaving));
            }
        }
    }
    None
}

/// How a straight line goes on.
enum Step {
    /// Along a halfedge.
    To(u32),
    /// Over the side of a triangle.
    Across(u32),
}

fn step(disk: &ChartDisk, uvs: &[DVec2], leaving: u32, path: &[u32], end: u32) -> Option<Step> {
    if let Some(last) = disk.turn(leaving).find(|&h| disk.destination(h) == end) {
        return Some(Step::To(last));
    }
    // What the line has passed lies on it, whatever rounding makes of that.
    let side = |vertex: u32| {
        let is_passed = path.contains(&vertex);
        let sign = || orientation(DVec2::ZERO, uvs[end as usize], uvs[vertex as usize]);
        (if is_passed { 0 } else { sign() }, is_passed)
    };
    disk.turn(leaving).find_map(|halfedge| {
        let (right, is_passed) = side(disk.destination(halfedge));
        let (left, _) = side(disk.origin(previous(halfedge)));
        match (right, left) {
            (0, 1) if !is_passed => Some(Step::To(halfedge)),
            (-1, 1) => Some(Step::Across(next(halfedge))),
            _ => None,
        }
    })
}

/// A halfedge that leaves an inner vertex.
fn leaving_halfedge(disk: &ChartDisk, vertex: u32) -> Option<u32> {
    let halfedges = 0..3 * disk.triangles.len() as u32;
    halfedges
        .into_iter()
        .find(|&halfedge| disk.origin(halfedge) == vertex)
}

/// Cuts along the paths; returns the triangles of each sector, ascending.
fn separate(disk: &mut ChartDisk, paths: &[Vec<u32>]) -> Option<Vec<Vec<u32>>> {
    let mut edges: Vec<[u32; 2]> = paths
        .iter()
        .flat_map(|p| p.windows(2))
        .map(|e| [e[0], e[1]])
        .collect();
    edges.sort_unstable();
    for halfedge in 0..3 * disk.triangles.len() as u32 {
        let ends = [disk.origin(halfedge), disk.destination(halfedge)];
        if edges.binary_search(&ends).is_ok() {
            disk.separate(halfedge);
        }
    }
    let mut sets = DisjointSets::new(disk.triangles.len());
    for halfedge in 0..3 * disk.triangles.len() as u32 {
        if let Some(twin) = disk.twin(halfedge) {
            sets.join(halfedge / 3, twin / 3);
        }
    }
    let names = sets.into_names();
    // The border halfedge that arrives at the end of spoke `k` lies in sector `k`.
    let mut firsts = vec![None; paths.len()];
    let ends: Vec<u32> = paths
        .iter()
        .filter_map(|path| path.last().copied())
        .collect();
    for vertex in 0..disk.positions.len() as u32 {
        let Some(halfedge) = disk.border_halfedge(vertex) else {
            continue;
        };
        if let Some(spoke) = ends
            .iter()
            .position(|&end| end == disk.destination(halfedge))
        {
            firsts[spoke] = Some(names[halfedge as usize / 3]);
        }
    }
    let sectors = firsts.into_iter().map(|name| {
        let name = name?;
        let all = (0_u32..).zip(&names);
        Some(
            all.filter(|&(_, other)| *other == name)
                .map(|(triangle, _)| triangle)
                .collect(),
        )
    });
    let sectors: Vec<Vec<u32>> = sectors.collect::<Option<_>>()?;
    let covered: usize = sectors.iter().map(Vec::len).sum();
    (covered == names.len()).then_some(sectors)
}
