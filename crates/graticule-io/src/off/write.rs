use std::io;

use graticule::mesh::PolygonSoup;

use crate::write::{Losses, Sink, per_vertex};

/// Writes a whole OFF file; what vertices have beside positions is told by its first word.
pub(crate) fn write(
    sink: &mut Sink<'_>,
    soup: &PolygonSoup,
    losses: &mut Losses,
) -> io::Result<()> {
    let attributes = &soup.attributes;
    losses.lose_names(attributes);
    losses.lose_uv_sets(attributes, 1);
    losses.lose("polylines", !soup.polylines.is_empty());
    let uvs = attributes
        .uv_sets
        .first()
        .and_then(|set| per_vertex(set, soup));
    let normals = attributes
        .normals
        .as_ref()
        .and_then(|set| per_vertex(set, soup));
    losses.lose(
        "texture coordinates that differ between the corners of a vertex",
        uvs.is_none() && !attributes.uv_sets.is_empty(),
    );
    losses.lose(
        "normals that differ between the corners of a vertex",
        normals.is_none() && attributes.normals.is_some(),
    );
    let colors = attributes.vertex_colors.as_deref();
    for (letters, there) in [
        ("ST", uvs.is_some()),
        ("C", colors.is_some()),
        ("N", normals.is_some()),
    ] {
        sink.text(if there { letters } else { "" })?;
    }
    sink.text("OFF\n")?;
    sink.integer(soup.positions.len());
    sink.bytes(b" ")?;
    sink.integer(soup.polygons.len());
    sink.text(" 0\n")?;
    for (vertex, position) in soup.positions.iter().enumerate() {
        sink.floats(&position.to_array());
        if let Some(normals) = &normals {
            sink.floats(&normals[vertex].to_array());
        }
        if let Some(colors) = colors {
            sink.singles(colors.get(vertex).unwrap_or(&[1.0; 4]));
        }
        if let Some(uvs) = &uvs {
            sink.floats(&uvs[vertex].to_array());
        }
        sink.line_end()?;
    }
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
