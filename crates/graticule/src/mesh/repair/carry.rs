//! Results and attributes taken back to the soup's own polygons.

use std::collections::BTreeMap;

use super::Repaired;
use crate::mesh::{
    Attributes, CornerAttribute, HalfedgeId, NO_VALUE, PerCorner, PolygonLabels, PolygonSoup,
    Polygons,
};

impl Repaired {
    /// For each soup corner a mesh corner that stands for it, or [`NO_VALUE`] where its polygon was
    /// dropped without another in its place.
    ///
    /// A soup corner with several triangles has the mesh corner of smallest number.
    #[must_use]
    pub fn mesh_corners(&self, soup: &PolygonSoup) -> Vec<u32> {
        let mut corners = vec![NO_VALUE; soup.polygons.corner_count()];
        for (corner, &source) in self.corner_sources.enumerate() {
            let slot = &mut corners[source as usize];
            *slot = corner.0.min(*slot);
        }
        for &[lost, bearer] in self.stand_ins.iter().rev() {
            if corners[lost as usize] == NO_VALUE {
                corners[lost as usize] = corners[bearer as usize];
            }
        }
        corners
    }

    /// For each soup vertex the first mesh vertex that stands for it, or [`NO_VALUE`] where it was
    /// dropped.
    #[must_use]
    pub fn mesh_vertices(&self, soup: &PolygonSoup) -> Vec<u32> {
        let mut vertices = vec![NO_VALUE; soup.positions.len()];
        let corners = self.mesh_corners(soup).into_iter();
        for (&vertex, corner) in soup.polygons.corner_vertices().iter().zip(corners) {
            if corner != NO_VALUE {
                let origin = self.surface.mesh().origin(HalfedgeId(corner)).0;
                let slot = &mut vertices[vertex as usize];
                *slot = origin.min(*slot);
            }
        }
        vertices
    }

    /// Values of the mesh corners as an attribute of the soup's own polygons, so that the input
    /// can be written again with a result on it.
    ///
    /// Corners of dropped polygons have [`NO_VALUE`]. A polygon whose triangles disagree at a
    /// corner shows the value of the first.
    #[must_use]
    pub fn to_soup_corners<T: Clone>(
        &self,
        soup: &PolygonSoup,
        name: &str,
        values: &PerCorner<T>,
    ) -> CornerAttribute<T> {
        CornerAttribute {
            name: name.into(),
            values: values.as_slice().to_vec(),
            corner_values: self.mesh_corners(soup),
        }
    }

    /// The repaired surface as a soup: with the attributes of the original, and with its polygons
    /// where all their triangles are still there and hold together.
    #[must_use]
    pub fn to_soup(&self, original: &PolygonSoup) -> PolygonSoup {
        let outlines = self.outlines(original);
        let polygons: Polygons = outlines
            .iter()
            .map(|outline| &outline.vertices[..])
            .collect();
        let vertices = self.mesh_vertices(original);
        let kept = |line: &Vec<u32>| {
            let ends = line.iter().map(|&v| vertices.get(v as usize).copied());
            ends.map(|v| v.filter(|&v| v != NO_VALUE)).collect()
        };
        PolygonSoup {
            positions: self.surface.positions().as_slice().to_vec(),
            polygons,
            polylines: original.polylines.iter().filter_map(kept).collect(),
            attributes: self.attributes(&original.attributes, &outlines),
        }
    }

    fn attributes(&self, original: &Attributes, outlines: &[Outline]) -> Attributes {
        let labels = |labels: &Option<PolygonLabels>| {
            labels.as_ref().map(|labels| carry_labels(labels, outlines))
        };
        let colors = |colors: &Vec<[f32; 4]>| {
            let color = |&source: &u32| colors.get(source as usize).copied();
            self.vertex_sources.iter().map(color).collect::<Option<_>>()
        };
        Attributes {
            uv_sets: original
                .uv_sets
                .iter()
                .map(|set| carry_corners(set, outlines))
                .collect(),
            normals: original
                .normals
                .as_ref()
                .map(|set| carry_corners(set, outlines)),
            vertex_colors: original.vertex_colors.as_ref().and_then(colors),
            objects: labels(&original.objects),
            groups: labels(&original.groups),
            materials: labels(&original.materials),
            smoothing_groups: labels(&original.smoothing_groups),
            material_libraries: original.material_libraries.clone(),
        }
    }

