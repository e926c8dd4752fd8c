//! A disk made coarser by taking vertices away one by one, each remembered, so that they can be
//! put back in reverse order.

use glam::DVec3;

/// A vertex taken away: its triangles now end at a neighbour, but for those that had both.
#[derive(Clone, Debug)]
pub(super) struct Collapse {
    pub(super) vertex: u32,
    /// The neighbour.
    pub(super) target: u32,
    /// The triangles that the vertex had.
    pub(super) star: Vec<u32>,
}

/// Triangles of a disk that vertices are taken out of. Triangles keep their numbers.
#[derive(Debug)]
pub(super) struct Coarsening {
    corners: Vec<[u32; 3]>,
    alive: Vec<bool>,
    alive_triangles: usize,
    alive_vertices: usize,
    /// The live triangles of each vertex; empty once it is gone.
    stars: Vec<Vec<u32>>,
    on_boundary: Vec<bool>,
    keeps_boundary: bool,
    points: Vec<DVec3>,
    collapses: Vec<Collapse>,
    marks: Vec<u32>,
    mark: u32,
}

/// A vertex that could go, where to, and what that would cost.
struct Candidate {
    cost: f64,
    vertex: u32,
    target: u32,
}

/// Largest number of triangles of a vertex that is taken away while others can be.
const MOST_TRIANGLES: usize = 12;

/// Cosine of the angle between normals from which a triangle counts as folded over.
const FOLDED: f64 = 0.2;

/// Factor on the cost of a fold.
const FOLD_COST: f64 = 1e3;

impl Coarsening {
    /// Starts from the triangles of a disk over `points`, all of which they use.
    pub(super) fn new(triangles: &[[u32; 3]], points: &[DVec3], on_boundary: Vec<bool>) -> Self {
        let mut stars = vec![Vec::new(); points.len()];
        for (index, triangle) in (0_u32..).zip(triangles) {
            for &vertex in triangle {
                stars[vertex as usize].push(index);
            }
        }
        Self {
            corners: triangles.to_vec(),
            alive: vec![true; triangles.len()],
            alive_triangles: triangles.len(),
            alive_vertices: points.len(),
            stars,
            on_boundary,
            keeps_boundary: false,
            points: points.to_vec(),
            collapses: Vec::new(),
            marks: vec![0; points.len()],
            mark: 0,
        }
    }

    /// Leaves the boundary as it is: vertices inside go, to others inside.
    pub(super) fn keeping_boundary(mut self) -> Self {
        self.keeps_boundary = true;
        self
    }

    /// The number of vertices still there.
    pub(super) fn vertex_count(&self) -> usize {
        self.alive_vertices
    }

    /// The number of vertices that are gone.
    pub(super) fn collapse_count(&self) -> usize {
        self.collapses.len()
    }

    /// Whether the vertex lies on the boundary of the disk.
    pub(super) fn is_on_boundary(&self, vertex: u32) -> bool {
        self.on_boundary[vertex as usize]
    }

    /// The corners of a triangle.
    pub(super) fn triangle(&self, triangle: u32) -> [u32; 3] {
        self.corners[triangle as usize]
    }

