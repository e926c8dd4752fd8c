use super::*;

/// A tetrahedron whose first edge is an edge of one triangle, and of several on the other side.
fn cracked(between: &[f64], off: f64) -> PolygonSoup {
    let mut positions = vec![[0., 0., 0.], [2., 0., 0.], [1., 2., 0.], [1., 1., 2.]];
    positions.extend(between.iter().map(|&x| [x, off, 0.0]));
    let mut polygons: Vec<Vec<u32>> = vec![vec![0, 2, 1], vec![0, 3, 2], vec![2, 3, 1]];
    let mut chain = vec![0];
    chain.extend(4..4 + between.len() as u32);
    chain.push(1);
    polygons.extend(chain.windows(2).map(|pair| vec![pair[0], pair[1], 3]));
    let polygons: Vec<&[u32]> = polygons.iter().map(Vec::as_slice).collect();
    soup(&positions, &polygons)
}

#[test]
fn a_triangle_is_cut_at_vertices_along_its_side() {
    for between in [&[0.7][..], &[0.3, 0.9, 1.9]] {
        let soup = cracked(between, 0.0);
        let repaired = repaired(&soup);
        let total = total(&repaired);
        assert_eq!((total.boundary_loops, total.euler_characteristic), (0, 2));
        assert_eq!(total.faces, 4 + 2 * between.len());
        assert_eq!(repaired.changes.cracks_closed.all(), [[0, 1]]);
        let of_first = repaired
            .face_polygons
            .iter()
            .filter(|&&polygon| polygon == 0);
        assert_eq!(of_first.count(), 1 + between.len());
        assert!(repaired.face_polygons.as_slice().is_sorted());
    }
}

#[test]
fn a_hole_with_a_width_stays_open() {
    let repaired = repaired(&cracked(&[0.7], 1e-3));
    assert_eq!(total(&repaired).boundary_loops, 1);
    assert!(repaired.changes.cracks_closed.is_empty());
}

#[test]
fn a_crack_stays_where_an_edge_would_be_made_twice() {
    // A pocket: the apex on the other side is the same.
    let pocket = soup(
        &[[0., 0., 0.], [2., 0., 0.], [1., 2., 0.], [1., 0., 0.]],
        &[&[1, 0, 2], &[0, 3, 2], &[3, 1, 2]],
    );
    let repaired = repaired(&pocket);
    assert_eq!(total(&repaired).boundary_loops, 1);
    assert!(repaired.changes.cracks_closed.is_empty());
}

#[test]
fn a_sliver_alone_is_none() {
    let sliver = soup(
        &[[0., 0., 0.], [1., 0., 0.], [0.5, 1e-8, 0.]],
        &[&[0, 1, 2]],
    );
    let repaired = repaired(&sliver);
    assert_eq!(total(&repaired).faces, 1);
    assert!(repaired.changes.is_empty());
}
