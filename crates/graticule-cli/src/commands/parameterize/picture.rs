//! The picture of periodic coordinates: their lines on the surface and what is singular.

use graticule::mesh::{FaceId, Surface};
use graticule::periodic::Parameterization;
use graticule_draw::{
    Color, DrawError, IsoLineStyle, Picture, Points, SurfaceStyle, View, iso_lines, side_by_side,
    surface,
};

/// Side of a panel in pixels.
const PANEL: u32 = 1280;

const FIELD_SINGULAR: Color = Color::hex(0x00d6_1f26);
const PHASE_SINGULAR: Color = Color::hex(0x001f_5fd6);
const INVERTED: Color = Color::hex(0x00e6_9f00);

/// The lines on which θ and φ are multiples of π ([PGP06] Figs. 1C, 11, 12): red dots where the
/// field is singular, blue ones where a line ends, orange ones where triangles are inverted.
pub(super) fn picture(shape: &Surface, map: &Parameterization) -> Result<Picture, DrawError> {
    let style = SurfaceStyle {
        view: View::Automatic,
        ..SurfaceStyle::default()
    };
    let mut panel = surface(shape, &style)?.with_caption("lines of kπ");
    let opens = |face: FaceId| !map.kinds[face].closes();
    let lines = iso_lines(
        shape,
        &map.layout.coordinates,
        opens,
        &IsoLineStyle::default(),
    );
    for lines in lines {
        panel = panel.with_layer(lines);
    }
    let singular = &map.singular;
    for (faces, color) in [
        (&singular.inverted_faces, INVERTED),
        (&singular.phase_faces, PHASE_SINGULAR),
        (&singular.field_faces, FIELD_SINGULAR),
    ] {
        let middle = |&face: &FaceId| {
            // Thirds first: the sum of three large coordinates could overflow.
            let corners = shape.corner_positions(face);
            corners.iter().map(|&corner| corner / 3.0).sum()
        };
        panel = panel.with_layer(Points {
            positions: faces.iter().map(middle).collect(),
            color,
            radius: 3.5,
            ring: false,
        });
    }
    side_by_side(vec![panel]).with_size(PANEL, PANEL)
}
