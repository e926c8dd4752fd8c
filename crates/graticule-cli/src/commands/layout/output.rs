//! What is written of a layout beside the picture.

use std::collections::BTreeMap;

use graticule::charts::{Arc, BaseComplex, Chart, ChartLayout, ChartMaps, SquareId};
use graticule::mesh::{Element, Repaired, SurfacePoint, VertexId};
use serde_json::{Value, json};

use crate::failure::Failure;

/// Nodes, arcs and charts, by the numbers of the refined mesh and the polygons of the file.
pub(super) fn layout(
    layout: &ChartLayout,
    complex: &BaseComplex,
    maps: &ChartMaps,
    repaired: &Repaired,
) -> Result<String, Failure> {
    let chart = |square: &SquareId| maps.squares()[square.index()].chart.0;
    let origin = |point: SurfacePoint| {
        json!({
            "polygon": repaired.face_polygons[point.face],
            "vertices": repaired.surface.mesh().triangle(point.face)
                .map(|vertex| repaired.vertex_sources[vertex]),
            "weights": point.barycentric,
        })
    };
    let node = |&node: &VertexId| {
        json!({
            "vertex": node.0,
            "position": layout.surface().position(node).to_array(),
            "on_input": origin(layout.refined().vertex_origin[node]),
        })
    };
    let arc = |arc: &Arc| {
        let vertices: Vec<u32> = arc.vertices.iter().map(|vertex| vertex.0).collect();
        json!({ "kind": arc.kind, "vertices": vertices })
    };
    let charts: Vec<Value> = (layout.charts().iter().enumerate())
        .map(|(index, chart)| chart_to_json(chart, index, complex))
        .collect();
    let document = json!({
        "graticule": env!("CARGO_PKG_VERSION"),
        "nodes": layout.nodes().iter().map(node).collect::<Vec<_>>(),
        "arcs": layout.arcs().iter().map(arc).collect::<Vec<_>>(),
        "charts": charts,
        "chart_of_triangle": maps.square_of().iter().map(chart).collect::<Vec<_>>(),
        "square_of_triangle": maps.square_of().iter().map(|square| square.0).collect::<Vec<_>>(),
        "polygon_of_triangle": maps.refined().face_origin.iter()
            .map(|&face| repaired.face_polygons[face]).collect::<Vec<_>>(),
    });
    let mut text = serde_json::to_string(&document).map_err(|error| {
        Failure::new(
            format!("the layout could not be put into JSON: {error}"),
            "this is a fault of graticule: please report it with the command and the file",
        )
    })?;
    text.push('\n');
    Ok(text)
}

fn chart_to_json(chart: &Chart, index: usize, complex: &BaseComplex) -> Value {
    let sides = chart.sides.iter().map(|side| {
        let arcs = side.iter();
        arcs.map(|(arc, _)| arc.index()).collect::<Vec<_>>()
    });
    json!({
        "kind": chart.kind,
        "sides": sides.collect::<Vec<_>>(),
        "nodes": complex.mesh.polygons.vertices(index),
        "beyond": complex.neighbors[index],
    })
}

/// How many vertices have each valence.
pub(super) fn counts_of_valences(valences: &[u32]) -> Value {
    let mut counts = BTreeMap::new();
    for &valence in valences {
        *counts.entry(valence).or_insert(0_usize) += 1;
    }
    let list = counts.into_iter();
    list.map(|(valence, count)| json!({ "valence": valence, "count": count }))
        .collect()
}
