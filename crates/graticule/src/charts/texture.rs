//! Textures of the input re-sampled into an atlas.

use glam::DVec2;
use rayon::prelude::*;
use serde::Serialize;

use super::atlas::{ChartAtlas, UDIM_COLUMNS};
use super::chart_map::ChartMaps;
use super::texture_normals::TangentTurn;
use super::texture_raster::{RasterPoint, TriangleRaster};
use crate::mesh::{Element, PerCorner, Surface, SurfacePoint};
use crate::watch::{Stopped, Watch};

/// Most samples along each side of a texel.
const MOST_SAMPLES: f64 = 8.0;

/// An image: red, green, blue and opacity in `0.0..=1.0`, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextureImage {
    /// Pixels along a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The pixels.
    pub pixels: Vec<[f32; 4]>,
}

/// What the numbers of a texture are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TextureKind {
    /// Colours as sRGB has them: blended as light is.
    #[default]
    Color,
    /// Numbers, blended as they are.
    Data,
    /// Normals in the frame of the texture's directions, as 0.5 + 0.5 n: turned into the atlas's
    /// directions.
    TangentNormals,
}

/// A texture on the input.
#[derive(Clone, Copy, Debug)]
pub struct SourceTexture<'a> {
    /// The surface that the layout was made from.
    pub input: &'a Surface,
    /// Its texture coordinates, where a corner has some. The image repeats with period 1.
    pub uvs: &'a PerCorner<Option<DVec2>>,
    /// The image.
    pub image: &'a TextureImage,
    /// What its numbers are.
    pub kind: TextureKind,
}

/// How textures are re-sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct TextureOptions {
    /// Texels along the side of a tile.
    pub resolution: u32,
    /// Texels that colours are carried over the borders of squares: half the padding or more keeps
    /// the gaps out of sight.
    pub bleed: u32,
}

/// The image of each tile of an atlas, with what the texture has at the same points of the surface.
///
/// Several samples are taken of each texel, the more the finer the texture is than the atlas. Texels
/// of squares without texture coordinates, and those far from any square, are transparent black.
///
/// Cost: linear in the triangles and in the samples; rows are sampled in parallel.
///
/// # Errors
/// [`Stopped`].
pub fn transfer_texture(
    maps: &ChartMaps,
    atlas: &ChartAtlas,
    source: &SourceTexture<'_>,
    options: &TextureOptions,
    watch: &Watch,
) -> Result<Vec<TextureImage>, Stopped> {
    let _stage = watch.stage("texture");
    let transfer = Transfer {
        maps,
        atlas,
        source,
        samples: samples_per_side(maps, atlas, source, *options),
        resolution: options.resolution.max(1),
    };
    let mut images = Vec::new();
    for tile in 0..atlas.tiles {
        watch.check()?;
        watch.progress(f64::from(tile) / f64::from(atlas.tiles));
        let mut image = transfer.tile(tile, watch)?;
        bleed(&mut image, options.bleed);
        if source.kind == TextureKind::Color {
            image
                .pixels
                .par_iter_mut()
                .for_each(|pixel| *pixel = pixel_of(*pixel, encoded));
        }
        images.push(image);
    }
    Ok(images)
}

/// Samples along the side of a texel: two, or one for each pixel of the source there.
#[allow(clippy::cast_sign_loss, reason = "clamped")]
fn samples_per_side(
    maps: &ChartMaps,
    atlas: &ChartAtlas,
    source: &SourceTexture<'_>,
    options: TextureOptions,
) -> u32 {
    let mesh = source.input.mesh();
    let area = |corners: [Option<DVec2>; 3]| match corners {
        [Some(a), Some(b), Some(c)] => 0.5 * (b - a).perp_dot(c - a).abs(),
        _ => 0.0,
    };
    let faces = mesh
        .faces()
        .map(|face| area(face.halfedges().map(|c| source.uvs[c])));
    let pixels = f64::from(source.image.width) * f64::from(source.image.height);
    let have = faces.sum::<f64>() * pixels;
    let placed = atlas
        .placements
        .iter()
        .zip(maps.squares())
        .map(|(p, _)| p.size.x * p.size.y);
    let texels = placed.sum::<f64>() * f64::from(options.resolution).powi(2);
    (have / texels.max(1.0))
        .sqrt()
        .ceil()
        .clamp(2.0, MOST_SAMPLES) as u32
}

struct Transfer<'a> {
    maps: &'a ChartMaps,
    atlas: &'a ChartAtlas,
    source: &'a SourceTexture<'a>,
    samples: u32,
    resolution: u32,
}

