use glam::DVec2;
use serde::Serialize;

use super::energy::{EnergyKind, energy_weights, phase_graph};
use super::refine::refine;
use super::unroll::{
    FaceKind, Layout, VertexFrames, angles_of_phases, face_kinds, layout,
};
use super::untangle::Untangling;
use super::{
    EdgeSteps, GRID_EXTENT, GridMap, GridMapError, MinimizationReport, ParameterizeOptions,
    PeriodicError, SingularElements, edge_steps,
};
use super::alignment::whole_coordinates;
use super::phase_graph::FIXED;
use crate::field::CrossField;
use crate::geometry::{
    EdgeLengths, IntrinsicTriangulation, face_areas, face_shapes, intrinsic_delaunay, normalized,
    vertex_areas,
};
use crate::measure::SourceTriangle;
use crate::mesh::{EdgeId, Element, PerEdge, PerFace, PerVertex, Surface, TriangleMesh, VertexId};
use crate::watch::Watch;

/// Periodic coordinates of a surface, with everything that was found on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameterization {
    /// The side h of a chart where the field has the scale 1, in the unit of the positions.
    pub chart_size: f64,
    /// The coordinates of each vertex in the frame of the field there, in periods: `θ = 2π u`.
    pub frames: VertexFrames,
    /// Which coordinates of a vertex are whole because a line runs along a boundary or feature edge.
    pub whole: PerVertex<[bool; 2]>,
    /// The kind of each triangle.
    pub kinds: PerFace<FaceKind>,
    /// The triangles laid out, with the transitions between them.
    pub layout: Layout,
    /// What is singular.
    pub singular: SingularElements,
    /// The figures.
    pub report: ParameterizationReport,
}

/// Figures of a [`Parameterization`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterizationReport {
    /// The side of a chart, in the unit of the positions.
    pub chart_size: f64,
    /// The side of a chart over the mean edge.
    pub chart_edges: f64,
    /// Area of the surface over that of a chart, by the scale of the field.
    pub charts: f64,
    /// The functional.
    pub energy: EnergyKind,
    /// Figures of the minimisation.
    pub minimization: MinimizationReport,
    /// Coordinates that are whole because a line runs along a boundary or feature edge.
    pub whole_coordinates: usize,
    /// Boundary and feature edges that the field does not follow, so that no line does.
    pub unaligned_edges: usize,
    /// Coordinates that were to be whole and are not: lines there run closer together than the charts
    /// are wide, so that triangles between them had no room.
    pub released_coordinates: usize,
    /// Triangles with a singularity of the field.
    pub field_singular_faces: usize,
    /// Triangles where a line ends.
    pub phase_singular_faces: usize,
    /// Triangles that do not turn counter-clockwise.
    pub inverted_faces: usize,
    /// Inverted triangles before they were untangled.
    pub inverted_before: usize,
    /// Edges of triangles that do not close.
    pub singular_edges: usize,
    /// Vertices whose neighbourhood does not close once.
    pub singular_vertices: usize,
    /// Singular triangles of all kinds over all triangles.
    pub singular_share: f64,
    /// Iterations of the final solve in real coordinates.
    pub refinement_iterations: usize,
    /// Distortion over regular triangles.
    pub distortion: RegularDistortion,
}

/// Distortion over the regular triangles, as in Table I of [PGP06].
///
/// [PGP06]: crate::papers::PGP06
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RegularDistortion {
    /// L² stretch, at the scale where an isometry has 1.
    pub stretch: f64,
    /// Mean |cos| of the angle between the gradients of both coordinates.
    pub shear: f64,
    /// Share of the area that is left out: that of triangles that are not regular.
    pub left_out_area: f64,
}

