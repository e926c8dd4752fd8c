use std::collections::{BTreeMap, HashSet};

use glam::DVec3;

use super::doublets::{remove_doublets, vertices_on_lines};
use super::partition::{MIDDLE, Partition, Pieces, WEIGHED_CORNERS, halves, ordered};
use super::polygon_mesh::PolygonMesh;
use super::shape::Lines;
use super::sides::Parity;
use crate::geometry::slide_towards;
use crate::mesh::{EdgeId, Polygons, Surface, SurfacePoint};

/// Cost of pieces from which on a vertex in the middle is tried: that of a flat corner.
const WORTH_A_MIDDLE: f64 = 1.0;

/// What was done to make quads of other polygons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct CutReport {
    /// Polygons that were no quads.
    pub polygons_cut: usize,
    /// Edges that got a vertex in their middle, so that all polygons are even.
    pub edges_split: usize,
    /// Polygons that got a vertex in their middle.
    pub middles: usize,
    /// Vertices with two quads and nothing else that were taken out.
    pub doublets: usize,
}

/// Cuts polygons with more than four corners into quads, and one triangle each where the corners are
/// odd in number ([PGP06] §5), by the shapes of the pieces.
///
/// [PGP06]: crate::papers::PGP06
#[must_use]
pub fn quad_dominant(mesh: &PolygonMesh, surface: &Surface) -> (PolygonMesh, CutReport) {
    let mut cutter = Cutter::new(mesh.clone(), surface, &[]);
    cutter.cut();
    cutter.report.doublets = remove_doublets(&mut cutter.mesh);
    (cutter.mesh, cutter.report)
}

/// Makes all polygons quads, in the number that they cover: odd polygons are joined in pairs by
/// chains of edges, each of which gets a vertex in its middle, so that all become even; even ones
/// are cut into quads.
///
/// On a surface with boundary a chain may end there. Only polygons along chains change. Chains
/// keep off features and the boundary where they can, whose vertices stay straight; a vertex that
/// such an edge gets lies on the boundary of the surface or on one of its edges in `features`.
#[must_use]
pub fn pure_quads(
    mesh: &PolygonMesh,
    surface: &Surface,
    features: &[EdgeId],
) -> (PolygonMesh, CutReport) {
    let mut cutter = Cutter::new(mesh.clone(), surface, features);
    cutter.make_even();
    cutter.cut();
    cutter.report.doublets = remove_doublets(&mut cutter.mesh);
    (cutter.mesh, cutter.report)
}

/// A mesh whose polygons are being cut.
struct Cutter<'a> {
    mesh: PolygonMesh,
    surface: &'a Surface,
    features: &'a [EdgeId],
    /// Features and boundary, once they are needed.
    lines: Option<Lines>,
    report: CutReport,
}

impl<'a> Cutter<'a> {
    fn new(mesh: PolygonMesh, surface: &'a Surface, features: &'a [EdgeId]) -> Self {
        Self {
            mesh,
            surface,
            features,
            lines: None,
            report: CutReport::default(),
        }
    }

    /// Adds a vertex at the point of the surface near this one, on the sheet of the corner that
    /// is nearest: another sheet may be nearer, on thin parts.
    fn add_vertex(&mut self, place: DVec3, corners: &[u32]) -> u32 {
        let distance = |&corner: &u32| self.mesh.positions[corner as usize].distance_squared(place);
        let nearest = corners
            .iter()
            .copied()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let start = self.mesh.origins[nearest.map_or(0, |corner| corner as usize)];
        self.add_origin(slide_towards(self.surface, start, place))
    }

    /// Adds a vertex at the point near this one of the lines that the ends of an edge are on.
    fn add_vertex_on_line(&mut self, place: DVec3, ends: [u32; 2]) -> u32 {
        let origins = ends.map(|end| self.mesh.origins[end as usize]);
        let lines = self
            .lines
            .get_or_insert_with(|| Lines::new(self.surface, self.features, f64::NEG_INFINITY));
        match lines.between(self.surface, origins, place) {
            Some(origin) => self.add_origin(origin),
            None => self.add_vertex(place, &ends),
        }
    }

    fn add_origin(&mut self, origin: SurfacePoint) -> u32 {
        self.mesh.positions.push(origin.position(self.surface));
        self.mesh.origins.push(origin);
        self.mesh.positions.len() as u32 - 1
    }