impl Transfer<'_> {
    /// The image of a tile, blended as light is.
    fn tile(&self, tile: u32, watch: &Watch) -> Result<TextureImage, Stopped> {
        let corner = DVec2::new(
            f64::from(tile % UDIM_COLUMNS),
            f64::from(tile / UDIM_COLUMNS),
        );
        let faces = self.maps.square_of().enumerate();
        let faces = faces.filter(|(_, s)| self.atlas.placements[s.index()].tile == tile);
        let faces: Vec<_> = faces.map(|(face, _)| face).collect();
        let (side, samples) = (self.resolution, self.samples);
        let mut pixels = vec![[0.0; 4]; side as usize * side as usize];
        // A band of rows at a time: samples of all would need much memory.
        let rows = (1_u32 << 22)
            .div_ceil(side * samples * samples)
            .clamp(1, side);
        for first in (0..side).step_by(rows as usize) {
            watch.check()?;
            let count = rows.min(side - first);
            let mut raster = TriangleRaster::new(side * samples, count * samples);
            let scale = f64::from(side * samples);
            let top = f64::from(first * samples);
            for &face in &faces {
                let [a, b, c] = face.halfedges().map(|corner| self.atlas.corner_uv[corner]);
                let point = |uv: DVec2| {
                    let place = uv - corner;
                    DVec2::new(place.x * scale - 0.5, (1.0 - place.y) * scale - 0.5 - top)
                };
                raster.draw(face, [a, c, b].map(point));
            }
            let points = raster.into_points();
            let band = &mut pixels[(first * side) as usize..((first + count) * side) as usize];
            band.par_iter_mut().enumerate().for_each(|(index, pixel)| {
                *pixel = self.texel(&points, index);
            });
        }
        Ok(TextureImage {
            width: side,
            height: side,
            pixels,
        })
    }

    /// The mean of the samples in a texel of a band.
    fn texel(&self, points: &[Option<RasterPoint>], index: usize) -> [f32; 4] {
        let (side, samples) = (self.resolution as usize, self.samples as usize);
        let (x, y) = (index % side, index / side);
        let mut sum = [0.0_f32; 4];
        let mut count = 0.0;
        for row in 0..samples {
            for column in 0..samples {
                let place = (y * samples + row) * side * samples + x * samples + column;
                if let Some(value) = points[place].and_then(|point| self.sample(point)) {
                    sum.iter_mut()
                        .zip(value)
                        .for_each(|(sum, part)| *sum += part);
                    count += 1.0;
                }
            }
        }
        if count > 0.0 {
            sum.map(|part| part / count)
        } else {
            sum
        }
    }

    /// What the source has at a point of the atlas; `None` without texture coordinates there.
    fn sample(&self, point: RasterPoint) -> Option<[f32; 4]> {
        let [a, c, b] = point.weights;
        let on_atlas = SurfacePoint {
            face: point.face,
            barycentric: [a, b, c],
        };
        let original = self.source.input.mesh();
        let on_input = self.maps.refined().to_original(original, on_atlas)?;
        let uv = self.source_uv(on_input)?;
        let value = self
            .source
            .image
            .sample(uv, self.source.kind == TextureKind::Color);
        if self.source.kind != TextureKind::TangentNormals {
            return Some(value);
        }
        let turn = TangentTurn::between(
            self.source,
            on_input.face,
            self.maps,
            self.atlas,
            point.face,
        );
        Some(turn?.apply(value))
    }

    fn source_uv(&self, point: SurfacePoint) -> Option<DVec2> {
        let [Some(a), Some(b), Some(c)] = point.face.halfedges().map(|c| self.source.uvs[c]) else {
            return None;
        };
        Some(point.interpolate([a, b, c]))
    }
}

impl TextureImage {
    /// The value at texture coordinates, blended between the four nearest pixels; repeats with
    /// period 1.
    fn sample(&self, uv: DVec2, is_color: bool) -> [f32; 4] {
        let size = DVec2::new(f64::from(self.width), f64::from(self.height));
        let place = DVec2::new(uv.x, 1.0 - uv.y) * size - 0.5;
        let low = place.floor();
        let share = (place - low).as_vec2();
        let pixel = |dx: f64, dy: f64| {
            let pixel = self.pixel(low + DVec2::new(dx, dy));
            if is_color {
                pixel_of(pixel, linear)
            } else {
                pixel
            }
        };
        let blend = |a: [f32; 4], b: [f32; 4], share: f32| {
            [0, 1, 2, 3].map(|k| a[k] + (b[k] - a[k]) * share)
        };
        let upper = blend(pixel(0.0, 0.0), pixel(1.0, 0.0), share.x);
        let lower = blend(pixel(0.0, 1.0), pixel(1.0, 1.0), share.x);
        blend(upper, lower, share.y)
    }

