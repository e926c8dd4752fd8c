//! What is written of periodic coordinates beside the picture.

use glam::DVec2;
use graticule::mesh::{FaceId, HalfedgeId, PerCorner, PerFace, Repaired};
use graticule::periodic::{Parameterization, Transition};
use serde_json::{Value, json};

use crate::failure::Failure;

/// The coordinates of all corners, with the triangles of each polygon of the file in one plane where
/// they fit together.
pub(super) fn polygon_coordinates(repaired: &Repaired, map: &Parameterization) -> PerCorner<DVec2> {
    let mesh = repaired.surface.mesh();
    let polygons = &repaired.face_polygons;
    let mut moves: PerFace<Option<Transition>> = PerFace::filled(mesh.face_count(), None);
    for first in mesh.faces() {
        if moves[first].is_some() {
            continue;
        }
        moves[first] = Some(Transition::identity());
        let mut waiting = vec![first];
        while let Some(face) = waiting.pop() {
            for side in face.halfedges() {
                let over = mesh.twin(side).zip(map.layout.transitions[side]);
                let Some((twin, there)) = over else { continue };
                let next = twin.face();
                if polygons[next] == polygons[face] && moves[next].is_none() {
                    let here = moves[face].unwrap_or_default();
                    moves[next] = Some(there.inverse().then(here));
                    waiting.push(next);
                }
            }
        }
    }
    PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
        let own = moves[corner.face()].unwrap_or_default();
        own.apply(map.layout.coordinates[corner])
    })
}

/// Triangles with their coordinates and the transitions to their neighbours, and all singular
/// elements, by the numbers of the mesh file.
pub(super) fn integers(repaired: &Repaired, map: &Parameterization) -> Result<String, Failure> {
    let mesh = repaired.surface.mesh();
    let vertex = |vertex| repaired.vertex_sources[vertex];
    let transition = |halfedge: HalfedgeId| -> Value {
        map.layout.transitions[halfedge].map_or(Value::Null, |step| {
            json!([step.turn.quarters(), step.shift[0], step.shift[1]])
        })
    };
    let triangle = |face: FaceId| {
        let corners = face.halfedges();
        json!({
            "polygon": repaired.face_polygons[face],
            "vertices": mesh.triangle(face).map(vertex),
            "kind": map.kinds[face],
            "coordinates": corners.map(|corner| map.layout.coordinates[corner].to_array()),
            "transitions": corners.map(transition),
        })
    };
    let faces = |faces: &[FaceId]| -> Vec<u32> { faces.iter().map(|face| face.0).collect() };
    let edges = map.singular.edges.iter();
    let ends = edges.map(|&edge| mesh.ends(mesh.edge_halfedge(edge)).map(vertex));
    let tension = mesh.vertices().map(|at| {
        let (norm, energy) = (map.tension.norms[at], map.tension.energies[at]);
        json!({ "vertex": vertex(at), "norm": norm, "energy": energy })
    });
    let document = json!({
        "graticule": env!("CARGO_PKG_VERSION"),
        "chart_size": map.chart_size,
        "field_singular_triangles": faces(&map.singular.field_faces),
        "phase_singular_triangles": faces(&map.singular.phase_faces),
        "inverted_triangles": faces(&map.singular.inverted_faces),
        "singular_edges": ends.collect::<Vec<_>>(),
        "singular_vertices": map.singular.vertices.iter().map(|&v| vertex(v)).collect::<Vec<_>>(),
        "vertices": tension.collect::<Vec<_>>(),
        "triangles": mesh.faces().map(triangle).collect::<Vec<_>>(),
    });
    let mut text = serde_json::to_string(&document).map_err(|error| {
        Failure::new(
            format!("the integers could not be put into JSON: {error}"),
            "this is a fault of graticule: please report it with the command and the file",
        )
    })?;
    text.push('\n');
    Ok(text)
}
