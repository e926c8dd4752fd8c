use std::io;

use glam::{DVec2, DVec3};
use graticule::mesh::{CornerAttribute, PolygonSoup};

use super::header::Scalar;
use crate::write::{Losses, Sink, fits_single, per_vertex, vertex_normals};

/// Writes a whole PLY file: little-endian, or text if `ascii`.
pub(crate) fn write(
    sink: &mut Sink<'_>,
    soup: &PolygonSoup,
    ascii: bool,
    losses: &mut Losses,
) -> io::Result<()> {
    losses.lose_names(&soup.attributes);
    losses.lose_uv_sets(&soup.attributes, 1);
    let content = Content::of(soup, losses);
    sink.text(&content.header(soup, ascii))?;
    let mut body = Body { sink, ascii };
    content.write_vertices(&mut body, soup)?;
    content.write_faces(&mut body, soup)?;
    for ends in soup.polylines.iter().flat_map(|line| line.windows(2)) {
        body.integer(content.index, ends[0])?;
        body.integer(content.index, ends[1])?;
        body.row_end()?;
    }
    Ok(())
}

/// What is written, and in which types: the smallest in which nothing is lost.
struct Content<'a> {
    position: Scalar,
    normals: Option<(Scalar, Vec<DVec3>)>,
    colors: Option<(Scalar, &'a [[f32; 4]])>,
    uvs: Option<(Scalar, Vec<DVec2>)>,
    corner_uvs: Option<(Scalar, &'a CornerAttribute<DVec2>)>,
    /// Type of the counts of lists.
    count: Scalar,
    /// Type of vertex indices: signed, as most tools expect, while that is enough.
    index: Scalar,
}

fn smallest_float<const N: usize>(values: impl IntoIterator<Item = [f64; N]>) -> Scalar {
    if values.into_iter().all(|value| fits_single(&value)) {
        Scalar::F32
    } else {
        Scalar::F64
    }
}

/// Bytes, as all tools read them, where they are exact.
fn color_scalar(colors: &[[f32; 4]]) -> Scalar {
    let exact = |part: &f32| {
        let byte = to_byte(*part);
        (f32::from(byte) / 255.0).to_bits() == part.to_bits()
    };
    if colors.iter().flatten().all(exact) {
        Scalar::U8
    } else {
        Scalar::F32
    }
}

#[allow(
    clippy::cast_sign_loss,
    reason = "the cast is to the nearest value that a byte has"
)]
fn to_byte(part: f32) -> u8 {
    (part * 255.0).round() as u8
}

impl<'a> Content<'a> {
    fn of(soup: &'a PolygonSoup, losses: &mut Losses) -> Self {
        let attributes = &soup.attributes;
        let normals = vertex_normals(soup, losses);
        let set = attributes.uv_sets.first();
        let uvs = set.and_then(|set| per_vertex(set, soup));
        let corner_uvs = set.filter(|_| uvs.is_none());
        if let Some(set) = corner_uvs {
            let partial = partial_faces(set, soup);
            losses.lose(
                &format!("texture coordinates at some corners of {partial} faces only"),
                partial > 0,
            );
        }
        let longest = soup.polygons.iter().map(<[u32]>::len).max().unwrap_or(0);
        let uv_scalar = set.map_or(Scalar::F32, |set| {
            smallest_float(set.values.iter().map(DVec2::to_array))
        });
        Self {
            position: smallest_float(soup.positions.iter().map(DVec3::to_array)),
            normals: normals
                .map(|values| (smallest_float(values.iter().map(DVec3::to_array)), values)),
            colors: attributes
                .vertex_colors
                .as_deref()
                .map(|colors| (color_scalar(colors), colors)),
            uvs: uvs.map(|values| (uv_scalar, values)),
            corner_uvs: corner_uvs.map(|set| (uv_scalar, set)),
            count: if 2 * longest <= 255 {
                Scalar::U8
            } else {
                Scalar::I32
            },
            index: if i32::try_from(soup.positions.len()).is_ok() {
                Scalar::I32
            } else {
                Scalar::U32
            },
        }
    }

