//! Pictures at half their size, for the documentation.

use std::fs;
use std::path::Path;

use graticule::charts::TextureImage;
use graticule_io::{ImageDepth, png_bytes, read_png};

use crate::Trouble;

/// The picture at half its width and height.
pub(crate) fn shrink(from: &Path, to: &Path) -> Result<(), Trouble> {
    let bytes = fs::read(from).map_err(|error| Trouble::reading(from, &error))?;
    let in_words = |error: graticule_io::ImageError| Trouble(error.to_string());
    let (picture, _) = read_png(&bytes).map_err(in_words)?;
    let bytes = png_bytes(&half(&picture), ImageDepth::Eight).map_err(in_words)?;
    fs::write(to, bytes).map_err(|error| Trouble::reading(to, &error))
}

fn half(picture: &TextureImage) -> TextureImage {
    let [width, height] = [picture.width / 2, picture.height / 2];
    let at = |x: u32, y: u32| picture.pixels[(y * picture.width + x) as usize];
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (2 * x, 2 * y)));
    let pixels = places.map(|(x, y)| {
        let four = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
        [0, 1, 2, 3].map(|channel| four.iter().map(|pixel| pixel[channel]).sum::<f32>() / 4.0)
    });
    TextureImage {
        width,
        height,
        pixels: pixels.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_of_half_the_size_has_the_means_of_four_pixels() {
        let pixels = (0..8_u8).map(|k| [f32::from(k), 1.0, 0.0, 1.0]).collect();
        let picture = TextureImage {
            width: 4,
            height: 2,
            pixels,
        };
        let half = half(&picture);
        assert_eq!((half.width, half.height), (2, 1));
        let first: Vec<f32> = half.pixels.iter().map(|pixel| pixel[0]).collect();
        assert!((first[0] - 2.5).abs() < 1e-6 && (first[1] - 4.5).abs() < 1e-6);
    }
}