    fn make_even(&mut self) {
        let old = std::mem::take(&mut self.mesh.polygons);
        let features = std::mem::take(&mut self.mesh.feature_edges);
        let is_feature = |[a, b]: [u32; 2]| features.binary_search(&ordered(a, b)).is_ok();
        let parity = Parity::new(&old, is_feature);
        let is_line: Vec<bool> = (0..old.corner_count())
            .map(|side| parity.is_line(side))
            .collect();
        let split = parity.into_split();
        let mut middles = BTreeMap::new();
        let mut vertices = Vec::new();
        for polygon in 0..old.len() {
            vertices.clear();
            let corners = old.vertices(polygon);
            for (index, side) in old.corner_range(polygon).enumerate() {
                let (from, to) = (corners[index], corners[(index + 1) % corners.len()]);
                vertices.push(from);
                if split[side] {
                    let middle = *middles
                        .entry(ordered(from, to))
                        .or_insert_with(|| self.add_middle([from, to], is_line[side]));
                    vertices.push(middle);
                }
            }
            self.mesh.polygons.push(&vertices);
        }
        self.report.edges_split = middles.len();
        let halves = |edge: [u32; 2]| match middles.get(&edge) {
            Some(&middle) => vec![ordered(edge[0], middle), ordered(edge[1], middle)],
            None => vec![edge],
        };
        self.mesh.feature_edges = features.into_iter().flat_map(halves).collect();
        self.mesh.feature_edges.sort_unstable();
    }

    /// Adds a vertex in the middle of an edge.
    fn add_middle(&mut self, ends: [u32; 2], on_line: bool) -> u32 {
        let [from, to] = ends.map(|vertex| self.mesh.positions[vertex as usize]);
        let middle = (from + to) / 2.0;
        if on_line {
            self.add_vertex_on_line(middle, ends)
        } else {
            self.add_vertex(middle, &ends)
        }
    }

    fn cut(&mut self) {
        let old = std::mem::take(&mut self.mesh.polygons);
        let mut edges = HashSet::with_capacity(old.corner_count());
        for polygon in 0..old.len() {
            let corners = old.vertices(polygon);
            for (index, &from) in corners.iter().enumerate() {
                edges.insert(ordered(from, corners[(index + 1) % corners.len()]));
            }
        }
        let count = self.mesh.positions.len();
        let held = vertices_on_lines(&old, &self.mesh.feature_edges, count);
        let mut cut = Polygons::with_capacity(old.len(), old.corner_count());
        for polygon in 0..old.len() {
            let corners = old.vertices(polygon);
            self.report.polygons_cut += usize::from(corners.len() > 4);
            for piece in self.pieces(corners.to_vec(), &held, &mut edges) {
                cut.push(&piece);
            }
        }
        self.mesh.polygons = cut;
    }

    /// The pieces of a polygon; their sides are added to `edges`.
    fn pieces(
        &mut self,
        polygon: Vec<u32>,
        held: &[bool],
        edges: &mut HashSet<[u32; 2]>,
    ) -> Vec<Vec<u32>> {
        let mut pieces = Vec::new();
        let mut open = vec![polygon];
        while let Some(corners) = open.pop() {
            if corners.len() <= 4 {
                pieces.push(corners);
            } else if corners.len() <= WEIGHED_CORNERS {
                pieces.extend(self.best_pieces(&corners, held, edges));
            } else if let Some(halves) = halves(&corners, &self.mesh.positions, edges) {
                edges.insert(ordered(halves[1][0], halves[0][0]));
                open.extend(halves);
            } else {
                pieces.extend(self.star(&corners));
            }
        }
        for piece in &pieces {
            let next = piece.iter().cycle().skip(1);
            edges.extend(piece.iter().zip(next).map(|(&from, &to)| ordered(from, to)));
        }
        pieces
    }

    /// The better of the best pieces without and with a vertex in the middle.
    fn best_pieces(
        &mut self,
        corners: &[u32],
        held: &[bool],
        edges: &HashSet<[u32; 2]>,
    ) -> Vec<Vec<u32>> {
        let middle = self.middle_of(corners);
        let mut partition = Partition::of(corners, &self.mesh.positions, held, edges);
        let without = partition.without_middle();
        let cost = |pieces: &Option<Pieces>| pieces.as_ref().map_or(f64::INFINITY, |p| p.cost);
        let with = (cost(&without) >= WORTH_A_MIDDLE)
            .then(|| partition.with_middle(middle))
            .flatten();
        if cost(&with) < cost(&without)
            && let Some(with) = with
        {
            return self.around_new_vertex(with.polygons, middle, corners);
        }
        without.map_or_else(|| self.star(corners), |pieces| pieces.polygons)
    }

