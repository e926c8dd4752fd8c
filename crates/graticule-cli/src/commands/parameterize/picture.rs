//! The picture of periodic coordinates: their lines on the surface and what is singular.

use glam::DVec2;
use graticule::mesh::{FaceId, PerCorner, Surface};
use graticule::periodic::{Parameterization, PhaseTension};
use graticule_draw::{
    Color, ColorMap, ColorScale, DrawError, Figure, IsoLineStyle, Panel, Picture, Points,
    SurfaceStyle, iso_lines, side_by_side, surface,
};

/// Side of a panel in pixels.
const PANEL: u32 = 1280;

/// Where something is singular.
pub(crate) const FIELD_SINGULAR: Color = Color::hex(0x00d6_1f26);
const PHASE_SINGULAR: Color = Color::hex(0x001f_5fd6);
const INVERTED: Color = Color::hex(0x00e6_9f00);

/// The lines on which θ and φ are multiples of π ([PGP06] Figs. 1C, 11, 12): red dots where the
/// field is singular, blue ones where a line ends, orange ones where triangles are inverted.
/// With norms, also those of the periodic variables and their energy (Fig. 5).
pub(super) fn picture(
    shape: &Surface,
    map: &Parameterization,
    with_norms: bool,
) -> Result<Picture, DrawError> {
    let opens = |face: FaceId| !map.kinds[face].closes();
    let mut panel = lines_panel(shape, &map.layout.coordinates, opens)?.with_caption("lines of kπ");
    let singular = &map.singular;
    for (faces, color) in [
        (&singular.inverted_faces, INVERTED),
        (&singular.phase_faces, PHASE_SINGULAR),
        (&singular.field_faces, FIELD_SINGULAR),
    ] {
        panel = panel.with_layer(dots(shape, faces, color));
    }
    let mut panels = vec![panel];
    if with_norms {
        panels.extend(tension_panels(shape, &map.tension)?);
    }
    let width = PANEL * panels.len() as u32;
    side_by_side(panels).with_size(width, PANEL)
}

fn tension_panels(shape: &Surface, tension: &PhaseTension) -> Result<[Panel; 2], DrawError> {
    let panel = |figure: Figure<'_>, map, caption: &str| {
        let style = SurfaceStyle {
            figure: Some(figure.with_scale(ColorScale {
                map,
                ..ColorScale::default()
            })),
            ..SurfaceStyle::default()
        };
        Ok(surface(shape, &style)?.with_caption(caption))
    };
    let norms = Figure::per_vertex("norm", &tension.norms);
    let energies = Figure::per_vertex("energy", &tension.energies);
    Ok([
        panel(norms, ColorMap::Viridis, "least norm of the variables")?,
        panel(energies, ColorMap::YellowRed, "energy")?,
    ])
}

/// The lines on which coordinates are multiples of a half.
pub(crate) fn lines_panel(
    shape: &Surface,
    coordinates: &PerCorner<DVec2>,
    is_left_out: impl Fn(FaceId) -> bool,
) -> Result<Panel, DrawError> {
    let lines = iso_lines(shape, coordinates, is_left_out, &IsoLineStyle::default());
    let panel = surface(shape, &SurfaceStyle::default())?;
    Ok(lines.into_iter().fold(panel, Panel::with_layer))
}

/// A dot on each of these triangles.
pub(crate) fn dots(shape: &Surface, faces: &[FaceId], color: Color) -> Points {
    let middle = |&face: &FaceId| {
        // Thirds first: the sum of three large coordinates could overflow.
        let corners = shape.corner_positions(face);
        corners.iter().map(|&corner| corner / 3.0).sum()
    };
    Points {
        positions: faces.iter().map(middle).collect(),
        color,
        radius: 3.5,
        ring: false,
    }
}
