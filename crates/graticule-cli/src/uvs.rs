//! Texture coordinates between the file's corners and the surface's.

use glam::DVec2;
use graticule::mesh::{
    CornerAttribute, HalfedgeId, NO_VALUE, PerCorner, PerVertex, PolygonSoup, Repaired,
    TriangleMesh, VertexId, fan_apex,
};

/// The texture coordinates that a set of the file gives to the corners of the surface.
pub(crate) fn of_surface(
    repaired: &Repaired,
    set: &CornerAttribute<DVec2>,
) -> PerCorner<Option<DVec2>> {
    repaired
        .corner_sources
        .map(|&corner| set.get(corner as usize))
}

/// The mesh to write, with these coordinates as its first set; other sets stay.
///
/// That is the soup as read where its polygons still describe the surface, and the repaired one
/// otherwise: polygons that repair turned or dropped would contradict the map. `uv_of_vertex` says
/// which of the coordinates a vertex of the repaired surface has, or [`NO_VALUE`].
pub(crate) fn put_into(
    soup: PolygonSoup,
    repaired: &Repaired,
    uvs: &PerVertex<DVec2>,
    uv_of_vertex: impl Fn(VertexId) -> u32,
) -> PolygonSoup {
    let mesh = repaired.surface.mesh();
    let uv_of_corner = PerCorner::from_fn(mesh.halfedge_count(), |corner| {
        uv_of_vertex(mesh.origin(corner))
    });
    put_at_corners(soup, repaired, uvs.as_slice().to_vec(), &uv_of_corner)
}

/// The same where corners of one vertex may have different coordinates: `uv_of_corner` says which
/// of `uvs` each corner of the repaired surface has, or [`NO_VALUE`].
pub(crate) fn put_at_corners(
    soup: PolygonSoup,
    repaired: &Repaired,
    uvs: Vec<DVec2>,
    uv_of_corner: &PerCorner<u32>,
) -> PolygonSoup {
    let value = |corner: Option<HalfedgeId>| corner.map_or(NO_VALUE, |corner| uv_of_corner[corner]);
    if repaired.changes.keep_polygons() {
        let corners = repaired.mesh_corners(&soup).into_iter();
        let corners = corners.map(|corner| (corner != NO_VALUE).then_some(HalfedgeId(corner)));
        let corner_values = corners.map(value).collect();
        return with_first_set(soup, uvs, corner_values);
    }
    let soup = repaired.to_soup(&soup);
    let mesh = repaired.surface.mesh();
    let mut corner_values = Vec::with_capacity(soup.polygons.corner_count());
    for polygon in soup.polygons.iter() {
        for (index, &vertex) in polygon.iter().enumerate() {
            let next = polygon[(index + 1) % polygon.len()];
            let side = mesh.halfedge_between(VertexId(vertex), VertexId(next));
            corner_values.push(value(side));
        }
    }
    with_first_set(soup, uvs, corner_values)
}

/// Lets polygons begin at the corner from which a fan of triangles turns none over, as most readers
/// cut them into that from the first corner; how many had to be changed.
pub(crate) fn begin_polygons_for_fans(soup: &mut PolygonSoup) -> usize {
    let Some(set) = soup.attributes.uv_sets.first() else {
        return 0;
    };
    let apex = |polygon: usize| {
        let corners = soup.polygons.corner_range(polygon);
        let places: Option<Vec<DVec2>> = corners.map(|corner| set.get(corner)).collect();
        places.map_or(0, |places| fan_apex(&places))
    };
    let count = soup.polygons.len();
    let changed: Vec<_> = (0..count)
        .map(|polygon| (polygon, apex(polygon)))
        .filter(|&(_, apex)| apex != 0)
        .collect();
    for &(polygon, apex) in &changed {
        soup.begin_polygon_at(polygon, apex);
    }
    changed.len()
}

