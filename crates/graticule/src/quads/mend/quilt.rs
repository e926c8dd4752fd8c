use std::collections::HashSet;

use glam::DVec3;

use super::super::doublets::{drop_unused, vertices_on_lines};
use super::super::partition::ordered;
use super::super::polygon_mesh::PolygonMesh;
use super::super::shape::{Ground, Place};
use crate::mesh::{Polygons, Surface, SurfacePoint};

/// A polygon mesh of which pieces are replaced.
pub(super) struct Quilt {
    /// The vertices of each polygon; none where it was taken out.
    polygons: Vec<Vec<u32>>,
    /// The polygons at each vertex.
    around: Vec<Vec<u32>>,
    places: Vec<Place>,
    positions: Vec<DVec3>,
    /// Edges on features and on the boundary; asked, never walked.
    lines: HashSet<[u32; 2]>,
    held: Vec<bool>,
}

impl Quilt {
    pub(super) fn of(mesh: &PolygonMesh, ground: &Ground) -> Self {
        let places: Vec<Place> = mesh.origins.iter().map(|&o| ground.place(o)).collect();
        let mut quilt = Self {
            polygons: Vec::with_capacity(mesh.polygons.len()),
            around: vec![Vec::new(); places.len()],
            positions: places.iter().map(|place| place.position).collect(),
            held: vertices_on_lines(&mesh.polygons, &mesh.feature_edges, places.len()),
            places,
            lines: mesh.feature_edges.iter().copied().collect(),
        };
        for polygon in 0..mesh.polygons.len() {
            quilt.add(mesh.polygons.vertices(polygon).to_vec());
        }
        let all_sides = quilt.polygons.iter().flat_map(|polygon| sides(polygon));
        let border: Vec<[u32; 2]> = all_sides
            .filter(|&side| quilt.beyond(side).is_none())
            .map(|[from, to]| ordered(from, to))
            .collect();
        quilt.lines.extend(border);
        quilt
    }

    fn add(&mut self, polygon: Vec<u32>) -> u32 {
        let number = self.polygons.len() as u32;
        for &vertex in &polygon {
            self.around[vertex as usize].push(number);
        }
        self.polygons.push(polygon);
        number
    }

    pub(super) fn polygon_count(&self) -> usize {
        self.polygons.len()
    }

    /// The vertices of a polygon; none where it was taken out.
    pub(super) fn vertices(&self, polygon: u32) -> &[u32] {
        &self.polygons[polygon as usize]
    }

    /// The polygons at a vertex.
    pub(super) fn around(&self, vertex: u32) -> &[u32] {
        &self.around[vertex as usize]
    }

    pub(super) fn place(&self, vertex: u32) -> Place {
        self.places[vertex as usize]
    }

    pub(super) fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// For each vertex whether it is on a feature or on the boundary.
    pub(super) fn held(&self) -> &[bool] {
        &self.held
    }

    /// Whether an edge runs along a feature or the boundary.
    pub(super) fn is_line(&self, [from, to]: [u32; 2]) -> bool {
        self.lines.contains(&ordered(from, to))
    }

    /// Makes common edges of those along features at a vertex; returns how many there were.
    pub(super) fn release_lines_at(&mut self, vertex: u32) -> usize {
        let around = self.around(vertex).iter();
        let released: Vec<[u32; 2]> = around
            .flat_map(|&polygon| sides(self.vertices(polygon)))
            .filter(|side| side.contains(&vertex) && self.beyond(*side).is_some())
            .map(|[from, to]| ordered(from, to))
            .collect();
        let mut count = 0;
        for edge in released {
            count += usize::from(self.lines.remove(&edge));
            for end in edge {
                self.held[end as usize] = self.is_on_line(end);
            }
        }
        count
    }

    fn is_on_line(&self, vertex: u32) -> bool {
        let mut around = self.around(vertex).iter();
        let is_line_here = |side: [u32; 2]| side.contains(&vertex) && self.is_line(side);
        around.any(|&polygon| sides(self.vertices(polygon)).any(is_line_here))
    }

    /// The polygon that runs along a side in the other direction.
    pub(super) fn beyond(&self, [from, to]: [u32; 2]) -> Option<u32> {
        let has_side =
            |&polygon: &u32| sides(self.vertices(polygon)).any(|side| side == [to, from]);
        self.around(from).iter().copied().find(has_side)
    }

    /// The polygons at a vertex of a polygon that are reached from it without crossing a line.
    pub(super) fn fan(&self, vertex: u32, polygon: u32) -> Vec<u32> {
        let mut fan = vec![polygon];
        let mut next = 0;
        while next < fan.len() {
            for side in sides(self.vertices(fan[next])) {
                if side.contains(&vertex)
                    && !self.is_line(side)
                    && let Some(beyond) = self.beyond(side)
                    && !fan.contains(&beyond)
                {
                    fan.push(beyond);
                }
            }
            next += 1;
        }
        fan
    }

    pub(super) fn add_vertex(&mut self, place: Place) -> u32 {
        self.places.push(place);
        self.positions.push(place.position);
        self.around.push(Vec::new());
        self.held.push(false);
        self.places.len() as u32 - 1
    }

    pub(super) fn put(&mut self, vertex: u32, place: Place) {
        self.places[vertex as usize] = place;
        self.positions[vertex as usize] = place.position;
    }

    /// Takes polygons out and puts others in their place.
    pub(super) fn replace(&mut self, old: &[u32], new: Vec<Vec<u32>>) {
        for &polygon in old {
            for vertex in std::mem::take(&mut self.polygons[polygon as usize]) {
                self.around[vertex as usize].retain(|&other| other != polygon);
            }
        }
        for polygon in new {
            self.add(polygon);
        }
    }

    /// Writes the polygons and places down, and which feature edges of `mesh` are still there.
    pub(super) fn write_to(self, mesh: &mut PolygonMesh, surface: &Surface) {
        mesh.feature_edges.retain(|edge| self.lines.contains(edge));
        mesh.polygons = Polygons::default();
        for polygon in self.polygons.iter().filter(|polygon| !polygon.is_empty()) {
            mesh.polygons.push(polygon);
        }
        mesh.origins = self.places.iter().map(|place| place.origin).collect();
        mesh.positions = (mesh.origins.iter())
            .map(|origin: &SurfacePoint| origin.position(surface))
            .collect();
        drop_unused(mesh);
    }
}

/// The sides of a polygon by their ends.
pub(super) fn sides(vertices: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    let next = vertices.iter().cycle().skip(1);
    vertices.iter().zip(next).map(|(&from, &to)| [from, to])
}
