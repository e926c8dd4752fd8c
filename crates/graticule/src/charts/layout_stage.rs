use glam::DVec2;
use serde::Serialize;

use super::layout_map::{left_out_count, map_for_charts};
use super::layout_refine::embed;
use super::{ChartKind, ChartLayout, LayoutError};
use crate::field::{CrossField, FieldOptions, FieldResult, cross_field};
use crate::geometry::{EdgeLengths, face_areas, face_shapes, normalized, total_area};
use crate::mesh::{EdgeId, PerCorner, PerEdge, PerFace, Surface, TriangleMesh};
use crate::periodic::{
    ChartSize, GridDensity, GridMap, IntegerGrid, IntegerGridMap, IntegerGridOptions,
    ParameterizationReport, ParameterizeOptions, parameterize,
};
use crate::quads::{NetCells, all_features};
use crate::watch::Watch;

/// The map whose lines a layout follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LayoutMap {
    /// Periodic coordinates ([PGP06]): lines may end where they are singular, so that charts there
    /// have any number of sides.
    ///
    /// [PGP06]: crate::papers::PGP06
    Periodic,
    /// An integer grid map, of which lines run from the singular points until they meet another:
    /// nearly all charts are rectangles of the map, with singular points at their corners.
    #[default]
    IntegerGrid,
}

impl LayoutMap {
    fn name(self) -> &'static str {
        match self {
            Self::Periodic => "periodic coordinates",
            Self::IntegerGrid => "an integer grid map",
        }
    }
}

/// Which lines of a map become borders of charts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChartLines {
    /// All, so that charts are cells of the net; closer ones in cells that are no disks.
    All,
    /// Those that bound rectangles with sides of about so many spacings of lines, which are the unit of
    /// the layout's coordinates then. Each singular point is a corner of the rectangles around it; where
    /// one ends along another's side is a T-junction.
    Rectangles(u32),
}

/// Lines of an integer grid map along the side of a chart, if charts have room for them: singular
/// points, which it puts on lines, move by a small part of a chart only, and no chart is thinner than one
/// spacing.
const LINES_PER_CHART: u32 = 4;

/// The same, at most, on surfaces with parts so thin, or features so close, that there are flips else.
const MOST_LINES_PER_CHART: u32 = 16;

/// The least distance of lines in mean edges: closer ones cost more than the triangles do.
const CLOSEST_LINES: f64 = 0.25;

/// Rounds of relaxing an integer grid map where it squeezes triangles: what it does to them shows in
/// the atlas.
const RELAXATION_ROUNDS: usize = 3;

/// How [`chart_layout`] works.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayoutOptions {
    /// How the field that the arcs follow is made; its features become arcs.
    pub field: FieldOptions,
    /// The size of charts, and how periodic coordinates are made. Features are added to those given.
    pub coordinates: ParameterizeOptions,
    /// The map whose lines become arcs.
    pub map: LayoutMap,
}

/// Counts of a layout.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LayoutReport {
    /// Nodes.
    pub nodes: usize,
    /// Arcs.
    pub arcs: usize,
    /// Charts.
    pub charts: usize,
    /// Nodes less arcs plus charts.
    pub euler_characteristic: i64,
    /// Charts of which the map makes rectangles.
    pub regular: usize,
    /// Charts with four sides that are not regular.
    pub singular: usize,
    /// Charts with another number of sides.
    pub polygonal: usize,
    /// The share of charts that are not regular.
    pub singular_share: f64,
    /// The share of the area that they cover.
    pub singular_area_share: f64,
    /// Charts with no more than three sides, with four, five, six, and more.
    pub side_counts: [usize; 5],
    /// Nodes between corners, counted once for each side that they lie on.
    pub t_junctions: usize,
    /// Triangles of the refined surface.
    pub triangles: usize,
    /// Triangles of the input where the map is singular.
    pub left_out_triangles: usize,
    /// Pieces of lines that ended inside a chart and were taken away.
    pub pruned_pieces: usize,
    /// Charts that were no disks, or stood out too far, and got closer lines.
    pub refined_charts: usize,
    /// Charts that were no disks still, and were cut along edges.
    pub split_charts: usize,
}

