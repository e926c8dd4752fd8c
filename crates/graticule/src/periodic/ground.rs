use glam::{DVec2, DVec3};

use super::alignment::whole_coordinates;
use super::energy::{energy_weights, phase_graph};
use super::phase_graph::{FIXED, NodeOrder, mirrored};
use super::refine::Refinement;
use super::sizing::denser_about;
use super::tension::PhaseTension;
use super::unroll::{FaceKind, VertexFrames, angles_of_phases, face_kinds};
use super::untangle::Untangling;
use super::{
    EdgeSteps, EnergyTriangles, GRID_EXTENT, MinimizationReport, ParameterizationReport,
    ParameterizeOptions, PeriodicError, RegularDistortion, SingularElements, edge_steps,
};
use crate::field::{CrossField, phase};
use crate::geometry::{
    EdgeLengths, IntrinsicTriangulation, Similarity, intrinsic_delaunay, vertex_areas,
    vertex_frames,
};
use crate::mesh::{EdgeId, Element, FaceId, PerEdge, PerFace, PerVertex, Surface, VertexId};
use crate::solve::along_curve;
use crate::tolerance::NEEDLE_COTANGENT;
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
    whole: PerVertex<[bool; 2]>,
    unaligned: usize,
    /// How often charts were halved so far.
    halvings: usize,
}

/// Rings of triangles round singular ones without which distortion is measured once more.
const RINGS_APART: usize = 2;

/// Most rounds in which whole coordinates are released.
const RELEASES: usize = 8;

/// Share of the inverted triangles that a halving may leave for another one to be tried: where most
/// stay, they are not for want of room.
const WORTH_HALVING: f64 = 0.9;

/// Visits of each triangle, in the mean, in the search for coordinates without inverted ones.
///
/// Models on which all of these go take fifteen to two hundred.
const MOST_VISITS: usize = 300;

/// Coordinates that minimise the energy, and how they came about.
pub(super) struct Solution {
    pub(super) frames: VertexFrames,
    pub(super) kinds: PerFace<FaceKind>,
    pub(super) whole: PerVertex<[bool; 2]>,
    pub(super) tension: PhaseTension,
    minimization: MinimizationReport,
    deviation: Option<f64>,
    inverted_before: usize,
    released: usize,
}

/// Coordinates of the vertices up to whole numbers, as the minimiser finds them.
struct Phased {
    coordinates: PerVertex<DVec2>,
    tension: PhaseTension,
    report: MinimizationReport,
}

/// The same, unrolled; with how far it deviates from the field, if it was refined.
struct Minimized {
    frames: VertexFrames,
    tension: PhaseTension,
    minimization: MinimizationReport,
    deviation: Option<f64>,
}

impl<'a> Ground<'a> {
    pub(super) fn new(
        surface: &'a Surface,
        field: &'a CrossField,
        scale: Option<&PerVertex<f64>>,
        options: &'a ParameterizeOptions,
        similarity: &Similarity,
    ) -> Result<Self, PeriodicError> {
        let wanted = options.chart_size.at_exponent(similarity.exponent());
        let chart_size = wanted.length(surface)?;
        let density = PerVertex::from_fn(surface.mesh().vertex_count(), |vertex| {
            scale.map_or(1.0, |scale| scale[vertex]) / chart_size
        });
        Self::with_density(surface, field, density, options, chart_size)
    }

