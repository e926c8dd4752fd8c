//! The pictures on the road from a surface to its atlas ([PGP06] Fig. 1).

use glam::DVec3;
use graticule::charts::{ArcKind, BaseComplex, ChartId, ChartKind, ChartLayout, LaidOut};
use graticule::mesh::{Element, FaceId, Surface};
use graticule_draw::{
    Color, DrawError, Layer, Lines, Paint, Panel, Points, Shading, SurfaceStyle, Triangles, surface,
};

use crate::commands::field::{self, Drawing};
use crate::commands::parameterize::{FIELD_SINGULAR, dots, lines_panel};
use crate::failure::Failure;

const NODE: Color = Color::hex(0x0011_1111);
const ARC: Color = Color::hex(0x0011_1111);
const CUT: Color = Color::hex(0x00d6_1f26);
const FEATURE: Color = Color::hex(0x001f_5fd6);

/// How much of a chart's colour is white: regular ones are pale, so that the others stand out.
const PALE: f32 = 0.65;

/// The surface with its field, the lines of the map, the charts, and the base complex.
pub(crate) fn panels(
    shape: &Surface,
    found: &LaidOut,
    complex: &BaseComplex,
) -> Result<Vec<Panel>, Failure> {
    let field = field::panel(shape, &found.field, Drawing::Streamlines)?;
    let charts = charts_panel(&found.layout)?;
    let complex = complex_panel(&found.layout, complex, &charts);
    Ok(vec![
        field.with_caption("A: the surface and its field"),
        map_panel(shape, found)?.with_caption("B: the lines of the map"),
        charts.with_caption("C: charts"),
        complex.with_caption("D: the base complex"),
    ])
}

/// The lines of the map, and dots where it is singular.
fn map_panel(shape: &Surface, found: &LaidOut) -> Result<Panel, DrawError> {
    let is_left_out = |face: FaceId| found.map.is_left_out(face);
    let faces = shape.mesh().faces();
    let singular: Vec<FaceId> = faces.filter(|&face| is_left_out(face)).collect();
    let panel = lines_panel(shape, found.map.coordinates(), is_left_out)?;
    Ok(panel.with_layer(dots(shape, &singular, FIELD_SINGULAR)))
}

/// The colour of a chart, pale if it is regular.
fn chart_color(layout: &ChartLayout, chart: ChartId) -> Color {
    let color = Color::of_class(chart.index());
    if layout.chart(chart).kind == ChartKind::Regular {
        color.mix(Color::hex(0x00ff_ffff), PALE)
    } else {
        color
    }
}

/// The charts as flat fans round their middles, seen as in another panel.
fn complex_panel(layout: &ChartLayout, complex: &BaseComplex, seen_as: &Panel) -> Panel {
    let mesh = &complex.mesh;
    let mut positions = mesh.positions.clone();
    let (mut triangles, mut colors) = (Vec::new(), Vec::new());
    let mut edges = Lines::new(ARC, 1.4);
    for chart in 0..mesh.polygons.len() {
        let corners = mesh.polygons.vertices(chart);
        let share = 1.0 / corners.len() as f64;
        let places = corners
            .iter()
            .map(|&corner| mesh.positions[corner as usize]);
        let middle = positions.len() as u32;
        positions.push(places.clone().map(|place| place * share).sum());
        edges.push(places.clone().chain(places.clone().take(1)));
        for (&from, &to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            triangles.push([from, to, middle]);
            colors.push(chart_color(layout, ChartId::from_index(chart)));
        }
    }
    let fans = Triangles {
        positions,
        triangles,
        paint: Paint::PerFace(colors),
        checker: None,
        shading: Shading::Flat,
    };
    let nodes = mesh.positions.clone();
    Panel::new(seen_as.eye, vec![fans.into(), edges.into()]).with_layer(node_dots(nodes))
}

fn node_dots(positions: Vec<DVec3>) -> Points {
    Points {
        positions,
        color: NODE,
        radius: 2.2,
        ring: false,
    }
}

/// Charts in colours, those that are not regular in stronger ones; arcs in black, cuts in red,
/// features in blue; nodes as dots ([PGP06] Fig. 1D).
fn charts_panel(layout: &ChartLayout) -> Result<Panel, DrawError> {
    let mut panel = surface(layout.surface(), &SurfaceStyle::default())?;
    let colors = (layout.chart_of().iter()).map(|&chart| chart_color(layout, chart));
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
    let positions = nodes.map(|&node| layout.surface().position(node));
    Ok(panel.with_layer(node_dots(positions.collect())))
}
