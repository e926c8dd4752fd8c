use std::f64::consts::PI;

use rayon::prelude::*;
use serde::Serialize;

use super::uv_map::UvMap;
use crate::mesh::{Element, FaceId, HalfedgeId, VertexId};

/// A part of a map that holds together: triangles joined across edges on both sides of which the
/// coordinates agree exactly.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Island {
    /// Its triangle with the smallest number.
    #[serde(serialize_with = "face_number")]
    pub first_face: FaceId,
    /// The number of its triangles.
    pub faces: usize,
    /// Whether more of its triangles are turned over than not.
    ///
    /// A mirrored island is one seen from behind as a whole: its triangles are not flipped.
    pub mirrored: bool,
    /// Its triangles whose orientation is not that of most.
    pub flipped: usize,
    /// The number of its boundary loops.
    pub boundary_loops: usize,
    /// V − E + F, each fan of triangles around a corner counted as a vertex: 1 for a disk.
    pub euler_characteristic: i64,
    /// The area of its triangles in the map, those of overlaps and folds all counted, in squared
    /// units of the map.
    pub uv_area: f64,
    /// The area of its triangles in space, in squared units of the surface.
    pub surface_area: f64,
}

/// A closed walk along the boundary of an island.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IslandLoop {
    /// The number of the island.
    pub island: u32,
    /// The smallest halfedge of the loop.
    #[serde(serialize_with = "halfedge_number")]
    pub first_halfedge: HalfedgeId,
    /// The number of its edges.
    pub edges: usize,
    /// Its length in the map, in units of the map.
    pub uv_length: f64,
    /// Its length in space, in units of the surface.
    pub surface_length: f64,
    /// The angle in radians by which the boundary turns to the left along the loop, the island to
    /// its left: the sum of π less the angles of the triangles at each corner.
    ///
    /// The loops of an island without flipped triangles and folded vertices turn by 2π times its
    /// Euler characteristic together: an outer boundary by 2π, each hole by −2π.
    pub turning: f64,
    /// The largest turn at one corner, to either side, in radians.
    pub largest_turn: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // the signature is serde's
fn face_number<S: serde::Serializer>(face: &FaceId, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u32(face.0)
}

#[allow(clippy::trivially_copy_pass_by_ref)] // the signature is serde's
fn halfedge_number<S: serde::Serializer>(
    halfedge: &HalfedgeId,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.serialize_u32(halfedge.0)
}

/// The islands of a map, and what holds of them whatever their distortion.
pub(super) struct Islands {
    pub(super) all: Vec<Island>,
    /// The island of each triangle, `NO_ISLAND` where its coordinates are not known.
    pub(super) of_face: Vec<u32>,
    pub(super) loops: Vec<IslandLoop>,
    /// Vertices without border around which the map is not one to one, in order.
    pub(super) folded_vertices: Vec<VertexId>,
    pub(super) border_edges: usize,
    /// Length in scaled space of the edges inside the mesh where the map is cut.
    pub(super) seam_length: f64,
}

pub(super) const NO_ISLAND: u32 = u32::MAX;

impl Islands {
    pub(super) fn find(map: &UvMap<'_>) -> Self {
        let of_face = number_islands(map);
        let mut islands = count_faces(map, &of_face);
        let loops = walk_loops(map, &of_face);
        let border_edges = loops.iter().map(|border| border.edges).sum();
        for border in &loops {
            let island = &mut islands[border.island as usize];
            island.boundary_loops += 1;
            // Each border halfedge begins one open fan (a vertex), and is half an edge too many.
            island.euler_characteristic += signed(border.edges);
        }
        count_vertices_and_edges(map, &of_face, &mut islands, &loops);
        Self {
            folded_vertices: folded_vertices(map),
            seam_length: seam_length(map),
            all: islands,
            of_face,
            loops,
            border_edges,
        }
    }

    /// Whether most triangles of the island of this one are turned over.
    pub(super) fn is_mirrored(&self, face: FaceId) -> bool {
        let island = self.of_face[face.index()];
        self.all
            .get(island as usize)
            .is_some_and(|island| island.mirrored)
    }

