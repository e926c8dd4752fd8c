//! A chart cut from its centre to the middles of its sides.

use glam::DVec2;

use super::split_mesh::{ChartDisk, NONE, next, previous};
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
/// alone, whatever its shape. Where double precision leads one astray, all of them pass through the
/// middles of edges instead, along the fewest triangles that lead there. `None` for ends that are not
/// on the border of a disk, each once.
pub(super) fn cut_spokes(disk: &mut ChartDisk, uvs: &[DVec2], ends: &[u32]) -> Option<Spokes> {
    let mut uvs = uvs.to_vec();
    let arrivals = arrivals(disk, ends)?;
    let centre = insert_centre(disk, &mut uvs)?;
    let unsplit = disk.clone();
    if let Some(paths) = straight_paths(disk, &mut uvs, centre, ends)
        && meet_in_centre_alone(&paths, &unsplit)
        && let Some(sectors) = sectors(disk, &arrivals)
    {
        return Some(Spokes { paths, sectors });
    }
    *disk = unsplit;
    let paths = paths_along_strips(disk, centre, ends)?;
    let sectors = sectors(disk, &arrivals)?;
    Some(Spokes { paths, sectors })
}

/// Cuts along straight lines of a map.
fn straight_paths(
    disk: &mut ChartDisk,
    uvs: &mut Vec<DVec2>,
    centre: u32,
    ends: &[u32],
) -> Option<Vec<Vec<u32>>> {
    let paths = ends.iter().map(|&end| walk(disk, uvs, centre, end));
    let paths: Vec<Vec<u32>> = paths.collect::<Option<_>>()?;
    for path in &paths {
        separate(disk, path);
    }
    Some(paths)
}

/// Whether paths share nothing but where they begin, and have nothing but their ends on the border.
fn meet_in_centre_alone(paths: &[Vec<u32>], disk: &ChartDisk) -> bool {
    let inner = paths.iter().flat_map(|path| &path[1..path.len() - 1]);
    let mut inner: Vec<u32> = inner.copied().collect();
    inner.sort_unstable();
    let has_twice = inner.windows(2).any(|pair| pair[0] == pair[1]);
    // Later vertices were made inside.
    let of_disk = inner
        .iter()
        .take_while(|&&vertex| (vertex as usize) < disk.positions.len());
    !has_twice
        && of_disk
            .copied()
            .all(|vertex| disk.border_halfedge(vertex).is_none())
}

/// Cuts along paths found by which triangles share edges alone: what lies between those cut before is
/// a disk that has the centre and the next end on its border, and so there is a strip between these.
fn paths_along_strips(disk: &mut ChartDisk, centre: u32, ends: &[u32]) -> Option<Vec<Vec<u32>>> {
    let path = |&end: &u32| {
        let path = cut_strip(disk, centre, end)?;
        separate(disk, &path);
        Some(path)
    };
    ends.iter().map(path).collect()
}

