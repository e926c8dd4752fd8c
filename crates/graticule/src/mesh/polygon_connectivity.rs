use std::ops::Range;

use super::PolygonSoup;
use super::faces::{Faces, PolygonFaces};
use super::gluing::{EdgeUses, NONE};
use super::usable::UsablePolygons;

/// How the polygons of a soup hang together, sound or not.
///
/// Polygons that span no face are left out, so they are numbered anew; corners and sides share
/// their numbers, side `c` running from corner `c` to the next one of its polygon. Vertices have
/// the numbers of the soup.
#[derive(Clone, Debug)]
pub(crate) struct PolygonConnectivity {
    faces: PolygonFaces,
    sources: Vec<u32>,
    uses: EdgeUses,
    twins: Vec<u32>,
    vertex_starts: Vec<u32>,
    vertex_corners: Vec<u32>,
}

impl PolygonConnectivity {
    /// Near-linear time.
    pub(crate) fn of(soup: &PolygonSoup) -> Self {
        let vertex_count = soup.positions.len();
        let identity: Vec<u32> = (0..vertex_count as u32).collect();
        let usable = UsablePolygons::of(soup, &identity);
        let faces = usable.faces;
        let uses = EdgeUses::of(&faces, vertex_count);
        let (vertex_starts, vertex_corners) = corners_by_vertex(&faces, vertex_count);
        Self {
            twins: uses.twins(),
            sources: usable.polygon_sources,
            faces,
            uses,
            vertex_starts,
            vertex_corners,
        }
    }

    pub(crate) fn polygon_count(&self) -> usize {
        self.faces.face_count()
    }

    pub(crate) fn vertex_count(&self) -> usize {
        self.vertex_starts.len() - 1
    }

    /// The polygon of the soup.
    pub(crate) fn source(&self, polygon: usize) -> usize {
        self.sources[polygon] as usize
    }

    /// The vertices of a polygon, in order.
    pub(crate) fn vertices(&self, polygon: usize) -> &[u32] {
        self.faces.vertices(polygon as u32)
    }

    /// The corners of a polygon.
    pub(crate) fn corners(&self, polygon: usize) -> Range<u32> {
        self.faces.corners(polygon as u32)
    }

    /// The corners at a vertex, in ascending order.
    pub(crate) fn corners_at(&self, vertex: usize) -> &[u32] {
        &self.vertex_corners
            [self.vertex_starts[vertex] as usize..self.vertex_starts[vertex + 1] as usize]
    }

    pub(crate) fn origin(&self, corner: u32) -> u32 {
        self.faces.origin(corner)
    }

    pub(crate) fn polygon(&self, corner: u32) -> usize {
        self.faces.face(corner) as usize
    }

    /// The next corner of the same polygon.
    pub(crate) fn next(&self, corner: u32) -> u32 {
        self.faces.next(corner)
    }

    /// The corner before in the same polygon.
    pub(crate) fn previous(&self, corner: u32) -> u32 {
        self.faces.previous(corner)
    }

    /// The vertices of a side, the smaller one first.
    pub(crate) fn edge(&self, side: u32) -> [u32; 2] {
        self.faces.edge(side)
    }

    /// The other side on the edge of this one, if the edge has just two.
    pub(crate) fn twin(&self, side: u32) -> Option<u32> {
        let twin = self.twins[side as usize];
        (twin != NONE).then_some(twin)
    }

    /// The sides on each edge in turn.
    pub(crate) fn edges(&self) -> impl Iterator<Item = &[u32]> {
        self.uses.iter().filter(|sides| !sides.is_empty())
    }
}

fn corners_by_vertex(faces: &PolygonFaces, vertex_count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0_u32; vertex_count + 1];
    let corners = 0..faces.corner_count() as u32;
    for corner in corners.clone() {
        starts[faces.origin(corner) as usize + 1] += 1;
    }
    for vertex in 0..vertex_count {
        starts[vertex + 1] += starts[vertex];
    }
    let mut filled = starts.clone();
    let mut by_vertex = vec![0; faces.corner_count()];
    for corner in corners {
        let slot = &mut filled[faces.origin(corner) as usize];
        by_vertex[*slot as usize] = corner;
        *slot += 1;
    }
    (starts, by_vertex)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Polygons;
    use glam::DVec3;

    #[test]
    fn corners_sides_and_twins_of_two_quads_agree() {
        let polygons: [&[u32]; 3] = [&[0, 1, 4, 3], &[9, 1], &[1, 2, 5, 4]];
        let soup = PolygonSoup {
            positions: (0..6)
                .map(|i| DVec3::new(f64::from(i % 3), f64::from(i / 3), 0.0))
                .collect(),
            polygons: polygons.into_iter().collect::<Polygons>(),
            ..PolygonSoup::default()
        };
        let mesh = PolygonConnectivity::of(&soup);
        assert_eq!(mesh.polygon_count(), 2);
        assert_eq!(mesh.source(1), 2);
        assert_eq!(mesh.edges().count(), 7);
        let shared = mesh.corners_at(4)[1];
        assert_eq!(mesh.vertices(mesh.polygon(shared)), [1, 2, 5, 4]);
        let twin = mesh.twin(shared).unwrap();
        assert_eq!(mesh.edge(twin), [1, 4]);
        assert_eq!(
            mesh.origin(mesh.next(mesh.previous(twin))),
            mesh.origin(twin)
        );
        assert_eq!(mesh.twin(mesh.next(shared)), None);
    }
}
