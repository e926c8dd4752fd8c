use glam::DVec2;

use super::alignment::whole_coordinates;
use super::energy::{energy_weights, phase_graph};
use super::phase_graph::FIXED;
use super::refine::refine;
use super::unroll::{FaceKind, VertexFrames, angles_of_phases, face_kinds};
use super::untangle::Untangling;
use super::{
    EdgeSteps, EnergyTriangles, GRID_EXTENT, MinimizationReport, ParameterizationReport,
    ParameterizeOptions, PeriodicError, RegularDistortion, SingularElements, edge_steps,
};
use crate::field::CrossField;
use crate::geometry::{
    EdgeLengths, IntrinsicTriangulation, Similarity, face_areas, face_shapes, intrinsic_delaunay,
    vertex_areas,
};
use crate::mesh::{EdgeId, Element, FaceId, PerEdge, PerFace, PerVertex, Surface, VertexId};
use crate::watch::Watch;

/// What every step stands on.
pub(super) struct Ground<'a> {
    surface: &'a Surface,
    field: &'a CrossField,
    options: &'a ParameterizeOptions,
    own: IntrinsicTriangulation,
    /// The steps along the surface's own edges.
    steps: EdgeSteps,
    density: PerVertex<f64>,
    pub(super) chart_size: f64,
    mean_edge: f64,
    whole: PerVertex<[bool; 2]>,
    unaligned: usize,
}

/// Most rounds in which whole coordinates are released.
const RELEASES: usize = 8;

/// Coordinates that minimise the energy, and how they came about.
pub(super) struct Solution {
    pub(super) frames: VertexFrames,
    pub(super) kinds: PerFace<FaceKind>,
    pub(super) whole: PerVertex<[bool; 2]>,
    minimization: MinimizationReport,
    refinement_iterations: usize,
    inverted_before: usize,
    released: usize,
}

impl<'a> Ground<'a> {
    pub(super) fn new(
        surface: &'a Surface,
        field: &'a CrossField,
        scale: Option<&PerVertex<f64>>,
        options: &'a ParameterizeOptions,
        similarity: &Similarity,
    ) -> Result<Self, PeriodicError> {
        let own = IntrinsicTriangulation::of(surface)?;
        let mean_edge = EdgeLengths::of(surface).mean();
        let wanted = options.chart_size.at_exponent(similarity.exponent());
        let chart_size = wanted.length(mean_edge, area(surface))?;
        let density = PerVertex::from_fn(surface.mesh().vertex_count(), |vertex| {
            scale.map_or(1.0, |scale| scale[vertex]) / chart_size
        });
        let steps = edge_steps(&own, field, &density);
        check_steps(&own, &steps)?;
        let mut edges = options.features.clone();
        if options.follow_boundary {
            let mesh = surface.mesh();
            edges.extend(mesh.edges().filter(|&edge| mesh.is_boundary_edge(edge)));
        }
        edges.sort_unstable();
        edges.dedup();
        let (whole, unaligned) = whole_coordinates(&own, field, &steps, &edges);
        Ok(Self {
            surface,
            field,
            options,
            own,
            steps,
            density,
            chart_size,
            mean_edge,
            whole,
            unaligned,
        })
    }

    /// Minimises the energy, unrolls, and turns over what is inverted.
    pub(super) fn solved(&self, watch: &Watch) -> Result<Solution, PeriodicError> {
        let (frames, minimization, refinement_iterations) = self.minimized(watch)?;
        let kinds = face_kinds(self.surface.mesh(), &frames);
        let mut solution = Solution {
            inverted_before: inverted(&kinds).count(),
            whole: self.whole.clone(),
            released: 0,
            frames,
            kinds,
            minimization,
            refinement_iterations,
        };
        if self.options.untangle {
            self.untangle(&mut solution, watch)?;
        }
        Ok(solution)
    }

    /// Minimises the energy and unrolls; with the figures, and the iterations of the refinement.
    fn minimized(
        &self,
        watch: &Watch,
    ) -> Result<(VertexFrames, MinimizationReport, usize), PeriodicError> {
        let functional = Functional::of(self, watch)?;
        let (coordinates, report) = self.phases(&functional, watch)?;
        let mut frames = {
            let _stage = watch.stage("unrolling");
            VertexFrames::new(&functional.triangulation, &functional.steps, coordinates)
        };
        let mut iterations = 0;
        if self.options.refine {
            iterations = functional.refined(self, &mut frames, watch)?;
        }
        let _stage = watch.stage("unrolling");
        // The integers of the surface's own edges, which are not those of the triangulation.
        let own = VertexFrames::new(&self.own, &self.steps, frames.coordinates);
        Ok((own, report, iterations))
    }

    /// The coordinates of all vertices that minimise the energy, each up to whole numbers.
    fn phases(
        &self,
        functional: &Functional,
        watch: &Watch,
    ) -> Result<(PerVertex<DVec2>, MinimizationReport), PeriodicError> {
        let graph = phase_graph(
            &functional.triangulation,
            &functional.steps,
            &functional.weights,
            &self.whole,
        );
        let positions = self.surface.positions().as_slice();
        let nodes = graph.places.iter().enumerate();
        let free = nodes.filter(|(_, place)| **place != FIXED);
        let points: Vec<_> = free.map(|(node, _)| positions[node / 2]).collect();
        let (values, report) = self.options.minimizer.run(&graph, &points, watch)?;
        let value = |node: usize| match graph.places[node] {
            FIXED => DVec2::X,
            place => values[place as usize],
        };
        let phases = PerVertex::from_fn(positions.len(), |vertex: VertexId| {
            [0, 1].map(|coordinate| value(2 * vertex.index() + coordinate))
        });
        Ok((angles_of_phases(&phases), report))
    }