    fn outlines(&self, original: &PolygonSoup) -> Vec<Outline> {
        let faces = self.face_polygons.as_slice();
        let mut members: Vec<u32> = (0..faces.len() as u32).collect();
        // Exchanged edges may have moved a triangle to a polygon beside its neighbours' ones.
        members.sort_by_key(|&face| faces[face as usize]);
        let same = |a: &u32, b: &u32| faces[*a as usize] == faces[*b as usize];
        let mut outlines = Vec::with_capacity(faces.len());
        for members in members.chunk_by(same) {
            let polygon = faces[members[0] as usize];
            let whole = (members.len() > 1)
                .then(|| self.whole_outline(original, polygon, members))
                .flatten();
            match whole {
                Some(outline) => outlines.push(outline),
                None => outlines.extend(members.iter().map(|&face| self.triangle(face))),
            }
        }
        outlines
    }

    fn triangle(&self, face: u32) -> Outline {
        let corners = [0, 1, 2].map(|side| HalfedgeId(3 * face + side));
        let origin = |&corner: &HalfedgeId| self.surface.mesh().origin(corner).0;
        Outline {
            polygon: self.face_polygons.as_slice()[face as usize],
            vertices: corners.iter().map(origin).collect(),
            corners: corners
                .iter()
                .map(|&corner| self.corner_sources[corner])
                .collect(),
        }
    }

    /// The polygon that the triangles were cut from, if they still make it up.
    fn whole_outline(
        &self,
        original: &PolygonSoup,
        polygon: u32,
        members: &[u32],
    ) -> Option<Outline> {
        let mesh = self.surface.mesh();
        let mut vertices = BTreeMap::new();
        let mut steps = BTreeMap::new();
        for corner in members
            .iter()
            .flat_map(|face| [0, 1, 2].map(|side| HalfedgeId(3 * face + side)))
        {
            let source = self.corner_sources[corner];
            let vertex = mesh.origin(corner).0;
            if *vertices.entry(source).or_insert(vertex) != vertex {
                return None;
            }
            let inside = |twin: HalfedgeId| members.binary_search(&twin.face().0).is_ok();
            if !mesh.twin(corner).is_some_and(inside)
                && steps
                    .insert(source, self.corner_sources[corner.next()])
                    .is_some()
            {
                return None;
            }
        }
        let range = original.polygons.corner_range(polygon as usize);
        let own = |source: &u32| range.contains(&(*source as usize));
        let first = *vertices.keys().find(|source| own(source))?;
        let walk = std::iter::successors(Some(first), |corner| {
            steps.get(corner).copied().filter(|&next| next != first)
        });
        let corners: Vec<_> = walk.take(vertices.len() + 1).collect();
        let is_whole = corners.len() == vertices.len()
            && vertices.len() == members.len() + 2
            && corners.iter().all(own);
        is_whole.then(|| Outline {
            polygon,
            vertices: corners.iter().map(|corner| vertices[corner]).collect(),
            corners,
        })
    }
}

/// A polygon of the repaired soup.
struct Outline {
    /// The polygon of the original.
    polygon: u32,
    /// Mesh vertices.
    vertices: Vec<u32>,
    /// Corners of the original.
    corners: Vec<u32>,
}

fn carry_corners<T: Clone>(
    attribute: &CornerAttribute<T>,
    outlines: &[Outline],
) -> CornerAttribute<T> {
    let value = |corner: &u32| attribute.corner_values.get(*corner as usize).copied();
    let corners = outlines.iter().flat_map(|outline| &outline.corners);
    CornerAttribute {
        name: attribute.name.clone(),
        values: attribute.values.clone(),
        corner_values: corners.map(|c| value(c).unwrap_or(NO_VALUE)).collect(),
    }
}

fn carry_labels(labels: &PolygonLabels, outlines: &[Outline]) -> PolygonLabels {
    let name = |polygon: u32| labels.polygon_names.get(polygon as usize).copied();
    PolygonLabels {
        names: labels.names.clone(),
        polygon_names: outlines
            .iter()
            .map(|outline| name(outline.polygon).unwrap_or(NO_VALUE))
            .collect(),
    }
}
