use std::collections::HashSet;

use glam::DVec3;

use super::doublets::remove_doublets;
use super::partition::{Partition, ordered};
use super::polygon_mesh::PolygonMesh;
use super::sides::Sides;
use crate::geometry::TriangleTree;
use crate::mesh::{Polygons, Surface, SurfacePoint};

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
    let mut cutter = Cutter::new(mesh.clone(), surface);
    cutter.cut();
    cutter.report.doublets = remove_doublets(&mut cutter.mesh);
    (cutter.mesh, cutter.report)
}

/// Makes all polygons quads, in the number that they cover: odd polygons are joined in pairs by
/// chains of edges, each of which gets a vertex in its middle, so that all become even; even ones
/// are cut into quads.
///
/// On a surface with boundary a chain may end there. Only polygons along chains change.
#[must_use]
pub fn pure_quads(mesh: &PolygonMesh, surface: &Surface) -> (PolygonMesh, CutReport) {
    let mut cutter = Cutter::new(mesh.clone(), surface);
    cutter.make_even();
    cutter.cut();
    cutter.report.doublets = remove_doublets(&mut cutter.mesh);
    (cutter.mesh, cutter.report)
}

/// A mesh whose polygons are being cut.
struct Cutter<'a> {
    mesh: PolygonMesh,
    surface: &'a Surface,
    tree: Option<TriangleTree>,
    report: CutReport,
}

impl<'a> Cutter<'a> {
    fn new(mesh: PolygonMesh, surface: &'a Surface) -> Self {
        Self {
            mesh,
            surface,
            tree: None,
            report: CutReport::default(),
        }
    }

    /// Adds a vertex at the point of the surface nearest to this one.
    fn add_vertex(&mut self, place: DVec3) -> u32 {
        let tree = (self.tree).get_or_insert_with(|| TriangleTree::of_surface(self.surface));
        let origin = tree.closest(place).unwrap_or(SurfacePoint {
            face: crate::mesh::FaceId(0),
            barycentric: [1.0, 0.0, 0.0],
        });
        self.mesh.positions.push(origin.position(self.surface));
        self.mesh.origins.push(origin);
        self.mesh.positions.len() as u32 - 1
    }

    fn make_even(&mut self) {
        let old = std::mem::take(&mut self.mesh.polygons);
        let split = Sides::of(&old).to_split(&old);
        let mut middles = std::collections::BTreeMap::new();
        let mut vertices = Vec::new();
        for polygon in 0..old.len() {
            vertices.clear();
            let corners = old.vertices(polygon);
            for (index, side) in old.corner_range(polygon).enumerate() {
                let (from, to) = (corners[index], corners[(index + 1) % corners.len()]);
                vertices.push(from);
                if split[side] {
                    let known = middles.get(&ordered(from, to)).copied();
                    vertices.push(known.unwrap_or_else(|| {
                        let ends = [from, to].map(|v| self.mesh.positions[v as usize]);
                        let middle = self.add_vertex((ends[0] + ends[1]) / 2.0);
                        middles.insert(ordered(from, to), middle);
                        middle
                    }));
                }
            }
            self.mesh.polygons.push(&vertices);
        }
        self.report.edges_split = middles.len();
        let halves = |edge: [u32; 2]| match middles.get(&edge) {
            Some(&middle) => vec![ordered(edge[0], middle), ordered(edge[1], middle)],
            None => vec![edge],
        };
        let edges = std::mem::take(&mut self.mesh.feature_edges);
        self.mesh.feature_edges = edges.into_iter().flat_map(halves).collect();
        self.mesh.feature_edges.sort_unstable();
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
        let mut cut = Polygons::with_capacity(old.len(), old.corner_count());
        for polygon in 0..old.len() {
            let corners = old.vertices(polygon);
            if corners.len() <= 4 {
                cut.push(corners);
                continue;
            }
            self.report.polygons_cut += 1;
            let pieces = Partition::new(&self.mesh.positions, &mut edges).pieces(corners);
            for piece in pieces.unwrap_or_else(|| self.star(corners)) {
                cut.push(&piece);
            }
        }
        self.mesh.polygons = cut;
    }

    /// Pieces round a new vertex in the middle, joined to every other corner.
    fn star(&mut self, corners: &[u32]) -> Vec<Vec<u32>> {
        let sum: DVec3 = (corners.iter())
            .map(|&vertex| self.mesh.positions[vertex as usize])
            .sum();
        let middle = self.add_vertex(sum / corners.len() as f64);
        self.report.middles += 1;
        (0..corners.len())
            .step_by(2)
            .map(|index| {
                let ahead = [1, 2].map(|step| corners[(index + step) % corners.len()]);
                let mut piece = vec![middle, corners[index], ahead[0], ahead[1]];
                // The last piece of an odd polygon ends at the first corner.
                if index + 1 == corners.len() {
                    piece.pop();
                }
                piece
            })
            .collect()
    }
}