    fn with_density(
        surface: &'a Surface,
        field: &'a CrossField,
        density: PerVertex<f64>,
        options: &'a ParameterizeOptions,
        chart_size: f64,
    ) -> Result<Self, PeriodicError> {
        let own = IntrinsicTriangulation::of(surface)?;
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
            whole,
            unaligned,
            halvings: 0,
        })
    }

    /// Minimises the energy, unrolls, and turns over what is inverted; where that fails, with charts
    /// half as wide. Charts are wider than what they are to cover there: the lines round a limb come to
    /// less than half a period, which rounds to none.
    pub(super) fn solved_with_room(
        mut self,
        watch: &Watch,
    ) -> Result<(Self, Solution), PeriodicError> {
        let mut solution = self.solved(watch)?;
        let mesh = self.surface.mesh();
        let mut halved = 0;
        while self.halvings < self.options.halvings && inverted(&solution.kinds).next().is_some() {
            let faces = inverted(&solution.kinds);
            let vertices: Vec<VertexId> = faces.flat_map(|face| mesh.triangle(face)).collect();
            let before = vertices.len() / 3;
            let denser = denser_about(&self.own, &self.density, &vertices);
            let next = Self {
                halvings: self.halvings + 1,
                ..Self::with_density(
                    self.surface,
                    self.field,
                    denser,
                    self.options,
                    self.chart_size,
                )?
            };
            let found = next.solved(watch)?;
            let left = inverted(&found.kinds).count();
            if left < before {
                (self, solution) = (next, found);
                halved += before;
            }
            if left as f64 > WORTH_HALVING * before as f64 {
                break;
            }
        }
        Self::warn(&solution, halved, watch);
        Ok((self, solution))
    }

    /// Tells what the coordinates alone do not show.
    fn warn(solution: &Solution, halved: usize, watch: &Watch) {
        if solution.released > 0 {
            let message = format!(
                "{} coordinates beside boundary or feature edges are not on a line: the charts are too \
                 large for what is between these edges",
                solution.released
            );
            watch.warn("lines-released", message);
        }
        if halved > 0 {
            let message = format!(
                "charts were made smaller about {halved} triangles that are inverted in charts of the \
                 size asked for"
            );
            watch.warn("charts-halved", message);
        }
        let left = inverted(&solution.kinds).count();
        if left > 0 {
            let message = format!(
                "{left} triangles are inverted: the charts are too large for the part that they are on"
            );
            watch.warn("inverted-triangles", message);
        }
    }

    /// Minimises the energy, unrolls, and turns over what is inverted.
    fn solved(&self, watch: &Watch) -> Result<Solution, PeriodicError> {
        let Minimized {
            frames,
            tension,
            minimization,
            deviation,
        } = self.minimized(watch)?;
        let kinds = face_kinds(self.surface.mesh(), &frames);
        let mut solution = Solution {
            inverted_before: inverted(&kinds).count(),
            whole: self.whole.clone(),
            released: 0,
            frames,
            kinds,
            tension,
            minimization,
            deviation,
        };
        if self.options.untangle {
            self.untangle(&mut solution, watch)?;
        }
        Ok(solution)
    }

    /// Minimises the energy and unrolls.
    fn minimized(&self, watch: &Watch) -> Result<Minimized, PeriodicError> {
        let functional = Functional::of(self, watch)?;
        let Phased {
            coordinates,
            tension,
            report,
        } = self.phases(&functional, watch)?;
        let mut frames = {
            let _stage = watch.stage("unrolling");
            VertexFrames::new(&functional.triangulation, &functional.steps, coordinates)
        };
        let mut deviation = None;
        if self.options.refine {
            deviation = Some(functional.refined(self, &mut frames, watch)?);
        }
        let _stage = watch.stage("unrolling");
        // The integers of the surface's own edges, which are not those of the triangulation.
        let own = VertexFrames::new(&self.own, &self.steps, frames.coordinates);
        Ok(Minimized {
            frames: own,
            tension,
            minimization: report,
            deviation,
        })
    }

    /// The coordinates of all vertices that minimise the energy, each up to whole numbers.
    fn phases(&self, functional: &Functional, watch: &Watch) -> Result<Phased, PeriodicError> {
        let graph = phase_graph(
            &functional.triangulation,
            &functional.steps,
            &functional.weights,
            &self.whole,
            &self.order_of_nodes(),
        );
        let positions = self.surface.positions().as_slice();
        let mut points = vec![DVec3::ZERO; graph.count()];
        for (node, &place) in graph.places.iter().enumerate() {
            if place != FIXED {
                points[place as usize] = positions[node / 2];
            }
        }
        let (found, report) = self.options.minimizer.run(&graph, &points, watch)?;
        let value = |node: usize| match graph.places[node] {
            FIXED => DVec2::X,
            place => found.values[place as usize],
        };
        let phases = PerVertex::from_fn(positions.len(), |vertex: VertexId| {
            [0, 1].map(|coordinate| value(2 * vertex.index() + coordinate))
        });
        Ok(Phased {
            coordinates: angles_of_phases(&phases),
            tension: PhaseTension::of(&graph, &found),
            report,
        })
    }

    /// An order and starts of the phase graph's nodes that depend neither on how vertices are numbered
    /// nor on which of a cross's directions is the first: along a curve through space, the axis first
    /// that has more of the x axis, forward where that grows. Neighbours are close in memory, too.
    fn order_of_nodes(&self) -> NodeOrder {
        let positions = self.surface.positions().as_slice();
        let vertices = along_curve(positions);
        let frames = vertex_frames(self.surface);
        let directions = self.field.directions_in_space(self.surface, &self.own);
        let seed = self.options.minimizer.seed();
        let mut order = NodeOrder {
            nodes: Vec::with_capacity(2 * positions.len()),
            starts_from: vec![DVec2::X; 2 * positions.len()],
        };
        for vertex in vertices.into_iter().map(VertexId) {
            let along = directions[vertex];
            let axes = [along.x, frames[vertex].normal.cross(along).x];
            let first = u32::from(axes[1].abs() > axes[0].abs());
            for axis in [first, 1 - first] {
                let node = 2 * vertex.0 + axis;
                let start = phase(VertexId::from_index(order.nodes.len()), seed);
                order.starts_from[node as usize] = mirrored(start, axes[axis as usize] < 0.0);
                order.nodes.push(node);
            }
        }
        order
    }

    /// Turns inverted triangles over again. Where that fails beside coordinates that must be whole,
    /// these are released, as two lines to follow may be closer than a period.
    fn untangle(&self, solution: &mut Solution, watch: &Watch) -> Result<(), PeriodicError> {
        let mesh = self.surface.mesh();
        let mut candidates: Vec<FaceId> = mesh.faces().collect();
        let mut visits = MOST_VISITS * mesh.face_count();
        for _ in 0..RELEASES {
            let untangling = Untangling {
                mesh,
                triangulation: &self.own,
                density: &self.density,
                whole: &solution.whole,
                kinds: &solution.kinds,
            };
            untangling.run(candidates, &mut solution.frames, &mut visits, watch)?;
            solution.kinds = face_kinds(mesh, &solution.frames);
            let released = self.release(solution);
            solution.released += released;
            if released == 0 {
                break;
            }
            candidates = inverted(&solution.kinds).collect();
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
            chart_edges: self.chart_size / EdgeLengths::of(self.surface).mean(),
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
            field_deviation: solution.deviation,
            halvings: self.halvings,
            distortion: self.distortion(solution, 0),
            distortion_apart: self.distortion(solution, RINGS_APART),
        }
    }

    /// Distortion without what is singular and this many rings of triangles round it.
    fn distortion(&self, solution: &Solution, rings: usize) -> RegularDistortion {
        let mesh = self.surface.mesh();
        let mut counts = solution.kinds.map(|kind| *kind == FaceKind::Regular);
        for _ in 0..rings {
            let mut is_beside = PerVertex::filled(mesh.vertex_count(), false);
            for face in mesh.faces().filter(|&face| !counts[face]) {
                for vertex in mesh.triangle(face) {
                    is_beside[vertex] = true;
                }
            }
            counts = PerFace::from_fn(mesh.face_count(), |face| {
                !mesh.triangle(face).iter().any(|&vertex| is_beside[vertex])
            });
        }
        RegularDistortion::of(self.surface, &solution.frames, &counts, &self.density)
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
    /// a miss by the same share of their distance counts as much as elsewhere. Returns the mean angle
    /// to the field, in degrees.
    ///
    /// Each relaxation turns the steps a good way towards the differences that the last solution has,
    /// as *A Local/Global Approach to Mesh Parameterization* (Liu et al. 2008) does with rotations of
    /// triangles: what is left of shear comes from a field that no map can follow.
    fn refined(
        &self,
        ground: &Ground<'_>,
        frames: &mut VertexFrames,
        watch: &Watch,
    ) -> Result<f64, PeriodicError> {
        let _stage = watch.stage("refinement");
        let (triangulation, steps) = (&self.triangulation, &self.steps);
        let relative = |edge: EdgeId| {
            let ends = triangulation.ends(triangulation.edge_halfedge(edge));
            let [i, j] = ends.map(|vertex| ground.density[vertex] * ground.chart_size);
            self.weights[edge].min(NEEDLE_COTANGENT) / (i * j)
        };
        let weights = PerEdge::new(triangulation.edges().map(relative).collect());
        let positions = ground.surface.positions().as_slice();
        let refinement = Refinement::new(triangulation, steps, weights, &ground.whole, positions)?;
        let mut turns = PerVertex::filled(positions.len(), 0.0);
        refinement.solve(&turns, frames)?;
        for _ in 0..ground.options.relaxations {
            watch.check()?;
            turns = refinement.turns(frames).map(|turn| YIELD * turn);
            refinement.solve(&turns, frames)?;
        }
        let areas = vertex_areas(triangulation);
        let turns = refinement.turns(frames);
        let sum = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>();
        let turned = sum(&mut areas
            .iter()
            .zip(&turns)
            .map(|(area, turn)| area * turn.abs()));
        Ok(360.0 * turned / sum(&mut areas.iter().copied()))
    }
}

/// Share of its turn against the field that a relaxation grants to the map. The whole turn would let
/// the field go after enough relaxations.
const YIELD: f64 = 0.8;

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
