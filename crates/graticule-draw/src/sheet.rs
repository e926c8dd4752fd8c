//! From panels to a flat list of shapes in pixels, which both kinds of file are written from.

use glam::{DVec2, DVec3};

use crate::camera::Camera;
use crate::legend::{LEGEND_HEIGHT, push_legend};
use crate::painter::painted_triangles;
use crate::raster::{Raster, rasterize};
use crate::text::wrapped;
use crate::{Color, Eye, Layer, Lines, Panel, Picture, Points};

/// Panels with more triangles than this are embedded in an SVG as an image.
const MOST_VECTOR_TRIANGLES: usize = 4000;
/// Polygons of a panel, parts of triangles between the lines of a checker counted apart, beyond
/// which an image is smaller and drawn faster.
const MOST_VECTOR_POLYGONS: usize = 12_000;
/// Height of a line of text, in font sizes.
const LINE_HEIGHT: f64 = 1.4;
/// Space around a drawing, in font sizes.
const MARGIN: f64 = 0.9;

/// What the shapes are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Medium {
    /// An image: all triangles as pixels.
    Pixels,
    /// A drawing: triangles as shapes where there are few.
    Shapes,
}

/// A shape in pixels; x to the right, y down. Later ones lie on top.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    Image {
        corner: DVec2,
        raster: Raster,
    },
    Polygon {
        points: Vec<DVec2>,
        fill: Color,
        /// Whether it is one of many that tile an area: drawn a little larger then, against gaps.
        tile: bool,
    },
    Stroke {
        polylines: Vec<Vec<DVec2>>,
        color: Color,
        width: f64,
        opacity: f32,
    },
    Disc {
        center: DVec2,
        radius: f64,
        color: Color,
        ring: bool,
    },
    /// Columns of colours from left to right.
    Ramp {
        corner: DVec2,
        size: DVec2,
        colors: Vec<Color>,
    },
    /// Text whose base line has its middle at `place`.
    Text {
        place: DVec2,
        size: f64,
        text: String,
    },
}

/// The shapes of a picture.
pub(crate) fn shapes(picture: &Picture, medium: Medium) -> Vec<Shape> {
    let [width, height] = picture.size().map(f64::from);
    let (columns, rows) = (picture.columns, picture.rows());
    let cell = DVec2::new(width / columns as f64, height / rows as f64);
    let mut shapes = Vec::new();
    for (row, panels) in picture.panels.chunks(columns).enumerate() {
        let style = Style::of_row(panels, cell);
        for (column, panel) in panels.iter().enumerate() {
            let corner = DVec2::new(column as f64, row as f64) * cell;
            push_panel(&mut shapes, panel, corner.round(), &style, medium);
        }
    }
    shapes
}

/// What the panels of a row have in common, so that their drawings stand level.
pub(crate) struct Style {
    cell: DVec2,
    pub(crate) font_size: f64,
    legend_height: f64,
    caption_height: f64,
}

impl Style {
    fn of_row(panels: &[Panel], cell: DVec2) -> Self {
        let font_size = (cell.min_element() / 46.0).clamp(8.0, 60.0);
        let has_legend = panels.iter().any(|panel| panel.legend.is_some());
        let lines = panels
            .iter()
            .map(|panel| caption_lines(panel, font_size, cell.x).len())
            .max()
            .unwrap_or(0);
        Self {
            cell,
            font_size,
            legend_height: f64::from(u8::from(has_legend)) * LEGEND_HEIGHT * font_size,
            caption_height: lines as f64 * LINE_HEIGHT * font_size,
        }
    }

    /// Width and height of the drawing itself, in whole pixels.
    fn drawing_size(&self) -> DVec2 {
        let text = self.legend_height + self.caption_height;
        let gap = if text > 0.0 {
            0.5 * self.font_size
        } else {
            0.0
        };
        DVec2::new(self.cell.x, self.cell.y - text - gap)
            .floor()
            .max(DVec2::ONE)
    }

    /// Pixels of a length given in thousandths of the smaller side of the panel.
    fn thousandths(&self, length: f64) -> f64 {
        length * self.cell.min_element() / 1000.0
    }
}

fn caption_lines(panel: &Panel, font_size: f64, width: f64) -> Vec<String> {
    let parts: Vec<&str> = panel
        .caption
        .iter()
        .chain(&panel.notes)
        .map(String::as_str)
        .collect();
    wrapped(&parts.join(" · "), font_size, width - 2.0 * font_size)
}

