use std::ops::Range;

use glam::{DVec2, DVec3};

use super::Surface;

/// Marks a corner without a value in [`CornerAttribute::corner_values`].
pub const NO_VALUE: u32 = u32::MAX;

/// What a mesh file holds: positions, polygons that index them, and attributes; nothing checked.
///
/// Indices may be out of range, polygons may have fewer than three corners, positions may not be
/// finite. [`Defects`](super::Defects) names what is wrong and [`repair`](super::repair()) makes a
/// [`Surface`] of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonSoup {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Polygons, as indices into [`positions`](Self::positions).
    pub polygons: Polygons,
    /// Open polylines, as indices into [`positions`](Self::positions): feature lines or guides.
    pub polylines: Vec<Vec<u32>>,
    /// Texture coordinates, normals, colours, names.
    pub attributes: Attributes,
}

impl From<&Surface> for PolygonSoup {
    /// The triangles of a surface, numbered as they are, without attributes.
    fn from(surface: &Surface) -> Self {
        let mesh = surface.mesh();
        let mut polygons = Polygons::with_capacity(mesh.face_count(), mesh.halfedge_count());
        for face in mesh.faces() {
            polygons.push(&mesh.triangle(face).map(|vertex| vertex.0));
        }
        Self {
            positions: surface.positions().as_slice().to_vec(),
            polygons,
            ..Self::default()
        }
    }
}

impl PolygonSoup {
    /// Makes corner `first` of a polygon, counted from 0 within it, its first one, with what the
    /// corners hold; the polygon itself and its sense stay.
    ///
    /// # Panics
    /// If the polygon has no such corner.
    pub fn begin_polygon_at(&mut self, polygon: usize, first: usize) {
        let range = self.polygons.corner_range(polygon);
        self.polygons.corners[range.clone()].rotate_left(first);
        let sets = self.attributes.uv_sets.iter_mut();
        let normals = self.attributes.normals.iter_mut();
        let values = sets
            .map(|set| &mut set.corner_values)
            .chain(normals.map(|set| &mut set.corner_values));
        for corner_values in values {
            if let Some(own) = corner_values.get_mut(range.clone()) {
                own.rotate_left(first);
            }
        }
    }
}

/// Polygons in one array: polygon `p` owns the corners `starts[p]..starts[p + 1]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygons {
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl Default for Polygons {
    fn default() -> Self {
        Self {
            starts: vec![0],
            corners: Vec::new(),
        }
    }
}

impl Polygons {
    /// Room for `polygons` polygons with `corners` corners in all.
    #[must_use]
    pub fn with_capacity(polygons: usize, corners: usize) -> Self {
        let mut starts = Vec::with_capacity(polygons + 1);
        starts.push(0);
        Self {
            starts,
            corners: Vec::with_capacity(corners),
        }
    }

    /// The number of polygons.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether there is no polygon.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of corners of all polygons together.
    #[must_use]
    pub fn corner_count(&self) -> usize {
        self.corners.len()
    }

    /// Adds a polygon with these vertices.
    ///
    /// # Panics
    /// If there were 2^32 corners or more in all. Readers refuse such files before.
    pub fn push(&mut self, vertices: &[u32]) {
        self.corners.extend_from_slice(vertices);
        let end = u32::try_from(self.corners.len()).expect("fewer than 2^32 corners");
        self.starts.push(end);
    }

    /// The vertices of polygon `polygon`, in order.
    #[must_use]
    pub fn vertices(&self, polygon: usize) -> &[u32] {
        &self.corners[self.corner_range(polygon)]
    }

    /// The numbers of the corners of polygon `polygon` among the corners of all polygons.
    #[must_use]
    pub fn corner_range(&self, polygon: usize) -> Range<usize> {
        self.starts[polygon] as usize..self.starts[polygon + 1] as usize
    }

    /// The vertex of each corner of each polygon.
    #[must_use]
    pub fn corner_vertices(&self) -> &[u32] {
        &self.corners
    }

    /// The vertex of each corner of each polygon, to be renumbered.
    #[must_use]
    pub fn corner_vertices_mut(&mut self) -> &mut [u32] {
        &mut self.corners
    }

    /// The vertices of each polygon in turn.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.len()).map(|polygon| self.vertices(polygon))
    }
}

impl<'a> FromIterator<&'a [u32]> for Polygons {
    fn from_iter<I: IntoIterator<Item = &'a [u32]>>(polygons: I) -> Self {
        let mut result = Self::default();
        for vertices in polygons {
            result.push(vertices);
        }
        result
    }
}

