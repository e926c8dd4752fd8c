//! The field as properties of the vertices of a PLY file.

use std::fmt::Write;

use glam::DVec3;
use graticule::mesh::{NO_VALUE, VertexId};

use super::Found;

impl Found<'_> {
    /// The polygons of the file, little-endian. At each vertex `nx ny nz`, the normal; `dx dy dz`,
    /// one of the directions, from which the others follow by turns about the normal; with curl
    /// correction `scale`. Zeros at vertices that are no part of the surface. At each polygon
    /// `index`, that of its singularities.
    pub(super) fn to_ply(&self) -> Vec<u8> {
        let mut bytes = self.ply_header().into_bytes();
        let vertices = self.repaired.mesh_vertices(self.soup);
        for (position, &vertex) in self.soup.positions.iter().zip(&vertices) {
            let of_surface = (vertex != NO_VALUE).then_some(VertexId(vertex));
            let field = &self.field;
            let [normal, direction] = [&field.normals, &field.directions]
                .map(|values| of_surface.map_or(DVec3::ZERO, |vertex| values[vertex]));
            for vector in [*position, normal, direction] {
                for value in vector.to_array() {
                    bytes.extend(value.to_le_bytes());
                }
            }
            if let Some(scale) = &field.scale {
                let scale = of_surface.map_or(0.0, |vertex| scale[vertex]);
                bytes.extend(scale.to_le_bytes());
            }
        }
        for (polygon, index) in self.soup.polygons.iter().zip(self.polygon_indices()) {
            bytes.extend((polygon.len() as u32).to_le_bytes());
            for vertex in polygon {
                bytes.extend(vertex.to_le_bytes());
            }
            bytes.extend(index.to_le_bytes());
        }
        bytes
    }

    fn ply_header(&self) -> String {
        let mut header = String::from("ply\nformat binary_little_endian 1.0\n");
        let order = self.field.field.symmetry().order();
        let _ = writeln!(header, "comment directions at each vertex: {order}");
        let _ = writeln!(header, "element vertex {}", self.soup.positions.len());
        let scale = self.field.scale.as_ref().map(|_| "scale");
        let names = ["x", "y", "z", "nx", "ny", "nz", "dx", "dy", "dz"];
        for name in names.into_iter().chain(scale) {
            let _ = writeln!(header, "property double {name}");
        }
        let _ = writeln!(header, "element face {}", self.soup.polygons.len());
        header.push_str(
            "property list uint uint vertex_indices\nproperty double index\nend_header\n",
        );
        header
    }

    /// The sum of the indices in each polygon of the file.
    fn polygon_indices(&self) -> Vec<f64> {
        let found = &self.field.singularities;
        let order = f64::from(found.symmetry.order());
        let mut indices = vec![0.0; self.soup.polygons.len()];
        for singularity in &found.faces {
            let polygon = self.repaired.face_polygons[singularity.face] as usize;
            indices[polygon] += f64::from(singularity.steps) / order;
        }
        indices
    }
}