fn push_panel(
    shapes: &mut Vec<Shape>,
    panel: &Panel,
    corner: DVec2,
    style: &Style,
    medium: Medium,
) {
    let size = style.drawing_size();
    if let Some(camera) = Camera::fit(panel, size, MARGIN * style.font_size) {
        let drawing = Drawing {
            panel,
            camera,
            corner,
            size,
            style,
        };
        drawing.push_shapes(shapes, medium);
    }
    let middle = corner.x + style.cell.x / 2.0;
    let below = corner.y + size.y;
    if let Some(legend) = &panel.legend {
        push_legend(shapes, legend, DVec2::new(middle, below), style);
    }
    let first_line = corner.y + style.cell.y - style.caption_height;
    let lines = caption_lines(panel, style.font_size, style.cell.x);
    for (index, text) in lines.into_iter().enumerate() {
        let down = (index as f64 + 0.85) * LINE_HEIGHT * style.font_size;
        shapes.push(Shape::Text {
            place: DVec2::new(middle, first_line + down - 0.2 * style.font_size),
            size: style.font_size,
            text,
        });
    }
}

impl Style {
    /// Width that a legend may take.
    pub(crate) fn legend_width(&self) -> f64 {
        (24.0 * self.font_size).min(0.7 * self.cell.x)
    }
}

/// A panel on its place in the picture.
struct Drawing<'a> {
    panel: &'a Panel,
    camera: Camera,
    corner: DVec2,
    size: DVec2,
    style: &'a Style,
}

impl Drawing<'_> {
    fn push_shapes(&self, shapes: &mut Vec<Shape>, medium: Medium) {
        let count: usize = self.panel.layers.iter().map(triangle_count).sum();
        let in_space = self.panel.eye != Eye::Plane;
        let over_triangles = self
            .panel
            .layers
            .iter()
            .any(|layer| matches!(layer, Layer::Lines(_) | Layer::Points(_)));
        let may_be_shapes = medium == Medium::Shapes && count <= MOST_VECTOR_TRIANGLES;
        let polygons = may_be_shapes
            .then(|| painted_triangles(self.panel, &self.camera, self.corner))
            .filter(|polygons| polygons.len() <= MOST_VECTOR_POLYGONS);
        // Lines and points in space need the depths to tell what is hidden.
        let needs_raster = count > 0 && (polygons.is_none() || (in_space && over_triangles));
        let raster = needs_raster.then(|| {
            rasterize(
                self.panel,
                &self.camera,
                [self.size.x as u32, self.size.y as u32],
            )
        });
        let strokes = self.strokes(raster.as_ref().filter(|_| in_space));
        if let Some(polygons) = polygons {
            shapes.extend(polygons);
        } else if let Some(raster) = raster {
            let corner = self.corner;
            shapes.push(Shape::Image { corner, raster });
        }
        shapes.extend(strokes);
    }

    /// Lines, then points, without what `depths` hides.
    fn strokes(&self, depths: Option<&Raster>) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for layer in &self.panel.layers {
            if let Layer::Lines(lines) = layer {
                shapes.extend(self.stroke(lines, depths));
            }
        }
        for layer in &self.panel.layers {
            if let Layer::Points(points) = layer {
                shapes.extend(self.discs(points, depths));
            }
        }
        shapes
    }

    fn stroke(&self, lines: &Lines, depths: Option<&Raster>) -> Option<Shape> {
        let width = self.style.thousandths(lines.width);
        let faded = if lines.fades { self.fading(lines) } else { 1.0 };
        let opacity = (lines.opacity * faded).clamp(0.0, 1.0);
        if opacity < 0.02 {
            return None;
        }
        let mut polylines = Vec::new();
        for line in lines.iter() {
            let line: Vec<DVec3> = line.iter().map(|&p| self.camera.project(p)).collect();
            // A gap in the positions is a gap in the line.
            for piece in line.split(|point| !point.is_finite()) {
                match depths {
                    Some(depths) => push_visible(&mut polylines, piece, depths, width),
                    None => polylines.push(piece.iter().map(|p| p.truncate()).collect()),
                }
            }
        }
        polylines.retain(|polyline: &Vec<DVec2>| polyline.len() >= 2);
        for point in polylines.iter_mut().flatten() {
            *point += self.corner;
        }
        (!polylines.is_empty()).then_some(Shape::Stroke {
            polylines,
            color: lines.color,
            width,
            opacity,
        })
    }

    /// 1 where segments are long in the image, falling to 0 where they are a few pixels.
    fn fading(&self, lines: &Lines) -> f32 {
        let lengths = lines.iter().flat_map(|line| line.windows(2)).map(|ends| {
            let [a, b] = [ends[0], ends[1]].map(|p| self.camera.project(p).truncate());
            a.distance(b)
        });
        let (sum, count) = lengths
            .filter(|length| length.is_finite())
            .fold((0.0, 0_u32), |(sum, count), length| {
                (sum + length, count + 1)
            });
        let mean = sum / f64::from(count.max(1));
        ((mean - 4.0) / 14.0).clamp(0.0, 1.0) as f32
    }

    fn discs(&self, points: &Points, depths: Option<&Raster>) -> Vec<Shape> {
        let radius = self.style.thousandths(points.radius);
        let places = points.positions.iter().map(|&p| self.camera.project(p));
        places
            .filter(|place| place.is_finite())
            .filter(|place| {
                depths.is_none_or(|depths| place.z + radius >= depths.depth(place.truncate()))
            })
            .map(|place| Shape::Disc {
                center: self.corner + place.truncate(),
                radius,
                color: points.color,
                ring: points.ring,
            })
            .collect()
    }
}

