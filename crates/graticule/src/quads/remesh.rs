use serde::Serialize;

use super::alone::remesh_alone;
use super::count::CountSearch;
use super::debris::Debris;
use super::extents::check_extents;
use super::features::clear_features;
use super::finer::finer_surface;
use super::roomy::{Roomy, roomy_grid};
use super::sizing::{QuadSizing, finest_first};
use super::small_components::split_small_components;
use super::{
    CutReport, FeatureReport, MendReport, Net, PolygonMesh, QuadsError, ShapeError, ShapeOptions,
    ShapeReport, extract_polygons, mend, pure_quads, quad_dominant, shape,
};
use crate::Hint;
use crate::field::{
    CurvatureOptions, FieldError, FieldOptions, FieldReport, FieldResult, feature_edges,
};
use crate::geometry::{face_shapes, total_area};
use crate::measure::scaled_jacobian;
use crate::mesh::{EdgeId, FaceId, PerEdge, Surface};
use crate::periodic::{
    GridDensity, GridMap, IntegerGridError, IntegerGridMap, IntegerGridReport, PeriodicError,
};
use crate::tolerance::{CLOSE_PAIR_IN_QUADS, FOLLOWING_VERTICES_PER_QUAD};
use crate::watch::{Stopped, Watch};

/// Which polygons a quad mesh may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum QuadMode {
    /// Quads only.
    #[default]
    Pure,
    /// Quads, and triangles where the net has odd cells.
    Dominant,
}

/// How [`remesh`] works.
#[derive(Clone, Debug, PartialEq)]
pub struct RemeshOptions {
    /// How many quads, or how long their sides.
    pub density: GridDensity,
    /// How their sides vary over the surface.
    pub sizing: QuadSizing,
    /// Which polygons are allowed.
    pub mode: QuadMode,
    /// How the field that the sides follow is made; its features become edges.
    pub field: FieldOptions,
    /// How vertices are moved in the end; `None` leaves them where lines cross.
    pub shape: Option<ShapeOptions>,
}

impl Default for RemeshOptions {
    fn default() -> Self {
        Self {
            density: GridDensity::Quads(5000),
            sizing: QuadSizing::default(),
            mode: QuadMode::default(),
            field: FieldOptions::default(),
            shape: Some(ShapeOptions::default()),
        }
    }
}

/// What was done on the way.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RemeshReport {
    /// The sharp edges of the surface.
    pub features: FeatureReport,
    /// The field.
    pub field: FieldReport,
    /// The map.
    pub map: IntegerGridReport,
    /// Polygons read off the map, before any was cut.
    pub polygons: usize,
    /// Pieces of lines that ended inside a cell and were taken away.
    pub pruned_pieces: usize,
    /// Cells that were no disks, or stood out of the net, and were cut up.
    pub split_cells: usize,
    /// Arcs between images of the same lattice point that were contracted.
    pub folds: usize,
    /// Short arcs to or along features and the boundary that were contracted.
    pub snapped: usize,
    /// Feature edges of the surface on which the map has no line.
    pub features_dropped: usize,
    /// What became of polygons that were no quads.
    pub cut: CutReport,
    /// The final shape, if there was one.
    pub shape: Option<ShapeReport>,
    /// What was cut anew for the sake of its shape, if there was one.
    pub mend: Option<MendReport>,
    /// Components whose quads were inverted in the net of the whole surface, and are better in one of
    /// their own.
    pub remeshed_alone: usize,
    /// Components too small for the net, whose triangles were cut into three quads each.
    pub split_components: usize,
    /// Maps that were made to meet the number of quads.
    pub rounds: usize,
}

/// A quad mesh on a surface.
///
/// Triangles longer than the sides of the quads leave field and map no room. They are cut for the
/// way to the quads, and components smaller than a quad are set aside; origins are on the surface
/// given.
#[derive(Clone, Debug, PartialEq)]
pub struct Remeshed {
    /// The mesh.
    pub mesh: PolygonMesh,
    /// The field that it follows, on the surface or the one with smaller triangles and without
    /// components smaller than a quad.
    pub field: FieldResult,
    /// The figures.
    pub report: RemeshReport,
}

