use std::f64::consts::PI;

use glam::DVec2;

use super::graded::graded_turns;
use super::{PrincipalCurvature, Symmetry};
use crate::geometry::{IntrinsicTriangulation, reverse_direction};
use crate::mesh::{EdgeId, HalfedgeId, PerCorner, PerVertex, TriangleMesh, VertexId};
use crate::tolerance::AGREEING_EDGES;

/// How strongly a field is held to a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strength {
    /// With this weight; a fully trusted direction of curvature has the weight 3.
    Soft(f64),
    /// Exactly.
    Hard,
}

/// The weight of a fully trusted direction of curvature: at the default smoothing a field turns from
/// one to another over some two edges. The weight `|kmax / kmin|` of [PGP06] Eq. 21 is about this where
/// a surface bends clearly, and has no bound.
///
/// [PGP06]: crate::papers::PGP06
pub(super) const CURVATURE_WEIGHT: f64 = 3.0;

/// What a field should follow: at each vertex any number of directions with weights, or one that
/// is fixed.
#[derive(Clone, Debug, PartialEq)]
pub struct Guidance {
    symmetry: Symmetry,
    /// Sum of weight × power of the direction.
    pulls: PerVertex<DVec2>,
    weights: PerVertex<f64>,
    fixed: PerVertex<Option<DVec2>>,
    /// The logarithm of how dense lines are to be; `None` for the same everywhere.
    density: Option<PerVertex<f64>>,
}

impl Guidance {
    /// No wish at all.
    #[must_use]
    pub fn none(symmetry: Symmetry, vertex_count: usize) -> Self {
        Self {
            symmetry,
            pulls: PerVertex::filled(vertex_count, DVec2::ZERO),
            weights: PerVertex::filled(vertex_count, 0.0),
            fixed: PerVertex::filled(vertex_count, None),
            density: None,
        }
    }

    /// The directions of the larger curvature, as far as they can be trusted
    /// ([PGP06] Eq. 21, with a bounded weight in place of `|kmax / kmin|`).
    ///
    /// [PGP06]: crate::papers::PGP06
    #[must_use]
    pub fn from_curvature(symmetry: Symmetry, curvatures: &PerVertex<PrincipalCurvature>) -> Self {
        let mut guidance = Self::none(symmetry, curvatures.len());
        for (vertex, curvature) in curvatures.enumerate() {
            let strength = Strength::Soft(CURVATURE_WEIGHT * curvature.confidence);
            guidance.follow(vertex, curvature.direction, strength);
        }
        guidance
    }

    /// The symmetry of the field that is guided.
    #[must_use]
    pub fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    /// Asks the field to have this angle, in the tangent plane of the vertex, among its own. A soft
    /// wish adds to those before it, a hard one replaces a hard one.
    ///
    /// Wishes that are no numbers are not heard.
    pub fn follow(&mut self, vertex: VertexId, angle: f64, strength: Strength) {
        if !angle.is_finite() {
            return;
        }
        let power = self.symmetry.power(angle);
        match strength {
            Strength::Soft(weight) if weight.is_finite() && weight > 0.0 => {
                self.pulls[vertex] += power * weight;
                self.weights[vertex] += weight;
            }
            Strength::Soft(_) => {}
            Strength::Hard => self.fixed[vertex] = Some(power),
        }
    }

    /// Asks the field to run along these edges at both their ends. `triangulation` must have the
    /// edges of `mesh`.
    ///
    /// Where several of the edges meet at a vertex and their directions do not agree up to the
    /// symmetry, as at most corners, the vertex is left free.
    pub fn follow_edges(
        &mut self,
        triangulation: &IntrinsicTriangulation,
        edges: impl IntoIterator<Item = EdgeId>,
        strength: Strength,
    ) {
        let mut sums = std::collections::BTreeMap::<VertexId, (DVec2, u32)>::new();
        for edge in edges {
            let halfedge = triangulation.edge_halfedge(edge);
            let [from, to] = triangulation.ends(halfedge);
            for (vertex, angle) in [
                (from, triangulation.direction(halfedge)),
                (to, reverse_direction(triangulation, halfedge)),
            ] {
                let (sum, count) = sums.entry(vertex).or_default();
                *sum += self.edge_power(angle);
                *count += 1;
            }
        }
        for (vertex, (sum, count)) in sums {
            if sum.length() >= AGREEING_EDGES * f64::from(count) {
                self.follow(vertex, self.edge_angle(sum), strength);
            }
        }
    }

