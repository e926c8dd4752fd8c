use serde::Serialize;

use crate::mesh::{EdgeId, Element, Surface};
use crate::watch::{Stopped, Watch};

use super::flip::Diamond;
use super::mollify::Mollification;
use super::weights::cotangent_weight;
use super::{GeometryError, IntrinsicTriangulation};

/// What [`intrinsic_delaunay`] has done.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DelaunayReport {
    /// Edges flipped, each as often as it was.
    pub flips: usize,
    /// What mollification changed; nothing on a surface whose degenerate triangles could all be
    /// flipped away.
    pub mollification: Mollification,
    /// Whether all edges inside are Delaunay to rounding; if not, a warning was left.
    pub is_complete: bool,
    /// The least cotangent weight of an edge inside, before what is negative by rounding is set
    /// to 0; 0 if there is none.
    pub least_inner_weight: f64,
    /// The least cotangent weight of a boundary edge, negative opposite to an obtuse angle, which
    /// no flip can mend; 0 if there is none.
    pub least_boundary_weight: f64,
}

/// The intrinsic Delaunay triangulation of a surface: no edge inside has a negative cotangent
/// weight, and the surface itself, its area and angles, stays what it was
/// (A. Bobenko, B. Springborn, *A Discrete Laplace–Beltrami Operator for Simplicial Surfaces*,
/// 2007; M. Fisher et al., *An Algorithm for the Construction of Intrinsic Delaunay Triangulations*,
/// 2006).
///
/// Triangles without area inside are flipped away. Only where some remain (at the boundary, or
/// because vertices coincide) their component is mollified: see the report and the warning
/// `mollified`. A boundary edge opposite to an obtuse angle keeps its negative weight.
///
/// Cost: a flip takes constant time, below a microsecond. Real models need 0 to 0.7 flips for each
/// edge; at worst the number grows with the square of the edges, and beyond ten million and a
/// thousand for each edge the run ends with the warning `delaunay-incomplete`. Deterministic.
///
/// # Errors
/// [`GeometryError::Scale`], [`GeometryError::DegenerateFace`] where all vertices of a component
/// coincide, or [`GeometryError::Stopped`].
pub fn intrinsic_delaunay(
    surface: &Surface,
    watch: &Watch,
) -> Result<(IntrinsicTriangulation, DelaunayReport), GeometryError> {
    let mut triangulation = IntrinsicTriangulation::of(surface)?;
    let report = triangulation.make_delaunay(watch)?;
    Ok((triangulation, report))
}

impl IntrinsicTriangulation {
    /// Flips and, where needed, mollifies as [`intrinsic_delaunay`] does.
    ///
    /// # Errors
    /// As [`intrinsic_delaunay`]; the triangulation is sound then too.
    pub fn make_delaunay(&mut self, watch: &Watch) -> Result<DelaunayReport, GeometryError> {
        let _stage = watch.stage("intrinsic Delaunay triangulation");
        let mut run = FlipRun::new(self.edge_count());
        run.flip_all(self, watch)?;
        let mollification = self.mollify();
        if mollification.components > 0 {
            watch.warn("mollified", mollified_message(&mollification));
            run.flip_all(self, watch)?;
        }
        if !run.is_complete() {
            let flips = run.flips;
            let message = format!("edge flips stopped after {flips}: some weights are negative");
            watch.warn("delaunay-incomplete", message);
        }
        let [least_inner_weight, least_boundary_weight] = self.least_weights()?;
        Ok(DelaunayReport {
            flips: run.flips,
            mollification,
            is_complete: run.is_complete(),
            least_inner_weight,
            least_boundary_weight,
        })
    }

    /// Least cotangent weights inside and on the boundary.
    fn least_weights(&self) -> Result<[f64; 2], GeometryError> {
        let mut least = [f64::INFINITY; 2];
        for edge in self.edges() {
            let kind = usize::from(self.is_boundary_edge(edge));
            least[kind] = least[kind].min(cotangent_weight(self, edge)?);
        }
        Ok(least.map(|weight| if weight.is_finite() { weight } else { 0.0 }))
    }
}

fn mollified_message(mollification: &Mollification) -> String {
    let Mollification {
        faces,
        components,
        largest_shift,
    } = mollification;
    format!(
        "{faces} degenerate triangles: up to {largest_shift:e} was added to all edge lengths of \
         {components} component(s)"
    )
}

struct FlipRun {
    stack: Vec<EdgeId>,
    is_waiting: Vec<bool>,
    flips: usize,
    limit: usize,
}

impl FlipRun {
    fn new(edges: usize) -> Self {
        Self {
            stack: Vec::with_capacity(edges),
            is_waiting: vec![false; edges],
            flips: 0,
            // Real models need less than one flip for each edge; a strip of `n` sheared cells needs
            // some n² / 3. Beyond this, a minute or so, the run ends and says so.
            limit: 10_000_000 + 1_000 * edges,
        }
    }

    fn is_complete(&self) -> bool {
        self.stack.is_empty()
    }

    /// Flips until no edge has a negative weight. A stack rather than a queue: the next edge looked
    /// at is near the last, in the surface and in memory.
    fn flip_all(
        &mut self,
        triangulation: &mut IntrinsicTriangulation,
        watch: &Watch,
    ) -> Result<(), Stopped> {
        for edge in (0..triangulation.edge_count()).rev() {
            self.wait(EdgeId::from_index(edge));
        }
        let mut looked_at = 0_usize;
        while self.flips < self.limit {
            let Some(edge) = self.stack.pop() else {
                break;
            };
            self.is_waiting[edge.index()] = false;
            looked_at += 1;
            if looked_at.is_multiple_of(1 << 14) {
                watch.check()?;
            }
            let diamond = Diamond::around(triangulation, edge);
            if diamond.is_some_and(|diamond| diamond.is_negative()) && triangulation.flip(edge) {
                self.flips += 1;
                self.wait_around(triangulation, edge);
            }
        }
        Ok(())
    }

    fn wait(&mut self, edge: EdgeId) {
        let is_waiting = &mut self.is_waiting[edge.index()];
        if !*is_waiting {
            *is_waiting = true;
            self.stack.push(edge);
        }
    }

    fn wait_around(&mut self, triangulation: &IntrinsicTriangulation, edge: EdgeId) {
        let halfedge = triangulation.edge_halfedge(edge);
        for side in [Some(halfedge), triangulation.twin(halfedge)]
            .into_iter()
            .flatten()
        {
            self.wait(triangulation.edge(side.next()));
            self.wait(triangulation.edge(side.previous()));
        }
    }
}