/// Why a surface could not be remeshed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RemeshError {
    /// There is no field.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// There is no map.
    #[error(transparent)]
    Map(#[from] IntegerGridError),
    /// The surface does not tell how the sides of quads are to vary.
    #[error(transparent)]
    Sizing(#[from] PeriodicError),
    /// There are no polygons.
    #[error(transparent)]
    Quads(#[from] QuadsError),
    /// The polygons could not be shaped.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// Squares of lengths would overflow or vanish.
    #[error("the extent of the surface is {extent:e}; it can be remeshed from 1e-140 to 1e140")]
    Extent {
        /// The largest side of the box around it.
        extent: f64,
    },
    /// A component is next to a point beside the whole surface.
    #[error(
        "the component of {face} has {share:e} of the extent of the surface: too few digits to remesh it"
    )]
    TinyComponent {
        /// Its first triangle.
        face: FaceId,
        /// Its extent over that of the surface.
        share: f64,
    },
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl Hint for RemeshError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::Field(error) => error.hint(),
            Self::Map(error) => error.hint(),
            Self::Sizing(error) => error.hint(),
            Self::Quads(error) => error.hint(),
            Self::Shape(error) => error.hint(),
            Self::Extent { .. } => Some("scale the coordinates to ordinary sizes".into()),
            Self::TinyComponent { .. } => {
                Some("remesh it in a file of its own, or take it out".into())
            }
            Self::Stopped(error) => error.hint(),
        }
    }
}

/// Makes a mesh of quads that lies on the surface and follows a smooth cross field.
///
/// The mesh has the components, genus and boundary loops of the surface, is manifold and oriented,
/// and, in [`QuadMode::Pure`], has quads only. The number of quads is met to within
/// [`COUNT_MISS`](crate::tolerance::COUNT_MISS) where the surface allows it; a miss is a warning.
///
/// Cost: near-linear, most of it two factorisations.
///
/// # Errors
/// [`RemeshError`].
pub fn remesh(
    surface: &Surface,
    options: &RemeshOptions,
    watch: &Watch,
) -> Result<Remeshed, RemeshError> {
    let levels = remesh_levels(surface, options, &[options.density], watch)?;
    let only = levels.into_iter().next();
    Ok(only.unwrap_or_else(|| unreachable!("there is a mesh for each density")))
}

/// [`remesh`] at several densities, whose meshes are in the same order; that of `options` plays no
/// part.
///
/// All follow one field, and come from one system of equations: features and singularities are those
/// that the coarsest has room for, triangles as small as the finest needs them.
///
/// Cost: that of the finest one, and of each other one the part that is not field and factorisation:
/// about half.
///
/// # Errors
/// [`RemeshError`].
pub fn remesh_levels(
    surface: &Surface,
    options: &RemeshOptions,
    densities: &[GridDensity],
    watch: &Watch,
) -> Result<Vec<Remeshed>, RemeshError> {
    let Some(&coarsest) = finest_first(densities, surface).last() else {
        return Ok(Vec::new());
    };
    let _stage = watch.stage("remesh");
    check_extents(surface)?;
    options.sizing.check(surface)?;
    let mut options = options.clone();
    options.density = densities[coarsest];
    let (mut options, features) = with_clear_features(surface, &options, watch);
    let is_feature = marked(surface, &options.field);
    let mut levels = match Debris::of(surface, &options) {
        None => remesh_whole(surface, &options, densities, watch)?,
        Some(debris) => {
            let (rest, options) = debris.rest();
            let densities: Vec<GridDensity> =
                densities.iter().map(|&d| debris.density(d)).collect();
            let mut levels = remesh_whole(rest, options, &densities, watch)?;
            for made in &mut levels {
                made.report.split_components =
                    debris.put_back(&mut made.mesh, surface, &is_feature);
            }
            levels
        }
    };
    for made in &mut levels {
        made.report.features = features;
        options.density = GridDensity::EdgeLength(made.report.map.edge_length);
        made.report.remeshed_alone = remesh_alone(&mut made.mesh, surface, &options, watch)?;
        let split = split_small_components(&mut made.mesh, surface, &is_feature);
        made.report.split_components += split;
        warn_of_split(made.report.split_components, watch);
        made.mesh.check(surface)?;
        warn_of_inverted(&made.mesh, watch);
    }
    Ok(levels)
}