    /// Asks the field to run along the boundary; a field of vectors, with the surface on its left.
    pub fn follow_boundary(
        &mut self,
        mesh: &TriangleMesh,
        triangulation: &IntrinsicTriangulation,
        strength: Strength,
    ) {
        if self.symmetry == Symmetry::Vector {
            return self.follow_boundary_onward(mesh, triangulation, strength);
        }
        let halfedges = mesh.boundary_loops().flat_map(|l| mesh.boundary_loop(l));
        let edges: Vec<_> = halfedges.map(|&h: &HalfedgeId| mesh.edge(h)).collect();
        self.follow_edges(triangulation, edges, strength);
    }

    /// At each boundary vertex the mean of the directions in which the boundary arrives and leaves.
    fn follow_boundary_onward(
        &mut self,
        mesh: &TriangleMesh,
        triangulation: &IntrinsicTriangulation,
        strength: Strength,
    ) {
        for &halfedge in mesh.boundary_loops().flat_map(|l| mesh.boundary_loop(l)) {
            let [from, to] = mesh.ends(halfedge);
            let leaving = triangulation.direction(halfedge);
            let arriving = reverse_direction(triangulation, halfedge) + PI;
            for (vertex, angle) in [(from, leaving), (to, arriving)] {
                match (strength, self.fixed[vertex]) {
                    (Strength::Hard, Some(other)) => {
                        let mean = (other + self.symmetry.power(angle)).try_normalize();
                        self.fixed[vertex] = mean;
                    }
                    _ => self.follow(vertex, angle, strength),
                }
            }
        }
    }

    /// Lets soft wishes so far count for this share, 0 to 1, of what they did.
    pub fn lighten(&mut self, share: f64) {
        for pull in self.pulls.as_mut_slice() {
            *pull *= share;
        }
        for weight in self.weights.as_mut_slice() {
            *weight *= share;
        }
    }

    /// Asks the field to be smooth in the metric in which lines of these distances, above 0, lie
    /// equally far apart everywhere.
    pub fn follow_sizes(&mut self, sizes: &PerVertex<f64>) {
        self.density = Some(sizes.map(|&size| -libm::log(size)));
    }

    /// By how much more directions turn along halfedges for the sizes that are followed.
    pub(super) fn graded_turns(
        &self,
        triangulation: &IntrinsicTriangulation,
    ) -> Option<PerCorner<f64>> {
        let density = self.density.as_ref();
        density.map(|density| graded_turns(triangulation, density))
    }

    /// The number of vertices whose direction is fixed.
    #[must_use]
    pub fn fixed_count(&self) -> usize {
        self.fixed.iter().flatten().count()
    }

    /// An edge has no direction along itself, so that its two ends agree up to a half turn at
    /// least.
    fn edge_power(&self, angle: f64) -> DVec2 {
        self.edge_symmetry().power(angle)
    }

    fn edge_angle(&self, power: DVec2) -> f64 {
        self.edge_symmetry().root(power)
    }

    fn edge_symmetry(&self) -> Symmetry {
        match self.symmetry {
            Symmetry::Cross => Symmetry::Cross,
            Symmetry::Vector | Symmetry::Line => Symmetry::Line,
        }
    }

    pub(super) fn vertex_count(&self) -> usize {
        self.weights.len()
    }

    pub(super) fn pull(&self, vertex: VertexId) -> DVec2 {
        self.pulls[vertex]
    }

    pub(super) fn weight(&self, vertex: VertexId) -> f64 {
        self.weights[vertex]
    }

    pub(super) fn fixed(&self, vertex: VertexId) -> Option<DVec2> {
        self.fixed[vertex]
    }

    /// Whether the directions at both ends of a halfedge are fixed, and with them the turn along it.
    pub(super) fn holds_ends(&self, mesh: &TriangleMesh, halfedge: HalfedgeId) -> bool {
        mesh.ends(halfedge)
            .iter()
            .all(|&vertex| self.fixed[vertex].is_some())
    }
}
