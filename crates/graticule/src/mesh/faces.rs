use std::ops::Range;

use super::HalfedgeId;

/// Faces by their corners: what the search for defects (polygons) and the repair (triangles)
/// share. The side of a corner runs from its vertex to the vertex of the next corner.
pub(super) trait Faces {
    fn face_count(&self) -> usize;
    fn corner_count(&self) -> usize;
    fn corners(&self, face: u32) -> Range<u32>;
    fn face(&self, corner: u32) -> u32;
    fn origin(&self, corner: u32) -> u32;
    /// The next corner of the same face.
    fn next(&self, corner: u32) -> u32;
    /// The corner before in the same face.
    fn previous(&self, corner: u32) -> u32;

    fn destination(&self, corner: u32) -> u32 {
        self.origin(self.next(corner))
    }

    /// The ends of the corner's side, the smaller vertex first.
    fn edge(&self, corner: u32) -> [u32; 2] {
        let [from, to] = [self.origin(corner), self.destination(corner)];
        [from.min(to), from.max(to)]
    }
}

/// Triangles over shared vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleFaces<'a>(pub(super) &'a [[u32; 3]]);

impl Faces for TriangleFaces<'_> {
    fn face_count(&self) -> usize {
        self.0.len()
    }

    fn corner_count(&self) -> usize {
        3 * self.0.len()
    }

    fn corners(&self, face: u32) -> Range<u32> {
        3 * face..3 * face + 3
    }

    #[inline]
    fn face(&self, corner: u32) -> u32 {
        corner / 3
    }

    #[inline]
    fn origin(&self, corner: u32) -> u32 {
        self.0.as_flattened()[corner as usize]
    }

    #[inline]
    fn next(&self, corner: u32) -> u32 {
        HalfedgeId(corner).next().0
    }

    #[inline]
    fn previous(&self, corner: u32) -> u32 {
        HalfedgeId(corner).previous().0
    }
}

/// Polygons over shared vertices, each with three corners or more.
#[derive(Clone, Debug)]
pub(super) struct PolygonFaces {
    starts: Vec<u32>,
    origins: Vec<u32>,
    faces: Vec<u32>,
    /// Then corners are found by counting, without a look into the tables.
    all_triangles: bool,
}

impl PolygonFaces {
    pub(super) fn with_capacity(polygons: usize, corners: usize) -> Self {
        let mut starts = Vec::with_capacity(polygons + 1);
        starts.push(0);
        Self {
            starts,
            origins: Vec::with_capacity(corners),
            faces: Vec::with_capacity(corners),
            all_triangles: true,
        }
    }

    pub(super) fn push(&mut self, vertices: impl Iterator<Item = u32>) {
        let face = self.face_count() as u32;
        self.origins.extend(vertices);
        self.faces.resize(self.origins.len(), face);
        self.all_triangles &= self.origins.len() == 3 * (face as usize + 1);
        self.starts.push(self.origins.len() as u32);
    }

    pub(super) fn vertices(&self, face: u32) -> &[u32] {
        let corners = self.corners(face);
        &self.origins[corners.start as usize..corners.end as usize]
    }
}

impl Faces for PolygonFaces {
    fn face_count(&self) -> usize {
        self.starts.len() - 1
    }

    fn corner_count(&self) -> usize {
        self.origins.len()
    }

    fn corners(&self, face: u32) -> Range<u32> {
        if self.all_triangles {
            return 3 * face..3 * face + 3;
        }
        self.starts[face as usize]..self.starts[face as usize + 1]
    }

    #[inline]
    fn face(&self, corner: u32) -> u32 {
        if self.all_triangles {
            return corner / 3;
        }
        self.faces[corner as usize]
    }

    #[inline]
    fn origin(&self, corner: u32) -> u32 {
        self.origins[corner as usize]
    }

    #[inline]
    fn next(&self, corner: u32) -> u32 {
        let corners = self.corners(self.face(corner));
        if corner + 1 == corners.end {
            corners.start
        } else {
            corner + 1
        }
    }

    #[inline]
    fn previous(&self, corner: u32) -> u32 {
        let corners = self.corners(self.face(corner));
        if corner == corners.start {
            corners.end - 1
        } else {
            corner - 1
        }
    }
}