/// [`remesh_levels`] of a surface without debris.
pub(super) fn remesh_whole(
    surface: &Surface,
    options: &RemeshOptions,
    densities: &[GridDensity],
    watch: &Watch,
) -> Result<Vec<Remeshed>, RemeshError> {
    let finest = densities[finest_first(densities, surface)[0]];
    let Some(finer) = finer_surface(surface, options, finest, watch)? else {
        return remesh_fine(surface, options, densities, watch);
    };
    let options = finer.translated(options, surface);
    let refined = &finer.refinement.refined;
    let mut levels = remesh_fine(&refined.surface, &options, densities, watch)?;
    for origin in levels.iter_mut().flat_map(|made| &mut made.mesh.origins) {
        let found = refined.to_original(surface.mesh(), *origin);
        *origin = found.unwrap_or_else(|| unreachable!("it was made from the surface"));
    }
    Ok(levels)
}

/// The features as marks.
fn marked(surface: &Surface, options: &FieldOptions) -> PerEdge<bool> {
    let mut is_feature = PerEdge::filled(surface.mesh().edge_count(), false);
    for edge in all_features(surface, options) {
        is_feature[edge] = true;
    }
    is_feature
}

fn warn_of_split(count: usize, watch: &Watch) {
    if count > 0 {
        let message = format!(
            "{count} components leave the net no room: their triangles are cut into three quads each"
        );
        watch.warn("split-components", message);
    }
}

/// The options with the features as edges: which of the sharp ones are some is seen on the surface as
/// it is given, not on smaller triangles.
fn with_clear_features(
    surface: &Surface,
    options: &RemeshOptions,
    watch: &Watch,
) -> (RemeshOptions, FeatureReport) {
    let (edges, report) = clear_features(surface, options, watch);
    let mut options = options.clone();
    options.field.features.edges = edges;
    options.field.features.dihedral = None;
    (options, report)
}

/// [`remesh_levels`] on triangles that are small enough.
///
/// The finest comes first: lines that are drawn closer together for one stay so for those after it,
/// which need it the more.
fn remesh_fine(
    surface: &Surface,
    options: &RemeshOptions,
    densities: &[GridDensity],
    watch: &Watch,
) -> Result<Vec<Remeshed>, RemeshError> {
    let mut ground = roomy_grid(surface, options, watch)?;
    let mut levels = Vec::with_capacity(densities.len());
    for place in finest_first(densities, surface) {
        levels.push((
            place,
            remesh_at(surface, &mut ground, options, densities[place], watch)?,
        ));
    }
    levels.sort_by_key(|&(place, _)| place);
    let meshes = levels.into_iter().map(|(_, (mesh, report))| Remeshed {
        mesh,
        field: ground.field.clone(),
        report,
    });
    Ok(meshes.collect())
}

/// The mesh of one density.
fn remesh_at(
    surface: &Surface,
    ground: &mut Roomy,
    options: &RemeshOptions,
    density: GridDensity,
    watch: &Watch,
) -> Result<(PolygonMesh, RemeshReport), RemeshError> {
    let Roomy {
        grid,
        field,
        features,
    } = ground;
    let (mut mesh, mut report) = counted(density, watch, |density| {
        let made = grid.map(density, watch)?;
        net(surface, (field, made), features, options.mode, watch)
    })?;
    report.map.warn(watch);
    warn_of_dropped(report.features_dropped, features.len(), watch);
    if let Some(shaping) = &options.shape {
        report.shape = Some(reshape(&mut mesh, surface, features, shaping, watch)?);
        report.mend = Some(mend(&mut mesh, surface, features, watch)?);
    }
    Ok((mesh, report))
}

