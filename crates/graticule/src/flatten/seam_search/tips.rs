//! Where a map would be distorted most: the logarithmic scale of the flat conformal metric that is
//! least distorted (Ben-Chen, Gotsman, Bunin 2008, *Conformal Flattening by Curvature Prescription
//! and Metric Scaling*; Springborn, Schröder, Pinkall 2008: the scale is constant along each loop of
//! the boundary). The outer loop keeps its length; any other is scaled so that it can be a hole in
//! the plane, which turns by -2π. An open tube so shows that it must be cut from end to end, a
//! window in its side that it need not.

use std::f64::consts::TAU;

use glam::DVec3;

use super::rims::Rims;
use crate::flatten::FlattenError;
use crate::geometry::{IntrinsicTriangulation, TriangleShape, angle_defects, cotangent_weights};
use crate::mesh::{PerVertex, Surface, TriangleMesh, VertexId};
use crate::solve::{DirichletSystem, Placement, SolveError, SymmetricMatrix};
use crate::watch::Watch;

/// The share of the strongest distortion down to which a region around a tip reaches.
const REGION: f64 = 0.5;

/// The Laplacian of a surface and the curvature that it has to take away.
pub(super) struct Tips<'a> {
    surface: &'a Surface,
    /// The ends of each edge of the Laplacian and its weight.
    weights: Vec<([VertexId; 2], f64)>,
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
        Ok(Self {
            surface,
            weights: weights.ends.into_iter().zip(weights.weights).collect(),
            curvature,
        })
    }

    /// A vertex of the rim that is the outer loop: that which turns most where all keep their
    /// lengths.
    pub(super) fn on_outer(&self, rims: &Rims) -> Result<VertexId, SolveError> {
        let all: Vec<usize> = rims.rims().map(|(node, _)| node).collect();
        let mut outer = all.first().copied().unwrap_or(0);
        if all.len() > 1 {
            let laplacian = self.laplacian(rims)?;
            let loads = self.loads(rims);
            let flux = laplacian.multiply(&self.solution(rims, &laplacian, &loads, &all)?);
            let excess = |node: usize| loads[node] - flux[node];
            for node in all {
                if excess(node) > excess(outer) {
                    outer = node;
                }
            }
        }
        let mut vertices = self.surface.mesh().vertices();
        let found = vertices.find(|&vertex| rims.node(vertex) == outer);
        Ok(found.unwrap_or(VertexId(0)))
    }

    /// The vertex whose scale changes most where one vertex keeps its length.
    pub(super) fn farthest(&self, from: VertexId) -> Result<VertexId, SolveError> {
        let rims = Rims::point(self.surface.mesh(), from);
        self.strongest(&rims, rims.node(from))
    }

    /// The vertex whose scale changes most where the outer rim keeps its length.
    pub(super) fn strongest(&self, rims: &Rims, outer: usize) -> Result<VertexId, SolveError> {
        let scales = self.scales(rims, outer)?;
        Ok(strongest_of(&scales, self.surface.mesh().vertices()))
    }

    /// Vertices whose scale changes by more than `threshold`, strongest first: one for each region
    /// of strong changes.
    pub(super) fn above(
        &self,
        rims: &Rims,
        outer: usize,
        threshold: f64,
    ) -> Result<Vec<VertexId>, SolveError> {
        let mesh = self.surface.mesh();
        let scales = self.scales(rims, outer)?;
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

    /// The size of the logarithmic scale at each vertex, 0 at the outer rim.
    fn scales(&self, rims: &Rims, outer: usize) -> Result<PerVertex<f64>, SolveError> {
        let laplacian = self.laplacian(rims)?;
        let values = self.solution(rims, &laplacian, &self.loads(rims), &[outer])?;
        let all = self.surface.mesh().vertex_count();
        Ok(PerVertex::from_fn(all, |vertex| {
            values[rims.node(vertex)].abs()
        }))
    }

    fn laplacian(&self, rims: &Rims) -> Result<SymmetricMatrix, SolveError> {
        let edges = self
            .weights
            .iter()
            .map(|&(ends, weight)| (ends.map(|end| rims.node(end)), weight))
            .filter(|([from, to], _)| from != to);
        SymmetricMatrix::laplacian(rims.node_count(), edges)
    }

    /// What each node has to lose: a vertex its curvature, a rim what it turns beyond a hole.
    fn loads(&self, rims: &Rims) -> Vec<f64> {
        let mut loads = vec![0.0; rims.node_count()];
        for (vertex, curvature) in self.curvature.enumerate() {
            loads[rims.node(vertex)] += curvature;
        }
        for (node, characteristic) in rims.rims() {
            loads[node] += TAU * f64::from(1 - characteristic);
        }
        loads
    }

    /// The solution for the loads that is 0 at some nodes.
    fn solution(
        &self,
        rims: &Rims,
        laplacian: &SymmetricMatrix,
        loads: &[f64],
        zeros: &[usize],
    ) -> Result<Vec<f64>, SolveError> {
        let mut points = vec![DVec3::ZERO; rims.node_count()];
        for (vertex, &position) in self.surface.positions().enumerate() {
            points[rims.node(vertex)] = position;
        }
        let system = DirichletSystem::new(laplacian, zeros, Placement::at(&points))?;
        let values = system
            .solve_with_loads(&vec![0.0; zeros.len()], loads)?
            .values;
        Ok(values)
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
