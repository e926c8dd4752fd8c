//! What is written of a field: JSON, or the mesh with lines.

use std::path::{Path, PathBuf};

use glam::DVec3;
use graticule::field::Symmetry;
use graticule::geometry::EdgeLengths;
use graticule::mesh::{FaceId, NO_VALUE, PolygonSoup, Surface, VertexId};
use serde_json::{Value, json};

use super::Found;
use crate::arguments::CommonOptions;
use crate::failure::Failure;
use crate::mesh_output::MeshOutput;
use crate::outcome::Plan;
use crate::output::extension;

/// What is written.
pub(super) enum FieldOutput {
    /// Directions as JSON, into a file or to standard output.
    Json(Option<PathBuf>),
    /// The mesh with directions as properties of its vertices.
    Ply(PathBuf),
    /// The mesh with lines, which the plan writes.
    Lines,
}

impl FieldOutput {
    /// Settles what is written where, by the ending of the file's name.
    pub(super) fn plan(path: &Path, common: &CommonOptions) -> Result<(Plan, Self), Failure> {
        let to_stdout = path.as_os_str() == "-";
        match extension(path).as_str() {
            "obj" => {
                let output = MeshOutput::new(path, None)?;
                Ok((Plan::with_mesh(common, Some(output))?, Self::Lines))
            }
            ending @ ("json" | "ply") => {
                let mut plan = Plan::check(common)?;
                let path = path.to_path_buf();
                plan.add_file(path.clone())?;
                let output = match ending {
                    "ply" => Self::Ply(path),
                    _ => Self::Json(Some(path)),
                };
                Ok((plan, output))
            }
            _ if to_stdout && common.json => Err(Failure::usage(
                "both the field and the report are to go to standard output",
                "name a file for one of them: --report FILE.json or -o FILE",
            )),
            _ if to_stdout => Ok((Plan::check(common)?, Self::Json(None))),
            other => Err(Failure::usage(
                format!(
                    "a field cannot be written as '{other}' ({})",
                    path.display()
                ),
                "end its name in .json or .ply for the directions, or in .obj for lines",
            )),
        }
    }
}

/// The middle of a triangle.
pub(super) fn middle(surface: &Surface, face: FaceId) -> DVec3 {
    // Thirds first: the sum of three large coordinates could overflow.
    surface
        .corner_positions(face)
        .iter()
        .map(|&p| p / 3.0)
        .sum()
}

/// The directions in which a field is drawn at a vertex, the two of a line apart.
pub(super) fn rays(symmetry: Symmetry, direction: DVec3, normal: DVec3) -> Vec<DVec3> {
    let across = normal.cross(direction);
    match symmetry {
        Symmetry::Vector => vec![direction],
        Symmetry::Line => vec![direction, -direction],
        Symmetry::Cross => vec![direction, across, -direction, -across],
    }
}

/// Length of a ray over the mean length of an edge, so that neighbours just do not touch.
const RAY: f64 = 0.4;

impl Found<'_> {
    /// The field by the vertices of the file; `null` for those that are no part of the surface.
    pub(super) fn to_json(&self) -> Result<String, Failure> {
        let vertices = self.repaired.mesh_vertices(self.soup);
        let of_file = |value: &dyn Fn(VertexId) -> Value| -> Value {
            let values = vertices.iter().map(|&vertex| match vertex {
                NO_VALUE => Value::Null,
                vertex => value(VertexId(vertex)),
            });
            values.collect()
        };
        let field = &self.field;
        let scale = field.scale.as_ref();
        let document = json!({
            "graticule": env!("CARGO_PKG_VERSION"),
            "symmetry": field.field.symmetry().order(),
            "directions": of_file(&|v| json!(field.directions[v].to_array())),
            "normals": of_file(&|v| json!(field.normals[v].to_array())),
            "scale": scale.map_or(Value::Null, |scale| of_file(&|v| json!(scale[v]))),
            "singularities": self.singularities(),
            "boundary_indices": field.singularities.boundary_indices,
        });
        let mut text = serde_json::to_string(&document).map_err(|error| {
            Failure::new(
                format!("the field could not be put into JSON: {error}"),
                "this is a fault of graticule: please report it with the command and the file",
            )
        })?;
        text.push('\n');
        Ok(text)
    }

    /// The file's polygons, and at each vertex of the surface a cross, a line or a ray.
    pub(super) fn to_lines(&self) -> PolygonSoup {
        let surface = &self.repaired.surface;
        let length = RAY * EdgeLengths::of(surface).mean();
        let mut soup = PolygonSoup {
            positions: self.soup.positions.clone(),
            polygons: self.soup.polygons.clone(),
            ..PolygonSoup::default()
        };
        for vertex in surface.mesh().vertices() {
            let middle = surface.position(vertex);
            let (direction, normal) = (self.field.directions[vertex], self.field.normals[vertex]);
            let rays = rays(self.field.field.symmetry(), direction, normal);
            let ends: Vec<DVec3> = rays.iter().map(|ray| middle + *ray * length).collect();
            let lines = match ends[..] {
                [end] => vec![[middle, end]],
                [end, opposite] => vec![[end, opposite]],
                [a, b, c, d] => vec![[a, c], [b, d]],
                _ => Vec::new(),
            };
            for line in lines {
                let first = soup.positions.len() as u32;
                soup.positions.extend(line);
                soup.polylines.push(vec![first, first + 1]);
            }
        }
        soup
    }
}
