use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec2;

use crate::png_file::raster_png;
use crate::sheet::{Medium, Shape, shapes};
use crate::text::FAMILIES;
use crate::{Color, Picture};

/// Colours that a gradient is written with; in between it is linear.
const GRADIENT_STOPS: usize = 33;
/// Width by which a polygon among others is enlarged, against hairlines between them.
const TILE_STROKE: f64 = 0.4;

impl Picture {
    /// The picture as the text of an SVG file.
    ///
    /// Panels of at most 4000 triangles, in at most 12 000 parts between the lines of checkers, are
    /// drawn as polygons from back to front; in larger ones the triangles are an embedded image, and lines, dots, legend and text remain shapes.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let [width, height] = self.size();
        let mut svg = Svg::default();
        svg.line(&format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{FAMILIES}\" \
             stroke-linecap=\"round\" stroke-linejoin=\"round\">"
        ));
        let background = hex(self.background);
        svg.line(&format!(
            "<rect width=\"{width}\" height=\"{height}\" fill=\"{background}\"/>"
        ));
        for shape in shapes(self, Medium::Shapes) {
            svg.shape(&shape);
        }
        svg.line("</svg>");
        svg.text
    }
}

#[derive(Default)]
struct Svg {
    text: String,
    gradients: usize,
}

impl Svg {
    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn shape(&mut self, shape: &Shape) {
        let line = match shape {
            Shape::Image { corner, raster } => {
                let data = STANDARD.encode(raster_png(raster));
                let (width, height) = (raster.width, raster.height);
                format!(
                    "<image x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{height}\" \
                     href=\"data:image/png;base64,{data}\"/>",
                    number(corner.x),
                    number(corner.y)
                )
            }
            Shape::Polygon { points, fill, tile } => polygon(points, *fill, *tile),
            Shape::Stroke {
                polylines,
                color,
                width,
                opacity,
            } => stroke(polylines, *color, *width, *opacity),
            Shape::Disc {
                center,
                radius,
                color,
                ring,
            } => disc(*center, *radius, *color, *ring),
            Shape::Ramp {
                corner,
                size,
                colors,
            } => self.ramp(*corner, *size, colors),
            Shape::Text { place, size, text } => label(*place, *size, text),
        };
        self.line(&line);
    }

    fn ramp(&mut self, corner: DVec2, size: DVec2, colors: &[Color]) -> String {
        let id = format!("ramp{}", self.gradients);
        self.gradients += 1;
        let stop = |index: usize| {
            let share = index as f64 / (GRADIENT_STOPS - 1) as f64;
            let color = colors[(share * (colors.len() - 1) as f64).round() as usize];
            let (offset, color) = (number(share), hex(color));
            format!("<stop offset=\"{offset}\" stop-color=\"{color}\"/>")
        };
        let stops: String = (0..GRADIENT_STOPS).map(stop).collect();
        self.line(&format!(
            "<defs><linearGradient id=\"{id}\">{stops}</linearGradient></defs>"
        ));
        let [x, y, width, height] = [corner.x, corner.y, size.x, size.y].map(number);
        format!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"url(#{id})\"/>"
        )
    }
}

fn polygon(points: &[DVec2], fill: Color, tile: bool) -> String {
    let points: Vec<String> = points.iter().map(|&point| pair(point)).collect();
    let (points, fill) = (points.join(" "), hex(fill));
    let stroke = if tile {
        format!(" stroke=\"{fill}\" stroke-width=\"{TILE_STROKE}\"")
    } else {
        String::new()
    };
    format!("<polygon points=\"{points}\" fill=\"{fill}\"{stroke}/>")
}

fn stroke(polylines: &[Vec<DVec2>], color: Color, width: f64, opacity: f32) -> String {
    let mut path = String::new();
    for polyline in polylines {
        for (index, &point) in polyline.iter().enumerate() {
            let letter = if index == 0 { 'M' } else { 'L' };
            // Writing to a string does not fail.
            let _ = write!(path, "{letter}{}", pair(point));
        }
    }
    let (color, width, opacity) = (hex(color), number(width), number(f64::from(opacity)));
    format!(
        "<path d=\"{path}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\" \
         stroke-opacity=\"{opacity}\"/>"
    )
}

fn disc(center: DVec2, radius: f64, color: Color, ring: bool) -> String {
    let (x, y, color) = (number(center.x), number(center.y), hex(color));
    let (radius, fill, stroke, width) = if ring {
        (radius, "none".to_owned(), color, radius / 4.0)
    } else {
        (0.925 * radius, color, hex(Color::WHITE), 0.15 * radius)
    };
    let (radius, width) = (number(radius), number(width));
    format!(
        "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{fill}\" stroke=\"{stroke}\" \
         stroke-width=\"{width}\"/>"
    )
}

fn label(place: DVec2, size: f64, text: &str) -> String {
    let (x, y, size) = (number(place.x), number(place.y), number(size));
    let (fill, text) = (hex(Color::INK), escaped(text));
    format!(
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"middle\" \
         fill=\"{fill}\">{text}</text>"
    )
}

fn pair(point: DVec2) -> String {
    format!("{},{}", number(point.x), number(point.y))
}

/// At most two decimals, none where they are zero.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".into()
    } else {
        text.into()
    }
}

fn hex(color: Color) -> String {
    let [red, green, blue] = color.to_bytes();
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Text that XML allows: marks escaped, control characters left out.
fn escaped(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => result.push_str("&amp;"),
            '<' => result.push_str("&lt;"),
            '>' => result.push_str("&gt;"),
            letter if letter.is_control() || matches!(letter, '\u{fffe}' | '\u{ffff}') => {}
            letter => result.push(letter),
        }
    }
    result
}
