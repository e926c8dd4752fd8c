//! The picture of a field: its directions, its singularities, and its scale.

use std::collections::BTreeMap;

use glam::DVec3;
use graticule::field::{FieldError, FieldResult, streamlines};
use graticule::mesh::{Surface, VertexId};
use graticule_draw::{
    Color, ColorScale, Figure, Lines, Panel, Picture, Points, SurfaceStyle, side_by_side, surface,
};

use super::options::Drawing;
use super::output::{middle, rays};
use crate::failure::Failure;

/// Side of a panel in pixels.
const PANEL: u32 = 1280;

/// Cells along the longest side of the bounding box: each shows the field once, or a line in each
/// direction.
const CELLS: f64 = 48.0;

/// Length of a ray over the side of a cell.
const RAY: f64 = 0.42;

const POSITIVE: Color = Color::hex(0x00d6_1f26);
const NEGATIVE: Color = Color::hex(0x001f_5fd6);

/// The field on its surface, red dots where it turns forward and blue ones where backward; beside
/// it the scale that takes the curl away, if there is one.
pub(super) fn picture(
    shape: &Surface,
    found: &FieldResult,
    drawing: Drawing,
) -> Result<Picture, Failure> {
    let mut panels = vec![panel(shape, found, drawing)?.with_caption("field")];
    if let Some(scale) = &found.scale {
        let logarithms = scale.map(|v| libm::log2(*v));
        let figure = Figure::per_vertex("scale, log2", &logarithms);
        let style = SurfaceStyle {
            figure: Some(figure.with_scale(ColorScale::diverging(0.0))),
            ..SurfaceStyle::default()
        };
        panels.push(surface(shape, &style)?.with_caption("scale without curl"));
    }
    let width = PANEL * panels.len() as u32;
    Ok(side_by_side(panels).with_size(width, PANEL)?)
}

/// The field on its surface, with its singularities.
pub(crate) fn panel(
    shape: &Surface,
    found: &FieldResult,
    drawing: Drawing,
) -> Result<Panel, Failure> {
    let [low, high] = shape.bounding_box();
    let cell = (high - low).max_element() / CELLS;
    let lines = match drawing {
        Drawing::Streamlines => streamlines_of(shape, found, cell)?,
        Drawing::Crosses => crosses(shape, found, cell),
    };
    Ok(with_field(
        surface(shape, &SurfaceStyle::default())?,
        lines,
        shape,
        found,
    ))
}

fn with_field(panel: Panel, lines: Lines, shape: &Surface, found: &FieldResult) -> Panel {
    let panel = panel.with_layer(lines);
    let dots = |color: Color, sign: i32| {
        let faces = found.singularities.faces.iter();
        let signed = faces.filter(|singularity| singularity.steps.signum() == sign);
        Points {
            positions: signed.map(|s| middle(shape, s.face)).collect(),
            color,
            radius: 5.0,
            ring: false,
        }
    };
    panel
        .with_layer(dots(NEGATIVE, -1))
        .with_layer(dots(POSITIVE, 1))
}

/// Lines along the field, a cell apart.
fn streamlines_of(shape: &Surface, found: &FieldResult, cell: f64) -> Result<Lines, FieldError> {
    let mut lines = Lines::new(Color::INK, 0.9);
    for line in streamlines(shape, &found.field, cell).map_err(FieldError::from)? {
        lines.push(line);
    }
    Ok(lines)
}

/// The field at one vertex of each cell of the bounding box.
fn crosses(shape: &Surface, found: &FieldResult, cell: f64) -> Lines {
    let [low, _] = shape.bounding_box();
    let mut lines = Lines::new(Color::INK, 1.1);
    for vertex in one_of_each_cell(shape, low, cell) {
        let place = shape.position(vertex);
        let (direction, normal) = (found.directions[vertex], found.normals[vertex]);
        for ray in rays(found.field.symmetry(), direction, normal) {
            lines.push([place, place + ray * (RAY * cell)]);
        }
    }
    lines
}

/// In each cell with vertices the one nearest to its middle.
fn one_of_each_cell(shape: &Surface, low: DVec3, cell: f64) -> Vec<VertexId> {
    let mut chosen = BTreeMap::<[i64; 3], (f64, VertexId)>::new();
    for (vertex, &position) in shape.positions().enumerate() {
        let place = (position - low) / cell;
        let corner = place.floor();
        let off = (place - corner - DVec3::splat(0.5)).length_squared();
        let key = corner.to_array().map(|x| x as i64);
        let nearest = chosen.entry(key).or_insert((off, vertex));
        if off < nearest.0 {
            *nearest = (off, vertex);
        }
    }
    let mut vertices: Vec<VertexId> = chosen.into_values().map(|(_, vertex)| vertex).collect();
    vertices.sort_unstable();
    vertices
}