/// A layout with what it was made from.
#[derive(Clone, Debug, PartialEq)]
pub struct LaidOut {
    /// The layout.
    pub layout: ChartLayout,
    /// The map whose lines it follows.
    pub map: GridMap,
    /// The kind of that map: not what was asked for, where that gave no layout; `None` where none did,
    /// and arcs follow edges.
    pub map_kind: Option<LayoutMap>,
    /// The field that the map follows.
    pub field: FieldResult,
    /// The figures of the periodic coordinates, where they were used.
    pub coordinates: Option<ParameterizationReport>,
    /// The figures of the layout.
    pub report: LayoutReport,
}

/// Cuts a surface into charts along the lines of a map that follows a cross field ([PGP06] §3.3).
///
/// Takes any surface: any genus, boundary and number of components. Scaling it changes nothing.
/// Where the map asked for gives no layout, the other is taken, with the warning `layout-from-periodic`
/// or `layout-from-integer-grid`; where that gives none, edges of the triangles, with the warning
/// `layout-without-lines`.
///
/// An integer grid map has four lines along the side of a chart, or more where it has flips else. Its charts end at lines that run
/// from singular points to the next line met: about three for each singular point at least, and
/// more where those would be longer than asked for. Features that it cannot follow are no arcs.
///
/// Cost: near-linear, most of it field and map.
///
/// # Errors
/// [`LayoutError`].
///
/// [PGP06]: crate::papers::PGP06
pub fn chart_layout(
    surface: &Surface,
    options: &LayoutOptions,
    watch: &Watch,
) -> Result<LaidOut, LayoutError> {
    let _stage = watch.stage("chart layout");
    let field = cross_field(surface, &options.field, watch)?;
    let mut features = all_features(surface, &options.field);
    features.extend(&options.coordinates.features);
    features.sort_unstable();
    features.dedup();
    let made = first_that_works(surface, &field, &features, options, watch)?;
    Ok(LaidOut {
        layout: made.layout,
        map: made.map,
        map_kind: made.map_kind,
        field,
        coordinates: made.coordinates,
        report: made.report,
    })
}

/// The layout from the map asked for, else from the other one, else without any line.
fn first_that_works(
    surface: &Surface,
    field: &FieldResult,
    features: &[EdgeId],
    options: &LayoutOptions,
    watch: &Watch,
) -> Result<Made, LayoutError> {
    let (other, code) = match options.map {
        LayoutMap::Periodic => (LayoutMap::IntegerGrid, "layout-from-integer-grid"),
        LayoutMap::IntegerGrid => (LayoutMap::Periodic, "layout-from-periodic"),
    };
    for (map, code) in [(options.map, code), (other, "layout-without-lines")] {
        let made = match map {
            LayoutMap::Periodic => periodic_layout(surface, field, features, options, watch),
            LayoutMap::IntegerGrid => integer_layout(surface, field, features, options, watch),
        };
        match made {
            Err(error) if !error.is_final() => {
                watch.warn(code, format!("{} gave no layout: {error}", map.name()));
            }
            outcome => return outcome,
        }
    }
    layout_without_lines(surface, features, watch)
}

/// A layout without the field.
struct Made {
    map: GridMap,
    map_kind: Option<LayoutMap>,
    coordinates: Option<ParameterizationReport>,
    layout: ChartLayout,
    report: LayoutReport,
}

impl Made {
    /// The layout from a map of a kind that is not told.
    fn of(
        surface: &Surface,
        map: GridMap,
        features: &[EdgeId],
        lines: ChartLines,
        watch: &Watch,
    ) -> Result<Self, LayoutError> {
        let (layout, report) = layout_from_map(surface, &map, features, lines, watch)?;
        Ok(Self {
            map,
            map_kind: None,
            coordinates: None,
            layout,
            report,
        })
    }
}

fn periodic_layout(
    surface: &Surface,
    field: &FieldResult,
    features: &[EdgeId],
    options: &LayoutOptions,
    watch: &Watch,
) -> Result<Made, LayoutError> {
    let wanted = ParameterizeOptions {
        features: features.to_vec(),
        ..options.coordinates.clone()
    };
    let found = parameterize(surface, &field.field, field.scale.as_ref(), &wanted, watch)?;
    let map = found.grid_map(surface.mesh())?;
    let made = Made::of(surface, map, features, ChartLines::All, watch)?;
    Ok(Made {
        map_kind: Some(LayoutMap::Periodic),
        coordinates: Some(found.report),
        ..made
    })
}

