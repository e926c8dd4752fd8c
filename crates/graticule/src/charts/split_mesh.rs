//! Triangles of one chart, which can be split.

use glam::DVec3;

use crate::mesh::{DisjointSets, FaceId};

/// No halfedge: the border.
pub(super) const NONE: u32 = u32::MAX;

/// What a vertex of a chart is outside the chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum VertexName {
    /// A vertex of the layout, or one put on an arc; shared by the charts around it.
    Shared(u32),
    /// One made inside the chart, counted from 0.
    Made(u32),
}

/// Where a triangle lies on the input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TriangleOrigin {
    /// The input's triangle.
    pub(super) face: FaceId,
    /// The barycentric coordinates of the corners in it.
    pub(super) corners: [[f64; 3]; 3],
}

/// A disk of triangles, a vertex once for each time that its border passes it. Triangle `t` owns the
/// halfedges `3t`, `3t + 1` and `3t + 2`. Splitting a triangle may give its sides other numbers, never
/// its vertices.
#[derive(Clone, Debug, Default)]
pub(super) struct ChartDisk {
    pub(super) positions: Vec<DVec3>,
    pub(super) names: Vec<VertexName>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) origins: Vec<TriangleOrigin>,
    twins: Vec<u32>,
    /// The halfedge on the border that leaves each vertex.
    on_border: Vec<u32>,
    made: u32,
}

impl ChartDisk {
    /// Triangles with their twins, by corners: corners are one vertex if triangles join them.
    pub(super) fn new(
        corners: &[(VertexName, DVec3)],
        twins: Vec<u32>,
        origins: Vec<TriangleOrigin>,
        made: u32,
    ) -> Self {
        let mut sets = DisjointSets::new(corners.len());
        for (halfedge, &twin) in (0_u32..).zip(&twins) {
            if twin != NONE {
                sets.join(halfedge, next(twin));
            }
        }
        let sets = sets.into_names();
        let mut numbers = vec![NONE; corners.len()];
        let mut disk = Self {
            origins,
            twins,
            made,
            ..Self::default()
        };
        for (&set, &(name, position)) in sets.iter().zip(corners) {
            if numbers[set as usize] == NONE {
                numbers[set as usize] = disk.positions.len() as u32;
                disk.positions.push(position);
                disk.names.push(name);
            }
        }
        let number = |corner: usize| numbers[sets[corner] as usize];
        let triangles = (0..corners.len() / 3).map(|t| [0, 1, 2].map(|k| number(3 * t + k)));
        disk.triangles = triangles.collect();
        disk.on_border = vec![NONE; disk.positions.len()];
        for halfedge in 0..corners.len() as u32 {
            if disk.twin(halfedge).is_none() {
                let vertex = disk.origin(halfedge) as usize;
                disk.on_border[vertex] = halfedge;
            }
        }
        disk
    }

    /// The part of these triangles, with the numbers that the vertices of the whole have there.
    pub(super) fn part(&self, triangles: &[u32]) -> (Self, Vec<u32>) {
        let mut numbers = vec![NONE; self.triangles.len()];
        for (number, &triangle) in (0_u32..).zip(triangles) {
            numbers[triangle as usize] = number;
        }
        let in_part = |h: u32| match numbers[h as usize / 3] {
            NONE => NONE,
            triangle => 3 * triangle + h % 3,
        };
        let halfedges = || triangles.iter().flat_map(|&t| (3 * t)..(3 * t + 3));
        let corners = halfedges().map(|h| {
            let vertex = self.origin(h) as usize;
            (self.names[vertex], self.positions[vertex])
        });
        let twins = halfedges().map(|h| match self.twins[h as usize] {
            NONE => NONE,
            twin => in_part(twin),
        });
        let origins = triangles.iter().map(|&t| self.origins[t as usize]);
        let corners: Vec<_> = corners.collect();
        let part = Self::new(&corners, twins.collect(), origins.collect(), self.made);
        let mut vertices = vec![NONE; self.positions.len()];
        for (&triangle, corners) in triangles.iter().zip(&part.triangles) {
            for (whole, &vertex) in self.triangles[triangle as usize].iter().zip(corners) {
                vertices[*whole as usize] = vertex;
            }
        }
        (part, vertices)
    }

    pub(super) fn origin(&self, halfedge: u32) -> u32 {
        self.triangles[halfedge as usize / 3][halfedge as usize % 3]
    }

    pub(super) fn destination(&self, halfedge: u32) -> u32 {
        self.origin(next(halfedge))
    }

    /// The other side of an edge; `None` on the border.
    pub(super) fn twin(&self, halfedge: u32) -> Option<u32> {
        Some(self.twins[halfedge as usize]).filter(|&twin| twin != NONE)
    }

    /// The halfedge on the border that leaves a vertex; `None` inside.
    pub(super) fn border_halfedge(&self, vertex: u32) -> Option<u32> {
        Some(self.on_border[vertex as usize]).filter(|&halfedge| halfedge != NONE)
    }