/// What a file tells of its vertices, corners and polygons beside the shape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attributes {
    /// Texture coordinates, any number of sets; the first is the one that tools show.
    pub uv_sets: Vec<CornerAttribute<DVec2>>,
    /// Shading normals.
    pub normals: Option<CornerAttribute<DVec3>>,
    /// Red, green, blue, opacity of each vertex, in `0.0..=1.0`.
    pub vertex_colors: Option<Vec<[f32; 4]>>,
    /// Named objects (OBJ `o`, a node of a glTF scene).
    pub objects: Option<PolygonLabels>,
    /// Named groups (OBJ `g`).
    pub groups: Option<PolygonLabels>,
    /// Materials (OBJ `usemtl`, glTF materials).
    pub materials: Option<PolygonLabels>,
    /// Smoothing groups (OBJ `s`), by the word that the file uses.
    pub smoothing_groups: Option<PolygonLabels>,
    /// Material libraries that the file names (OBJ `mtllib`).
    pub material_libraries: Vec<String>,
}

/// Values shared between corners: one of [`values`](Self::values) for each corner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CornerAttribute<T> {
    /// Name of the set; empty where the format has none.
    pub name: String,
    /// The values.
    pub values: Vec<T>,
    /// For each corner of each polygon an index into [`values`](Self::values), or [`NO_VALUE`].
    pub corner_values: Vec<u32>,
}

impl<T: Copy> CornerAttribute<T> {
    /// The value at corner `corner`, if it has one.
    #[must_use]
    pub fn get(&self, corner: usize) -> Option<T> {
        let index = *self.corner_values.get(corner)?;
        self.values.get(index as usize).copied()
    }
}

/// A name for each polygon.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonLabels {
    /// The names, in the order of their first use.
    pub names: Vec<String>,
    /// For each polygon an index into [`names`](Self::names), or [`NO_VALUE`].
    pub polygon_names: Vec<u32>,
}

impl PolygonLabels {
    /// The name of polygon `polygon`, if it has one.
    #[must_use]
    pub fn get(&self, polygon: usize) -> Option<&str> {
        let index = *self.polygon_names.get(polygon)?;
        self.names.get(index as usize).map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_keep_their_vertices_and_corner_numbers() {
        let polygons: Polygons = [&[0, 1, 2][..], &[2, 1, 3, 4], &[5]].into_iter().collect();
        assert_eq!(polygons.len(), 3);
        assert_eq!(polygons.vertices(1), [2, 1, 3, 4]);
        assert_eq!(polygons.corner_range(2), 7..8);
        assert_eq!(polygons.corner_count(), 8);
    }

    #[test]
    fn a_polygon_begins_elsewhere_with_all_that_its_corners_hold() {
        let polygons: Polygons = [&[0, 1, 2][..], &[2, 1, 3, 4]].into_iter().collect();
        let mut soup = PolygonSoup {
            polygons,
            ..PolygonSoup::default()
        };
        let set = |corner_values: &[u32]| CornerAttribute {
            corner_values: corner_values.to_vec(),
            ..CornerAttribute::default()
        };
        soup.attributes.uv_sets = vec![set(&[0, 1, 2, 3, 4, 5, 6]), set(&[])];
        let normals = set(&[9, 9, 9, 5, 6, 7, 8]);
        soup.attributes.normals = Some(CornerAttribute {
            corner_values: normals.corner_values,
            ..CornerAttribute::default()
        });
        soup.begin_polygon_at(1, 3);
        assert_eq!(soup.polygons.vertices(0), [0, 1, 2]);
        assert_eq!(soup.polygons.vertices(1), [4, 2, 1, 3]);
        let uvs = &soup.attributes.uv_sets;
        assert_eq!(uvs[0].corner_values, [0, 1, 2, 6, 3, 4, 5]);
        assert!(uvs[1].corner_values.is_empty());
        let normals = soup.attributes.normals.unwrap();
        assert_eq!(normals.corner_values, [9, 9, 9, 8, 5, 6, 7]);
    }

    #[test]
    fn a_corner_without_value_has_none() {
        let uvs = CornerAttribute {
            name: String::new(),
            values: vec![DVec2::ZERO, DVec2::ONE],
            corner_values: vec![1, NO_VALUE, 0],
        };
        assert_eq!(uvs.get(0), Some(DVec2::ONE));
        assert_eq!(uvs.get(1), None);
    }
}
