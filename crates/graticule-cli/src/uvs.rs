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

/// The soup as read, with these coordinates as its first set; other sets stay.
///
/// `uv_of_vertex` says which of the coordinates a vertex of the repaired surface has, or
/// [`NO_VALUE`]. Polygons that repair dropped without another in their place have none.
pub(crate) fn put_into(
    mut soup: PolygonSoup,
    repaired: &Repaired,
    uvs: &PerVertex<DVec2>,
    uv_of_vertex: impl Fn(VertexId) -> u32,
) -> PolygonSoup {
    let mesh = repaired.surface.mesh();
    let corners = repaired.mesh_corners(&soup).into_iter();
    let corner_values = corners.map(|corner| match corner {
        NO_VALUE => NO_VALUE,
        corner => uv_of_vertex(mesh.origin(HalfedgeId(corner))),
    });
    let corner_values = corner_values.collect();
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
