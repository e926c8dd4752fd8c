//! Measures of quad meshes as text, as part of the report, and as a picture.

use std::fmt::Write;

use graticule::measure::{LineCarrying, QuadMeasure, ReferenceMeasure};
use graticule::mesh::{PerFace, PolygonSoup, Repaired};
use graticule_draw::{
    Color, ColorScale, DrawError, Figure, Lines, Panel, Points, Range, SurfaceStyle, surface,
};

use crate::tables::{Table, counted, figure};

const FEWER_EDGES: Color = Color::hex(0x001f_5fd6);
const MORE_EDGES: Color = Color::hex(0x00d6_1f26);

/// What is worth knowing of a quad mesh at a glance.
pub(crate) fn quad_table(measure: &QuadMeasure, reference: Option<&ReferenceMeasure>) -> Table {
    let mut table = Table::new();
    connection_rows(&mut table, measure);
    shape_rows(&mut table, measure);
    if let Some(reference) = reference {
        reference_rows(&mut table, reference);
    }
    table
}

fn percent(share: f64) -> String {
    format!("{} %", figure(100.0 * share))
}

fn connection_rows(table: &mut Table, measure: &QuadMeasure) {
    let polygons = &measure.polygons;
    let mut text = format!(
        "{}: {} quads ({}, {} of the area), {} triangles, {} larger",
        polygons.total,
        polygons.quads,
        percent(polygons.quad_share),
        percent(polygons.quad_area_share),
        polygons.triangles,
        polygons.larger
    );
    if polygons.left_out > 0 {
        let _ = write!(text, ", {} that span no face", polygons.left_out);
    }
    table.row("polygons", text);
    let connections = &measure.connections;
    let components = counted(connections.components, "component", "components");
    let loops = counted(
        connections.boundary_loops,
        "boundary loop",
        "boundary loops",
    );
    let characteristic = connections.euler_characteristic;
    let text = format!("{components}, {loops}, Euler characteristic {characteristic}");
    table.row("topology", text);
    table.row("sound", soundness(measure));
    let valences = &measure.valences;
    let share = percent(valences.irregular_share);
    let inside = valences.irregular_inside;
    let text = format!("{} ({share}), {inside} inside", valences.irregular);
    table.row("irregular vertices", text);
    let strips = &measure.strips;
    let text = format!(
        "{}: {} closed, longest {}, {} self-crossing, {} spirals",
        strips.count, strips.closed, strips.longest, strips.self_crossing, strips.spiral
    );
    table.row("rows of quads", text);
}

/// Whether the mesh is sound, or every reason why it is not.
fn soundness(measure: &QuadMeasure) -> String {
    let connections = &measure.connections;
    let inverted = measure
        .quality
        .map_or(0, |q| q.scaled_jacobian.non_positive);
    let reasons: Vec<String> = [
        (
            connections.non_manifold_edges,
            "non-manifold edge",
            "non-manifold edges",
        ),
        (
            connections.non_manifold_vertices,
            "non-manifold vertex",
            "non-manifold vertices",
        ),
        (
            connections.inconsistent_edges,
            "inconsistent edge",
            "inconsistent edges",
        ),
        (connections.t_vertices, "T-vertex", "T-vertices"),
        (
            connections.duplicate_polygons,
            "duplicate polygon",
            "duplicate polygons",
        ),
        (
            connections.flat_polygons,
            "polygon without area",
            "polygons without area",
        ),
        (
            inverted,
            "quad that is not convex",
            "quads that are not convex",
        ),
        (measure.folds, "fold", "folds"),
    ]
    .into_iter()
    .filter(|(count, ..)| *count > 0)
    .map(|(count, singular, plural)| counted(count, singular, plural))
    .collect();
    if reasons.is_empty() {
        "yes".into()
    } else {
        format!("no: {}", reasons.join(", "))
    }
}