fn integer_layout(
    surface: &Surface,
    field: &FieldResult,
    features: &[EdgeId],
    options: &LayoutOptions,
    watch: &Watch,
) -> Result<Made, LayoutError> {
    let wanted = IntegerGridOptions {
        align_boundary: options.coordinates.follow_boundary,
        features: features.to_vec(),
        sizing: field.scale.clone(),
        relaxation_rounds: RELAXATION_ROUNDS,
        ..IntegerGridOptions::default()
    };
    let size = options.coordinates.chart_size;
    let (map, lines) = integer_map(surface, &field.field, &wanted, size, watch)?;
    let made = Made::of(surface, map, features, ChartLines::Rectangles(lines), watch)?;
    Ok(Made {
        map_kind: Some(LayoutMap::IntegerGrid),
        ..made
    })
}

/// An integer grid map, with closer lines where it has flips else, and the number of lines along the
/// side of a chart.
fn integer_map(
    surface: &Surface,
    field: &CrossField,
    wanted: &IntegerGridOptions,
    size: ChartSize,
    watch: &Watch,
) -> Result<(GridMap, u32), LayoutError> {
    let mean_edge = EdgeLengths::of(surface).mean();
    let side = chart_side(surface, size, mean_edge);
    let has_room = |lines: u32| side / f64::from(lines) >= CLOSEST_LINES * mean_edge;
    let mut lines = LINES_PER_CHART;
    while lines > 1 && !has_room(lines) {
        lines /= 2;
    }
    let mut grid = IntegerGrid::of(surface, field, wanted, watch)?;
    let at = |lines: u32| GridDensity::EdgeLength(side / f64::from(lines));
    let mut best = (grid.map(at(lines), watch)?, lines);
    while best.0.report.flips > 0 && lines < MOST_LINES_PER_CHART && has_room(2 * lines) {
        lines *= 2;
        let made = grid.map(at(lines), watch)?;
        if made.report.flips < best.0.report.flips {
            best = (made, lines);
        }
    }
    let (IntegerGridMap { map, report }, lines) = best;
    report.warn(watch);
    Ok((map, lines))
}

/// The side of a chart of the size asked for.
fn chart_side(surface: &Surface, size: ChartSize, mean_edge: f64) -> f64 {
    match size {
        ChartSize::MeanEdges(count) => count * mean_edge,
        ChartSize::Length(length) => length,
        ChartSize::Count(count) => (total_area(&face_shapes(surface)) / count).sqrt(),
    }
}

/// The surface cut into disks along its edges alone.
fn layout_without_lines(
    surface: &Surface,
    features: &[EdgeId],
    watch: &Watch,
) -> Result<Made, LayoutError> {
    let mesh = surface.mesh();
    let map = GridMap::new(
        mesh,
        PerCorner::filled(mesh.halfedge_count(), DVec2::ZERO),
        PerCorner::filled(mesh.halfedge_count(), None),
        PerFace::filled(mesh.face_count(), true),
    )?;
    Made::of(surface, map, features, ChartLines::All, watch)
}

