use std::io;

use glam::{DVec2, DVec3};
use graticule::mesh::PolygonSoup;

use crate::write::{Losses, Sink, per_vertex, vertex_normals};

/// Writes a whole OFF file; what vertices have beside positions is told by its first word.
pub(crate) fn write(
    sink: &mut Sink<'_>,
    soup: &PolygonSoup,
    losses: &mut Losses,
) -> io::Result<()> {
    losses.lose_names(&soup.attributes);
    losses.lose_uv_sets(&soup.attributes, 1);
    losses.lose("polylines", !soup.polylines.is_empty());
    let content = Content::of(soup, losses);
    sink.text(&content.first_word())?;
    sink.integer(soup.positions.len());
    sink.bytes(b" ")?;
    sink.integer(soup.polygons.len());
    sink.text(" 0\n")?;
    content.write_vertices(sink, soup)?;
    for corners in soup.polygons.iter() {
        sink.integer(corners.len());
        for corner in corners {
            sink.bytes(b" ")?;
            sink.integer(*corner);
        }
        sink.line_end()?;
    }
    Ok(())
}

/// What vertices have beside positions.
struct Content<'a> {
    normals: Option<Vec<DVec3>>,
    colors: Option<&'a [[f32; 4]]>,
    uvs: Option<Vec<DVec2>>,
}

impl<'a> Content<'a> {
    fn of(soup: &'a PolygonSoup, losses: &mut Losses) -> Self {
        let attributes = &soup.attributes;
        let set = attributes.uv_sets.first();
        let uvs = set.and_then(|set| per_vertex(set, soup));
        losses.lose(
            "texture coordinates that differ between the corners of a vertex",
            uvs.is_none() && set.is_some(),
        );
        Self {
            normals: vertex_normals(soup, losses),
            colors: attributes.vertex_colors.as_deref(),
            uvs,
        }
    }

    fn first_word(&self) -> String {
        let parts = [
            ("ST", self.uvs.is_some()),
            ("C", self.colors.is_some()),
            ("N", self.normals.is_some()),
        ];
        let letters = parts.iter().filter(|(_, there)| *there);
        let letters: String = letters.map(|(letters, _)| *letters).collect();
        letters + "OFF\n"
    }

    fn write_vertices(&self, sink: &mut Sink<'_>, soup: &PolygonSoup) -> io::Result<()> {
        for (vertex, position) in soup.positions.iter().enumerate() {
            sink.floats(&position.to_array());
            if let Some(normals) = &self.normals {
                sink.floats(&normals[vertex].to_array());
            }
            if let Some(colors) = self.colors {
                sink.singles(colors.get(vertex).unwrap_or(&[1.0; 4]));
            }
            if let Some(uvs) = &self.uvs {
                sink.floats(&uvs[vertex].to_array());
            }
            sink.line_end()?;
        }
        Ok(())
    }
}
