use glam::{DVec2, DVec3};

use super::faces::{Counts, Faces, Missing};
use super::labels::LabelRuns;
use crate::Format;
use crate::error::{Place, Problem, ReadError, quoted};
use crate::format::is_control;
use crate::read::Draft;
use crate::stream::ByteStream;
use crate::text::{Text, decode};

/// Reads a whole OBJ file in one pass.
pub(crate) fn read(stream: ByteStream<'_>, draft: &mut Draft) -> Result<(), ReadError> {
    let mut reader = Reader {
        text: Text::new(stream, Format::Obj).with_comments(),
        positions: Vec::new(),
        colors: Vec::new(),
        uvs: Vec::new(),
        normals: Vec::new(),
        faces: Faces::default(),
        objects: LabelRuns::default(),
        groups: LabelRuns::default(),
        materials: LabelRuns::default(),
        smoothing_groups: LabelRuns::default(),
        libraries: Vec::new(),
        ignored: Ignored::default(),
    };
    loop {
        reader.statement()?;
        if !reader.text.next_line()? {
            return reader.finish(draft);
        }
    }
}

struct Reader<'a> {
    text: Text<'a>,
    positions: Vec<DVec3>,
    /// Shorter than the positions where the last vertices have no colour.
    colors: Vec<[f32; 4]>,
    uvs: Vec<DVec2>,
    normals: Vec<DVec3>,
    faces: Faces,
    objects: LabelRuns,
    groups: LabelRuns,
    materials: LabelRuns,
    smoothing_groups: LabelRuns,
    libraries: Vec<String>,
    ignored: Ignored,
}

/// What was read over.
#[derive(Default)]
struct Ignored {
    freeform: usize,
    weights: usize,
    /// Number of statements with an unknown keyword; line and keyword of the first.
    unknown: usize,
    first_unknown: Option<(u64, String)>,
}

impl Reader<'_> {
    /// Reads a line up to where nothing more of it matters.
    #[inline]
    fn statement(&mut self) -> Result<(), ReadError> {
        let Some(keyword) = self.text.word()? else {
            return Ok(());
        };
        let counts = self.counts();
        match self.text.bytes(&keyword) {
            b"v" => self.vertex(),
            b"vt" => self.uv(),
            b"vn" => self.normal(),
            b"f" | b"fo" => self.faces.polygon(&mut self.text, counts),
            b"l" => self.faces.polyline(&mut self.text, counts),
            _ => self.rare_statement(&keyword),
        }
    }

    fn counts(&self) -> Counts {
        Counts {
            vertices: self.positions.len(),
            uvs: self.uvs.len(),
            normals: self.normals.len(),
        }
    }

    fn rare_statement(&mut self, keyword: &std::ops::Range<usize>) -> Result<(), ReadError> {
        let polygon = self.faces.polygons.len();
        match self.text.bytes(keyword) {
            b"o" => self.objects.begin(polygon, self.text.rest_of_line()?),
            b"g" => self.groups.begin(polygon, self.text.rest_of_line()?),
            b"usemtl" => self.materials.begin(polygon, self.text.rest_of_line()?),
            b"s" => self
                .smoothing_groups
                .begin(polygon, self.text.rest_of_line()?),
            b"mtllib" => self.libraries.push(self.text.rest_of_line()?),
            b"vp" | b"cstype" | b"deg" | b"curv" | b"curv2" | b"surf" | b"parm" | b"trim"
            | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"step" | b"bmat" => {
                self.ignored.freeform += 1;
            }
            b"p" | b"mg" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"shadow_obj"
            | b"trace_obj" | b"ctech" | b"stech" | b"maplib" | b"usemap" => {}
            other => {
                if let Some(&byte) = other.iter().find(|&&byte| is_control(byte)) {
                    return Err(self.text.error(Problem::ControlByte { byte }));
                }
                let first = (self.text.line(), decode(other));
                self.ignored.first_unknown.get_or_insert(first);
                self.ignored.unknown += 1;
            }
        }
        Ok(())
    }

    /// `v x y z`, with an optional weight or an optional colour behind.
    #[inline]
    fn vertex(&mut self) -> Result<(), ReadError> {
        let [x, y, z] = self.triple("vertex", "3")?;
        self.positions.push(DVec3::new(x, y, z));
        if let Some(word) = self.text.word()? {
            let first = self.text.to_float(&word)?;
            self.weight_or_color(first)?;
        }
        Ok(())
    }

    #[cold]
    fn weight_or_color(&mut self, first: f64) -> Result<(), ReadError> {
        let mut color = [first, 0.0, 0.0, 1.0];
        let mut found = 1;
        while let Some(value) = self.text.float()? {
            if found < 4 {
                color[found] = value;
            }
            found += 1;
        }
        match found {
            1 => self.ignored.weights += 1,
            3 | 4 => {
                self.colors.resize(self.positions.len() - 1, [1.0; 4]);
                self.colors.push(color.map(|part| part as f32));
            }
            _ => {
                return Err(self.text.error(Problem::NumberCount {
                    kind: "vertex",
                    needed: "3, 4, 6 or 7",
                    found: 3 + found,
                }));
            }
        }
        Ok(())
    }

    /// `vt u [v [w]]`; w is for volume textures.
    #[inline]
    fn uv(&mut self) -> Result<(), ReadError> {
        let Some(u) = self.text.float()? else {
            return Err(self.text.error(Problem::NumberCount {
                kind: "texture vertex",
                needed: "2",
                found: 0,
            }));
        };
        let v = self.text.float()?.unwrap_or(0.0);
        self.uvs.push(DVec2::new(u, v));
        Ok(())
    }

    #[inline]
    fn normal(&mut self) -> Result<(), ReadError> {
        let [x, y, z] = self.triple("normal", "3")?;
        self.normals.push(DVec3::new(x, y, z));
        Ok(())
    }

    #[inline]
    fn triple(&mut self, kind: &'static str, needed: &'static str) -> Result<[f64; 3], ReadError> {
        let mut numbers = [0.0; 3];
        for (found, number) in numbers.iter_mut().enumerate() {
            let Some(value) = self.text.float()? else {
                return Err(self.text.error(Problem::NumberCount {
                    kind,
                    needed,
                    found,
                }));
            };
            *number = value;
        }
        Ok(numbers)
    }

    fn finish(mut self, draft: &mut Draft) -> Result<(), ReadError> {
        let vertices = self.positions.len();
        if let Some((index, line)) = self.faces.missing_vertex(vertices) {
            let problem = Problem::IndexOutOfRange {
                kind: "vertex",
                index,
                count: vertices,
            };
            return Err(ReadError::malformed(
                Format::Obj,
                Place::Line(line),
                problem,
            ));
        }
        let (uvs, missing_uvs) = self.faces.take_uvs(self.uvs);
        let (normals, missing_normals) = self.faces.take_normals(self.normals);
        warn_of_missing(draft, "texture coordinates", missing_uvs);
        warn_of_missing(draft, "normals", missing_normals);
        self.ignored.warn(draft);
        let polygons = self.faces.polygons.len();
        let attributes = &mut draft.soup.attributes;
        attributes.uv_sets.extend(uvs);
        attributes.normals = normals;
        attributes.objects = self.objects.finish(polygons);
        attributes.groups = self.groups.finish(polygons);
        attributes.materials = self.materials.finish(polygons);
        attributes.smoothing_groups = self.smoothing_groups.finish(polygons);
        attributes.material_libraries = self.libraries;
        draft.soup.positions = self.positions;
        draft.soup.polygons = self.faces.polygons;
        draft.soup.polylines = self.faces.polylines;
        finish_colors(self.colors, draft);
        Ok(())
    }
}

