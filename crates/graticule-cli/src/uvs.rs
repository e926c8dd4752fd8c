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
        return with_first_set(soup, uvs, corner_values);
    }
    let mesh = repaired.surface.mesh();
    put_corners_into(soup, repaired, uvs, |corner| {
        uv_of_vertex(mesh.origin(corner))
    })
}

/// The same for a mesh whose polygons repair keeps, and coordinates told for each corner of the
/// repaired surface.
pub(crate) fn put_corners_into(
    soup: PolygonSoup,
    repaired: &Repaired,
    uvs: &PerVertex<DVec2>,
    uv_of_corner: impl Fn(HalfedgeId) -> u32,
) -> PolygonSoup {
    let corners = repaired.mesh_corners(&soup).into_iter();
    let corner_values = corners.map(|corner| match corner {
        NO_VALUE => NO_VALUE,
        corner => uv_of_corner(HalfedgeId(corner)),
    });
    let corner_values = corner_values.collect();
    with_first_set(soup, uvs, corner_values)
}

/// As [`put_into`], where corners of one vertex may have different coordinates: `uv_of_corner`
/// says which of `uvs` each corner of the repaired surface has, or [`NO_VALUE`].
pub(crate) fn put_at_corners(
    soup: PolygonSoup,
    repaired: &Repaired,
    uvs: Vec<DVec2>,
    uv_of_corner: &PerCorner<u32>,
) -> PolygonSoup {
    let value = |corner: Option<HalfedgeId>| corner.map_or(NO_VALUE, |corner| uv_of_corner[corner]);
    let uvs = PerVertex::new(uvs);
    if repaired.changes.keep_polygons() {
        let corners = repaired.mesh_corners(&soup).into_iter();
        let corners = corners.map(|corner| (corner != NO_VALUE).then_some(HalfedgeId(corner)));
        let corner_values = corners.map(value).collect();
        return with_first_set(soup, &uvs, corner_values);
    }
    let soup = repaired.to_soup(&soup);
    let mesh = repaired.surface.mesh();
    let mut corner_values = Vec::with_capacity(soup.polygons.corner_count());
    for polygon in soup.polygons.iter() {
        for (index, &vertex) in polygon.iter().enumerate() {
            let next = VertexId(polygon[(index + 1) % polygon.len()]);
            let mut sides = mesh.outgoing(VertexId(vertex));
            corner_values.push(value(sides.find(|&side| mesh.destination(side) == next)));
        }
    }
    with_first_set(soup, &uvs, corner_values)
}

fn with_first_set(
    mut soup: PolygonSoup,
    uvs: &PerVertex<DVec2>,
    corner_values: Vec<u32>,
) -> PolygonSoup {
    let sets = &mut soup.attributes.uv_sets;
    let name = sets.first().map(|set| set.name.clone()).unwrap_or_default();
    let set = CornerAttribute {
        name,
        values: uvs.as_slice().to_vec(),
        corner_values,
    };
    match sets.first_mut() {
        Some(first) => *first = set,
        None => sets.push(set),
    }
    soup
}
