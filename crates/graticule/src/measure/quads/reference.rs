use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::carrying::{EdgeTree, LineCarrying};
use super::polygons::Measured;
use super::samples::spread_over_triangles;
use crate::geometry::{TriangleTree, dihedral_angles};
use crate::measure::MeasureError;
use crate::measure::statistics::{self, Sample, weighted_quantiles};
use crate::measure::uv_map::scale_to_unit;
use crate::mesh::{EdgeId, Element, PerVertex, PolygonSoup, Surface, Topology};
use crate::watch::Watch;

/// Points on each side from which distances are measured.
const SAMPLES: usize = 20_000;

/// Angle between two triangles from which on their edge is a sharp one, in degrees.
const SHARP: f64 = 40.0;

/// Share of sharp edges from which on they are no lines but the surface itself.
const ALL_SHARP: f64 = 0.2;

/// A mesh held against the surface that it stands for. Made by [`compare_to_reference`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReferenceMeasure {
    /// Whether the mesh has as many components and boundary loops as the reference, and its Euler
    /// characteristic.
    pub topology_kept: bool,
    /// Components of the reference.
    pub components: usize,
    /// Boundary loops of the reference.
    pub boundary_loops: usize,
    /// Euler characteristic of the reference.
    pub euler_characteristic: i64,
    /// Distances from the mesh to the reference.
    pub distance: Deviation,
    /// Distances from the reference to the mesh: large where a part of it is missing.
    pub distance_from_reference: Deviation,
    /// Angles between the normals of the mesh and those of the reference.
    pub normal_deviation: NormalDeviation,
    /// How the mesh carries the sharp edges of the reference (40° and more); `None` where there
    /// are none, or more than a fifth of all edges.
    pub sharp_edges: Option<LineCarrying>,
    /// How the mesh carries the boundary of the reference; `None` without boundary.
    pub boundary: Option<LineCarrying>,
    /// Points on each side from which distances were measured.
    pub samples: usize,
}

/// Distances, in percent of the diagonal of the reference's box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Deviation {
    /// The mean by area.
    pub mean: f64,
    /// The root of the mean square.
    pub rms: f64,
    /// The largest found.
    pub max: f64,
}

/// Angles between normals, in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct NormalDeviation {
    /// The mean by area.
    pub mean: f64,
    /// The value that 95 % of the area does not exceed.
    pub p95: f64,
    /// Share of the area with more than 90°, in `0.0..=1.0`.
    pub flipped_share: f64,
}

/// Holds a polygon mesh against a reference surface.
///
/// Distances are sampled evenly over the area of either side, from points that are always the
/// same, each to the closest point of the other side; so the largest found is a lower bound. Nothing
/// depends on units.
///
/// Cost: O(n log n) for the search trees and some 50,000 searches.
///
/// # Errors
/// [`MeasureError`]: an extent beyond 1e±140, or stopped. A mesh without area has no distances
/// (all 0) and keeps no topology.
pub fn compare_to_reference(
    soup: &PolygonSoup,
    reference: &Surface,
    watch: &Watch,
) -> Result<ReferenceMeasure, MeasureError> {
    let _stage = watch.stage("compare to reference");
    let sides = Sides::new(soup, reference)?;
    watch.check()?;
    let to_reference = distances(&sides.mesh, &sides.reference);
    watch.check()?;
    let from_reference = distances(&sides.reference, &sides.mesh);
    watch.check()?;
    let topology = Topology::of(reference.mesh());
    let lines = Lines::of(&sides.surface);
    let edges = EdgeTree::new(sides.edges);
    Ok(ReferenceMeasure {
        topology_kept: super::connections::same_topology(soup, &topology),
        components: topology.components.len(),
        boundary_loops: topology.total.boundary_loops,
        euler_characteristic: topology.total.euler_characteristic,
        distance: deviation(&to_reference, sides.diagonal),
        distance_from_reference: deviation(&from_reference, sides.diagonal),
        normal_deviation: normal_deviation(&to_reference),
        sharp_edges: lines
            .sharp
            .and_then(|lines| edges.carrying(&lines, sides.diagonal)),
        boundary: edges.carrying(&lines.boundary, sides.diagonal),
        samples: SAMPLES,
    })
}

/// Mesh and reference, both scaled so that the reference has unit extent.
struct Sides {
    mesh: TriangleTree,
    edges: Vec<[DVec3; 2]>,
    reference: TriangleTree,
    surface: Surface,
    diagonal: f64,
}