    #[allow(clippy::cast_sign_loss, reason = "a remainder is not negative")]
    fn pixel(&self, place: DVec2) -> [f32; 4] {
        let wrapped = |x: f64, count: u32| x.rem_euclid(f64::from(count)) as usize;
        let x = wrapped(place.x, self.width).min(self.width as usize - 1);
        let y = wrapped(place.y, self.height).min(self.height as usize - 1);
        self.pixels[y * self.width as usize + x]
    }
}

/// A pixel with a function applied to its colours, not to its opacity.
fn pixel_of([red, green, blue, alpha]: [f32; 4], function: impl Fn(f32) -> f32) -> [f32; 4] {
    [function(red), function(green), function(blue), alpha]
}

/// Light from an sRGB value (IEC 61966-2-1).
fn linear(value: f32) -> f32 {
    if value <= 0.040_45 {
        value / 12.92
    } else {
        libm::powf((value + 0.055) / 1.055, 2.4)
    }
}

/// An sRGB value from light.
fn encoded(light: f32) -> f32 {
    if light <= 0.003_130_8 {
        light * 12.92
    } else {
        1.055 * libm::powf(light, 1.0 / 2.4) - 0.055
    }
}

/// Carries colours over the borders of what is covered, step by step.
fn bleed(image: &mut TextureImage, steps: u32) {
    let (width, height) = (image.width as usize, image.height as usize);
    for _ in 0..steps {
        let before = &image.pixels;
        let filled = |x: usize, y: usize| {
            let pixel = before[y * width + x];
            if pixel[3] > 0.0 {
                return pixel;
            }
            let (xs, ys) = (
                x.saturating_sub(1)..(x + 2).min(width),
                y.saturating_sub(1)..(y + 2).min(height),
            );
            let mut sum = [0.0_f32; 4];
            let mut count = 0.0;
            for near in ys.flat_map(|y| xs.clone().map(move |x| before[y * width + x])) {
                if near[3] > 0.0 {
                    sum.iter_mut()
                        .zip(near)
                        .for_each(|(sum, part)| *sum += part);
                    count += 1.0;
                }
            }
            if count > 0.0 {
                sum.map(|part| part / count)
            } else {
                pixel
            }
        };
        let after = (0..width * height)
            .into_par_iter()
            .map(|i| filled(i % width, i / width));
        image.pixels = after.collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_and_srgb_are_inverse_to_each_other() {
        for step in 0..=100_u8 {
            let value = f32::from(step) / 100.0;
            assert!((encoded(linear(value)) - value).abs() < 1e-6);
        }
    }

    #[test]
    fn a_sample_at_the_middle_of_a_pixel_is_the_pixel_and_images_repeat() {
        let pixels = (0..6_u8)
            .map(|k| [f32::from(k) / 8.0, 0.0, 0.0, 1.0])
            .collect();
        let image = TextureImage {
            width: 3,
            height: 2,
            pixels,
        };
        let middle = |x: f64, y: f64| DVec2::new((x + 0.5) / 3.0, 1.0 - 0.5 * (y + 0.5));
        assert!((image.sample(middle(1.0, 0.0), false)[0] - 0.125).abs() < 1e-6);
        assert!((image.sample(middle(2.0, 1.0), false)[0] - 0.625).abs() < 1e-6);
        let shifted = middle(2.0, 1.0) + DVec2::new(-3.0, 5.0);
        assert!((image.sample(shifted, false)[0] - 0.625).abs() < 1e-6);
        let between = image.sample(middle(2.5, 0.0), false)[0];
        assert!((between - 0.125).abs() < 1e-6, "{between}");
    }

    #[test]
    fn colours_bleed_as_far_as_they_are_asked_to() {
        let mut image = TextureImage {
            width: 7,
            height: 1,
            pixels: vec![[0.0; 4]; 7],
        };
        image.pixels[3] = [0.5, 0.25, 1.0, 1.0];
        bleed(&mut image, 2);
        let bits = |pixel: usize| image.pixels[pixel].map(f32::to_bits);
        assert_eq!(bits(1), bits(3));
        assert_eq!(bits(0), [0; 4]);
    }
}
