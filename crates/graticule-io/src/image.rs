//! Images: PNG, and `OpenEXR` for values of any size.

use std::io::Cursor;

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
            Self::Encoding(_) => None,
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

/// The colours of an image as an `OpenEXR` file of single precision numbers: one part in scan lines, not
/// compressed ([`OpenEXR` file layout](https://openexr.com/en/latest/OpenEXRFileLayout.html)).
#[must_use]
pub fn exr_bytes(image: &TextureImage) -> Vec<u8> {
    let mut file = exr_header(image.width, image.height);
    let (width, height) = (image.width as usize, image.height as usize);
    let line = 4 * CHANNELS.len() * width;
    let first = file.len() + 8 * height;
    for row in 0..height {
        file.extend(((first + row * (8 + line)) as u64).to_le_bytes());
    }
    for (row, pixels) in (0_u32..).zip(image.pixels.chunks_exact(width.max(1))) {
        file.extend(row.to_le_bytes());
        file.extend((line as u32).to_le_bytes());
        for (_, channel) in CHANNELS {
            file.extend(pixels.iter().flat_map(|pixel| pixel[channel].to_le_bytes()));
        }
    }
    file
}

/// The channels in the order of the file, by name, and where a pixel has them.
const CHANNELS: [(&str, usize); 3] = [("B", 2), ("G", 1), ("R", 0)];

fn exr_header(width: u32, height: u32) -> Vec<u8> {
    const SINGLE_PRECISION: u32 = 2;
    let mut header = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        for text in [name, kind] {
            header.extend(text.as_bytes());
            header.push(0);
        }
        header.extend((value.len() as u32).to_le_bytes());
        header.extend(value);
    };
    let mut channels = Vec::new();
    for (name, _) in CHANNELS {
        channels.extend(name.as_bytes());
        channels.push(0);
        // The kind of number, one byte of hints and three of padding, a sample for each pixel.
        for number in [SINGLE_PRECISION, 0, 1, 1] {
            channels.extend(number.to_le_bytes());
        }
    }
    channels.push(0);
    let corners = [0, 0, width.max(1) - 1, height.max(1) - 1];
    let window = corners.map(u32::to_le_bytes).concat();
    attribute("channels", "chlist", &channels);
    attribute("compression", "compression", &[0]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1.0_f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1.0_f32.to_le_bytes());
    header.push(0);
    header
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
    fn an_exr_file_holds_values_beyond_one_where_its_table_says() {
        let mut image = ramp(1.0);
        image.pixels[5] = [-3.5, 1e6, 0.125, 1.0];
        let bytes = exr_bytes(&image);
        let at = |place: usize| -> [u8; 4] { bytes[place..place + 4].try_into().unwrap() };
        let table = exr_header(4, 3).len();
        let second = u32::from_le_bytes(at(table + 8)) as usize;
        assert_eq!(
            [at(second), at(second + 4)],
            [1_u32, 48].map(u32::to_le_bytes)
        );
        let found = [2, 1, 0].map(|channel| f32::from_le_bytes(at(second + 8 + 16 * channel + 4)));
        assert_eq!(
            found.map(f32::to_bits),
            [-3.5_f32, 1e6, 0.125].map(f32::to_bits)
        );
        assert_eq!(bytes.len(), second + 2 * (8 + 48));
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