impl Sides {
    fn new(soup: &PolygonSoup, reference: &Surface) -> Result<Self, MeasureError> {
        let measured = Measured::new(soup)?;
        let [low, high] = reference.bounding_box();
        let scale = scale_to_unit("reference", (high - low).max_element())?;
        let factor = scale / measured.scale;
        let triangles =
            (0..measured.mesh.polygon_count()).flat_map(|polygon| measured.triangles(polygon));
        let edges = measured.mesh.edges().map(|sides| {
            let ends = measured.mesh.edge(sides[0]);
            ends.map(|vertex| measured.position(vertex) * factor)
        });
        let positions = reference
            .positions()
            .iter()
            .map(|&position| position * scale);
        let surface = Surface::new(reference.shared_mesh(), PerVertex::new(positions.collect()))
            .unwrap_or_else(|_| unreachable!("a surface scaled to unit extent"));
        Ok(Self {
            mesh: TriangleTree::new(triangles.map(|t| t.map(|corner| corner * factor)).collect()),
            edges: edges.collect(),
            reference: TriangleTree::of_surface(&surface),
            diagonal: ((high - low) * scale).length(),
            surface,
        })
    }
}

/// Distance of a point from the other side, and the angle between the normals, in degrees.
#[derive(Clone, Copy)]
struct Gap {
    distance: f64,
    angle: f64,
}

fn distances(from: &TriangleTree, to: &TriangleTree) -> Vec<Gap> {
    let samples = spread_over_triangles(from.triangles(), SAMPLES);
    let gaps = samples.into_par_iter().filter_map(|sample| {
        let closest = to.closest(sample.position)?;
        let place = closest.interpolate(to.triangles()[closest.face.index()]);
        let [own, other] = [
            from.normals()[sample.triangle],
            to.normals()[closest.face.index()],
        ];
        Some(Gap {
            distance: place.distance(sample.position),
            angle: libm::atan2(own.cross(other).length(), own.dot(other)).to_degrees(),
        })
    });
    gaps.collect()
}

fn deviation(gaps: &[Gap], diagonal: f64) -> Deviation {
    if gaps.is_empty() {
        return Deviation::default();
    }
    let percent = 100.0 / diagonal;
    let count = gaps.len() as f64;
    let squares = statistics::sum(gaps, |gap| gap.distance * gap.distance);
    Deviation {
        mean: percent * statistics::sum(gaps, |gap| gap.distance) / count,
        rms: percent * (squares / count).sqrt(),
        max: percent * gaps.iter().map(|gap| gap.distance).fold(0.0, f64::max),
    }
}

fn normal_deviation(gaps: &[Gap]) -> NormalDeviation {
    if gaps.is_empty() {
        return NormalDeviation::default();
    }
    let count = gaps.len() as f64;
    let mut samples: Vec<_> = gaps
        .iter()
        .map(|gap| Sample {
            value: gap.angle,
            weight: 1.0,
        })
        .collect();
    let [p95] = weighted_quantiles(&mut samples, [0.95]);
    NormalDeviation {
        mean: statistics::sum(gaps, |gap| gap.angle) / count,
        p95,
        flipped_share: gaps.iter().filter(|gap| gap.angle > 90.0).count() as f64 / count,
    }
}

/// Lines of a reference that a mesh should carry.
struct Lines {
    sharp: Option<Vec<[DVec3; 2]>>,
    boundary: Vec<[DVec3; 2]>,
}

impl Lines {
    fn of(surface: &Surface) -> Self {
        let mesh = surface.mesh();
        let ends = |edge: EdgeId| {
            mesh.ends(mesh.edge_halfedge(edge))
                .map(|v| surface.position(v))
        };
        let angles = dihedral_angles(surface);
        let sharp: Vec<_> = mesh
            .edges()
            .filter(|&edge| angles[edge].abs() > SHARP.to_radians())
            .map(ends)
            .collect();
        let inner = mesh
            .edges()
            .filter(|&edge| !mesh.is_boundary_edge(edge))
            .count();
        let are_lines = (sharp.len() as f64) < ALL_SHARP * inner as f64;
        let boundary = mesh.edges().filter(|&edge| mesh.is_boundary_edge(edge));
        Self {
            sharp: are_lines.then_some(sharp),
            boundary: boundary.map(ends).collect(),
        }
    }
}
