//! Pictures of results.

use std::path::Path;

use glam::DVec2;
use graticule::measure::MapMeasure;
use graticule::mesh::{PerCorner, PerFace, Surface};
use graticule_draw::{
    CheckerStyle, ColorScale, DrawError, Figure, LayoutStyle, Picture, Squares, SurfaceStyle,
    side_by_side, surface, uv_layout,
};

use crate::failure::Failure;
use crate::output::extension;

/// Width and height of a panel in pixels.
pub(crate) const PANEL: u32 = 560;

/// How a picture is encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    Png,
    Svg,
}

impl PictureFormat {
    /// The format that the ending of the file's name asks for.
    pub(crate) fn of(path: &Path) -> Result<Self, Failure> {
        match extension(path).as_str() {
            "png" => Ok(Self::Png),
            "svg" => Ok(Self::Svg),
            other => Err(Failure::usage(
                format!(
                    "a picture cannot be written as '{other}' ({})",
                    path.display()
                ),
                "end its name in .png or .svg",
            )),
        }
    }

    /// The bytes of the picture's file.
    pub(crate) fn encode(self, picture: &Picture) -> Vec<u8> {
        match self {
            Self::Png => picture.to_png(),
            Self::Svg => picture.to_svg().into_bytes(),
        }
    }
}

/// The surface with its edges.
pub(crate) fn surface_picture(shape: &Surface) -> Result<Picture, DrawError> {
    let style = SurfaceStyle {
        edges: true,
        ..SurfaceStyle::default()
    };
    side_by_side(vec![surface(shape, &style)?]).with_size(PANEL * 2, PANEL * 2)
}

/// A map: the checker that it lays on the surface, its layout, and how it scales areas.
pub(crate) fn map_picture(
    shape: &Surface,
    uvs: &PerCorner<DVec2>,
    measure: &MapMeasure,
) -> Result<Picture, DrawError> {
    let on_surface = SurfaceStyle {
        checker: Some(CheckerStyle::fitting(uvs)),
        seams: Some(uvs),
        ..SurfaceStyle::default()
    };
    let flipped = measure.elements.distortion.map(|face| face.flipped);
    let layout = LayoutStyle {
        checker: Some(Squares::Fitting),
        edges: false,
        flipped: Some(&flipped),
        ..LayoutStyle::default()
    };
    let scales = area_scales(measure);
    let figure = Figure::per_face("area scale, log2", &scales);
    let distortion = SurfaceStyle {
        figure: Some(figure.with_scale(ColorScale::diverging(0.0))),
        ..SurfaceStyle::default()
    };
    side_by_side(vec![
        surface(shape, &on_surface)?,
        uv_layout(shape, uvs, &layout)?,
        surface(shape, &distortion)?,
    ])
    .with_size(3 * PANEL, PANEL)
}

/// The factor by which the map changes each triangle's area, over that of the whole, as a
/// logarithm to base 2; NaN, which is drawn as missing, where there is none.
fn area_scales(measure: &MapMeasure) -> PerFace<f64> {
    let whole = measure.faces.uv_area / measure.faces.surface_area;
    measure
        .elements
        .distortion
        .map(|face| match face.area_scale() {
            Some(scale) => libm::log2(scale / whole),
            None => f64::NAN,
        })
}
