use glam::{DVec2, DVec3};

use super::header::{Element, Property};
use super::read::{skip_property, truncated};
use super::values::Values;
use crate::Format;
use crate::error::{Place, Problem, ReadError};
use crate::read::Draft;
use crate::weld::vertex_attribute;

/// The vertex properties that are understood.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Column {
    Position(usize),
    Normal(usize),
    Color(usize),
    Uv(usize),
    Other,
}

impl Column {
    fn of(property: &Property) -> Self {
        if property.count.is_some() {
            return Self::Other;
        }
        match property.name.as_str() {
            "x" => Self::Position(0),
            "y" => Self::Position(1),
            "z" => Self::Position(2),
            "nx" => Self::Normal(0),
            "ny" => Self::Normal(1),
            "nz" => Self::Normal(2),
            "red" | "r" | "diffuse_red" => Self::Color(0),
            "green" | "g" | "diffuse_green" => Self::Color(1),
            "blue" | "b" | "diffuse_blue" => Self::Color(2),
            "alpha" | "a" | "diffuse_alpha" => Self::Color(3),
            "s" | "u" | "texture_u" | "texture_s" => Self::Uv(0),
            "t" | "v" | "texture_v" | "texture_t" => Self::Uv(1),
            _ => Self::Other,
        }
    }
}

/// Whether a vertex property is one of those that are understood.
pub(super) fn is_known_of_vertex(property: &Property) -> bool {
    Column::of(property) != Column::Other
}

/// The numbers of one vertex; what the file lacks keeps its value from before.
struct Row {
    position: [f64; 3],
    normal: [f64; 3],
    color: [f32; 4],
    uv: [f64; 2],
}

impl Row {
    #[inline]
    fn set(&mut self, column: Column, value: f64, full: f64) {
        match column {
            Column::Position(axis) => self.position[axis] = value,
            Column::Normal(axis) => self.normal[axis] = value,
            Column::Color(part) => self.color[part] = (value / full) as f32,
            Column::Uv(axis) => self.uv[axis] = value,
            Column::Other => {}
        }
    }
}

/// The element `vertex`.
#[derive(Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<DVec3>,
    normals: Option<Vec<DVec3>>,
    colors: Option<Vec<[f32; 4]>>,
    uvs: Option<Vec<DVec2>>,
}

impl Vertices {
    pub(super) fn read(values: &mut impl Values, element: &Element) -> Result<Self, ReadError> {
        let columns: Vec<Column> = element.properties.iter().map(Column::of).collect();
        let mut vertices = Self::with_columns(&columns)?;
        vertices.positions.reserve_exact(element.rows as usize);
        let mut row = Row {
            position: [0.0; 3],
            normal: [0.0; 3],
            color: [0.0, 0.0, 0.0, 1.0],
            uv: [0.0; 2],
        };
        for number in 0..element.rows {
            for (property, &column) in element.properties.iter().zip(&columns) {
                if column == Column::Other {
                    skip_property(values, element, property, number)?;
                    continue;
                }
                let value = values.next(property.scalar)?;
                let value = value.ok_or_else(|| truncated(element, number))?;
                row.set(column, value, property.scalar.full());
            }
            vertices.push(&row);
        }
        Ok(vertices)
    }

    /// No vertices yet, but a place for all that they have in full.
    fn with_columns(columns: &[Column]) -> Result<Self, ReadError> {
        for (axis, property) in ["x", "y", "z"].into_iter().enumerate() {
            if !columns.contains(&Column::Position(axis)) {
                let element = "vertex";
                let problem = Problem::MissingProperty { element, property };
                return Err(ReadError::malformed(Format::Ply, Place::Header, problem));
            }
        }
        let all = |column: fn(usize) -> Column, count: usize| {
            (0..count).all(|part| columns.contains(&column(part)))
        };
        Ok(Self {
            positions: Vec::new(),
            normals: all(Column::Normal, 3).then(Vec::new),
            colors: all(Column::Color, 3).then(Vec::new),
            uvs: all(Column::Uv, 2).then(Vec::new),
        })
    }

    #[inline]
    fn push(&mut self, row: &Row) {
        self.positions.push(DVec3::from_array(row.position));
        if let Some(normals) = &mut self.normals {
            normals.push(DVec3::from_array(row.normal));
        }
        if let Some(colors) = &mut self.colors {
            colors.push(row.color);
        }
        if let Some(uvs) = &mut self.uvs {
            uvs.push(DVec2::from_array(row.uv));
        }
    }

    pub(super) fn store(self, draft: &mut Draft) {
        let soup = &mut draft.soup;
        let corners = soup.polygons.corner_vertices();
        soup.attributes.normals = self.normals.map(|values| vertex_attribute(values, corners));
        let uvs = self.uvs.map(|values| vertex_attribute(values, corners));
        soup.attributes.uv_sets.extend(uvs);
        soup.attributes.vertex_colors = self.colors;
        soup.positions = self.positions;
    }
}