    /// The triangles still there.
    pub(super) fn triangles(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.corners.len() as u32).filter(|&triangle| self.alive[triangle as usize])
    }

    /// Takes away an independent set of vertices, those first whose loss changes least; about one
    /// in five. Returns how many went.
    pub(super) fn round(&mut self) -> usize {
        let mut candidates = self.candidates(MOST_TRIANGLES);
        if candidates.is_empty() {
            candidates = self.candidates(usize::MAX);
        }
        candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.vertex.cmp(&b.vertex)));
        let considered = candidates.len().div_ceil(2);
        let mut locked = vec![false; self.points.len()];
        let before = self.collapses.len();
        for candidate in &candidates[..considered] {
            let ring = self.ring(candidate.vertex);
            if ring.iter().any(|&vertex| locked[vertex as usize])
                || locked[candidate.vertex as usize]
            {
                continue;
            }
            self.collapse(candidate.vertex, candidate.target);
            for vertex in ring {
                locked[vertex as usize] = true;
            }
        }
        self.collapses.len() - before
    }

    /// Puts the vertex that went last back, and tells how it had gone. Its place is not known here.
    pub(super) fn restore(&mut self) -> Option<Collapse> {
        let collapse = self.collapses.pop()?;
        for &triangle in &collapse.star {
            let corners = &mut self.corners[triangle as usize];
            if self.alive[triangle as usize] {
                for corner in corners
                    .iter_mut()
                    .filter(|corner| **corner == collapse.target)
                {
                    *corner = collapse.vertex;
                }
            } else {
                self.alive[triangle as usize] = true;
                self.alive_triangles += 1;
            }
        }
        self.alive_vertices += 1;
        Some(collapse)
    }

    /// The other two corners of each triangle of a vertex that was just put back, in turn.
    pub(super) fn link(&self, collapse: &Collapse) -> Vec<[u32; 2]> {
        let opposite = |&triangle: &u32| self.opposite(triangle, collapse.vertex);
        collapse.star.iter().map(opposite).collect()
    }

    fn opposite(&self, triangle: u32, vertex: u32) -> [u32; 2] {
        let [a, b, c] = self.corners[triangle as usize];
        match vertex {
            v if v == a => [b, c],
            v if v == b => [c, a],
            _ => [a, b],
        }
    }

    /// The neighbours of a vertex, ascending.
    fn ring(&self, vertex: u32) -> Vec<u32> {
        let star = self.stars[vertex as usize].iter();
        let mut ring: Vec<u32> = star
            .flat_map(|&triangle| self.opposite(triangle, vertex))
            .collect();
        ring.sort_unstable();
        ring.dedup();
        ring
    }

    fn collapse(&mut self, vertex: u32, target: u32) {
        let star = std::mem::take(&mut self.stars[vertex as usize]);
        for &triangle in &star {
            let corners = &mut self.corners[triangle as usize];
            if corners.contains(&target) {
                let others = *corners;
                self.alive[triangle as usize] = false;
                self.alive_triangles -= 1;
                for other in others.into_iter().filter(|&other| other != vertex) {
                    self.stars[other as usize].retain(|&t| t != triangle);
                }
            } else {
                for corner in corners.iter_mut().filter(|corner| **corner == vertex) {
                    *corner = target;
                }
                self.stars[target as usize].push(triangle);
            }
        }
        self.alive_vertices -= 1;
        self.collapses.push(Collapse {
            vertex,
            target,
            star,
        });
    }

    fn candidates(&mut self, most_triangles: usize) -> Vec<Candidate> {
        let vertices = 0..self.points.len() as u32;
        vertices
            .filter_map(|vertex| self.candidate(vertex, most_triangles))
            .collect()
    }

    /// The cheapest way to take a vertex away, if there is one that leaves a disk.
    fn candidate(&mut self, vertex: u32, most_triangles: usize) -> Option<Candidate> {
        let triangles = self.stars[vertex as usize].len();
        if triangles == 0 || triangles > most_triangles || self.alive_triangles == 1 {
            return None;
        }
        let mut best: Option<Candidate> = None;
        for target in self.ring(vertex) {
            // An edge between two vertices of a straight side would leave no room for triangles.
            let is_kept = [vertex, target]
                .iter()
                .any(|&end| self.on_boundary[end as usize]);
            if self.keeps_boundary && is_kept || !self.leaves_a_disk(vertex, target) {
                continue;
            }
            let cost = self.cost(vertex, target);
            if best.as_ref().is_none_or(|best| cost < best.cost) {
                best = Some(Candidate {
                    cost,
                    vertex,
                    target,
                });
            }
        }
        best
    }

    /// The link condition: the ends of the edge share no neighbours but those of its triangles,
    /// and the edge does not cut through the disk.
    fn leaves_a_disk(&mut self, vertex: u32, target: u32) -> bool {
        let star = self.stars[vertex as usize].iter();
        let shared = star
            .filter(|&&t| self.corners[t as usize].contains(&target))
            .count();
        let both = self.on_boundary[vertex as usize] && self.on_boundary[target as usize];
        let on_one_side = self.on_boundary[vertex as usize] && !self.on_boundary[target as usize];
        if on_one_side || both && shared == 2 {
            return false;
        }
        self.mark += 1;
        for neighbor in self.ring(vertex) {
            self.marks[neighbor as usize] = self.mark;
        }
        let common = self.ring(target).into_iter();
        common
            .filter(|&n| self.marks[n as usize] == self.mark)
            .count()
            == shared
    }

    /// How bad the triangles would be, times the square of the distance: short edges go first,
    /// folds last.
    fn cost(&self, vertex: u32, target: u32) -> f64 {
        let point = |v: u32| self.points[v as usize];
        let mut worst: f64 = 1.0;
        for &triangle in &self.stars[vertex as usize] {
            let [a, b] = self.opposite(triangle, vertex);
            if a == target || b == target {
                continue;
            }
            let [before, after] = [vertex, target].map(|v| normal([point(v), point(a), point(b)]));
            let sides = [
                point(a) - point(target),
                point(b) - point(a),
                point(target) - point(b),
            ];
            let longest = sides.iter().map(|s| s.length_squared()).fold(0.0, f64::max);
            let shape = longest / after.length().max(f64::MIN_POSITIVE);
            let folded = before.dot(after) < FOLDED * before.length() * after.length();
            worst = worst.max(if folded { FOLD_COST * shape } else { shape });
        }
        worst * point(vertex).distance_squared(point(target))
    }
}

