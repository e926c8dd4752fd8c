use std::io;

use glam::DVec3;
use graticule::mesh::PolygonSoup;

use crate::Format;
use crate::write::{Losses, Sink, WriteError, facets};

/// Writes a whole STL file.
pub(crate) fn write(
    sink: &mut Sink<'_>,
    soup: &PolygonSoup,
    ascii: bool,
    losses: &mut Losses,
) -> Result<(), WriteError> {
    losses.lose_names(&soup.attributes);
    losses.lose_uv_sets(&soup.attributes, 0);
    losses.lose("normals of corners", soup.attributes.normals.is_some());
    losses.lose("colours", soup.attributes.vertex_colors.is_some());
    losses.lose("polylines", !soup.polylines.is_empty());
    losses.lose_shape(soup);
    let mut used = vec![false; soup.positions.len()];
    for &vertex in soup.polygons.corner_vertices() {
        used[vertex as usize] = true;
    }
    losses.lose_unused_vertices(soup, &used);
    let facets = facets(soup);
    if ascii {
        write_text(sink, &facets)?;
        return Ok(());
    }
    let Ok(count) = u32::try_from(facets.len()) else {
        return Err(WriteError::UnsupportedByFormat {
            format: Format::Stl,
            what: format!("{} facets", facets.len()),
        });
    };
    write_binary(sink, &facets, count)?;
    Ok(())
}

/// The header must not begin with "solid".
fn write_binary(sink: &mut Sink<'_>, facets: &[[DVec3; 3]], count: u32) -> io::Result<()> {
    let mut header = [b' '; 80];
    header[..10].copy_from_slice(b"binary STL");
    sink.bytes(&header)?;
    sink.bytes(&count.to_le_bytes())?;
    for facet in facets {
        for vector in [unit_normal(facet)].iter().chain(facet) {
            for coordinate in vector.to_array() {
                sink.bytes(&(coordinate as f32).to_le_bytes())?;
            }
        }
        sink.bytes(&[0, 0])?;
    }
    Ok(())
}

fn write_text(sink: &mut Sink<'_>, facets: &[[DVec3; 3]]) -> io::Result<()> {
    let single = |vector: &DVec3| vector.to_array().map(|coordinate| coordinate as f32);
    sink.text("solid\n")?;
    for facet in facets {
        sink.text("facet normal")?;
        sink.singles(&single(&unit_normal(facet)));
        sink.text("\nouter loop\n")?;
        for vertex in facet {
            sink.text("vertex")?;
            sink.singles(&single(vertex));
            sink.line_end()?;
        }
        sink.text("endloop\nendfacet\n")?;
    }
    sink.text("endsolid\n")
}

/// The direction that a facet faces; zero where it has none.
fn unit_normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    let (u, v) = (*b - *a, *c - *a);
    // Scaled first: the cross product of tiny or huge sides would underflow or overflow.
    let largest = u.abs().max_element().max(v.abs().max_element());
    if largest == 0.0 || !largest.is_finite() {
        return DVec3::ZERO;
    }
    (u / largest).cross(v / largest).normalize_or_zero()
}