    fn middle_of(&self, corners: &[u32]) -> DVec3 {
        let positions = corners.iter().map(|&v| self.mesh.positions[v as usize]);
        positions.sum::<DVec3>() / corners.len() as f64
    }

    /// Adds the vertex that the pieces of a polygon have in the middle.
    fn around_new_vertex(
        &mut self,
        mut pieces: Vec<Vec<u32>>,
        middle: DVec3,
        corners: &[u32],
    ) -> Vec<Vec<u32>> {
        let middle = self.add_vertex(middle, corners);
        self.report.middles += 1;
        for vertex in pieces.iter_mut().flatten() {
            if *vertex == MIDDLE {
                *vertex = middle;
            }
        }
        pieces
    }

    /// Pieces round a new vertex in the middle, joined to every other corner.
    fn star(&mut self, corners: &[u32]) -> Vec<Vec<u32>> {
        let pieces = (0..corners.len()).step_by(2).map(|index| {
            let ahead = [1, 2].map(|step| corners[(index + step) % corners.len()]);
            let mut piece = vec![MIDDLE, corners[index], ahead[0], ahead[1]];
            // The last piece of an odd polygon ends at the first corner.
            if index + 1 == corners.len() {
                piece.pop();
            }
            piece
        });
        let pieces = pieces.collect();
        let middle = self.middle_of(corners);
        self.around_new_vertex(pieces, middle, corners)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A roof over a sheet that is nearer to the middle of what spans the roof.
    fn roof_over_sheet() -> (Surface, PolygonMesh) {
        let roof =
            [-1.0, 0.0, 1.0].map(|x: f64| [0.0, 1.0].map(|y| DVec3::new(x, y, 1.0 - x.abs())));
        let sheet = [-0.2, 0.2].map(|x| [0.0, 1.0].map(|y| DVec3::new(x, y, 0.4)));
        let positions: Vec<DVec3> = roof.iter().chain(&sheet).flatten().copied().collect();
        let square = |at: u32| [[at, at + 2, at + 3], [at, at + 3, at + 1]];
        let triangles: Vec<[u32; 3]> = [0, 2, 6].into_iter().flat_map(square).collect();
        let surface = Surface::from_triangles(positions.clone(), &triangles).unwrap();
        let mesh = surface.mesh();
        let corner_at = |vertex| mesh.halfedges().find(|&side| mesh.origin(side) == vertex);
        let origins = mesh
            .vertices()
            .take(6)
            .map(|v| SurfacePoint::at_corner(corner_at(v).unwrap()));
        let mut polygons = Polygons::default();
        polygons.push(&[0, 2, 4, 5, 3, 1]);
        let mesh = PolygonMesh {
            positions: positions[..6].to_vec(),
            polygons,
            origins: origins.collect(),
            feature_edges: Vec::new(),
        };
        (surface, mesh)
    }

    #[test]
    fn new_vertices_stay_on_the_sheet_of_their_polygon() {
        let (surface, mesh) = roof_over_sheet();
        let mut cutter = Cutter::new(mesh, &surface, &[]);
        let middle = cutter.middle_of(&[0, 2, 4, 5, 3, 1]);
        assert!((middle.z - 0.4).abs() < 0.1, "{middle}");
        let vertex = cutter.add_vertex(middle, &[0, 2, 4, 5, 3, 1]);
        let origin = cutter.mesh.origins[vertex as usize];
        assert!(origin.face.0 < 4, "{origin:?}");
    }

    #[test]
    fn new_vertices_on_lines_stay_between_the_ends_of_their_edge() {
        let (surface, mesh) = roof_over_sheet();
        let mut cutter = Cutter::new(mesh, &surface, &[]);
        // The rim of the sheet passes right below.
        let vertex = cutter.add_vertex_on_line(DVec3::new(-0.2, 0.0, 0.4), [0, 2]);
        let position = cutter.mesh.positions[vertex as usize];
        assert!(
            position.distance(DVec3::new(-0.4, 0.0, 0.6)) < 1e-9,
            "{position}"
        );
    }
}
