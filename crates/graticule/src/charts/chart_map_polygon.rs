//! A chart laid onto a convex polygon.

use glam::DVec2;
use serde::Serialize;

use super::split_mesh::ChartDisk;
use super::{ChartId, ChartMapError};
use crate::flatten::{
    BoundaryFreedom, BoundaryPositions, FixedOptions, InjectiveOptions, Patch, Weights, convex_map,
    fixed_map, improve_map,
};
use crate::measure::{SourceTriangle, orientation};
use crate::mesh::{PerVertex, Surface, VertexId};
use crate::tolerance::CHART_GAIN;
use crate::watch::Watch;

/// How the coordinates of a chart were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChartMethod {
    /// They are those of the net.
    Net,
    /// Mean value coordinates on the square.
    MeanValue,
    /// Each vertex in the middle of its neighbours: with mean value coordinates rounding had flipped
    /// triangles.
    Uniform,
    /// From a coarse mesh to the fine one, vertex by vertex.
    CoarseToFine,
}

/// A side of a polygon: the border vertices from its first corner on, without the last one, and
/// their places.
pub(super) type PolygonSide = Vec<(u32, DVec2)>;

/// Lays a chart onto a convex polygon with given places of the border, without a flip: mean value
/// coordinates ([PGP06] §3.4), or what comes to their aid.
///
/// An edge inside that joins two vertices of one side is split first: the triangles next to it could
/// only collapse. Without such edges and with positive weights, no triangle flips (Floater 1997).
///
/// [PGP06]: crate::papers::PGP06
pub(super) fn polygon_map(
    disk: &mut ChartDisk,
    sides: &[PolygonSide],
    chart: ChartId,
    watch: &Watch,
) -> Result<(Vec<DVec2>, ChartMethod), ChartMapError> {
    let (_, places, method) = laid_down(disk, sides, chart, watch)?;
    Ok((places, method))
}

/// The same on the unit square, and then, with the border where it is, down to less distortion in as
/// many steps.
///
/// What counts is the symmetric Dirichlet energy of the map onto the rectangle with the chart's area
/// and the ratio of its sides. The first map stays where the descent finds nothing better in double
/// precision.
pub(super) fn square_map(
    disk: &mut ChartDisk,
    sides: &[PolygonSide],
    chart: ChartId,
    steps: u32,
    watch: &Watch,
) -> Result<(Vec<DVec2>, ChartMethod), ChartMapError> {
    let (patch, places, method) = laid_down(disk, sides, chart, watch)?;
    if steps == 0 {
        return Ok((places, method));
    }
    let size = rectangle_size(disk, sides);
    let uv = PerVertex::new(places.iter().map(|&place| place * size).collect());
    let options = InjectiveOptions {
        least_gain: CHART_GAIN,
        iterations: steps as usize,
        ..InjectiveOptions::default()
    };
    let fixed = BoundaryFreedom::Fixed;
    let improved = improve_map(&patch, &uv, fixed, &options, &watch.quiet_part());
    watch.check()?;
    let improved = improved.ok().map(|improved| {
        let found = improved.map.uv.iter().map(|&place| place / size);
        let border = sides.iter().flatten().copied().collect::<Vec<_>>();
        with_border(found.collect(), &border)
    });
    match improved.filter(|improved| is_upright(&disk.triangles, improved)) {
        Some(improved) => Ok((improved, method)),
        None => Ok((places, method)),
    }
}

/// The sides of the rectangle of a disk's area that are in the ratio of its four sides.
fn rectangle_size(disk: &ChartDisk, sides: &[PolygonSide]) -> DVec2 {
    let at = |&(vertex, _): &(u32, DVec2)| disk.positions[vertex as usize];
    let length = |side: usize| -> f64 {
        let end = sides[(side + 1) % sides.len()].first();
        let places: Vec<_> = sides[side].iter().chain(end).map(at).collect();
        places
            .windows(2)
            .map(|ends| ends[0].distance(ends[1]))
            .sum()
    };
    let ratio = (length(0) + length(2)) / (length(1) + length(3));
    let area = source_triangles(disk).map(|(_, triangle)| triangle.area());
    rectangle(area.sum(), ratio)
}

/// The triangles that have an area, by number.
fn source_triangles(disk: &ChartDisk) -> impl Iterator<Item = (usize, SourceTriangle)> + '_ {
    let triangles = disk.triangles.iter().enumerate();
    triangles.filter_map(|(number, corners)| {
        let corners = corners.map(|vertex| disk.positions[vertex as usize]);
        Some((number, SourceTriangle::from_positions(corners)?))
    })
}

/// The mean symmetric Dirichlet energy, 4 at least, of a map of a disk onto the unit square, seen as the
/// rectangle with the disk's area and the ratio of its sides. Infinite if a triangle is flipped.
pub(super) fn square_energy(disk: &ChartDisk, sides: &[PolygonSide], places: &[DVec2]) -> f64 {
    if !is_upright(&disk.triangles, places) {
        return f64::INFINITY;
    }
    let size = rectangle_size(disk, sides);
    let (mut sum, mut area) = (0.0, 0.0);
    for (number, source) in source_triangles(disk) {
        let images = disk.triangles[number].map(|vertex| places[vertex as usize] * size);
        sum += source.area() * source.jacobian(images).symmetric_dirichlet();
        area += source.area();
    }
    if area > 0.0 { sum / area } else { 4.0 }
}

