use glam::DVec2;

use crate::sheet::{Shape, Style};
use crate::{Color, Legend};

/// Height of a legend, in font sizes.
pub(crate) const LEGEND_HEIGHT: f64 = 4.2;

/// Colours along the bar.
const COLUMNS: usize = 256;

/// Puts a legend below `top`, the middle of its upper side: title, bar with arrows where values
/// lie beyond its ends, marks; a swatch for missing values to the right.
pub(crate) fn push_legend(shapes: &mut Vec<Shape>, legend: &Legend, top: DVec2, style: &Style) {
    let unit = style.font_size;
    let size = DVec2::new(style.legend_width(), 0.85 * unit).round();
    let corner = (top + DVec2::new(-size.x / 2.0, 1.5 * unit)).round();
    let title_place = top + DVec2::new(0.0, unit);
    shapes.push(text(&legend.title, title_place, unit));
    let share = |column: usize| column as f64 / (COLUMNS - 1) as f64;
    shapes.push(Shape::Ramp {
        corner,
        size,
        colors: (0..COLUMNS)
            .map(|column| legend.map.at(share(column)))
            .collect(),
    });
    push_arrows(shapes, legend, corner, size);
    push_marks(shapes, legend, corner, size, unit);
    if legend.missing > 0 {
        push_missing(
            shapes,
            corner + DVec2::new(size.x + 2.4 * unit, 0.0),
            size.y,
            unit,
        );
    }
}

fn text(content: &str, place: DVec2, size: f64) -> Shape {
    Shape::Text {
        place,
        size,
        text: content.into(),
    }
}

/// Arrows in the end colours where values lie beyond the ends.
fn push_arrows(shapes: &mut Vec<Shape>, legend: &Legend, corner: DVec2, size: DVec2) {
    let sides = [
        (legend.below, corner.x, -1.0, 0.0),
        (legend.above, corner.x + size.x, 1.0, 1.0),
    ];
    for (count, x, direction, share) in sides {
        if count > 0 {
            let base = x + 2.0 * direction;
            shapes.push(Shape::Polygon {
                points: vec![
                    DVec2::new(base, corner.y),
                    DVec2::new(base, corner.y + size.y),
                    DVec2::new(base + direction * 0.8 * size.y, corner.y + size.y / 2.0),
                ],
                fill: legend.map.at(share),
                tile: false,
            });
        }
    }
}

fn push_marks(shapes: &mut Vec<Shape>, legend: &Legend, corner: DVec2, size: DVec2, unit: f64) {
    let bottom = corner.y + size.y;
    let mark_x = |value: f64| corner.x + legend.share(value) * size.x;
    let marks = legend.ticks().into_iter().map(|value| {
        vec![
            DVec2::new(mark_x(value), bottom),
            DVec2::new(mark_x(value), bottom + 0.3 * unit),
        ]
    });
    shapes.push(Shape::Stroke {
        polylines: marks.collect(),
        color: Color::INK,
        width: (unit / 14.0).max(0.8),
        opacity: 1.0,
    });
    let size_of_numbers = 0.88 * unit;
    for value in legend.ticks() {
        let place = DVec2::new(mark_x(value), bottom + 1.25 * unit);
        shapes.push(text(&legend.format(value), place, size_of_numbers));
    }
}

fn push_missing(shapes: &mut Vec<Shape>, corner: DVec2, side: f64, unit: f64) {
    let corner = corner.round();
    shapes.push(Shape::Ramp {
        corner,
        size: DVec2::splat(side),
        colors: vec![Color::MISSING],
    });
    let label = "none";
    let place = corner + DVec2::new(side / 2.0, side + 1.25 * unit);
    shapes.push(text(label, place, 0.88 * unit));
}