/// Halves the shortest strip of triangles between two vertices; returns the path along its middle.
fn cut_strip(disk: &mut ChartDisk, centre: u32, end: u32) -> Option<Vec<u32>> {
    let has = |disk: &ChartDisk, triangle: u32, vertex: u32| {
        disk.triangles[triangle as usize].contains(&vertex)
    };
    let triangles = 0..disk.triangles.len() as u32;
    let mut queue: Vec<u32> = triangles.filter(|&t| has(disk, t, end)).collect();
    // The side by which each triangle leads on towards the end.
    let mut onward: Vec<Option<u32>> = vec![None; disk.triangles.len()];
    let mut is_found = vec![false; disk.triangles.len()];
    for &triangle in &queue {
        is_found[triangle as usize] = true;
    }
    let mut next = 0;
    let first = loop {
        let &triangle = queue.get(next)?;
        next += 1;
        if has(disk, triangle, centre) {
            break triangle;
        }
        for twin in (3 * triangle..3 * triangle + 3).filter_map(|side| disk.twin(side)) {
            let beyond = twin / 3;
            if !std::mem::replace(&mut is_found[beyond as usize], true) {
                onward[beyond as usize] = Some(twin);
                queue.push(beyond);
            }
        }
    };
    let crossed = std::iter::successors(onward[first as usize], |&side| {
        onward[disk.twin(side)? as usize / 3]
    });
    let crossed: Vec<[u32; 2]> = crossed
        .map(|side| [disk.origin(side), disk.destination(side)])
        .collect();
    let mut path = vec![centre];
    for ends in crossed {
        let leaving = disk.split_inner_edge(disk.halfedge_between(ends)?, 0.5);
        path.push(disk.origin(leaving));
    }
    path.push(end);
    Some(path)
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

/// Cuts along a path.
fn separate(disk: &mut ChartDisk, path: &[u32]) {
    let mut edges: Vec<[u32; 2]> = path.windows(2).map(|e| [e[0], e[1]]).collect();
    edges.sort_unstable();
    for halfedge in 0..3 * disk.triangles.len() as u32 {
        let ends = [disk.origin(halfedge), disk.destination(halfedge)];
        if edges.binary_search(&ends).is_ok() {
            disk.separate(halfedge);
        }
    }
}

/// The triangles of each sector between paths that were cut along, ascending, given the border's edge
/// that arrives at the end of each: it lies in the sector before.
fn sectors(disk: &ChartDisk, arrivals: &[[u32; 2]]) -> Option<Vec<Vec<u32>>> {
    let mut sets = DisjointSets::new(disk.triangles.len());
    for halfedge in 0..3 * disk.triangles.len() as u32 {
        if let Some(twin) = disk.twin(halfedge) {
            sets.join(halfedge / 3, twin / 3);
        }
    }
    let names = sets.into_names();
    let sectors = arrivals.iter().map(|&arrival| {
        let name = names[disk.halfedge_between(arrival)? as usize / 3];
        let all = (0_u32..).zip(&names);
        let sector = all.filter(|&(_, other)| *other == name);
        Some(sector.map(|(triangle, _)| triangle).collect())
    });
    let sectors: Vec<Vec<u32>> = sectors.collect::<Option<_>>()?;
    let covered: usize = sectors.iter().map(Vec::len).sum();
    (covered == names.len()).then_some(sectors)
}

/// The border's edges that arrive at each of these vertices of it.
fn arrivals(disk: &ChartDisk, ends: &[u32]) -> Option<Vec<[u32; 2]>> {
    let mut origins = vec![NONE; disk.positions.len()];
    for vertex in 0..disk.positions.len() as u32 {
        if let Some(halfedge) = disk.border_halfedge(vertex) {
            origins[disk.destination(halfedge) as usize] = vertex;
        }
    }
    let arrival = |&end: &u32| {
        let origin = origins[end as usize];
        (origin != NONE).then_some([origin, end])
    };
    ends.iter().map(arrival).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::split_mesh::{TriangleOrigin, VertexName};
    use super::*;
    use crate::mesh::{Element, FaceId, TriangleMesh};

    /// A grid of unit squares round the origin, and its places.
    fn grid_disk(cells: u32) -> (ChartDisk, Vec<DVec2>) {
        let fixture = graticule_fixtures::grid(2.0, 2.0, cells, cells);
        let mesh = TriangleMesh::new(fixture.positions.len(), &fixture.triangles).unwrap();
        let place =
            |corner| fixture.positions[mesh.origin(corner).index()] - DVec3::new(1.0, 1.0, 0.0);
        let corners: Vec<_> = (mesh.halfedges())
            .map(|corner| (VertexName::Shared(mesh.origin(corner).0), place(corner)))
            .collect();
        let twins = mesh
            .halfedges()
            .map(|h| mesh.twin(h).map_or(NONE, |twin| twin.0));
        let origin = |face: FaceId| TriangleOrigin {
            face,
            corners: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        };
        let origins = mesh.faces().map(origin).collect();
        let disk = ChartDisk::new(&corners, twins.collect(), origins, 0);
        let places = disk.positions.iter().map(|position| position.truncate());
        let places = places.collect();
        (disk, places)
    }

    /// Vertices of the border at which the square's outline has these places.
    fn border(disk: &ChartDisk, places: &[DVec2]) -> Vec<u32> {
        let at = |place: &DVec2| {
            let near = |position: &DVec3| position.truncate().distance(*place) < 1e-9;
            disk.positions.iter().position(near).unwrap() as u32
        };
        places.iter().map(at).collect()
    }

    const MIDDLES: [DVec2; 4] = [DVec2::NEG_Y, DVec2::X, DVec2::Y, DVec2::NEG_X];

    fn check(disk: &ChartDisk, spokes: &Spokes, ends: &[u32]) {
        for (path, end) in spokes.paths.iter().zip(ends) {
            assert_eq!((path[0], path.last()), (spokes.paths[0][0], Some(end)));
        }
        let mut inner: Vec<u32> = spokes
            .paths
            .iter()
            .flat_map(|path| &path[1..])
            .copied()
            .collect();
        let count = inner.len();
        inner.sort_unstable();
        inner.dedup();
        assert_eq!(inner.len(), count, "paths meet");
        let area = |&triangle: &u32| {
            let [a, b, c] = disk.triangles[triangle as usize].map(|v| disk.positions[v as usize]);
            (b - a).cross(c - a).z / 2.0
        };
        for sector in &spokes.sectors {
            assert!(sector.iter().all(|triangle| area(triangle) > 0.0));
            assert!(sector.iter().map(area).sum::<f64>() > 0.05);
        }
        let whole: f64 = spokes.sectors.iter().flatten().map(area).sum();
        assert!((whole - 4.0).abs() < 1e-12);
    }

    #[test]
    fn straight_spokes_quarter_a_square() {
        let (mut disk, places) = grid_disk(6);
        let ends = border(&disk, &MIDDLES);
        let spokes = cut_spokes(&mut disk, &places, &ends).unwrap();
        check(&disk, &spokes, &ends);
    }

    #[test]
    fn where_places_lead_astray_strips_of_triangles_part_the_chart() {
        let (mut disk, mut places) = grid_disk(6);
        let ends = border(&disk, &MIDDLES);
        // A fold: the line to the right never arrives.
        let folded = border(&disk, &[DVec2::new(2.0 / 3.0, 0.0)])[0] as usize;
        places[folded] = DVec2::new(-0.5, 0.1);
        let spokes = cut_spokes(&mut disk, &places, &ends).unwrap();
        check(&disk, &spokes, &ends);
    }

    #[test]
    fn spokes_to_neighbours_on_the_border_share_nothing_but_the_centre() {
        let (mut disk, _) = grid_disk(4);
        let step = 0.5;
        let places = [-0.5, 0.0, 0.5].map(|x| DVec2::new(x, -1.0));
        let ends = border(
            &disk,
            &[places[0], places[1], places[2], DVec2::new(1.0, -step)],
        );
        let centre = border(&disk, &[DVec2::ZERO])[0];
        let arrivals = arrivals(&disk, &ends).unwrap();
        let paths = paths_along_strips(&mut disk, centre, &ends).unwrap();
        let sectors = sectors(&disk, &arrivals).unwrap();
        check(&disk, &Spokes { paths, sectors }, &ends);
    }
}
