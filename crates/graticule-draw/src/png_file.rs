use std::num::NonZeroU32;

use glam::DVec2;
use tiny_skia::{
    FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, PremultipliedColorU8, Rect,
    Stroke, Transform,
};

use crate::raster::Raster;
use crate::sheet::{Medium, Shape, shapes};
use crate::text::{text_outline, text_width};
use crate::{Color, Picture};

impl Picture {
    /// The picture as the bytes of a PNG file.
    ///
    /// Cost: linear in the pixels and in the triangles; the bytes are the same for any number of
    /// threads.
    #[must_use]
    pub fn to_png(&self) -> Vec<u8> {
        let [width, height] = self.size();
        let mut canvas = Canvas::new(width, height, self.background);
        for shape in shapes(self, Medium::Pixels) {
            canvas.draw(&shape);
        }
        let rows = canvas.0.pixels().iter().flat_map(|pixel| {
            let [red, green, blue] = [pixel.red(), pixel.green(), pixel.blue()];
            [red, green, blue]
        });
        encode(
            [width, height],
            png::ColorType::Rgb,
            &rows.collect::<Vec<u8>>(),
        )
    }
}

/// A PNG file of pixels with opacity, for a picture inside a drawing.
pub(crate) fn raster_png(raster: &Raster) -> Vec<u8> {
    let plain = |&[red, green, blue, alpha]: &[u8; 4]| {
        let divide = |part: u8| match alpha {
            0 => 0,
            _ => ((u32::from(part) * 255 + u32::from(alpha) / 2) / u32::from(alpha)).min(255) as u8,
        };
        [divide(red), divide(green), divide(blue), alpha]
    };
    let bytes: Vec<u8> = raster.pixels.iter().flat_map(plain).collect();
    encode([raster.width, raster.height], png::ColorType::Rgba, &bytes)
}

fn encode([width, height]: [u32; 2], color: png::ColorType, bytes: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    let mut writer = encoder
        .write_header()
        .expect("a header in memory, of a size above zero");
    writer
        .write_image_data(bytes)
        .expect("as many bytes as the header says, in memory");
    drop(writer);
    file
}

struct Canvas(Pixmap);

impl Canvas {
    fn new(width: u32, height: u32, background: Color) -> Self {
        let side = |side: u32| NonZeroU32::new(side).map_or(1, NonZeroU32::get);
        let mut pixmap = Pixmap::new(side(width), side(height))
            .expect("both sides were checked when the picture was made");
        pixmap.fill(skia_color(background, 1.0));
        Self(pixmap)
    }

    fn draw(&mut self, shape: &Shape) {
        match shape {
            Shape::Image { corner, raster } => self.image(*corner, raster),
            Shape::Polygon { points, fill, .. } => {
                self.fill(polyline_path([points.as_slice()], true), *fill);
            }
            Shape::Stroke {
                polylines,
                color,
                width,
                opacity,
            } => {
                let path = polyline_path(polylines.iter().map(Vec::as_slice), false);
                self.stroke(path, *color, *width, *opacity);
            }
            Shape::Disc {
                center,
                radius,
                color,
                ring,
            } => self.disc(*center, *radius, *color, *ring),
            Shape::Ramp {
                corner,
                size,
                colors,
            } => self.ramp(*corner, *size, colors),
            Shape::Text { place, size, text } => {
                let start = *place - DVec2::new(text_width(text, *size) / 2.0, 0.0);
                self.fill(text_outline(text, *size, start), Color::INK);
            }
        }
    }

    fn fill(&mut self, path: Option<Path>, color: Color) {
        if let Some(path) = path {
            let paint = solid(color, 1.0);
            self.0.fill_path(
                &path,
                &paint,
                FillRule::Winding,
                Transform::identity(),
                None,
            );
        }
    }

    fn stroke(&mut self, path: Option<Path>, color: Color, width: f64, opacity: f32) {
        if let Some(path) = path {
            let stroke = Stroke {
                width: width as f32,
                line_cap: LineCap::Round,
                line_join: LineJoin::Round,
                ..Stroke::default()
            };
            let paint = solid(color, opacity);
            self.0
                .stroke_path(&path, &paint, &stroke, Transform::identity(), None);
        }
    }

    fn disc(&mut self, center: DVec2, radius: f64, color: Color, ring: bool) {
        let circle = |radius: f64| {
            PathBuilder::from_circle(center.x as f32, center.y as f32, radius.max(0.1) as f32)
        };
        if ring {
            self.stroke(circle(radius), color, radius / 4.0, 1.0);
        } else {
            self.fill(circle(radius), Color::WHITE);
            self.fill(circle(0.85 * radius), color);
        }
    }

    fn ramp(&mut self, corner: DVec2, size: DVec2, colors: &[Color]) {
        let columns = size.x.round().max(1.0) as usize;
        for column in 0..columns {
            let share = column as f64 / (columns - 1).max(1) as f64;
            let color = colors[(share * (colors.len() - 1) as f64).round() as usize];
            let left = (corner.x + column as f64) as f32;
            let rectangle = Rect::from_xywh(left, corner.y as f32, 1.0, size.y as f32);
            if let Some(rectangle) = rectangle {
                self.0
                    .fill_rect(rectangle, &solid(color, 1.0), Transform::identity(), None);
            }
        }
    }

    /// Lays the image over what is there; `corner` is at whole pixels.
    fn image(&mut self, corner: DVec2, raster: &Raster) {
        let (canvas_width, canvas_height) = (self.0.width() as usize, self.0.height() as usize);
        let (left, top) = (corner.x as usize, corner.y as usize);
        let pixels = self.0.pixels_mut();
        for (row, line) in raster.pixels.chunks(raster.width as usize).enumerate() {
            if top + row >= canvas_height {
                break;
            }
            let start = (top + row) * canvas_width;
            let below = &mut pixels[start + left.min(canvas_width)..start + canvas_width];
            for (below, above) in below.iter_mut().zip(line) {
                *below = over(*above, *below);
            }
        }
    }
}

/// A colour multiplied by its opacity, over an opaque one.
fn over([red, green, blue, alpha]: [u8; 4], below: PremultipliedColorU8) -> PremultipliedColorU8 {
    let blend = |above: u8, below: u8| {
        let rest = (u32::from(below) * u32::from(255 - alpha) + 127) / 255;
        (u32::from(above) + rest).min(255) as u8
    };
    let [red, green, blue] = [
        blend(red, below.red()),
        blend(green, below.green()),
        blend(blue, below.blue()),
    ];
    PremultipliedColorU8::from_rgba(red, green, blue, 255).unwrap_or(below)
}

fn skia_color(color: Color, opacity: f32) -> tiny_skia::Color {
    let [red, green, blue] = color.to_bytes();
    let opacity = (opacity.clamp(0.0, 1.0) * 255.0).round() as u8;
    tiny_skia::Color::from_rgba8(red, green, blue, opacity)
}

fn solid(color: Color, opacity: f32) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color(skia_color(color, opacity));
    paint.anti_alias = true;
    paint
}

fn polyline_path<'a>(
    polylines: impl IntoIterator<Item = &'a [DVec2]>,
    closed: bool,
) -> Option<Path> {
    let mut path = PathBuilder::new();
    for polyline in polylines {
        for (index, point) in polyline.iter().enumerate() {
            let (x, y) = (point.x as f32, point.y as f32);
            if index == 0 {
                path.move_to(x, y);
            } else {
                path.line_to(x, y);
            }
        }
        if closed || (polyline.len() > 3 && polyline.first() == polyline.last()) {
            path.close();
        }
    }
    path.finish()
}