fn warn_of_missing(draft: &mut Draft, kind: &str, missing: Missing) {
    if missing.corners > 0 {
        draft.warn(
            "missing-attributes",
            format!(
                "{} corners name {kind} that are not in the file (one on line {}): read without",
                missing.corners, missing.line
            ),
        );
    }
}

/// Some tools write 0..255 instead of 0..1.
fn finish_colors(mut colors: Vec<[f32; 4]>, draft: &mut Draft) {
    if colors.is_empty() {
        return;
    }
    colors.resize(draft.soup.positions.len(), [1.0; 4]);
    let largest = colors.iter().flatten().copied().fold(0.0, f32::max);
    if largest > 1.0 && largest <= 255.0 {
        draft.warn(
            "colors-scaled",
            format!("vertex colours go up to {largest}: taken as parts of 255"),
        );
        for color in &mut colors {
            let [red, green, blue, alpha] = *color;
            let alpha = if alpha > 1.0 { alpha / 255.0 } else { alpha };
            *color = [red / 255.0, green / 255.0, blue / 255.0, alpha];
        }
    }
    draft.soup.attributes.vertex_colors = Some(colors);
}

impl Ignored {
    fn warn(self, draft: &mut Draft) {
        draft.freeform = self.freeform;
        if self.freeform > 0 {
            draft.warn(
                "freeform-ignored",
                format!(
                    "{} statements of free-form curves and surfaces were ignored",
                    self.freeform
                ),
            );
        }
        if self.weights > 0 {
            draft.warn(
                "weights-ignored",
                format!("the weights (w) of {} vertices were ignored", self.weights),
            );
        }
        if let Some((line, keyword)) = self.first_unknown {
            draft.warn(
                "unknown-statements",
                format!(
                    "{} statements of an unknown kind were ignored; the first is {} on line {line}",
                    self.unknown,
                    quoted(keyword.as_bytes())
                ),
            );
        }
    }
}