    /// The halfedge from one vertex to another.
    pub(super) fn halfedge_between(&self, ends: [u32; 2]) -> Option<u32> {
        let mut halfedges = 0..3 * self.triangles.len() as u32;
        halfedges.find(|&h| [self.origin(h), self.destination(h)] == ends)
    }

    /// Vertices made inside so far, in this disk and in those that it is a part of.
    pub(super) fn made_count(&self) -> u32 {
        self.made
    }

    /// Lets what is made from now on be counted on from there.
    pub(super) fn count_made_from(&mut self, made: u32) {
        self.made = made;
    }

    /// Cuts the disk open along an edge; its ends stay one vertex each.
    pub(super) fn separate(&mut self, halfedge: u32) {
        if let Some(twin) = self.twin(halfedge) {
            self.twins[halfedge as usize] = NONE;
            self.twins[twin as usize] = NONE;
        }
    }

    /// The halfedges that leave the origin of one, counter-clockwise from it as far as triangles go.
    pub(super) fn turn(&self, halfedge: u32) -> impl Iterator<Item = u32> + '_ {
        let left = move |&h: &u32| self.twin(previous(h)).filter(|&h| h != halfedge);
        std::iter::successors(Some(halfedge), left)
    }

    /// Puts a new vertex on an edge, a `share` along the halfedge. The halfedge keeps its origin and
    /// ends at the vertex; returned is the halfedge from there to where it ended.
    pub(super) fn split_edge(&mut self, halfedge: u32, share: f64, name: VertexName) -> u32 {
        let ends = [halfedge, next(halfedge)].map(|h| self.origin(h) as usize);
        let position = self.positions[ends[0]].lerp(self.positions[ends[1]], share);
        let vertex = self.add_vertex(name, position);
        let onward = self.split_triangle(halfedge, share, vertex);
        if let Some(twin) = self.twin(halfedge) {
            let back = self.split_triangle(twin, 1.0 - share, vertex);
            self.join(halfedge, back);
            self.join(onward, twin);
        } else {
            self.on_border[vertex as usize] = onward;
        }
        onward
    }

    /// As [`split_edge`](Self::split_edge), with a vertex made inside.
    pub(super) fn split_inner_edge(&mut self, halfedge: u32, share: f64) -> u32 {
        let name = self.next_name();
        self.split_edge(halfedge, share, name)
    }

    /// Puts a new vertex into a triangle and joins it to the corners; returns a halfedge that leaves
    /// it.
    pub(super) fn split_inside(&mut self, triangle: u32, weights: [f64; 3]) -> u32 {
        let corners = self.triangles[triangle as usize];
        let [a, b, c] = corners.map(|v| self.positions[v as usize]);
        let [u, v, w] = weights;
        let name = self.next_name();
        let vertex = self.add_vertex(name, a * u + b * v + c * w);
        let origin = self.origins[triangle as usize];
        let inside = blend(&origin.corners, weights);
        let sides = [0, 1, 2].map(|k| self.twin(3 * triangle + k));
        let first = self.triangles.len() as u32;
        let parts = [triangle, first, first + 1];
        for (k, part) in parts.into_iter().enumerate() {
            let (from, to) = (k, (k + 1) % 3);
            let kept = [origin.corners[from], origin.corners[to], inside];
            let face = [corners[from], corners[to], vertex];
            self.put_triangle(
                part,
                face,
                TriangleOrigin {
                    face: origin.face,
                    corners: kept,
                },
            );
        }
        for (k, part) in parts.into_iter().enumerate() {
            match sides[k] {
                Some(twin) => self.join(3 * part, twin),
                None => self.put_on_border(3 * part),
            }
            self.join(3 * part + 1, 3 * parts[(k + 1) % 3] + 2);
        }
        3 * triangle + 2
    }

    /// The name of the next vertex made inside.
    fn next_name(&mut self) -> VertexName {
        self.made += 1;
        VertexName::Made(self.made - 1)
    }

    fn add_vertex(&mut self, name: VertexName, position: DVec3) -> u32 {
        self.positions.push(position);
        self.names.push(name);
        self.on_border.push(NONE);
        self.positions.len() as u32 - 1
    }

    /// Splits the triangle of a halfedge from a vertex on it to the corner opposite; returns the
    /// second half of the halfedge. Its twin stays to be set.
    fn split_triangle(&mut self, halfedge: u32, share: f64, vertex: u32) -> u32 {
        let triangle = halfedge / 3;
        let [from, to, across] = [0, 1, 2].map(|k| (halfedge as usize + k) % 3);
        let corners = self.triangles[triangle as usize];
        let origin = self.origins[triangle as usize];
        let mut weights = [0.0; 3];
        weights[from] = 1.0 - share;
        weights[to] = share;
        let middle = blend(&origin.corners, weights);
        let beyond = self.twin(next(halfedge));
        let second = self.triangles.len() as u32;
        let kept = [middle, origin.corners[to], origin.corners[across]];
        let face = [vertex, corners[to], corners[across]];
        self.put_triangle(
            second,
            face,
            TriangleOrigin {
                face: origin.face,
                corners: kept,
            },
        );
        self.triangles[triangle as usize][to] = vertex;
        self.origins[triangle as usize].corners[to] = middle;
        match beyond {
            Some(twin) => self.join(3 * second + 1, twin),
            None => self.put_on_border(3 * second + 1),
        }
        self.join(next(halfedge), 3 * second + 2);
        3 * second
    }

    fn put_triangle(&mut self, triangle: u32, corners: [u32; 3], origin: TriangleOrigin) {
        if triangle as usize == self.triangles.len() {
            self.triangles.push(corners);
            self.origins.push(origin);
            self.twins.extend([NONE; 3]);
        } else {
            self.triangles[triangle as usize] = corners;
            self.origins[triangle as usize] = origin;
        }
    }

    fn put_on_border(&mut self, halfedge: u32) {
        self.twins[halfedge as usize] = NONE;
        let vertex = self.origin(halfedge) as usize;
        self.on_border[vertex] = halfedge;
    }

    fn join(&mut self, one: u32, other: u32) {
        self.twins[one as usize] = other;
        self.twins[other as usize] = one;
    }
}

