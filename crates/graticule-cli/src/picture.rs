//! Pictures of results.

use std::path::Path;

use glam::DVec2;
use graticule::measure::{MapMeasure, overlapping_faces};
use graticule::mesh::{PerCorner, PerFace, Surface};
use graticule::watch::Watch;
use graticule_draw::{
    CheckerStyle, Color, ColorScale, DrawError, Eye, Figure, LayoutStyle, Lines, Panel, Picture,
    Points, Squares, SurfaceStyle, side_by_side, surface, uv_layout,
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

/// A map: the checker that it lays on the surface, its layout, and how it scales areas. The
/// layout marks triangles that are flipped or overlap others.
pub(crate) fn map_picture(
    shape: &Surface,
    uvs: &PerCorner<DVec2>,
    measure: &MapMeasure,
    watch: &Watch,
) -> Result<Picture, Failure> {
    Ok(in_rows_of_three(map_panels(shape, uvs, measure, watch)?)?)
}

/// Panels three in a row.
pub(crate) fn in_rows_of_three(panels: Vec<Panel>) -> Result<Picture, DrawError> {
    let rows = panels.len().div_ceil(3) as u32;
    let picture = side_by_side(panels).with_columns(3);
    picture.with_size(3 * PANEL, rows * PANEL)
}

/// The panels of [`map_picture`].
pub(crate) fn map_panels(
    shape: &Surface,
    uvs: &PerCorner<DVec2>,
    measure: &MapMeasure,
    watch: &Watch,
) -> Result<Vec<Panel>, Failure> {
    let on_surface = SurfaceStyle {
        checker: Some(CheckerStyle::fitting(uvs)),
        seams: Some(uvs),
        ..SurfaceStyle::default()
    };
    let flipped = measure.elements.distortion.map(|face| face.flipped);
    let overlapping = if measure.overlap.any {
        Some(overlapping_faces(shape, uvs, watch)?)
    } else {
        None
    };
    let layout = LayoutStyle {
        checker: Some(Squares::Fitting),
        edges: false,
        flipped: Some(&flipped),
        overlapping: overlapping.as_ref(),
        ..LayoutStyle::default()
    };
    Ok(vec![
        surface(shape, &on_surface)?,
        uv_layout(shape, uvs, &layout)?,
        area_panel(shape, measure)?,
    ])
}

/// How a map scales areas, on the surface.
pub(crate) fn area_panel(shape: &Surface, measure: &MapMeasure) -> Result<Panel, DrawError> {
    let scales = area_scales(measure);
    let figure = Figure::per_face("area scale, log2", &scales);
    let distortion = SurfaceStyle {
        figure: Some(figure.with_scale(ColorScale::diverging(0.0))),
        ..SurfaceStyle::default()
    };
    surface(shape, &distortion)
}

/// A curve over its frame, both stretched to fit; `marked` is a point of it. Values are drawn by
/// their logarithms where all are above 0.
pub(crate) fn curve_panel(curve: &[[f64; 2]], marked: [f64; 2], caption: &str) -> Panel {
    let positive = curve.iter().all(|point| point[1] > 0.0) && marked[1] > 0.0;
    let level = |value: f64| if positive { libm::log10(value) } else { value };
    let points: Vec<DVec2> = curve
        .iter()
        .map(|&[x, y]| DVec2::new(x, level(y)))
        .collect();
    let marked = DVec2::new(marked[0], level(marked[1]));
    let all = points.iter().chain([&marked]);
    let (low, high) = all.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
        (low.min(*p), high.max(*p))
    });
    let extent = (high - low).map(|side| if side > 0.0 { side } else { 1.0 });
    let frame = DVec2::new(1.25, 1.0);
    let placed = |p: &DVec2| ((*p - low) / extent * frame).extend(0.0);
    let mut axes = Lines::new(Color::INK, 1.6);
    let corners = [
        DVec2::ZERO,
        frame * DVec2::X,
        frame,
        frame * DVec2::Y,
        DVec2::ZERO,
    ];
    axes.push(corners.map(|corner| corner.extend(0.0)));
    let mut line = Lines::new(Color::INK, 3.0);
    line.push(points.iter().map(placed));
    let dot = Points {
        positions: vec![placed(&marked)],
        color: Color::FLIPPED,
        radius: 9.0,
        ring: false,
    };
    Panel::new(Eye::Plane, vec![axes.into(), line.into(), dot.into()]).with_caption(caption)
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
