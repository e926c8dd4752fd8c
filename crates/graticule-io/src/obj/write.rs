use std::borrow::Cow;
use std::io;

use graticule::mesh::{NO_VALUE, PolygonLabels, PolygonSoup};

use crate::write::{Losses, Sink};

/// Writes a whole OBJ file.
pub(crate) fn write(
    sink: &mut Sink<'_>,
    soup: &PolygonSoup,
    losses: &mut Losses,
) -> io::Result<()> {
    losses.lose_uv_sets(&soup.attributes, 1);
    let names = Names::of(soup, losses);
    for library in &names.libraries {
        statement(sink, "mtllib ", library)?;
    }
    write_vertices(sink, soup)?;
    write_values(sink, soup)?;
    write_faces(sink, soup, &names)?;
    for line in &soup.polylines {
        sink.text("l")?;
        for vertex in line {
            sink.bytes(b" ")?;
            sink.integer(vertex + 1);
        }
        sink.line_end()?;
    }
    Ok(())
}

fn statement(sink: &mut Sink<'_>, keyword: &str, name: &str) -> io::Result<()> {
    sink.text(keyword)?;
    sink.text(name)?;
    sink.line_end()
}

fn write_vertices(sink: &mut Sink<'_>, soup: &PolygonSoup) -> io::Result<()> {
    let colors = soup.attributes.vertex_colors.as_deref().unwrap_or_default();
    let opaque = colors.iter().all(|color| color[3] == 1.0);
    for (vertex, position) in soup.positions.iter().enumerate() {
        sink.text("v")?;
        sink.floats(&position.to_array());
        if let Some(color) = colors.get(vertex) {
            sink.singles(if opaque { &color[..3] } else { color });
        }
        sink.line_end()?;
    }
    Ok(())
}

fn write_values(sink: &mut Sink<'_>, soup: &PolygonSoup) -> io::Result<()> {
    for uv in soup
        .attributes
        .uv_sets
        .first()
        .iter()
        .flat_map(|set| &set.values)
    {
        sink.text("vt")?;
        sink.floats(&uv.to_array());
        sink.line_end()?;
    }
    for normal in soup.attributes.normals.iter().flat_map(|set| &set.values) {
        sink.text("vn")?;
        sink.floats(&normal.to_array());
        sink.line_end()?;
    }
    Ok(())
}

fn write_faces(sink: &mut Sink<'_>, soup: &PolygonSoup, names: &Names) -> io::Result<()> {
    let mut current = [NO_VALUE; 4];
    for (polygon, vertices) in soup.polygons.iter().enumerate() {
        for ((keyword, labels), current) in names.labels.iter().zip(&mut current) {
            let name = labels
                .polygon_names
                .get(polygon)
                .copied()
                .unwrap_or(NO_VALUE);
            if std::mem::replace(current, name) != name {
                let name = labels.names.get(name as usize).map_or("", String::as_str);
                statement(sink, keyword, name)?;
            }
        }
        sink.text("f")?;
        let first = soup.polygons.corner_range(polygon).start;
        for (corner, vertex) in (first..).zip(vertices) {
            write_corner(sink, soup, corner, *vertex)?;
        }
        sink.line_end()?;
    }
    Ok(())
}

fn write_corner(
    sink: &mut Sink<'_>,
    soup: &PolygonSoup,
    corner: usize,
    vertex: u32,
) -> io::Result<()> {
    let attributes = &soup.attributes;
    let uv = index(
        attributes
            .uv_sets
            .first()
            .map(|set| (&set.corner_values[..], set.values.len())),
        corner,
    );
    let normal = index(
        attributes
            .normals
            .as_ref()
            .map(|set| (&set.corner_values[..], set.values.len())),
        corner,
    );
    sink.bytes(b" ")?;
    sink.integer(vertex + 1);
    if uv.is_some() || normal.is_some() {
        sink.bytes(b"/")?;
    }
    if let Some(uv) = uv {
        sink.integer(uv + 1);
    }
    if let Some(normal) = normal {
        sink.bytes(b"/")?;
        sink.integer(normal + 1);
    }
    Ok(())
}

fn index(set: Option<(&[u32], usize)>, corner: usize) -> Option<u32> {
    let (indices, values) = set?;
    let index = *indices.get(corner)?;
    ((index as usize) < values).then_some(index)
}

/// Names as they can stand on a line.
struct Names {
    libraries: Vec<String>,
    /// Keyword and labels, the wider before the narrower.
    labels: [(&'static str, PolygonLabels); 4],
}

impl Names {
    fn of(soup: &PolygonSoup, losses: &mut Losses) -> Self {
        let attributes = &soup.attributes;
        let mut changed = 0;
        let mut clean = |name: &String| {
            let line = one_line(name);
            changed += usize::from(line != name.as_str());
            line.into_owned()
        };
        let libraries = attributes
            .material_libraries
            .iter()
            .map(&mut clean)
            .collect();
        let labels = [
            ("o ", &attributes.objects),
            ("g ", &attributes.groups),
            ("usemtl ", &attributes.materials),
            ("s ", &attributes.smoothing_groups),
        ];
        let labels = labels.map(|(keyword, labels)| {
            let mut labels = labels.clone().unwrap_or_default();
            labels.names = labels.names.iter().map(&mut clean).collect();
            (keyword, labels)
        });
        if changed > 0 {
            losses.warn(
                "names-changed",
                format!("{changed} names cannot stand on a line as they are: changed to '_' there"),
            );
        }
        Self { libraries, labels }
    }
}

/// `name` without what would end the line, join it with the next one, or vanish.
fn one_line(name: &str) -> Cow<'_, str> {
    let sound = |name: &str| {
        !name.is_empty()
            && name.trim_ascii() == name
            && !name.ends_with('\\')
            && !name.contains(char::is_control)
    };
    if sound(name) {
        return Cow::Borrowed(name);
    }
    let mut line: String = name
        .trim_ascii()
        .chars()
        .map(|letter| if letter.is_control() { '_' } else { letter })
        .collect();
    if line.ends_with('\\') || line.is_empty() {
        line.pop();
        line.push('_');
    }
    Cow::Owned(line)
}

#[cfg(test)]
mod tests {
    use super::one_line;

    #[test]
    fn names_cannot_break_out_of_their_line() {
        assert_eq!(one_line("Größe 2"), "Größe 2");
        assert_eq!(one_line("a\nf 1 2 3"), "a_f 1 2 3");
        assert_eq!(one_line(" a\\"), "a_");
        assert_eq!(one_line(" "), "_");
    }
}