/// Covers a surface with two periodic coordinates whose gradients follow a field ([PGP06] §§2,
/// 3.1, 3.2).
///
/// `scale` multiplies the density of lines at each vertex: the scale of a curl correction, or the
/// chart size over the size wanted there.
///
/// The energy is minimised on the intrinsic Delaunay triangulation; its vertices are those of the
/// surface, on whose own triangles the coordinates are then unrolled. Every component gets its
/// coordinates.
///
/// The surface is brought to unit size inside: the result is the same at every scale. Cost:
/// near-linear.
///
/// # Errors
/// [`PeriodicError`].
///
/// [PGP06]: crate::papers::PGP06
pub fn parameterize(
    surface: &Surface,
    field: &CrossField,
    scale: Option<&PerVertex<f64>>,
    options: &ParameterizeOptions,
    watch: &Watch,
) -> Result<Parameterization, PeriodicError> {
    let _stage = watch.stage("parameterization");
    options.minimizer.check()?;
    check_counts(surface.mesh(), field, scale, &options.features)?;
    let (unit_surface, similarity) = normalized(surface);
    let ground = Ground::new(&unit_surface, field, scale, options, &similarity)?;
    let (mut frames, minimization, refinement_iterations) = ground.minimized(watch)?;
    let mut kinds = face_kinds(surface.mesh(), &frames);
    let inverted_before = count(&kinds, FaceKind::Inverted);
    let mut whole = ground.whole.clone();
    let mut released = 0;
    if options.untangle {
        released = untangled(&ground, &mut whole, &mut frames, &mut kinds, watch)?;
    }
    watch.check()?;
    let _stage = watch.stage("singular elements");
    let singular = SingularElements::of(surface.mesh(), &frames, &kinds);
    let chart_size = similarity.invert_length(ground.chart_size);
    let report = ParameterizationReport {
        chart_size,
        chart_edges: ground.chart_size / ground.mean_edge,
        charts: ground.charts(),
        energy: options.energy,
        minimization,
        whole_coordinates: whole.iter().flatten().filter(|is| **is).count(),
        unaligned_edges: ground.unaligned,
        released_coordinates: released,
        field_singular_faces: singular.field_faces.len(),
        phase_singular_faces: singular.phase_faces.len(),
        inverted_faces: singular.inverted_faces.len(),
        inverted_before,
        singular_edges: singular.edges.len(),
        singular_vertices: singular.vertices.len(),
        singular_share: singular.face_count() as f64 / surface.mesh().face_count() as f64,
        refinement_iterations,
        distortion: regular_distortion(&unit_surface, &frames, &kinds),
    };
    Ok(Parameterization {
        chart_size,
        layout: layout(surface.mesh(), &frames, &kinds),
        whole,
        frames,
        kinds,
        singular,
        report,
    })
}

/// Most rounds in which whole coordinates are released.
const RELEASES: usize = 8;

/// Turns inverted triangles over again. Where that fails beside coordinates that must be whole, these
/// are released, as two lines to follow may be closer than a period; returns how many were.
fn untangled(
    ground: &Ground<'_>,
    whole: &mut PerVertex<[bool; 2]>,
    frames: &mut VertexFrames,
    kinds: &mut PerFace<FaceKind>,
    watch: &Watch,
) -> Result<usize, PeriodicError> {
    let mesh = ground.surface.mesh();
    let mut released = 0;
    for _ in 0..RELEASES {
        let untangling = Untangling {
            mesh,
            triangulation: &ground.own,
            density: &ground.density,
            whole,
            kinds,
        };
        untangling.run(frames, watch)?;
        *kinds = face_kinds(mesh, frames);
        let inverted = kinds.enumerate().filter(|(_, kind)| **kind == FaceKind::Inverted);
        let mut now = 0;
        for vertex in inverted.flat_map(|(face, _)| mesh.triangle(face)) {
            now += whole[vertex].iter().filter(|is_whole| **is_whole).count();
            whole[vertex] = [false; 2];
        }
        released += now;
        if now == 0 {
            break;
        }
    }
    if released > 0 {
        let message = format!(
            "{released} coordinates beside boundary or feature edges are not on a line: the charts are \
             too large for what is between these edges"
        );
        watch.warn("lines-released", message);
    }
    Ok(released)
}

impl Parameterization {
    /// The coordinates as a map whose whole numbers are lines, one for each period; triangles that do
    /// not close are left out.
    ///
    /// # Errors
    /// [`GridMapError`]: coordinates that leave its range.
    pub fn grid_map(&self, mesh: &TriangleMesh) -> Result<GridMap, GridMapError> {
        GridMap::new(
            mesh,
            self.layout.coordinates.clone(),
            self.layout.transitions.clone(),
            self.kinds.map(|kind| !kind.closes()),
        )
    }
}