    /// Whether the triangle is oriented against most of its island.
    pub(super) fn is_flipped(&self, map: &UvMap<'_>, face: FaceId) -> bool {
        let usual = if self.is_mirrored(face) { -1 } else { 1 };
        map.sign(face) == -usual
    }
}

/// The island of each triangle; islands are numbered in the order of their smallest triangle.
fn number_islands(map: &UvMap<'_>) -> Vec<u32> {
    let mut of_face = vec![NO_ISLAND; map.face_count()];
    let mut count = 0;
    let mut pending = Vec::new();
    for seed in map.surface.mesh().faces() {
        if of_face[seed.index()] != NO_ISLAND || !map.is_known(seed) {
            continue;
        }
        of_face[seed.index()] = count;
        pending.push(seed);
        while let Some(face) = pending.pop() {
            let neighbors = face.halfedges().map(|side| map.continuation(side));
            for neighbor in neighbors.into_iter().flatten().map(HalfedgeId::face) {
                if of_face[neighbor.index()] == NO_ISLAND {
                    of_face[neighbor.index()] = count;
                    pending.push(neighbor);
                }
            }
        }
        count += 1;
    }
    of_face
}

/// The islands with the figures that are sums over their triangles, areas aside.
fn count_faces(map: &UvMap<'_>, of_face: &[u32]) -> Vec<Island> {
    let mut islands: Vec<Island> = Vec::new();
    let mut signs: Vec<[usize; 2]> = Vec::new();
    for face in map.surface.mesh().faces() {
        let island = of_face[face.index()] as usize;
        if !map.is_known(face) {
            continue;
        }
        if island == islands.len() {
            islands.push(empty_island(face));
            signs.push([0, 0]);
        }
        islands[island].faces += 1;
        signs[island][0] += usize::from(map.sign(face) > 0);
        signs[island][1] += usize::from(map.sign(face) < 0);
    }
    for (island, [positive, negative]) in islands.iter_mut().zip(signs) {
        island.mirrored = negative > positive;
        island.flipped = positive.min(negative);
    }
    islands
}

fn empty_island(first_face: FaceId) -> Island {
    Island {
        first_face,
        faces: 0,
        mirrored: false,
        flipped: 0,
        boundary_loops: 0,
        euler_characteristic: 0,
        uv_area: 0.0,
        surface_area: 0.0,
    }
}

/// Completes V − E + F, of which the vertices on the border are counted.
fn count_vertices_and_edges(
    map: &UvMap<'_>,
    of_face: &[u32],
    islands: &mut [Island],
    loops: &[IslandLoop],
) {
    let mesh = map.surface.mesh();
    for vertex in mesh.vertices().filter(|&vertex| is_surrounded(map, vertex)) {
        let face = mesh.vertex_halfedge(vertex).face();
        islands[of_face[face.index()] as usize].euler_characteristic += 1;
    }
    let mut sides: Vec<usize> = islands.iter().map(|island| 3 * island.faces).collect();
    for border in loops {
        sides[border.island as usize] += border.edges;
    }
    for (island, sides) in islands.iter_mut().zip(sides) {
        island.euler_characteristic += signed(island.faces) - signed(sides / 2);
    }
}

#[allow(clippy::cast_possible_wrap)] // counts of mesh elements are below 2^32
fn signed(count: usize) -> i64 {
    count as i64
}

/// Whether the map is continuous all around the vertex.
fn is_surrounded(map: &UvMap<'_>, vertex: VertexId) -> bool {
    let mut around = map.surface.mesh().outgoing(vertex);
    around.all(|halfedge| map.continuation(halfedge).is_some())
}

fn folded_vertices(map: &UvMap<'_>) -> Vec<VertexId> {
    let count = map.surface.mesh().vertex_count();
    let folded: Vec<bool> = (0..count)
        .into_par_iter()
        .map(|index| is_folded(map, VertexId::from_index(index)))
        .collect();
    let folded = folded.into_iter().enumerate().filter(|&(_, folded)| folded);
    folded
        .map(|(index, _)| VertexId::from_index(index))
        .collect()
}

