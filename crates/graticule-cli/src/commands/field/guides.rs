//! Directions and lines that the field should follow, by the numbers of the file.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use glam::DVec3;
use graticule::field::{Guide, GuidePlace, Strength};
use graticule::mesh::{EdgeId, Element, FaceId, NO_VALUE, PolygonSoup, Repaired, VertexId};
use graticule::watch::Watch;
use serde::Deserialize;

use crate::failure::Failure;

/// The guides of a file, in its order.
pub(super) struct Wishes(Vec<Wish>);

/// One guide as the file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wish {
    vertex: Option<u32>,
    face: Option<u32>,
    direction: [f64; 3],
    weight: Option<f64>,
}

impl Wishes {
    /// Reads the file, if there is one.
    pub(super) fn read(path: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = path else {
            return Ok(Self(Vec::new()));
        };
        let text = fs::read(path).map_err(|error| {
            Failure::new(
                format!("{} could not be read: {error}", path.display()),
                "check its name and the rights to it",
            )
        })?;
        let wishes: Vec<Wish> = serde_json::from_slice(&text).map_err(|error| {
            Failure::new(
                format!("{} is no list of guides: {error}", path.display()),
                "write [{\"vertex\": 7, \"direction\": [1, 0, 0], \"weight\": 5}]",
            )
        })?;
        let is_plain = |wish: &Wish| wish.vertex.is_some() != wish.face.is_some();
        match wishes.iter().position(|wish| !is_plain(wish)) {
            Some(number) => Err(Failure::new(
                format!("guide {number} of {} needs a place", path.display()),
                "give it either a vertex or a face, by its number in the mesh file",
            )),
            None => Ok(Self(wishes)),
        }
    }

    /// The guides on the surface, each with its number in the file. A polygon that was cut has one
    /// for each of its triangles.
    pub(super) fn on_surface(
        &self,
        soup: &PolygonSoup,
        repaired: &Repaired,
    ) -> Result<Vec<(usize, Guide)>, Failure> {
        if self.0.is_empty() {
            return Ok(Vec::new());
        }
        let vertices = repaired.mesh_vertices(soup);
        let mut triangles = BTreeMap::<u32, Vec<FaceId>>::new();
        for (face, &polygon) in repaired.face_polygons.enumerate() {
            triangles.entry(polygon).or_default().push(face);
        }
        let mut guides = Vec::new();
        for (number, wish) in self.0.iter().enumerate() {
            let places: Vec<GuidePlace> = match (wish.vertex, wish.face) {
                (Some(vertex), _) => (vertices.get(vertex as usize).into_iter())
                    .filter(|&&vertex| vertex != NO_VALUE)
                    .map(|&vertex| GuidePlace::Vertex(VertexId(vertex)))
                    .collect(),
                (None, Some(face)) => (triangles.get(&face).into_iter().flatten())
                    .map(|&face| GuidePlace::Face(face))
                    .collect(),
                (None, None) => Vec::new(),
            };
            if places.is_empty() {
                return Err(nowhere(number, wish));
            }
            let guide = |place| Guide {
                place,
                direction: DVec3::from_array(wish.direction),
                strength: wish.weight.map_or(Strength::Hard, Strength::Soft),
            };
            guides.extend(places.into_iter().map(|place| (number, guide(place))));
        }
        Ok(guides)
    }
}

fn nowhere(number: usize, wish: &Wish) -> Failure {
    let place = match (wish.vertex, wish.face) {
        (Some(vertex), _) => format!("vertex {vertex}"),
        (None, face) => format!("face {}", face.unwrap_or_default()),
    };
    Failure::new(
        format!("guide {number} is for {place}, which is no part of the surface"),
        "elements are numbered from 0 in the order of the mesh file; 'graticule info' tells what \
         repair drops",
    )
}

/// The edges of the surface that the file's polylines run along; warns of pieces beside the edges.
pub(crate) fn lines_of_file(soup: &PolygonSoup, repaired: &Repaired, watch: &Watch) -> Vec<EdgeId> {
    if soup.polylines.is_empty() {
        return Vec::new();
    }
    let vertices = repaired.mesh_vertices(soup);
    let mesh = repaired.surface.mesh();
    let edge = |pair: &[u32]| {
        let ends = [pair[0], pair[1]].map(|v| vertices.get(v as usize).copied());
        let [Some(from), Some(to)] = ends.map(|v| v.filter(|&v| v != NO_VALUE)) else {
            return None;
        };
        let is_between = |&edge: &EdgeId| {
            let [a, b] = mesh
                .ends(mesh.edge_halfedge(edge))
                .map(|v| v.index() as u32);
            [a, b] == [from, to] || [b, a] == [from, to]
        };
        let around = mesh.outgoing(VertexId(from)).flat_map(|halfedge| {
            // The last edge round a boundary vertex only arrives.
            [halfedge, halfedge.previous()].map(|side| mesh.edge(side))
        });
        around.into_iter().find(is_between)
    };
    let pieces = || soup.polylines.iter().flat_map(|line| line.windows(2));
    let edges: Vec<EdgeId> = pieces().filter_map(edge).collect();
    let beside = pieces().count() - edges.len();
    if beside > 0 {
        watch.warn(
            "line-off-edges",
            format!("{beside} pieces of the file's lines run along no edge and are not followed"),
        );
    }
    edges
}
