use std::sync::LazyLock;

use glam::DVec2;
use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// Noto Sans: it has the Greek letters and signs of the field, and viewers of SVG know it.
static FONT: LazyLock<Face<'static>> = LazyLock::new(|| {
    Face::parse(ttf_noto_sans::REGULAR, 0).expect("the embedded font is a valid font")
});

/// The families that an SVG viewer may take, in order.
pub(crate) const FAMILIES: &str = "Noto Sans, Open Sans, DejaVu Sans, Helvetica, Arial, sans-serif";

/// The width of a text in this size, in pixels.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let units: f64 = text.chars().map(|letter| f64::from(advance(letter))).sum();
    units * size / f64::from(FONT.units_per_em())
}

/// The glyph of a letter; for small digits that the font lacks the plain ones, for other letters
/// that it lacks a question mark, for control characters nothing.
fn glyph(letter: char) -> Option<GlyphId> {
    const SMALL_DIGITS: u32 = '₀' as u32;
    if letter.is_control() {
        return None;
    }
    let plain = (letter as u32)
        .checked_sub(SMALL_DIGITS)
        .and_then(|value| char::from_digit(value, 10));
    [Some(letter), plain, Some('?')]
        .into_iter()
        .flatten()
        .find_map(|letter| FONT.glyph_index(letter))
}

fn advance(letter: char) -> u16 {
    glyph(letter)
        .and_then(|glyph| FONT.glyph_hor_advance(glyph))
        .unwrap_or(0)
}

/// The outlines of a text whose base line begins at `place`; `None` if nothing is to be seen.
pub(crate) fn text_outline(text: &str, size: f64, place: DVec2) -> Option<Path> {
    let scale = size / f64::from(FONT.units_per_em());
    let mut pen = Pen {
        path: PathBuilder::new(),
        place,
        scale,
    };
    for letter in text.chars() {
        if let Some(glyph) = glyph(letter) {
            FONT.outline_glyph(glyph, &mut pen);
        }
        pen.place.x += f64::from(advance(letter)) * scale;
    }
    pen.path.finish()
}

/// Breaks a text into lines of at most `width`, at spaces; a word too long has a line of its own.
pub(crate) fn wrapped(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if text_width(line, size) + text_width(word, size) < width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

struct Pen {
    path: PathBuilder,
    place: DVec2,
    scale: f64,
}

impl Pen {
    fn pixel(&self, x: f32, y: f32) -> (f32, f32) {
        let x = self.place.x + f64::from(x) * self.scale;
        let y = self.place.y - f64::from(y) * self.scale;
        (x as f32, y as f32)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.pixel(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.pixel(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.pixel(x1, y1), self.pixel(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2)) = (self.pixel(x1, y1), self.pixel(x2, y2));
        let (x, y) = self.pixel(x, y);
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_the_signs_of_the_field() {
        for letter in "aZ09θφλμσκπ°²·×−–".chars() {
            assert!(FONT.glyph_index(letter).is_some(), "{letter}");
        }
    }

    #[test]
    fn letters_that_the_font_lacks_are_replaced() {
        assert_eq!(glyph('₂'), glyph('2'));
        assert_eq!(glyph('字'), glyph('?'));
        assert_eq!(glyph('\n'), None);
    }

    #[test]
    fn a_text_is_as_wide_as_its_outline_and_wraps() {
        let outline = text_outline("graticule", 20.0, DVec2::new(5.0, 30.0)).unwrap();
        let width = text_width("graticule", 20.0);
        assert!((f64::from(outline.bounds().right()) - 5.0 - width).abs() < 3.0);
        assert_eq!(
            wrapped("one two three", 10.0, text_width("one two", 10.0) + 1.0).len(),
            2
        );
        assert!(text_outline("  \u{7}", 10.0, DVec2::ZERO).is_none());
    }
}