/// Whether the map, continuous all around the vertex, is not one to one there: triangles around it
/// are oriented differently, or their angles sum to another multiple of 2π than one.
///
/// Exact: where all turn the same way by less than π, the number of times around is that of
/// entries into the upper half-plane. A vertex of a triangle with zero area is not judged.
fn is_folded(map: &UvMap<'_>, vertex: VertexId) -> bool {
    let around = || map.surface.mesh().outgoing(vertex);
    let [mut left, mut flat, mut right] = [false; 3];
    for halfedge in around() {
        if map.continuation(halfedge).is_none() {
            return false;
        }
        match map.sign(halfedge.face()) {
            1 => left = true,
            0 => flat = true,
            _ => right = true,
        }
    }
    if left && right {
        return true;
    }
    if flat {
        return false;
    }
    #[allow(clippy::float_cmp)] // exact by intention
    let is_upper = |halfedge: HalfedgeId| {
        let [centre, end] = map.image_of_side(halfedge);
        end.y > centre.y || (end.y == centre.y && end.x > centre.x)
    };
    let enters = |halfedge: &HalfedgeId| {
        let before = is_upper(*halfedge);
        let left = map.surface.mesh().turn_left(*halfedge);
        !before && left.is_some_and(is_upper)
    };
    around().filter(enters).count() != 1
}

/// The length in scaled space of the edges that have known coordinates on both sides, not the same.
fn seam_length(map: &UvMap<'_>) -> f64 {
    let mesh = map.surface.mesh();
    let is_seam = |halfedge: &HalfedgeId| {
        let twin = mesh.twin(*halfedge);
        twin.is_some_and(|twin| halfedge.0 < twin.0 && map.is_border(twin))
    };
    let seams = map.border().filter(is_seam);
    // From 0.0 on: the empty `sum` is -0.0.
    seams.fold(0.0, |sum, halfedge| sum + map.length_in_space(halfedge))
}

/// The boundary loops of all islands, in the order of their smallest halfedge.
fn walk_loops(map: &UvMap<'_>, of_face: &[u32]) -> Vec<IslandLoop> {
    let mut visited = vec![false; map.surface.mesh().halfedge_count()];
    let mut loops = Vec::new();
    for first in map.border() {
        if visited[first.index()] {
            continue;
        }
        let mut border = empty_loop(of_face[first.face().index()], first);
        let mut halfedge = first;
        while !visited[halfedge.index()] {
            visited[halfedge.index()] = true;
            extend_loop(map, &mut border, halfedge);
            halfedge = map.next_on_border(halfedge);
        }
        border.uv_length /= map.uv_scale;
        border.surface_length /= map.surface_scale;
        loops.push(border);
    }
    loops
}

fn empty_loop(island: u32, first_halfedge: HalfedgeId) -> IslandLoop {
    IslandLoop {
        island,
        first_halfedge,
        edges: 0,
        uv_length: 0.0,
        surface_length: 0.0,
        turning: 0.0,
        largest_turn: 0.0,
    }
}

fn extend_loop(map: &UvMap<'_>, border: &mut IslandLoop, halfedge: HalfedgeId) {
    let [from, to] = map.image_of_side(halfedge);
    let turn = PI - angle_at_end(map, halfedge);
    border.edges += 1;
    border.uv_length += from.distance(to);
    border.surface_length += map.length_in_space(halfedge);
    border.turning += turn;
    border.largest_turn = border.largest_turn.max(turn.abs());
}

/// The angle of the island in the map at the end of a border halfedge, triangle by triangle.
fn angle_at_end(map: &UvMap<'_>, border: HalfedgeId) -> f64 {
    let mut corner = border.next();
    let mut angle = corner_angle(map, corner);
    while let Some(twin) = map.continuation(corner) {
        corner = twin.next();
        angle += corner_angle(map, corner);
    }
    angle
}

/// The angle of a triangle's image at a corner, in `0.0..=π`.
fn corner_angle(map: &UvMap<'_>, corner: HalfedgeId) -> f64 {
    let centre = map.uvs[corner];
    let a = map.uvs[corner.next()] - centre;
    let b = map.uvs[corner.previous()] - centre;
    libm::atan2(super::jacobian::accurate_perp_dot(a, b).abs(), a.dot(b))
}
