//! Where a map would be distorted most: the logarithmic scale of the flat conformal metric that
//! keeps the lengths along a seam (Ben-Chen, Gotsman, Bunin 2008, *Conformal Flattening by Curvature
//! Prescription and Metric Scaling*; it is the least distorted among conformal ones: Springborn,
//! Schröder, Pinkall 2008).

use crate::flatten::FlattenError;
use crate::geometry::{IntrinsicTriangulation, TriangleShape, angle_defects, cotangent_weights};
use crate::mesh::{Element, PerVertex, Surface, TriangleMesh, VertexId};
use crate::solve::{DirichletSystem, Placement, SolveError, SymmetricMatrix};
use crate::watch::Watch;

/// The share of the strongest distortion down to which a region around a tip reaches.
const REGION: f64 = 0.5;

/// The Laplacian of a surface and the curvature that it has to take away.
pub(super) struct Tips<'a> {
    surface: &'a Surface,
    laplacian: SymmetricMatrix,
    curvature: PerVertex<f64>,
}

impl<'a> Tips<'a> {
    pub(super) fn new(surface: &'a Surface, watch: &Watch) -> Result<Self, FlattenError> {
        let mut triangulation = IntrinsicTriangulation::of(surface)?;
        if triangulation
            .shapes()
            .iter()
            .any(TriangleShape::is_degenerate)
        {
            triangulation.mollify();
        }
        let curvature = angle_defects(&triangulation);
        triangulation.make_delaunay(watch)?;
        let weights = cotangent_weights(&triangulation)?;
        let edges = weights.ends.iter().zip(&weights.weights);
        let edges = edges.map(|(ends, &weight)| (ends.map(VertexId::index), weight));
        let laplacian = SymmetricMatrix::laplacian(surface.mesh().vertex_count(), edges)?;
        Ok(Self {
            surface,
            laplacian,
            curvature,
        })
    }

    /// The size of the logarithmic scale at each vertex, 0 at those that keep their lengths.
    fn scales(&self, kept: &PerVertex<bool>) -> Result<PerVertex<f64>, SolveError> {
        let fixed: Vec<usize> = (0..kept.len()).filter(|&v| kept.as_slice()[v]).collect();
        let points = self.surface.positions().as_slice();
        let system = DirichletSystem::new(&self.laplacian, &fixed, Placement::at(points))?;
        let zeros = vec![0.0; fixed.len()];
        let solution = system.solve_with_loads(&zeros, self.curvature.as_slice())?;
        Ok(PerVertex::new(
            solution.values.into_iter().map(f64::abs).collect(),
        ))
    }

    /// The vertex whose scale changes most.
    pub(super) fn strongest(&self, kept: &PerVertex<bool>) -> Result<VertexId, SolveError> {
        let scales = self.scales(kept)?;
        let all = self.surface.mesh().vertices();
        Ok(strongest_of(&scales, all))
    }

    /// Vertices whose scale changes by more than `threshold`, strongest first: one for each region
    /// of strong changes.
    pub(super) fn above(
        &self,
        kept: &PerVertex<bool>,
        threshold: f64,
    ) -> Result<Vec<VertexId>, SolveError> {
        let mesh = self.surface.mesh();
        let scales = self.scales(kept)?;
        let strongest = scales[strongest_of(&scales, mesh.vertices())];
        if strongest <= threshold {
            return Ok(Vec::new());
        }
        let bound = threshold.max(REGION * strongest);
        let mut tips: Vec<VertexId> = regions(mesh, |vertex| scales[vertex] > bound)
            .into_iter()
            .map(|region| strongest_of(&scales, region.into_iter()))
            .collect();
        tips.sort_by(|&a, &b| scales[b].total_cmp(&scales[a]).then(a.cmp(&b)));
        Ok(tips)
    }
}

fn strongest_of(scales: &PerVertex<f64>, vertices: impl Iterator<Item = VertexId>) -> VertexId {
    let stronger = |best: VertexId, vertex: VertexId| {
        if scales[vertex] > scales[best] {
            vertex
        } else {
            best
        }
    };
    vertices.reduce(stronger).unwrap_or(VertexId(0))
}

/// Connected sets of the vertices that `belongs` names, in the order of their smallest ones.
fn regions(mesh: &TriangleMesh, belongs: impl Fn(VertexId) -> bool) -> Vec<Vec<VertexId>> {
    let mut seen = PerVertex::filled(mesh.vertex_count(), false);
    let mut regions = Vec::new();
    for seed in mesh.vertices() {
        if seen[seed] || !belongs(seed) {
            continue;
        }
        seen[seed] = true;
        let mut region = vec![seed];
        let mut next = 0;
        while let Some(&vertex) = region.get(next) {
            next += 1;
            for neighbor in mesh.neighbors(vertex) {
                if !seen[neighbor] && belongs(neighbor) {
                    seen[neighbor] = true;
                    region.push(neighbor);
                }
            }
        }
        regions.push(region);
    }
    regions
}