/// The different coordinates at the corners of each vertex, and which of them each corner has.
pub(crate) fn distinct_at_vertices(
    mesh: &TriangleMesh,
    uvs: &PerCorner<DVec2>,
) -> (Vec<DVec2>, PerCorner<u32>) {
    let mut values: Vec<DVec2> = Vec::new();
    let mut value_of_corner = PerCorner::filled(mesh.halfedge_count(), NO_VALUE);
    let mut sorted: Vec<(DVec2, usize, HalfedgeId)> = Vec::new();
    for vertex in mesh.vertices() {
        let corners = mesh.outgoing(vertex).enumerate();
        sorted.clear();
        // Adding 0 makes one of both zeros.
        sorted.extend(corners.map(|(turn, corner)| (uvs[corner] + DVec2::ZERO, turn, corner)));
        sorted.sort_unstable_by(|(a, turn, _), (b, other, _)| {
            a.x.total_cmp(&b.x)
                .then(a.y.total_cmp(&b.y))
                .then(turn.cmp(other))
        });
        let mut groups: Vec<_> = sorted.chunk_by(|(a, ..), (b, ..)| a == b).collect();
        groups.sort_unstable_by_key(|group| group[0].1);
        for group in groups {
            for &(_, _, corner) in group {
                value_of_corner[corner] = values.len() as u32;
            }
            values.push(uvs[group[0].2]);
        }
    }
    (values, value_of_corner)
}

fn with_first_set(
    mut soup: PolygonSoup,
    values: Vec<DVec2>,
    corner_values: Vec<u32>,
) -> PolygonSoup {
    let sets = &mut soup.attributes.uv_sets;
    let name = sets.first().map(|set| set.name.clone()).unwrap_or_default();
    let set = CornerAttribute {
        name,
        values,
        corner_values,
    };
    match sets.first_mut() {
        Some(first) => *first = set,
        None => sets.push(set),
    }
    soup
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule::mesh::Polygons;

    /// Soup with these polygons, one coordinate for each vertex.
    fn soup(polygons: &[&[u32]], places: &[[f64; 2]]) -> PolygonSoup {
        let polygons: Polygons = polygons.iter().copied().collect();
        let corner_values = polygons.corner_vertices().to_vec();
        let soup = PolygonSoup {
            polygons,
            ..PolygonSoup::default()
        };
        let values = places.iter().copied().map(DVec2::from).collect();
        with_first_set(soup, values, corner_values)
    }

    #[test]
    fn a_quad_bent_by_the_map_begins_at_its_dent_and_others_as_they_did() {
        let places = [
            [0.0, 0.0],
            [1.0, 0.2],
            [2.0, 0.0],
            [1.0, 2.0],
            [5.0, 0.0],
            [5.0, 3.0],
        ];
        let mut soup = soup(&[&[0, 1, 2, 3], &[2, 4, 5, 3], &[2, 1, 0]], &places);
        assert_eq!(begin_polygons_for_fans(&mut soup), 1);
        assert_eq!(soup.polygons.vertices(0), [1, 2, 3, 0]);
        assert_eq!(soup.polygons.vertices(1), [2, 4, 5, 3]);
        let values = &soup.attributes.uv_sets[0].corner_values;
        assert_eq!(values, soup.polygons.corner_vertices());
        assert_eq!(begin_polygons_for_fans(&mut soup), 0);
    }

    #[test]
    fn polygons_without_coordinates_stay() {
        let mut bare = soup(&[&[0, 1, 2, 3]], &[]);
        assert_eq!(begin_polygons_for_fans(&mut bare), 0);
        bare.attributes.uv_sets.clear();
        assert_eq!(begin_polygons_for_fans(&mut bare), 0);
    }

    #[test]
    fn corners_share_the_values_they_agree_on_in_the_order_they_come() {
        let fan = graticule_fixtures::icosphere(1);
        let mesh = TriangleMesh::new(fan.positions.len(), &fan.triangles).unwrap();
        let uvs = PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
            let zero = if corner.0.is_multiple_of(2) {
                0.0
            } else {
                -0.0
            };
            DVec2::new(f64::from(corner.0 % 3), zero)
        });
        let (values, value_of_corner) = distinct_at_vertices(&mesh, &uvs);
        for vertex in mesh.vertices() {
            let corners: Vec<_> = mesh.outgoing(vertex).collect();
            for &a in &corners {
                assert_eq!(values[value_of_corner[a] as usize], uvs[a]);
                for &b in &corners {
                    assert_eq!(value_of_corner[a] == value_of_corner[b], uvs[a] == uvs[b]);
                }
            }
        }
        let used = value_of_corner.iter().max().unwrap();
        assert_eq!(*used as usize + 1, values.len());
    }
}
