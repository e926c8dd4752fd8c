//! Images: PNG, and OpenEXR for values of any size.

use std::io::Cursor;

use exr::prelude::{Image, SpecificChannels, Vec2, WritableImage};
use graticule::Hint;
use graticule::charts::TextureImage;

/// Most pixels of an image that is read: what a PNG file claims is not believed beyond.
const MOST_PIXELS: u64 = 1 << 28;

/// Why an image could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The content is no sound PNG file.
    #[error("not a PNG image that can be read: {0}")]
    Decoding(#[from] png::DecodingError),
    /// The PNG file could not be made.
    #[error("the image cannot be written as PNG: {0}")]
    Encoding(#[from] png::EncodingError),
    /// The OpenEXR file could not be made.
    #[error("the image cannot be written as OpenEXR: {0}")]
    Exr(#[from] exr::error::Error),
    /// The image has too many pixels.
    #[error("an image of {width} by {height} pixels is too large")]
    TooLarge {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
}

impl Hint for ImageError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::Decoding(_) => Some("save the image as PNG".into()),
            Self::TooLarge { .. } => Some("scale the image down".into()),
            Self::Encoding(_) | Self::Exr(_) => None,
        }
    }
}

/// Bits for each number of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageDepth {
    /// 8 bits.
    Eight,
    /// 16 bits.
    Sixteen,
}

/// Reads a PNG image of any kind, and tells how many bits its numbers have.
///
/// # Errors
/// [`ImageError::Decoding`], [`ImageError::TooLarge`].
pub fn read_png(bytes: &[u8]) -> Result<(TextureImage, ImageDepth), ImageError> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info()?;
    let (width, height) = (reader.info().width, reader.info().height);
    let size = reader.output_buffer_size();
    let Some(size) = size.filter(|_| u64::from(width) * u64::from(height) <= MOST_PIXELS) else {
        return Err(ImageError::TooLarge { width, height });
    };
    let mut buffer = vec![0; size];
    let frame = reader.next_frame(&mut buffer)?;
    buffer.truncate(frame.buffer_size());
    let (depth, numbers): (_, Vec<f32>) = if frame.bit_depth == png::BitDepth::Sixteen {
        let pairs = buffer
            .chunks_exact(2)
            .map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
        (
            ImageDepth::Sixteen,
            pairs.map(|n| f32::from(n) / 65535.0).collect(),
        )
    } else {
        (
            ImageDepth::Eight,
            buffer.iter().map(|&n| f32::from(n) / 255.0).collect(),
        )
    };
    let pixels = numbers
        .chunks_exact(frame.color_type.samples())
        .map(|pixel| match *pixel {
            [gray] => [gray, gray, gray, 1.0],
            [gray, alpha] => [gray, gray, gray, alpha],
            [red, green, blue] => [red, green, blue, 1.0],
            [red, green, blue, alpha, ..] => [red, green, blue, alpha],
            [] => [0.0; 4],
        });
    Ok((
        TextureImage {
            width,
            height,
            pixels: pixels.collect(),
        },
        depth,
    ))
}

/// An image as a PNG file, with opacity where a pixel is not opaque.
///
/// # Errors
/// [`ImageError::Encoding`].
pub fn png_bytes(image: &TextureImage, depth: ImageDepth) -> Result<Vec<u8>, ImageError> {
    let is_opaque = image.pixels.iter().all(|pixel| pixel[3] >= 1.0);
    let channels = if is_opaque { 3 } else { 4 };
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, image.width, image.height);
    encoder.set_color(if is_opaque {
        png::ColorType::Rgb
    } else {
        png::ColorType::Rgba
    });
    let numbers = image.pixels.iter().flat_map(|pixel| &pixel[..channels]);
    let bytes: Vec<u8> = match depth {
        ImageDepth::Eight => {
            encoder.set_depth(png::BitDepth::Eight);
            numbers.map(|&n| steps(n, 255.0) as u8).collect()
        }
        ImageDepth::Sixteen => {
            encoder.set_depth(png::BitDepth::Sixteen);
            numbers
                .flat_map(|&n| (steps(n, 65535.0) as u16).to_be_bytes())
                .collect()
        }
    };
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(file)
}

/// The colours of an image as an OpenEXR file of single precision numbers.
///
/// # Errors
/// [`ImageError::Exr`].
pub fn exr_bytes(image: &TextureImage) -> Result<Vec<u8>, ImageError> {
    let size = (image.width as usize, image.height as usize);
    let pixel = |Vec2(x, y): Vec2<usize>| {
        let [red, green, blue, _] = image.pixels[y * size.0 + x];
        (red, green, blue)
    };
    let mut file = Vec::new();
    let image = Image::from_channels(size, SpecificChannels::rgb(pixel));
    image.write().to_buffered(Cursor::new(&mut file))?;
    Ok(file)
}

#[allow(clippy::cast_sign_loss, reason = "clamped")]
fn steps(value: f32, most: f32) -> u32 {
    (value.clamp(0.0, 1.0) * most).round() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(alpha: f32) -> TextureImage {
        let pixels = (0..12_u8)
            .map(|k| [f32::from(k) / 11.0, 0.25, 1.0, alpha])
            .collect();
        TextureImage {
            width: 4,
            height: 3,
            pixels,
        }
    }

    #[test]
    fn what_is_written_as_png_is_read_again() {
        for (depth, step) in [(ImageDepth::Eight, 255.0), (ImageDepth::Sixteen, 65535.0)] {
            for alpha in [1.0, 0.5] {
                let image = ramp(alpha);
                let (read, found) = read_png(&png_bytes(&image, depth).unwrap()).unwrap();
                assert_eq!([read.width, read.height], [4, 3]);
                assert_eq!(found, depth);
                for (a, b) in read
                    .pixels
                    .iter()
                    .flatten()
                    .zip(image.pixels.iter().flatten())
                {
                    assert!((a - b).abs() <= 0.5 / step + 1e-6, "{a} {b}");
                }
            }
        }
    }

    #[test]
    fn an_exr_file_holds_values_beyond_one() {
        let mut image = ramp(1.0);
        image.pixels[5] = [-3.5, 1e6, 0.125, 1.0];
        let bytes = exr_bytes(&image).unwrap();
        let read = exr::prelude::read_first_rgba_layer_from_file;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.exr");
        std::fs::write(&path, bytes).unwrap();
        let new = |size: Vec2<usize>, _: &_| vec![[0.0_f32; 3]; size.area()];
        let put =
            |pixels: &mut Vec<[f32; 3]>, at: Vec2<usize>, (r, g, b, _): (f32, f32, f32, f32)| {
                pixels[at.1 * 4 + at.0] = [r, g, b];
            };
        let found = read(&path, new, put).unwrap();
        assert_eq!(found.layer_data.channel_data.pixels[5], [-3.5, 1e6, 0.125]);
    }

    #[test]
    fn what_is_no_png_is_refused_with_a_hint() {
        let error = read_png(b"GIF89a").unwrap_err();
        assert!(error.hint().is_some(), "{error}");
        let mut broken = png_bytes(&ramp(1.0), ImageDepth::Eight).unwrap();
        broken.truncate(broken.len() / 2);
        assert!(read_png(&broken).is_err());
    }
}
