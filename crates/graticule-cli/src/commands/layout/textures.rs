//! Images of an atlas: textures of the input, and geometry images.

use std::path::{Path, PathBuf};

use glam::DVec3;
use graticule::charts::{
    ChartAtlas, ChartMaps, GeometryImage, SourceTexture, TextureImage, TextureKind, TextureOptions,
    geometry_images, transfer_texture,
};
use graticule_io::{ImageDepth, exr_bytes, png_bytes, read_png};
use serde_json::json;

use super::atlas::AtlasInput;
use super::atlas_options::{AtlasArguments, GeometryFormat};
use crate::failure::Failure;
use crate::session::Session;
use crate::uvs;

/// A file to be written with its content.
type File = (PathBuf, Vec<u8>);

/// The images that were asked for.
pub(super) fn files(
    arguments: &AtlasArguments,
    atlas_input: &AtlasInput<'_>,
    maps: &ChartMaps,
    atlas: &ChartAtlas,
    session: &Session,
) -> Result<Vec<File>, Failure> {
    let mut files = Vec::new();
    let textures = Textures {
        arguments,
        atlas_input,
        maps,
        atlas,
        session,
    };
    for (names, kind) in [
        (&arguments.texture, TextureKind::Color),
        (&arguments.normal_map, TextureKind::TangentNormals),
    ] {
        if let Some(names) = names {
            files.extend(textures.transferred(&names[0], &names[1], kind)?);
        }
    }
    if let Some(folder) = &arguments.geometry_images {
        let images = geometry_images(maps, arguments.geometry_side, &session.watch)?;
        let low_and_high = maps.surface().bounding_box();
        files.extend(geometry(
            folder,
            &images,
            low_and_high,
            arguments.geometry_format,
        )?);
    }
    Ok(files)
}

struct Textures<'a> {
    arguments: &'a AtlasArguments,
    atlas_input: &'a AtlasInput<'a>,
    maps: &'a ChartMaps,
    atlas: &'a ChartAtlas,
    session: &'a Session,
}

impl Textures<'_> {
    /// The image for each tile.
    fn transferred(&self, from: &Path, to: &Path, kind: TextureKind) -> Result<Vec<File>, Failure> {
        let at_image = |failure: Failure| failure.at(from.display());
        let Some(set) = self.atlas_input.soup.attributes.uv_sets.first() else {
            return Err(Failure::new(
                "the mesh has no texture coordinates that an image could belong to",
                "leave --texture and --normal-map out",
            ));
        };
        let bytes = std::fs::read(from).map_err(|error| {
            at_image(Failure::new(
                error.to_string(),
                "check the name and the rights to the file",
            ))
        })?;
        let (image, depth) = read_png(&bytes).map_err(|error| at_image(error.into()))?;
        let source = SourceTexture {
            input: &self.atlas_input.repaired.surface,
            uvs: &uvs::of_surface(self.atlas_input.repaired, set),
            image: &image,
            kind,
        };
        let options = TextureOptions {
            resolution: self.arguments.resolution,
            bleed: self.arguments.padding.div_ceil(2),
        };
        let watch = &self.session.watch;
        let tiles = transfer_texture(self.maps, self.atlas, &source, &options, watch)?;
        let count = tiles.len();
        let file = |(tile, image): (usize, TextureImage)| {
            let name = if count == 1 {
                to.to_path_buf()
            } else {
                tile_name(to, tile)
            };
            Ok((name, png_bytes(&image, depth)?))
        };
        tiles.into_iter().enumerate().map(file).collect()
    }
}

/// The name with the UDIM number of a tile before its ending.
fn tile_name(name: &Path, tile: usize) -> PathBuf {
    let ending = name
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    name.with_extension(format!("{}.{ending}", 1001 + tile))
}

/// Two images for each square, and what the numbers of positions mean.
fn geometry(
    folder: &Path,
    images: &[GeometryImage],
    [low, high]: [DVec3; 2],
    format: GeometryFormat,
) -> Result<Vec<File>, Failure> {
    let extent = (high - low).max_element();
    let pixel = |value: DVec3| [value.x as f32, value.y as f32, value.z as f32, 1.0];
    let image = |side: u32, values: &[DVec3], change: &dyn Fn(DVec3) -> DVec3| TextureImage {
        width: side,
        height: side,
        pixels: values.iter().map(|&value| pixel(change(value))).collect(),
    };
    let mut files = Vec::new();
    for (number, square) in images.iter().enumerate() {
        let name =
            |what: &str, ending: &str| folder.join(format!("square_{number:05}_{what}.{ending}"));
        let side = square.side;
        match format {
            GeometryFormat::Png => {
                let within = |p: DVec3| (p - low) / extent;
                let upward = |n: DVec3| 0.5 * n + 0.5;
                let positions = image(side, &square.positions, &within);
                let normals = image(side, &square.normals, &upward);
                files.push((
                    name("positions", "png"),
                    png_bytes(&positions, ImageDepth::Sixteen)?,
                ));
                files.push((
                    name("normals", "png"),
                    png_bytes(&normals, ImageDepth::Sixteen)?,
                ));
            }
            GeometryFormat::Exr => {
                let positions = image(side, &square.positions, &|p| p);
                let normals = image(side, &square.normals, &|n| n);
                files.push((name("positions", "exr"), exr_bytes(&positions)));
                files.push((name("normals", "exr"), exr_bytes(&normals)));
            }
        }
    }
    let meaning = json!({
        "squares": images.len(),
        "png_position": { "low": low.to_array(), "extent": extent, "is": "low + extent * value" },
        "png_normal": "2 * value - 1",
        "rows": "from the second axis's 1 down to 0, the border included",
    });
    files.push((
        folder.join("geometry_images.json"),
        format!("{meaning:#}\n").into_bytes(),
    ));
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_have_the_names_that_other_programs_look_for() {
        assert_eq!(
            tile_name(Path::new("a/skin.png"), 11),
            Path::new("a/skin.1012.png")
        );
    }
}