/// Cuts a surface into charts along lines of a map ([PGP06] Algorithm 2, by combinatorics alone).
///
/// Triangles that the map leaves out, flattens or turns over count as singular: lines end there and
/// are taken back to the next crossing. The boundary is an arc, and so are features; with
/// [`ChartLines::Rectangles`] those that lines follow. A chart that is no disk, or
/// stands out of its border so far that this does not show its shape, gets lines half or a quarter as
/// far apart; one that is no disk still is cut along edges, so that every surface has a layout. Both
/// are warnings.
///
/// Lines move by up to [`SNAPPED_CHART`](crate::tolerance::SNAPPED_CHART) of a chart to pass through
/// vertices close by.
///
/// Cost: linear in triangles and pieces of lines, up to sorting.
///
/// # Errors
/// [`LayoutError::OtherMesh`], [`LayoutError::Lines`]; the result is checked, so that others would be
/// faults of the program.
///
/// [PGP06]: crate::papers::PGP06
pub fn layout_from_map(
    surface: &Surface,
    map: &GridMap,
    features: &[EdgeId],
    lines: ChartLines,
    watch: &Watch,
) -> Result<(ChartLayout, LayoutReport), LayoutError> {
    let mesh = surface.mesh();
    let (given, needed) = (map.coordinates().len(), mesh.halfedge_count());
    if given != needed {
        return Err(LayoutError::OtherMesh { given, needed });
    }
    let _stage = watch.stage("layout");
    let (unit, _) = normalized(surface);
    let map = map_for_charts(mesh, map)?;
    let mut marks = PerEdge::filled(mesh.edge_count(), false);
    for &edge in features {
        marks[edge] = lines == ChartLines::All || is_followed(mesh, &map, edge);
    }
    let cells = match lines {
        ChartLines::All => NetCells::of(&unit, &map, Some(&marks), watch)?,
        ChartLines::Rectangles(spacings) => {
            NetCells::rectangles(&unit, &map, Some(&marks), f64::from(spacings), watch)?
        }
    };
    watch.check()?;
    let mut net = embed(&unit, &map, &cells)?;
    if let ChartLines::Rectangles(spacings) = lines {
        let unit = f64::from(spacings);
        net.coordinates = (net.coordinates).map(|point| point.map(|point| point / unit));
    }
    let layout = ChartLayout::new(net)?;
    layout.check_areas(&unit)?;
    warn_of_cells(&cells, watch);
    let report = report(&layout, &cells, left_out_count(&map));
    Ok((layout.carried_to(surface)?, report))
}

/// Whether a line of the map runs along an edge.
fn is_followed(mesh: &TriangleMesh, map: &GridMap, edge: EdgeId) -> bool {
    let side = mesh.edge_halfedge(edge);
    map.has_line_along(side) || mesh.twin(side).is_some_and(|twin| map.has_line_along(twin))
}

fn warn_of_cells(cells: &NetCells, watch: &Watch) {
    for (code, count, what) in [
        (
            "charts-refined",
            cells.refined,
            "charts that were no disks or stood out too far, and got closer lines",
        ),
        (
            "charts-split",
            cells.split,
            "charts that were no disks or stood out too far still, and were cut along edges",
        ),
    ] {
        if count > 0 {
            watch.warn(code, format!("{what}: {count}"));
        }
    }
}

fn singular_area_share(layout: &ChartLayout) -> f64 {
    let areas = face_areas(&face_shapes(layout.surface()));
    let is_singular = |face| layout.chart(layout.chart_of()[face]).kind != ChartKind::Regular;
    let singular = areas.enumerate().filter(|&(face, _)| is_singular(face));
    // The sum of no numbers would be -0.
    singular.fold(0.0, |sum, (_, area)| sum + area) / areas.iter().sum::<f64>()
}

fn report(layout: &ChartLayout, cells: &NetCells, left_out: usize) -> LayoutReport {
    let charts = layout.charts();
    let whole = |count: usize| i64::try_from(count).unwrap_or(i64::MAX);
    let of_kind = |kind| charts.iter().filter(|chart| chart.kind == kind).count();
    let mut side_counts = [0; 5];
    for chart in charts {
        side_counts[chart.sides.len().clamp(3, 7) - 3] += 1;
    }
    let sides = charts.iter().flat_map(|chart| &chart.sides);
    LayoutReport {
        nodes: layout.nodes().len(),
        arcs: layout.arcs().len(),
        charts: charts.len(),
        euler_characteristic: whole(layout.nodes().len()) - whole(layout.arcs().len())
            + whole(charts.len()),
        regular: of_kind(ChartKind::Regular),
        singular: of_kind(ChartKind::Singular),
        polygonal: of_kind(ChartKind::Polygonal),
        singular_share: layout.singular_share(),
        singular_area_share: singular_area_share(layout),
        side_counts,
        t_junctions: sides.map(|side| side.len() - 1).sum(),
        triangles: layout.surface().mesh().face_count(),
        left_out_triangles: left_out,
        pruned_pieces: cells.pruned,
        refined_charts: cells.refined,
        split_charts: cells.split,
    }
}