fn shape_rows(table: &mut Table, measure: &QuadMeasure) {
    if let Some(quality) = &measure.quality {
        let jacobian = &quality.scaled_jacobian;
        let [min, p05, mean] = [jacobian.min, jacobian.p05, jacobian.mean].map(figure);
        let text = format!("least {min}, 5 % {p05}, mean {mean}   (rectangle: 1)");
        table.row("scaled Jacobian", text);
        let angles = &quality.angle_deviation;
        let text = format!(
            "mean {}°, largest {}°",
            figure(angles.mean),
            figure(angles.max)
        );
        table.row("angles off 90°", text);
        if let Some(aspect) = &quality.aspect {
            let [mean, p95, max] = [aspect.mean, aspect.p95, aspect.max].map(figure);
            let text = format!("mean {mean}, 95 % {p95}, largest {max}");
            table.row("longest over shortest side", text);
        }
        let planarity = &quality.planarity;
        let text = format!(
            "mean {} %, largest {} %",
            figure(planarity.mean),
            figure(planarity.max)
        );
        table.row("diagonals apart", text);
    }
    if let Some(length) = &measure.edge_length {
        let text = format!(
            "mean {}, variation {}",
            figure(length.mean),
            figure(length.variation)
        );
        table.row("edge length", text);
    }
}

fn reference_rows(table: &mut Table, reference: &ReferenceMeasure) {
    let kept = if reference.topology_kept {
        "kept"
    } else {
        "not kept"
    };
    table.row("topology of the reference", kept);
    for (name, deviation) in [
        ("distance to reference", &reference.distance),
        (
            "distance from reference",
            &reference.distance_from_reference,
        ),
    ] {
        let [mean, max] = [deviation.mean, deviation.max].map(figure);
        table.row(
            name,
            format!("mean {mean} %, largest {max} % of the diagonal"),
        );
    }
    let normals = &reference.normal_deviation;
    let mut text = format!(
        "mean {}°, 95 % {}°",
        figure(normals.mean),
        figure(normals.p95)
    );
    if normals.flipped_share > 0.0 {
        let _ = write!(text, ", {} turned over", percent(normals.flipped_share));
    }
    table.row("normals off the reference's", text);
    if let Some(lines) = &reference.sharp_edges {
        table.row("sharp edges", carrying(lines));
    }
    if let Some(lines) = &reference.boundary {
        table.row("boundary", carrying(lines));
    }
}

fn carrying(lines: &LineCarrying) -> String {
    format!(
        "{} carried by edges, {} met within 0.05 % of the diagonal",
        percent(lines.carried_share),
        percent(lines.met_share)
    )
}

/// The polygons coloured by their scaled Jacobian, with blue dots at vertices that have fewer edges
/// than regular ones and red dots where there are more.
pub(crate) fn quad_panel(
    soup: &PolygonSoup,
    repaired: &Repaired,
    measure: &QuadMeasure,
) -> Result<Panel, DrawError> {
    let quality = &measure.elements.scaled_jacobians;
    let values = repaired
        .face_polygons
        .map(|&polygon| quality.get(polygon as usize).copied().unwrap_or(f64::NAN));
    let values: PerFace<f64> = values;
    let scale = ColorScale {
        range: Range::Fixed(0.0, 1.0),
        ..ColorScale::default()
    };
    let style = SurfaceStyle {
        figure: Some(Figure::per_face("scaled Jacobian", &values).with_scale(scale)),
        smooth: false,
        ..SurfaceStyle::default()
    };
    let irregular = &measure.elements.irregular_vertices;
    let dots = |color: Color, more: bool| Points {
        positions: irregular
            .iter()
            .filter(|vertex| (vertex.valence > vertex.regular) == more)
            .map(|vertex| soup.positions[vertex.vertex as usize])
            .collect(),
        color,
        radius: 4.0,
        ring: false,
    };
    Ok(surface(&repaired.surface, &style)?
        .with_layer(polygon_edges(soup))
        .with_layer(dots(FEWER_EDGES, false))
        .with_layer(dots(MORE_EDGES, true)))
}

/// The outlines of all polygons.
fn polygon_edges(soup: &PolygonSoup) -> Lines {
    let mut lines = Lines::new(Color::INK, 0.9);
    lines.opacity = 0.7;
    lines.fades = true;
    for polygon in soup.polygons.iter() {
        let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
        for (&from, &to) in sides {
            // Each edge once where its polygons run in opposite directions.
            let ends = [from, to].map(|vertex| soup.positions.get(vertex as usize).copied());
            if let (true, [Some(from), Some(to)]) = (from < to, ends) {
                lines.push([from, to]);
            }
        }
    }
    lines
}