/// The halfedge after this one in its triangle.
pub(super) fn next(halfedge: u32) -> u32 {
    if halfedge % 3 == 2 {
        halfedge - 2
    } else {
        halfedge + 1
    }
}

/// The halfedge before this one in its triangle.
pub(super) fn previous(halfedge: u32) -> u32 {
    if halfedge.is_multiple_of(3) {
        halfedge + 2
    } else {
        halfedge - 1
    }
}

fn blend(corners: &[[f64; 3]; 3], weights: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let terms = corners.iter().zip(weights);
        terms.map(|(corner, weight)| corner[k] * weight).sum()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The triangles (0, 1, 2) and (0, 2, 3) of a unit square.
    fn square() -> ChartDisk {
        let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let corner = |v: u32| {
            let [x, y] = points[v as usize];
            (VertexName::Shared(v), DVec3::new(x, y, 0.0))
        };
        let corners = [0, 1, 2, 0, 2, 3].map(corner);
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let origins = [0, 1].map(|face| TriangleOrigin {
            face: FaceId(face),
            corners: identity,
        });
        ChartDisk::new(
            &corners,
            vec![NONE, NONE, 3, 2, NONE, NONE],
            origins.into(),
            0,
        )
    }

    fn check(disk: &ChartDisk) {
        for halfedge in 0..3 * disk.triangles.len() as u32 {
            if let Some(twin) = disk.twin(halfedge) {
                assert_eq!(disk.twin(twin), Some(halfedge));
                assert_eq!(disk.origin(twin), disk.destination(halfedge));
                assert_eq!(disk.destination(twin), disk.origin(halfedge));
            }
        }
        let at = |v: u32| disk.positions[v as usize];
        let double = |t: &[u32; 3]| (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).z;
        let areas = disk.triangles.iter().map(double);
        assert!(areas.clone().all(|area| area > 0.0));
        assert!((areas.sum::<f64>() - 2.0).abs() < 1e-14);
        for vertex in 0..disk.positions.len() as u32 {
            if let Some(halfedge) = disk.border_halfedge(vertex) {
                assert_eq!(disk.origin(halfedge), vertex);
                assert_eq!(disk.twin(halfedge), None);
            }
        }
    }

    #[test]
    fn splits_keep_the_disk_whole_and_know_where_they_are_on_the_input() {
        let mut disk = square();
        assert_eq!(disk.positions.len(), 4);
        let onward = disk.split_inner_edge(2, 0.25);
        check(&disk);
        assert_eq!(
            disk.positions[disk.origin(onward) as usize],
            DVec3::new(0.75, 0.75, 0.0)
        );
        disk.split_edge(0, 0.5, VertexName::Shared(9));
        check(&disk);
        let leaving = disk.split_inside(1, [0.5, 0.25, 0.25]);
        check(&disk);
        assert_eq!(disk.turn(leaving).count(), 3);
        assert_eq!(disk.made_count(), 2);
        let corners = [
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [0.0, 1.0],
        ];
        for (triangle, origin) in disk.triangles.iter().zip(&disk.origins) {
            for (vertex, weights) in triangle.iter().zip(origin.corners) {
                let input = (0..3).map(|k| {
                    let [x, y] = corners[3 * origin.face.0 as usize + k];
                    DVec3::new(x, y, 0.0) * weights[k]
                });
                let missed = input.sum::<DVec3>() - disk.positions[*vertex as usize];
                assert!(missed.length() < 1e-15);
            }
        }
    }

    #[test]
    fn a_disk_cut_in_two_has_two_parts_that_keep_names() {
        let mut disk = square();
        disk.separate(2);
        let (part, vertices) = disk.part(&[1]);
        assert_eq!(part.positions.len(), 3);
        assert_eq!(vertices[1], NONE);
        assert_eq!(part.names[vertices[2] as usize], VertexName::Shared(2));
        assert!((0..3).all(|vertex| part.border_halfedge(vertex).is_some()));
    }
}
