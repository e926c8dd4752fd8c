use glam::DVec3;
use graticule::mesh::{CornerAttribute, PolygonSoup, triangulate_polygon};

/// Whether all numbers survive single precision unchanged.
pub(crate) fn fits_single(numbers: &[f64]) -> bool {
    numbers
        .iter()
        .all(|&number| f64::from(number as f32).to_bits() == number.to_bits())
}

/// One value for each vertex, if all corners of a vertex have the same; vertices without corners
/// get the default. `None` if corners differ or have no value.
pub(crate) fn per_vertex<T: Copy + Default + PartialEq>(
    set: &CornerAttribute<T>,
    soup: &PolygonSoup,
) -> Option<Vec<T>> {
    let mut values = vec![None; soup.positions.len()];
    for (corner, &vertex) in soup.polygons.corner_vertices().iter().enumerate() {
        let value = set.get(corner)?;
        if *values[vertex as usize].get_or_insert(value) != value {
            return None;
        }
    }
    Some(values.into_iter().map(Option::unwrap_or_default).collect())
}

/// Each polygon cut into triangles: the polygon and three corner numbers.
pub(crate) fn triangles(soup: &PolygonSoup) -> Vec<(u32, [u32; 3])> {
    let mut triangles = Vec::with_capacity(soup.polygons.len());
    let mut outline: Vec<DVec3> = Vec::new();
    for (polygon, vertices) in soup.polygons.iter().enumerate() {
        let first = soup.polygons.corner_range(polygon).start as u32;
        if vertices.len() == 3 {
            triangles.push((polygon as u32, [first, first + 1, first + 2]));
            continue;
        }
        outline.clear();
        outline.extend(
            vertices
                .iter()
                .map(|&vertex| soup.positions[vertex as usize]),
        );
        let parts = triangulate_polygon(&outline).into_iter();
        triangles.extend(parts.map(|part| (polygon as u32, part.map(|corner| first + corner))));
    }
    triangles
}

/// The corner positions of all triangles of all polygons.
pub(crate) fn facets(soup: &PolygonSoup) -> Vec<[DVec3; 3]> {
    let vertices = soup.polygons.corner_vertices();
    let position = |corner: u32| soup.positions[vertices[corner as usize] as usize];
    let triangles = triangles(soup).into_iter();
    triangles
        .map(|(_, corners)| corners.map(position))
        .collect()
}