fn triangle_count(layer: &Layer) -> usize {
    match layer {
        Layer::Triangles(triangles) => triangles.triangles.len(),
        _ => 0,
    }
}

/// Cuts a polyline with depths into the parts that the surface does not hide. A line on the surface
/// is seen: depth may differ by what a steep surface changes within a few pixels.
fn push_visible(polylines: &mut Vec<Vec<DVec2>>, line: &[DVec3], depths: &Raster, width: f64) {
    let slack = 3.0 + width;
    let is_seen = |p: DVec3| p.z + slack >= depths.depth(p.truncate());
    for [start, end] in visible_runs(line, is_seen) {
        let inner = line.iter().enumerate().filter(|&(index, _)| {
            let index = index as f64;
            start < index && index < end
        });
        let mut part = vec![point_at(line, start).truncate()];
        part.extend(inner.map(|(_, point)| point.truncate()));
        part.push(point_at(line, end).truncate());
        polylines.push(part);
    }
}

/// The parts of a polyline that are seen, tried at every pixel or so. A place on the line is the
/// number of its segment and the share of the segment before it.
///
/// Gaps of a few pixels are rounding and are closed. Parts of a few pixels are places where the
/// line runs just behind the rim of the surface, and are left out.
fn visible_runs(line: &[DVec3], is_seen: impl Fn(DVec3) -> bool) -> Vec<[f64; 2]> {
    const CLOSED_GAP: usize = 4;
    const SHORTEST_PART: usize = 8;
    let mut runs: Vec<([f64; 2], usize)> = Vec::new();
    let mut hidden = usize::MAX;
    for (segment, ends) in line.windows(2).enumerate() {
        let steps = (ends[1] - ends[0]).truncate().length().ceil().max(1.0) as usize;
        for step in usize::from(segment > 0)..=steps {
            let place = segment as f64 + step as f64 / steps as f64;
            if !is_seen(point_at(line, place)) {
                hidden = hidden.saturating_add(1);
                continue;
            }
            match runs.last_mut().filter(|_| hidden <= CLOSED_GAP) {
                Some((run, tries)) => (run[1], *tries) = (place, *tries + 1),
                None => runs.push(([place, place], 1)),
            }
            hidden = 0;
        }
    }
    let end = line.len() as f64 - 1.0;
    let is_whole = |[first, last]: [f64; 2]| first <= 0.0 && last >= end;
    runs.into_iter()
        .filter(|&(run, tries)| is_whole(run) || tries >= SHORTEST_PART)
        .map(|(run, _)| run)
        .collect()
}

fn point_at(line: &[DVec3], place: f64) -> DVec3 {
    let segment = (place as usize).min(line.len() - 2);
    line[segment].lerp(line[segment + 1], place - segment as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_cut_where_it_is_hidden_and_short_gaps_are_closed() {
        let line = [DVec3::ZERO, DVec3::X * 50.0, DVec3::X * 100.0];
        let all = visible_runs(&line, |_| true);
        assert_eq!(all, [[0.0, 2.0]]);
        assert!(visible_runs(&line, |_| false).is_empty());
        let cut = visible_runs(&line, |p| p.x < 20.0 || p.x > 70.0);
        assert_eq!(cut.len(), 2);
        assert!((cut[0][1] - 0.38).abs() < 1e-9 && (cut[1][0] - 1.42).abs() < 1e-9);
        assert!(visible_runs(&line, |p| p.x > 20.0 && p.x < 25.0).is_empty());
        let short = [DVec3::ZERO, DVec3::X * 3.0];
        assert_eq!(visible_runs(&short, |_| true), [[0.0, 1.0]]);
        let closed = visible_runs(&line, |p| p.x < 20.0 || p.x > 22.0);
        assert_eq!(closed, [[0.0, 2.0]]);
    }
}
