//! Texture coordinates between the file's corners and the surface's.

use glam::DVec2;
use graticule::mesh::{
    CornerAttribute, HalfedgeId, NO_VALUE, PerCorner, PerVertex, PolygonSoup, Repaired, VertexId,
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
    if !repaired.changes.keep_polygons() {
        // Its vertices are those of the surface.
        let soup = repaired.to_soup(&soup);
        let vertices = soup.polygons.corner_vertices().iter();
        let corner_values = vertices
            .map(|&vertex| uv_of_vertex(VertexId(vertex)))
            .collect();
        return with_first_set(soup, uvs.as_slice().to_vec(), corner_values);
    }
    let mesh = repaired.surface.mesh();
    let corners = repaired.mesh_corners(&soup).into_iter();
    let corner_values = corners.map(|corner| match corner {
        NO_VALUE => NO_VALUE,
        corner => uv_of_vertex(mesh.origin(HalfedgeId(corner))),
    });
    let corner_values = corner_values.collect();
    with_first_set(soup, uvs.as_slice().to_vec(), corner_values)
}

/// The mesh to write, with coordinates for each corner of the surface; equal ones at a vertex are
/// written once.
///
/// That is the soup as read where its polygons still describe the surface, else the triangles of the
/// surface, without other attributes.
pub(crate) fn put_corners_into(
    soup: PolygonSoup,
    repaired: &Repaired,
    uvs: &PerCorner<DVec2>,
) -> PolygonSoup {
    let mesh = repaired.surface.mesh();
    let mut values: Vec<DVec2> = Vec::new();
    let mut value_of_corner = PerCorner::filled(mesh.halfedge_count(), NO_VALUE);
    for vertex in mesh.vertices() {
        let first = values.len();
        for corner in mesh.outgoing(vertex) {
            let known = values[first..]
                .iter()
                .position(|value| *value == uvs[corner]);
            value_of_corner[corner] = (first + known.unwrap_or(values.len() - first)) as u32;
            if known.is_none() {
                values.push(uvs[corner]);
            }
        }
    }
    if !repaired.changes.keep_polygons() {
        let mut soup = PolygonSoup {
            positions: repaired.surface.positions().as_slice().to_vec(),
            ..PolygonSoup::default()
        };
        for face in mesh.faces() {
            soup.polygons
                .push(&mesh.triangle(face).map(|vertex| vertex.0));
        }
        return with_first_set(soup, values, value_of_corner.into_vec());
    }
    let corners = repaired.mesh_corners(&soup).into_iter();
    let corner_values = corners.map(|corner| match corner {
        NO_VALUE => NO_VALUE,
        corner => value_of_corner[HalfedgeId(corner)],
    });
    let corner_values = corner_values.collect();
    with_first_set(soup, values, corner_values)
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