    /// Turns inverted triangles over again. Where that fails beside coordinates that must be whole,
    /// these are released, as two lines to follow may be closer than a period.
    fn untangle(&self, solution: &mut Solution, watch: &Watch) -> Result<(), PeriodicError> {
        let mesh = self.surface.mesh();
        for _ in 0..RELEASES {
            let untangling = Untangling {
                mesh,
                triangulation: &self.own,
                density: &self.density,
                whole: &solution.whole,
                kinds: &solution.kinds,
            };
            untangling.run(&mut solution.frames, watch)?;
            solution.kinds = face_kinds(mesh, &solution.frames);
            let released = self.release(solution);
            solution.released += released;
            if released == 0 {
                break;
            }
        }
        if solution.released > 0 {
            let message = format!(
                "{} coordinates beside boundary or feature edges are not on a line: the charts are too \
                 large for what is between these edges",
                solution.released
            );
            watch.warn("lines-released", message);
        }
        Ok(())
    }

    /// Lets the coordinates of inverted triangles be anything; how many had to be whole.
    fn release(&self, solution: &mut Solution) -> usize {
        let mesh = self.surface.mesh();
        let mut released = 0;
        for vertex in inverted(&solution.kinds).flat_map(|face| mesh.triangle(face)) {
            let whole = &mut solution.whole[vertex];
            released += whole.iter().filter(|is_whole| **is_whole).count();
            *whole = [false; 2];
        }
        released
    }

    /// The figures; `chart_size` is in the unit of the caller.
    pub(super) fn report(
        &self,
        solution: &Solution,
        singular: &SingularElements,
        chart_size: f64,
    ) -> ParameterizationReport {
        let faces = self.surface.mesh().face_count();
        ParameterizationReport {
            chart_size,
            chart_edges: self.chart_size / self.mean_edge,
            charts: self.charts(),
            energy: self.options.energy,
            minimization: solution.minimization.clone(),
            whole_coordinates: solution.whole.iter().flatten().filter(|is| **is).count(),
            unaligned_edges: self.unaligned,
            released_coordinates: solution.released,
            field_singular_faces: singular.field_faces.len(),
            phase_singular_faces: singular.phase_faces.len(),
            inverted_faces: singular.inverted_faces.len(),
            inverted_before: solution.inverted_before,
            singular_edges: singular.edges.len(),
            singular_vertices: singular.vertices.len(),
            singular_share: singular.face_count() as f64 / faces as f64,
            refinement_iterations: solution.refinement_iterations,
            distortion: RegularDistortion::of(self.surface, &solution.frames, &solution.kinds),
        }
    }

    /// Area over that of a chart, by the wanted density.
    fn charts(&self) -> f64 {
        let areas = vertex_areas(&self.own);
        let own = self.density.iter().zip(&areas);
        own.map(|(density, area)| density * density * area).sum()
    }
}

/// The energy, with the triangulation that it is summed over.
struct Functional {
    triangulation: IntrinsicTriangulation,
    steps: EdgeSteps,
    weights: PerEdge<f64>,
}

impl Functional {
    fn of(ground: &Ground<'_>, watch: &Watch) -> Result<Self, PeriodicError> {
        let _stage = watch.stage("energy");
        let triangulation = match ground.options.triangles {
            EnergyTriangles::Delaunay => intrinsic_delaunay(ground.surface, watch)?.0,
            EnergyTriangles::Own => ground.own.clone(),
        };
        Ok(Self {
            steps: edge_steps(&triangulation, ground.field, &ground.density),
            weights: energy_weights(&triangulation, ground.options.energy)?,
            triangulation,
        })
    }

    /// Refines with the square of the wanted scale taken out of the weights: where lines are dense,
    /// a miss by the same share of their distance counts as much as elsewhere.
    fn refined(
        &self,
        ground: &Ground<'_>,
        frames: &mut VertexFrames,
        watch: &Watch,
    ) -> Result<usize, PeriodicError> {
        let (triangulation, steps) = (&self.triangulation, &self.steps);
        let relative = |edge: EdgeId| {
            let ends = triangulation.ends(triangulation.edge_halfedge(edge));
            let [i, j] = ends.map(|vertex| ground.density[vertex] * ground.chart_size);
            self.weights[edge] / (i * j)
        };
        let weights = PerEdge::new(triangulation.edges().map(relative).collect());
        refine(triangulation, steps, &weights, &ground.whole, frames, watch)
    }
}

fn area(surface: &Surface) -> f64 {
    face_areas(&face_shapes(surface)).iter().sum()
}

fn check_steps(
    triangulation: &IntrinsicTriangulation,
    steps: &EdgeSteps,
) -> Result<(), PeriodicError> {
    let longest = triangulation
        .edges()
        .map(|edge| steps.of_edge(edge).delta.length())
        .fold(0.0, f64::max);
    let limit = GRID_EXTENT / 4.0;
    if longest < limit {
        return Ok(());
    }
    Err(PeriodicError::ChartsTooSmall {
        charts: longest,
        limit,
    })
}

fn inverted(kinds: &PerFace<FaceKind>) -> impl Iterator<Item = FaceId> + '_ {
    let inverted = kinds
        .enumerate()
        .filter(|(_, kind)| **kind == FaceKind::Inverted);
    inverted.map(|(face, _)| face)
}