fn check_counts(
    mesh: &TriangleMesh,
    field: &CrossField,
    scale: Option<&PerVertex<f64>>,
    features: &[EdgeId],
) -> Result<(), PeriodicError> {
    let vertices = mesh.vertex_count();
    let lengths = [
        ("the field", field.angles().len()),
        ("the scale", scale.map_or(vertices, PerVertex::len)),
    ];
    if let Some((what, given)) = lengths.into_iter().find(|(_, given)| *given != vertices) {
        return Err(PeriodicError::VertexCount {
            what,
            given,
            vertices,
        });
    }
    let count = mesh.edge_count();
    if let Some(edge) = features.iter().find(|edge| edge.index() >= count) {
        let edge = edge.0;
        return Err(PeriodicError::NoSuchEdge { edge, count });
    }
    let is_bad = |value: f64| !(value.is_finite() && value > 0.0);
    let bad = scale.and_then(|scale| scale.enumerate().find(|(_, value)| is_bad(**value)));
    match bad {
        Some((vertex, &value)) => Err(PeriodicError::Scale { vertex, value }),
        None => Ok(()),
    }
}

/// What every step stands on.
struct Ground<'a> {
    surface: &'a Surface,
    field: &'a CrossField,
    options: &'a ParameterizeOptions,
    own: IntrinsicTriangulation,
    /// The steps along the surface's own edges.
    steps: EdgeSteps,
    density: PerVertex<f64>,
    chart_size: f64,
    mean_edge: f64,
    whole: PerVertex<[bool; 2]>,
    unaligned: usize,
}

impl<'a> Ground<'a> {
    fn new(
        surface: &'a Surface,
        field: &'a CrossField,
        scale: Option<&PerVertex<f64>>,
        options: &'a ParameterizeOptions,
        similarity: &crate::geometry::Similarity,
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
            iterations = functional.refined(&self.whole, &mut frames, watch)?;
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
        let triangulation = if ground.options.delaunay {
            intrinsic_delaunay(ground.surface, watch)?.0
        } else {
            ground.own.clone()
        };
        Ok(Self {
            steps: edge_steps(&triangulation, ground.field, &ground.density),
            weights: energy_weights(&triangulation, ground.options.energy)?,
            triangulation,
        })
    }

    fn refined(
        &self,
        whole: &PerVertex<[bool; 2]>,
        frames: &mut VertexFrames,
        watch: &Watch,
    ) -> Result<usize, PeriodicError> {
        let (triangulation, steps) = (&self.triangulation, &self.steps);
        refine(triangulation, steps, &self.weights, whole, frames, watch)
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

fn count(kinds: &PerFace<FaceKind>, wanted: FaceKind) -> usize {
    kinds.iter().filter(|kind| **kind == wanted).count()
}

fn regular_distortion(
    surface: &Surface,
    frames: &VertexFrames,
    kinds: &PerFace<FaceKind>,
) -> RegularDistortion {
    let [mut measured, mut total, mut image, mut stretch, mut shear] = [0.0; 5];
    for (face, kind) in kinds.enumerate() {
        let Some(source) = SourceTriangle::from_positions(surface.corner_positions(face)) else {
            continue;
        };
        let area = source.area();
        total += area;
        if *kind != FaceKind::Regular {
            continue;
        }
        let jacobian = source.jacobian(frames.corners(surface.mesh(), face));
        let square = jacobian.squared_stretch();
        if square.is_finite() {
            measured += area;
            image += area * jacobian.determinant();
            stretch += area * square;
            shear += area * jacobian.shear();
        }
    }
    let share = |sum: f64| if measured > 0.0 { sum / measured } else { 0.0 };
    RegularDistortion {
        stretch: (share(stretch) * share(image)).sqrt(),
        shear: share(shear),
        left_out_area: if total > 0.0 { 1.0 - measured / total } else { 0.0 },
    }
}