/// The options of the field, where pairs of singularities that the quads have no room for cancel, and
/// which turns over sides of quads rather than over triangles where these are much smaller.
pub(super) fn field_options(surface: &Surface, options: &RemeshOptions) -> FieldOptions {
    let side = side_length(surface, options.density);
    let cancel_length = options.field.cancel_length.max(CLOSE_PAIR_IN_QUADS * side);
    let area = total_area(&face_shapes(surface));
    let vertices_per_quad = side * side * surface.mesh().vertex_count() as f64 / area;
    // Where there is no area there is nothing to follow either.
    let counted = (FOLLOWING_VERTICES_PER_QUAD / vertices_per_quad).min(1.0);
    FieldOptions {
        cancel_length,
        curvature: options.field.curvature.map(|curvature| CurvatureOptions {
            share: curvature.share * counted,
            ..curvature
        }),
        ..options.field.clone()
    }
}

/// The side of a quad, or 0 where the density is none: the map, which knows the option's name,
/// refuses that.
pub(super) fn side_length(surface: &Surface, density: GridDensity) -> f64 {
    let side = match density {
        GridDensity::EdgeLength(length) => length,
        GridDensity::Quads(quads) => (total_area(&face_shapes(surface)) / quads as f64).sqrt(),
    };
    if side.is_finite() { side } else { 0.0 }
}

/// The edges that the field is held to as features.
pub(crate) fn all_features(surface: &Surface, options: &FieldOptions) -> Vec<EdgeId> {
    let given = &options.features;
    let mut features = given.edges.clone();
    if let Some(dihedral) = given.dihedral {
        features.extend(feature_edges(surface, dihedral, given.least_edges));
    }
    features.sort_unstable();
    features.dedup();
    features
}

/// The polygons of a map, with the vertices where lines cross.
fn net(
    surface: &Surface,
    (field, made): (&FieldResult, IntegerGridMap),
    features: &[EdgeId],
    mode: QuadMode,
    watch: &Watch,
) -> Result<(PolygonMesh, RemeshReport), RemeshError> {
    let marks = followed(surface, &made.map, features);
    let is_dropped = |edge: &&EdgeId| !marks[**edge];
    let found = extract_polygons(surface, &made.map, Some(&marks), watch)?;
    watch.check()?;
    let (mesh, cut) = match mode {
        QuadMode::Pure => pure_quads(&found.mesh, surface, features),
        QuadMode::Dominant => quad_dominant(&found.mesh, surface),
    };
    let report = RemeshReport {
        features: FeatureReport::default(),
        field: field.report.clone(),
        map: made.report,
        polygons: found.mesh.polygons.len(),
        pruned_pieces: found.pruned_pieces,
        split_cells: found.split_cells,
        folds: found.folds,
        snapped: found.snapped,
        features_dropped: features.iter().filter(is_dropped).count(),
        cut,
        shape: None,
        mend: None,
        remeshed_alone: 0,
        split_components: 0,
        rounds: 1,
    };
    Ok((mesh, report))
}

/// Marks the features that lines run along.
fn followed(surface: &Surface, map: &GridMap, features: &[EdgeId]) -> PerEdge<bool> {
    let mesh = surface.mesh();
    let mut marks = PerEdge::filled(mesh.edge_count(), false);
    for &edge in features {
        marks[edge] = map.has_line_along(mesh.edge_halfedge(edge));
    }
    marks
}

fn warn_of_dropped(count: usize, features: usize, watch: &Watch) {
    if count > 0 {
        let message = format!("{count} of {features} feature edges have no line along them");
        watch.warn("features-dropped", message);
    }
}

