use super::ground::{Ground, Solution};
use super::tension::PhaseTension;
use super::unroll::{FaceKind, Layout, VertexFrames, layout};
use super::{
    GridMap, GridMapError, ParameterizationReport, ParameterizeOptions, PeriodicError,
    SingularElements,
};
use crate::field::CrossField;
use crate::geometry::normalized;
use crate::mesh::{EdgeId, Element, PerFace, PerVertex, Surface, TriangleMesh};
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
    /// Where singular elements draw near.
    pub tension: PhaseTension,
    /// What is singular.
    pub singular: SingularElements,
    /// The figures.
    pub report: ParameterizationReport,
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
    let (ground, solution) = ground.solved_with_room(watch)?;
    watch.check()?;
    let _stage = watch.stage("singular elements");
    let Solution { frames, kinds, .. } = &solution;
    let singular = SingularElements::of(surface.mesh(), frames, kinds);
    let chart_size = similarity.invert_length(ground.chart_size);
    Ok(Parameterization {
        chart_size,
        layout: layout(surface.mesh(), frames, kinds),
        report: ground.report(&solution, &singular, chart_size),
        whole: solution.whole,
        frames: solution.frames,
        tension: solution.tension,
        kinds: solution.kinds,
        singular,
    })
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