    fn header(&self, soup: &PolygonSoup, ascii: bool) -> String {
        let encoding = if ascii {
            "ascii"
        } else {
            "binary_little_endian"
        };
        let mut lines = vec!["ply".to_owned(), format!("format {encoding} 1.0")];
        lines.push(format!("element vertex {}", soup.positions.len()));
        let mut properties = |scalar: Scalar, names: &[&str]| {
            let of_type = |name| format!("property {} {name}", scalar.name());
            lines.extend(names.iter().map(of_type));
        };
        properties(self.position, &["x", "y", "z"]);
        if let Some((scalar, _)) = self.normals {
            properties(scalar, &["nx", "ny", "nz"]);
        }
        if let Some((scalar, _)) = self.colors {
            properties(scalar, &["red", "green", "blue", "alpha"]);
        }
        if let Some((scalar, _)) = self.uvs {
            properties(scalar, &["s", "t"]);
        }
        let count = self.count.name();
        lines.push(format!("element face {}", soup.polygons.len()));
        let index = self.index.name();
        lines.push(format!("property list {count} {index} vertex_indices"));
        if let Some((scalar, _)) = self.corner_uvs {
            lines.push(format!("property list {count} {} texcoord", scalar.name()));
        }
        let segments: usize = soup
            .polylines
            .iter()
            .map(|line| line.len().saturating_sub(1))
            .sum();
        if segments > 0 {
            lines.push(format!("element edge {segments}"));
            lines.extend(["vertex1", "vertex2"].map(|name| format!("property {index} {name}")));
        }
        lines.push("end_header\n".to_owned());
        lines.join("\n")
    }

    fn write_vertices(&self, body: &mut Body<'_, '_>, soup: &PolygonSoup) -> io::Result<()> {
        for (vertex, position) in soup.positions.iter().enumerate() {
            body.floats(self.position, &position.to_array())?;
            if let Some((scalar, normals)) = &self.normals {
                body.floats(*scalar, &normals[vertex].to_array())?;
            }
            if let Some((scalar, colors)) = self.colors {
                let color = colors.get(vertex).unwrap_or(&[1.0; 4]);
                for &part in color {
                    if scalar == Scalar::U8 {
                        body.integer(scalar, to_byte(part).into())?;
                    } else {
                        body.float(scalar, part.into())?;
                    }
                }
            }
            if let Some((scalar, uvs)) = &self.uvs {
                body.floats(*scalar, &uvs[vertex].to_array())?;
            }
            body.row_end()?;
        }
        Ok(())
    }

    fn write_faces(&self, body: &mut Body<'_, '_>, soup: &PolygonSoup) -> io::Result<()> {
        for (polygon, vertices) in soup.polygons.iter().enumerate() {
            body.integer(self.count, vertices.len() as u32)?;
            for &vertex in vertices {
                body.integer(self.index, vertex)?;
            }
            if let Some((scalar, set)) = self.corner_uvs {
                let corners = soup.polygons.corner_range(polygon);
                let valued = corners.clone().all(|corner| set.get(corner).is_some());
                let count = if valued { 2 * vertices.len() } else { 0 };
                body.integer(self.count, count as u32)?;
                for uv in corners.take(count).filter_map(|corner| set.get(corner)) {
                    body.floats(scalar, &uv.to_array())?;
                }
            }
            body.row_end()?;
        }
        Ok(())
    }
}

/// Faces of which some corners have a value and others none.
fn partial_faces(set: &CornerAttribute<DVec2>, soup: &PolygonSoup) -> usize {
    let is_partial = |polygon: &usize| {
        let corners = soup.polygons.corner_range(*polygon);
        let valued = corners
            .clone()
            .filter(|&corner| set.get(corner).is_some())
            .count();
        valued > 0 && valued < corners.len()
    };
    (0..soup.polygons.len()).filter(is_partial).count()
}

struct Body<'a, 'b> {
    sink: &'a mut Sink<'b>,
    ascii: bool,
}

impl Body<'_, '_> {
    /// A number of a floating-point type.
    fn float(&mut self, scalar: Scalar, value: f64) -> io::Result<()> {
        let single = scalar == Scalar::F32;
        match (self.ascii, single) {
            (true, true) => self.sink.singles(&[value as f32]),
            (true, false) => self.sink.floats(&[value]),
            (false, true) => self.sink.bytes(&(value as f32).to_le_bytes())?,
            (false, false) => self.sink.bytes(&value.to_le_bytes())?,
        }
        Ok(())
    }

    fn floats(&mut self, scalar: Scalar, values: &[f64]) -> io::Result<()> {
        values
            .iter()
            .try_for_each(|&value| self.float(scalar, value))
    }

    /// A number of a type of one or four bytes; below 2^31 signed ones have the same bytes.
    fn integer(&mut self, scalar: Scalar, value: u32) -> io::Result<()> {
        if self.ascii {
            self.sink.bytes(b" ")?;
            self.sink.integer(value);
            return Ok(());
        }
        let bytes = value.to_le_bytes();
        self.sink.bytes(&bytes[..scalar.size() as usize])
    }

    fn row_end(&mut self) -> io::Result<()> {
        if self.ascii {
            self.sink.line_end()
        } else {
            Ok(())
        }
    }
}