/// The net that comes nearest to the number of quads wanted, of some that are made.
fn counted(
    wanted: GridDensity,
    watch: &Watch,
    mut made: impl FnMut(GridDensity) -> Result<(PolygonMesh, RemeshReport), RemeshError>,
) -> Result<(PolygonMesh, RemeshReport), RemeshError> {
    let mut best = made(wanted)?;
    let (Some(mut search), GridDensity::Quads(mut tried)) = (CountSearch::new(wanted), wanted)
    else {
        return Ok(best);
    };
    let (mut found, mut rounds) = (best.0.polygons.len(), 1);
    while let Some(next) = search.next(tried, found) {
        let new = made(GridDensity::Quads(next))?;
        (tried, found) = (next, new.0.polygons.len());
        rounds += 1;
        if search.miss(found) < search.miss(best.0.polygons.len()) {
            best = new;
        }
    }
    search.warn(best.0.polygons.len(), watch);
    best.1.rounds = rounds;
    Ok(best)
}

/// Warns of quads that no solver can use.
fn warn_of_inverted(mesh: &PolygonMesh, watch: &Watch) {
    let is_inverted = |&polygon: &usize| {
        <[u32; 4]>::try_from(mesh.polygons.vertices(polygon))
            .is_ok_and(|quad| scaled_jacobian(quad.map(|v| mesh.positions[v as usize])) <= 0.0)
    };
    let count = (0..mesh.polygons.len()).filter(is_inverted).count();
    if count > 0 {
        let message = format!("{count} quads have a corner of 180° or more");
        watch.warn("inverted-quads", message);
    }
}

fn reshape(
    mesh: &mut PolygonMesh,
    surface: &Surface,
    features: &[EdgeId],
    options: &ShapeOptions,
    watch: &Watch,
) -> Result<ShapeReport, ShapeError> {
    let net = Net {
        surface,
        features,
        polygons: &mesh.polygons,
        feature_edges: &mesh.feature_edges,
    };
    let shaped = shape(&net, &mesh.origins, options, watch)?;
    mesh.positions = (shaped.origins.iter())
        .map(|origin| origin.position(surface))
        .collect();
    mesh.origins = shaped.origins;
    Ok(shaped.report)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use graticule_fixtures::icosphere;

    use super::*;
    use crate::field::cross_field;

    /// A sphere with bumps of a quarter of its radius in width.
    fn bumpy() -> Surface {
        let fixture = icosphere(5).map(|p: DVec3| {
            let waves = [p.x, p.y, p.z].map(|x| libm::sin(25.0 * x));
            p * (1.0 + 0.02 * waves.iter().product::<f64>())
        });
        Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
    }

    fn wishes(surface: &Surface, quads: usize) -> FieldOptions {
        let options = RemeshOptions {
            density: GridDensity::Quads(quads),
            ..RemeshOptions::default()
        };
        field_options(surface, &options)
    }

    #[test]
    fn bumps_smaller_than_quads_make_few_singularities() {
        let surface = bumpy();
        let share = |quads| wishes(&surface, quads).curvature.unwrap().share;
        assert!((share(20_000) - 1.0).abs() < 1e-12);
        let vertices = surface.mesh().vertex_count() as f64;
        let expected = FOLLOWING_VERTICES_PER_QUAD * 100.0 / vertices;
        assert!((share(100) - expected).abs() < 1e-3 * expected);
        let count = |share: f64| {
            let options = FieldOptions {
                curvature: Some(CurvatureOptions {
                    share,
                    ..CurvatureOptions::default()
                }),
                ..FieldOptions::default()
            };
            let made = cross_field(&surface, &options, &Watch::new()).unwrap();
            made.report.singularities
        };
        let [whole, part] = [1.0, share(100)].map(count);
        assert!(part < whole, "{part} {whole}");
    }
}
