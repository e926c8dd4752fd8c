use super::overlay::NONE;
use super::polygon_mesh::PolygonMesh;
use super::sides::Sides;
use crate::mesh::Polygons;

/// Joins the two quads at vertices inside the surface that have no other polygon: along two sides in
/// a row they can only have a straight or a folded corner. Vertices of features are kept. Returns
/// how many vertices went.
pub(super) fn remove_doublets(mesh: &mut PolygonMesh) -> usize {
    let before = mesh.positions.len();
    loop {
        let fixed = vertices_on_lines(&mesh.polygons, &mesh.feature_edges, mesh.positions.len());
        let (joined, polygons) = join_once(&mesh.polygons, &fixed);
        if joined == 0 {
            break;
        }
        mesh.polygons = polygons;
    }
    drop_unused(mesh);
    before - mesh.positions.len()
}

/// Which of `count` vertices are on the boundary of the polygons or on features.
pub(super) fn vertices_on_lines(
    polygons: &Polygons,
    feature_edges: &[[u32; 2]],
    count: usize,
) -> Vec<bool> {
    let mut fixed = vec![false; count];
    for &vertex in feature_edges.as_flattened() {
        fixed[vertex as usize] = true;
    }
    let sides = Sides::of(polygons);
    for polygon in 0..polygons.len() {
        let vertices = polygons.vertices(polygon);
        for (index, side) in polygons.corner_range(polygon).enumerate() {
            if sides.is_border(side as u32) {
                fixed[vertices[index] as usize] = true;
                fixed[vertices[(index + 1) % vertices.len()] as usize] = true;
            }
        }
    }
    fixed
}

fn join_once(old: &Polygons, fixed: &[bool]) -> (usize, Polygons) {
    let mut around = vec![([NONE; 2], 0_u32); fixed.len()];
    for polygon in 0..old.len() {
        for &vertex in old.vertices(polygon) {
            let (polygons, count) = &mut around[vertex as usize];
            if let Some(place) = polygons.get_mut(*count as usize) {
                *place = polygon as u32;
            }
            *count += 1;
        }
    }
    let mut replaced: Vec<Option<Vec<u32>>> = vec![None; old.len()];
    let mut joined = 0;
    for (vertex, &(polygons, count)) in around.iter().enumerate() {
        let [one, other] = polygons.map(|polygon| polygon as usize);
        if count != 2 || fixed[vertex] || replaced[one].is_some() || replaced[other].is_some() {
            continue;
        }
        let from_vertex = |polygon: usize| {
            let mut corners = old.vertices(polygon).to_vec();
            let place = corners.iter().position(|&v| v as usize == vertex);
            corners.rotate_left(place.unwrap_or_default());
            corners
        };
        let (one_way, other_way) = (from_vertex(one), from_vertex(other));
        if let (&[_, b, c, a], &[_, _, d, _]) = (&one_way[..], &other_way[..])
            && c != d
        {
            replaced[one] = Some(vec![b, c, a, d]);
            replaced[other] = Some(Vec::new());
            joined += 1;
        }
    }
    let mut polygons = Polygons::with_capacity(old.len(), old.corner_count());
    for (polygon, new) in replaced.iter().enumerate() {
        match new {
            Some(corners) if corners.is_empty() => {}
            Some(corners) => polygons.push(corners),
            None => polygons.push(old.vertices(polygon)),
        }
    }
    (joined, polygons)
}

/// Drops vertices that no polygon has, and numbers the others anew in their order.
pub(super) fn drop_unused(mesh: &mut PolygonMesh) {
    let mut numbers = vec![NONE; mesh.positions.len()];
    for &vertex in mesh.polygons.corner_vertices() {
        numbers[vertex as usize] = 0;
    }
    let kept = |numbers: &[u32]| -> Vec<usize> {
        (0..numbers.len()).filter(|&v| numbers[v] != NONE).collect()
    };
    let kept = kept(&numbers);
    for (new, &old) in kept.iter().enumerate() {
        numbers[old] = new as u32;
    }
    mesh.positions = kept.iter().map(|&old| mesh.positions[old]).collect();
    mesh.origins = kept.iter().map(|&old| mesh.origins[old]).collect();
    for vertex in mesh.polygons.corner_vertices_mut() {
        *vertex = numbers[*vertex as usize];
    }
    for vertex in mesh.feature_edges.as_flattened_mut() {
        *vertex = numbers[*vertex as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{FaceId, SurfacePoint};
    use glam::DVec3;

    #[test]
    fn two_quads_that_share_two_sides_become_one() {
        // A square with a vertex in its middle that two corners lead to, in a ring of quads.
        let square = [
            [0, 0],
            [3, 0],
            [3, 3],
            [0, 3],
            [1, 1],
            [2, 1],
            [2, 2],
            [1, 2],
        ];
        let mut mesh = PolygonMesh::default();
        for [x, y] in square.into_iter().chain([[1, 1]]) {
            mesh.positions
                .push(DVec3::new(f64::from(x), f64::from(y), 0.0));
            mesh.origins.push(SurfacePoint {
                face: FaceId(0),
                barycentric: [1.0, 0.0, 0.0],
            });
        }
        for ring in [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]] {
            mesh.polygons.push(&ring);
        }
        mesh.polygons.push(&[4, 5, 6, 8]);
        mesh.polygons.push(&[4, 8, 6, 7]);
        let topology = mesh.topology().unwrap().total;
        assert_eq!(remove_doublets(&mut mesh), 1);
        assert_eq!((mesh.polygons.len(), mesh.positions.len()), (5, 8));
        assert_eq!(
            mesh.topology().unwrap().total.euler_characteristic,
            topology.euler_characteristic
        );
        assert_eq!(remove_doublets(&mut mesh), 0);
    }
}