/// Normal of a triangle, as long as twice its area.
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Topology, TriangleMesh};
    use graticule_fixtures::disk;

    fn coarsening(rings: u32) -> (Coarsening, Vec<[u32; 3]>) {
        let fixture = disk(rings);
        let mesh = TriangleMesh::new(fixture.positions.len(), &fixture.triangles).unwrap();
        let on_boundary = mesh
            .vertices()
            .map(|v| mesh.is_boundary_vertex(v))
            .collect();
        let coarse = Coarsening::new(&fixture.triangles, &fixture.positions, on_boundary);
        (coarse, fixture.triangles)
    }

    fn is_disk(coarse: &Coarsening) -> bool {
        let triangles: Vec<_> = coarse.triangles().map(|t| coarse.triangle(t)).collect();
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let number = |v: u32| used.binary_search(&v).unwrap() as u32;
        let triangles: Vec<_> = triangles.iter().map(|t| t.map(number)).collect();
        let mesh = TriangleMesh::new(used.len(), &triangles).unwrap();
        Topology::of(&mesh).total.is_disk()
    }

    #[test]
    fn a_disk_stays_one_down_to_a_triangle() {
        let (mut coarse, _) = coarsening(6);
        while coarse.round() > 0 {
            assert!(is_disk(&coarse));
        }
        assert_eq!(coarse.vertex_count(), 3);
        assert_eq!(coarse.triangles().count(), 1);
    }

    #[test]
    fn what_went_comes_back_as_it_was() {
        let (mut coarse, triangles) = coarsening(5);
        while coarse.round() > 0 {}
        while let Some(collapse) = coarse.restore() {
            let link = coarse.link(&collapse);
            assert_eq!(link.len(), collapse.star.len());
            assert!(link.iter().flatten().any(|&v| v == collapse.target));
        }
        let restored: Vec<_> = coarse.triangles().map(|t| coarse.triangle(t)).collect();
        assert_eq!(restored, triangles);
    }
}
