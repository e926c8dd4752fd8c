//! The picture of a layout: charts in colours, arcs, nodes.

use graticule::charts::{ArcKind, ChartKind, ChartLayout};
use graticule::mesh::Element;
use graticule_draw::{
    Color, DrawError, Layer, Lines, Paint, Panel, Points, SurfaceStyle, View, surface,
};

const NODE: Color = Color::hex(0x0011_1111);
const ARC: Color = Color::hex(0x0011_1111);
const CUT: Color = Color::hex(0x00d6_1f26);
const FEATURE: Color = Color::hex(0x001f_5fd6);

/// How much of a chart's colour is white: regular ones are pale, so that the others stand out.
const PALE: f32 = 0.65;

/// Charts in colours, those that are not regular in stronger ones; arcs in black, cuts in red,
/// features in blue; nodes as dots ([PGP06] Fig. 1D).
pub(super) fn panel(layout: &ChartLayout) -> Result<Panel, DrawError> {
    let style = SurfaceStyle {
        view: View::Automatic,
        ..SurfaceStyle::default()
    };
    let mut panel = surface(layout.surface(), &style)?;
    let colors = layout.chart_of().iter().map(|&chart| {
        let color = Color::of_class(chart.index());
        if layout.chart(chart).kind == ChartKind::Regular {
            color.mix(Color::hex(0x00ff_ffff), PALE)
        } else {
            color
        }
    });
    if let Some(Layer::Triangles(triangles)) = panel.layers.first_mut() {
        triangles.paint = Paint::PerFace(colors.collect());
    }
    for (kinds, color, width) in [
        (&[ArcKind::Line, ArcKind::Boundary][..], ARC, 1.4),
        (&[ArcKind::Feature], FEATURE, 1.8),
        (&[ArcKind::Cut], CUT, 1.8),
    ] {
        let mut lines = Lines::new(color, width);
        for arc in layout.arcs().iter().filter(|arc| kinds.contains(&arc.kind)) {
            lines.push(arc.vertices.iter().map(|&v| layout.surface().position(v)));
        }
        panel = panel.with_layer(lines);
    }
    let nodes = layout.nodes().iter();
    Ok(panel.with_layer(Points {
        positions: nodes.map(|&node| layout.surface().position(node)).collect(),
        color: NODE,
        radius: 2.2,
        ring: false,
    }))
}