/// The rectangle of an area with its width so many times its height; a square where that is no number.
pub(super) fn rectangle(area: f64, ratio: f64) -> DVec2 {
    let root = ratio.sqrt();
    let ratio = if root.is_normal() { root } else { 1.0 };
    DVec2::new(ratio, 1.0 / ratio) * area.sqrt()
}

/// The patch, its map, and how it was found.
fn laid_down(
    disk: &mut ChartDisk,
    sides: &[PolygonSide],
    chart: ChartId,
    watch: &Watch,
) -> Result<(Patch, Vec<DVec2>, ChartMethod), ChartMapError> {
    split_dividing_edges(disk, sides);
    let surface = Surface::from_triangles(disk.positions.clone(), &disk.triangles)?;
    // Stages and warnings of single charts are of no interest: charts are counted by method.
    let quiet = watch.quiet_part();
    watch.check()?;
    let patch = Patch::new(surface, &quiet)
        .map_err(|reason| ChartMapError::of_chart(chart, reason.into()))?;
    let places: Vec<_> = sides.iter().flatten().copied().collect();
    let border = places.iter().map(|&(v, place)| (VertexId(v), place));
    let border = BoundaryPositions::new(&patch, border)
        .map_err(|reason| ChartMapError::Polygon { chart, reason })?;
    for (weights, method) in [
        (Weights::MeanValue, ChartMethod::MeanValue),
        (Weights::Uniform, ChartMethod::Uniform),
    ] {
        let options = FixedOptions {
            weights,
            ..FixedOptions::default()
        };
        // Needles may have no weights, or not to double precision.
        if let Ok(map) = fixed_map(&patch, &border, &options, &quiet) {
            let uvs = with_border(map.uv.into_vec(), &places);
            if is_upright(&disk.triangles, &uvs) {
                return Ok((patch, uvs, method));
            }
        }
        watch.check()?;
    }
    let map = convex_map(&patch, &border, &quiet)
        .map_err(|reason| ChartMapError::of_chart(chart, reason))?;
    let uvs = with_border(map.into_vec(), &places);
    Ok((patch, uvs, ChartMethod::CoarseToFine))
}

/// Whether every triangle is laid down counter-clockwise. Exact.
fn is_upright(triangles: &[[u32; 3]], uvs: &[DVec2]) -> bool {
    triangles.iter().all(|triangle| {
        let [a, b, c] = triangle.map(|vertex| uvs[vertex as usize]);
        orientation(a, b, c) > 0
    })
}

/// The map with the border exactly in its places.
fn with_border(mut uvs: Vec<DVec2>, places: &[(u32, DVec2)]) -> Vec<DVec2> {
    for &(vertex, place) in places {
        uvs[vertex as usize] = place;
    }
    uvs
}

/// Splits edges inside between vertices of one side in the middle.
pub(super) fn split_dividing_edges(disk: &mut ChartDisk, sides: &[PolygonSide]) {
    let mut on_sides = vec![[usize::MAX; 2]; disk.positions.len()];
    for (index, side) in sides.iter().enumerate() {
        for (step, &(vertex, _)) in side.iter().enumerate() {
            let before = (index + sides.len() - 1) % sides.len();
            on_sides[vertex as usize] = [index, if step == 0 { before } else { index }];
        }
    }
    let mut halfedge = 0;
    // Splitting adds triangles; edges may move to their halfedges.
    while (halfedge as usize) < 3 * disk.triangles.len() {
        let ends = [disk.origin(halfedge), disk.destination(halfedge)];
        let sides = ends.map(|v| on_sides.get(v as usize).copied().unwrap_or([usize::MAX; 2]));
        let shares_side = sides[0]
            .iter()
            .any(|s| *s != usize::MAX && sides[1].contains(s));
        if shares_side && disk.twin(halfedge).is_some() {
            disk.split_inner_edge(halfedge, 0.5);
        }
        halfedge += 1;
    }
}

/// The corners of a convex polygon with sides of one length; the unit square, or round the origin.
pub(super) fn corner_places(count: usize) -> Vec<DVec2> {
    if count == 4 {
        return vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    }
    let angle = |k: usize| std::f64::consts::TAU * k as f64 / count as f64;
    let corner = |k| DVec2::new(libm::cos(angle(k)), libm::sin(angle(k)));
    (0..count).map(corner).collect()
}

/// Vertices along the sides of a polygon with these corners, each at its share of the side.
pub(super) fn sides_along(corners: &[DVec2], sides: &[Vec<(u32, f64)>]) -> Vec<PolygonSide> {
    let side = |(index, side): (usize, &Vec<(u32, f64)>)| {
        let [from, to] = [corners[index], corners[(index + 1) % corners.len()]];
        // One end plus a share of the way keeps vertices of an axis-parallel side on it exactly.
        side.iter()
            .map(|&(vertex, share)| (vertex, from + (to - from) * share))
            .collect()
    };
    sides.iter().enumerate().map(side).collect()
}

impl ChartDisk {
    /// The triangle that contains a place of a map without flips, with the place's weights there;
    /// of several the first.
    pub(super) fn locate(&self, uvs: &[DVec2], place: DVec2) -> Option<(u32, [i8; 3])> {
        let mut triangles = (0_u32..).zip(&self.triangles);
        triangles.find_map(|(number, triangle)| {
            let corners = triangle.map(|vertex| uvs[vertex as usize]);
            let signs = [0, 1, 2].map(|k| orientation(corners[k], corners[(k + 1) % 3], place));
            signs
                .iter()
                .all(|&sign| sign >= 0)
                .then_some((number, signs))
        })
    }
}
