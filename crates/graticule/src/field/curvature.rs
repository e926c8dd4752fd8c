use std::f64::consts::FRAC_PI_2;

use glam::{DMat3, DVec2, DVec3, Vec3Swizzles};
use rayon::prelude::*;

use super::Symmetry;
use super::disk::{DiskFinder, DiskVertex, EdgeGraph};
use super::tangent::TangentPlanes;
use crate::geometry::{EdgeLengths, IntrinsicTriangulation, dihedral_angles, vertex_areas};
use crate::mesh::{PerVertex, Surface, VertexId};
use crate::tolerance::{DISK_VERTEX_LIMIT, FINE_DISK, FLAT_CURVATURE, UMBILIC_CONFIDENCE};
use crate::watch::{Stopped, Watch};

/// How curvature is estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvatureOptions {
    /// Radius of the disk that the curvature of a vertex is averaged over, in mean edge lengths.
    pub radius: f64,
    /// How much of the weight of its directions counts, 0 to 1. The whole of it lets a field turn from
    /// one direction to another over some two edges; a share of it, over as many more as one over its
    /// root.
    pub share: f64,
}

impl Default for CurvatureOptions {
    fn default() -> Self {
        Self {
            radius: 3.0,
            share: 1.0,
        }
    }
}

/// The curvature of the surface at a vertex.
///
/// A curvature is positive where the surface bends away from its normal, as a sphere seen from
/// outside; its unit is one over that of the positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalCurvature {
    /// The larger curvature.
    pub max: f64,
    /// The smaller curvature.
    pub min: f64,
    /// The direction in which the curvature is `max`, as an angle in the tangent plane of the
    /// vertex in `-π..=π`, up to a half turn.
    pub direction: f64,
    /// How far the directions can be trusted, in `0.0..=1.0`; 0 where the surface is flat or
    /// bends alike in all directions.
    pub confidence: f64,
}

impl PrincipalCurvature {
    /// The larger size of the two.
    pub(crate) fn largest(&self) -> f64 {
        self.max.abs().max(self.min.abs())
    }
}

/// The principal curvatures and directions at each vertex, by normal cycles: each edge counts with
/// its dihedral angle and length along its own direction
/// (D. Cohen-Steiner, J.-M. Morvan, *Restricted Delaunay Triangulations and Normal Cycle*, 2003),
/// averaged over geodesic disks with a weight that falls to 0 at their rim.
///
/// Where the sampling is finer than on average, the radius is at most [`FINE_DISK`] of the edges
/// there, or as many as were asked for, and no disk holds more than [`DISK_VERTEX_LIMIT`] vertices. At the boundary the disk is what
/// is there of it.
///
/// Angles are those of [`IntrinsicTriangulation::direction`].
///
/// Cost: linear, in parallel; some 40 vertices a disk at the default radius on an even sampling.
///
/// # Errors
/// [`Stopped`] if the watch says so.
pub fn principal_curvatures(
    surface: &Surface,
    triangulation: &IntrinsicTriangulation,
    options: &CurvatureOptions,
    watch: &Watch,
) -> Result<PerVertex<PrincipalCurvature>, Stopped> {
    let planes = TangentPlanes::of(surface, triangulation);
    curvatures_on(planes, &EdgeGraph::of(surface), *options, watch)
}

/// The same where tangent planes and edges of the surface are at hand.
pub(super) fn curvatures_on(
    planes: TangentPlanes<'_>,
    graph: &EdgeGraph,
    options: CurvatureOptions,
    watch: &Watch,
) -> Result<PerVertex<PrincipalCurvature>, Stopped> {
    let _stage = watch.stage("curvature");
    let estimator = Estimator::new(planes, graph, options);
    let vertices = graph.vertices();
    let chunks: Result<Vec<Vec<_>>, Stopped> = (0..vertices.len().div_ceil(CHUNK))
        .into_par_iter()
        .map_init(
            || (DiskFinder::new(graph), Vec::new()),
            |(finder, disk), chunk| {
                watch.check()?;
                let ranks = chunk * CHUNK..vertices.len().min((chunk + 1) * CHUNK);
                Ok(ranks
                    .map(|rank| estimator.at(rank as u32, finder, disk))
                    .collect())
            },
        )
        .collect();
    let found = chunks?.concat();
    Ok(PerVertex::from_fn(vertices.len(), |vertex| {
        found[graph.rank(vertex) as usize]
    }))
}

/// Vertices between two looks at the watch.
const CHUNK: usize = 1024;

struct Estimator<'a> {
    planes: TangentPlanes<'a>,
    graph: &'a EdgeGraph,
    /// What each vertex brings into a disk, by rank.
    bends: Vec<Bend>,
    /// The radius of each disk, by rank.
    radii: Vec<f64>,
    flat: f64,
}

/// The bends of the edges at a vertex as a symmetric tensor, and its area.
#[derive(Clone, Copy, Debug, Default)]
struct Bend {
    diagonal: DVec3,
    /// The entries yz, zx and xy.
    mixed: DVec3,
    area: f64,
}

impl Bend {
    fn add(&mut self, other: &Self, weight: f64) {
        self.diagonal += other.diagonal * weight;
        self.mixed += other.mixed * weight;
        self.area += other.area * weight;
    }

    /// Adds `size` times the square of a direction.
    fn add_along(&mut self, direction: DVec3, size: f64) {
        self.diagonal += direction * direction * size;
        let (yzx, zxy) = (direction.yzx(), direction.zxy());
        self.mixed += yzx * zxy * size;
    }

    /// The tensor over twice the area, as each edge is at two vertices.
    fn mean(&self) -> DMat3 {
        if self.area <= 0.0 {
            return DMat3::ZERO;
        }
        let [
            DVec3 {
                x: xx,
                y: yy,
                z: zz,
            },
            DVec3 {
                x: yz,
                y: zx,
                z: xy,
            },
        ] = [self.diagonal, self.mixed].map(|part| part * (0.5 / self.area));
        DMat3::from_cols(
            DVec3::new(xx, xy, zx),
            DVec3::new(xy, yy, yz),
            DVec3::new(zx, yz, zz),
        )
    }
}

impl<'a> Estimator<'a> {
    fn new(planes: TangentPlanes<'a>, graph: &'a EdgeGraph, options: CurvatureOptions) -> Self {
        let (surface, triangulation) = (planes.surface, planes.triangulation);
        let lengths = EdgeLengths::of(surface);
        let areas = vertex_areas(triangulation);
        let bends = vertex_bends(surface, &lengths, &areas);
        Self {
            bends: graph.vertices().iter().map(|&v| bends[v]).collect(),
            radii: radii(graph, options.radius, lengths.mean()),
            flat: FLAT_CURVATURE / radius_of_gyration(surface, &areas),
            planes,
            graph,
        }
    }

    fn at(
        &self,
        rank: u32,
        finder: &mut DiskFinder<'_>,
        disk: &mut Vec<DiskVertex>,
    ) -> PrincipalCurvature {
        finder.find(rank, self.radii[rank as usize], DISK_VERTEX_LIMIT, disk);
        let mut sum = Bend::default();
        for entry in disk.iter() {
            let weight = (1.0 - entry.square).powi(2);
            sum.add(&self.bends[entry.rank as usize], weight);
        }
        self.principal(sum.mean(), self.graph.vertices()[rank as usize])
    }

    /// The normal cycle sees a bend across an edge along the edge, so that its larger eigenvalue
    /// belongs to the direction of the smaller curvature.
    fn principal(&self, tensor: DMat3, vertex: VertexId) -> PrincipalCurvature {
        let frame = &self.planes.frames[vertex];
        let (tx, ty) = (tensor * frame.x, tensor * frame.y);
        let (xx, xy, yy) = (frame.x.dot(tx), frame.x.dot(ty), frame.y.dot(ty));
        let mean = f64::midpoint(xx, yy);
        let half_difference = DVec2::new((xx - yy) / 2.0, xy);
        let half_gap = half_difference.length();
        let along = 0.5 * libm::atan2(half_difference.y, half_difference.x);
        let direction = if along > 0.0 {
            along - FRAC_PI_2
        } else {
            along + FRAC_PI_2
        };
        let (max, min) = (mean + half_gap, mean - half_gap);
        PrincipalCurvature {
            max,
            min,
            direction: self.planes.on_surface(Symmetry::Line, vertex, direction),
            confidence: confidence(max, min, self.flat),
        }
    }
}

/// The root of the mean square distance from the centre, by area: a size that does not change when
/// the surface is turned. Infinite without area.
fn radius_of_gyration(surface: &Surface, areas: &PerVertex<f64>) -> f64 {
    let total: f64 = areas.iter().sum();
    if total <= 0.0 {
        return f64::INFINITY;
    }
    let shares = || {
        surface
            .positions()
            .iter()
            .zip(areas.iter().map(|area| area / total))
    };
    let center: DVec3 = shares().map(|(&position, share)| position * share).sum();
    let squares = shares().map(|(position, share)| position.distance_squared(center) * share);
    squares.sum::<f64>().sqrt()
}

/// The radius of each disk, by rank: `radius` mean lengths, but no more than so many, or [`FINE_DISK`],
/// of the edges there.
fn radii(graph: &EdgeGraph, radius: f64, mean_length: f64) -> Vec<f64> {
    let most = radius.max(FINE_DISK);
    let means = graph.mean_lengths();
    let around = |rank: u32| {
        let ends = graph.at(rank);
        let sum: f64 = ends.iter().map(|&(end, _)| means[end as usize]).sum();
        (means[rank as usize] + sum) / (ends.len() + 1) as f64
    };
    let ranks = 0..means.len() as u32;
    ranks
        .map(|rank| (radius * mean_length).min(most * around(rank)))
        .collect()
}

/// For each vertex the sum over its edges of dihedral angle × length × direction ⊗ direction.
fn vertex_bends(
    surface: &Surface,
    lengths: &EdgeLengths,
    areas: &PerVertex<f64>,
) -> PerVertex<Bend> {
    let mesh = surface.mesh();
    let angles = dihedral_angles(surface);
    let mut sums = areas.map(|&area| Bend {
        area,
        ..Bend::default()
    });
    for edge in mesh.edges().filter(|&edge| lengths[edge] > 0.0) {
        let halfedge = mesh.edge_halfedge(edge);
        let along = surface.halfedge_vector(halfedge) / lengths[edge];
        for vertex in mesh.ends(halfedge) {
            sums[vertex].add_along(along, angles[edge] * lengths[edge]);
        }
    }
    sums
}

/// `(max - min)² / (max² + min² + flat²)`, at most 1: 1 on a cylinder and on any saddle, 0 on
/// spheres and planes, whatever the size of the model. The ratio `|max / min|` of [PGP06] Eq. 21 is
/// infinite at parabolic points and says nothing on flat ones.
///
/// What is below [`UMBILIC_CONFIDENCE`] counts as 0, and the rest from there: the disk has the same
/// number of edges on any sampling, so that on a sphere the error of the difference stays when the
/// mesh gets finer, while ever more vertices share it.
///
/// [PGP06]: crate::papers::PGP06
fn confidence(max: f64, min: f64, flat: f64) -> f64 {
    // In terms of the largest, so that squares neither overflow nor underflow.
    let scale = max.abs().max(min.abs()).max(flat);
    if scale == 0.0 || !scale.is_finite() {
        return 0.0;
    }
    let (max, min, flat) = (max / scale, min / scale, flat / scale);
    let share = (max - min).powi(2) / (max * max + min * min + flat * flat);
    ((share - UMBILIC_CONFIDENCE) / (1.0 - UMBILIC_CONFIDENCE)).clamp(0.0, 1.0)
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "exactness is what is tested")]
mod tests {
    use super::*;
    use graticule_fixtures::{
        Fixture, cylinder_patch, grid, icosphere, irregular_disk, saddle_patch, torus,
    };

    fn curvatures(fixture: Fixture, radius: f64) -> (Surface, PerVertex<PrincipalCurvature>) {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let triangulation = IntrinsicTriangulation::of(&surface).unwrap();
        let options = CurvatureOptions {
            radius,
            ..CurvatureOptions::default()
        };
        let found =
            principal_curvatures(&surface, &triangulation, &options, &Watch::new()).unwrap();
        (surface, found)
    }

    fn directions_in_space(
        surface: &Surface,
        found: &PerVertex<PrincipalCurvature>,
    ) -> PerVertex<DVec3> {
        let frames = crate::geometry::vertex_frames(surface);
        let lift = |v: VertexId| frames[v].lift(DVec2::from_angle(found[v].direction));
        PerVertex::from_fn(found.len(), lift)
    }

    #[test]
    fn a_plane_is_flat_and_trusted_nowhere() {
        let (_, found) = curvatures(grid(1.0, 1.0, 10, 10), 3.0);
        assert!(
            found
                .iter()
                .all(|c| c.max == 0.0 && c.min == 0.0 && c.confidence == 0.0)
        );
    }

    #[test]
    fn a_sphere_bends_alike_in_all_directions() {
        let (_, found) = curvatures(icosphere(4).map(|p| p * 2.0), 4.0);
        for c in &found {
            assert!(
                (c.max - 0.5).abs() < 0.02 && (c.min - 0.5).abs() < 0.02,
                "{c:?}"
            );
            assert!(c.confidence < 2e-3, "{c:?}");
        }
    }

    #[test]
    fn a_cylinder_bends_round_its_axis() {
        let (surface, found) = curvatures(cylinder_patch(2.0, 6.0, 60, 30), 3.0);
        let directions = directions_in_space(&surface, &found);
        for (vertex, c) in found.enumerate() {
            assert!((c.max - 0.5).abs() < 0.02 && c.min.abs() < 0.02, "{c:?}");
            assert!(c.confidence > 0.5, "{c:?}");
            assert!(
                directions[vertex].z.abs() < 0.03,
                "{vertex}: {}",
                directions[vertex]
            );
        }
    }

    #[test]
    fn a_torus_has_its_closed_form() {
        let (surface, found) = curvatures(torus(3.0, 1.0, 180, 60), 3.0);
        let directions = directions_in_space(&surface, &found);
        for (vertex, c) in found.enumerate() {
            let p = surface.position(vertex);
            let cos = p.truncate().length() - 3.0;
            let along = cos / (3.0 + cos);
            assert!(
                (c.max - 1.0).abs() < 0.02 && (c.min - along).abs() < 0.02,
                "{c:?} {along}"
            );
            let around = DVec3::new(-p.y, p.x, 0.0).normalize();
            assert!(directions[vertex].dot(around).abs() < 0.05);
        }
    }

    #[test]
    fn a_saddle_bends_both_ways_at_its_middle() {
        let (surface, found) = curvatures(saddle_patch(40), 4.0);
        let middle = VertexId(20 * 41 + 20);
        let c = found[middle];
        // z = (x² - y²) / 2 bends towards its upward normal along x.
        assert!(
            (c.max - 1.0).abs() < 0.05 && (c.min + 1.0).abs() < 0.05,
            "{c:?}"
        );
        assert!(c.confidence == 1.0);
        assert!(directions_in_space(&surface, &found)[middle].x.abs() < 0.05);
    }

    #[test]
    fn an_irregular_bowl_converges_inside() {
        // The mean over a disk of fixed size in edges would keep its noise: the disk must shrink
        // more slowly than the mesh.
        let error = |rings: u32, radius: f64| {
            let bowl = irregular_disk(rings, 5)
                .map(|p| DVec3::new(p.x, p.y, -(p.x * p.x + 0.3 * p.y * p.y)));
            let (surface, found) = curvatures(bowl, radius);
            let near = |v: &VertexId| surface.position(*v).truncate().length() < 0.04;
            let errors = surface
                .mesh()
                .vertices()
                .filter(near)
                .map(|v| (found[v].max - 2.0).abs().max((found[v].min - 0.6).abs()));
            errors.fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(30, 4.0), error(160, 12.0));
        assert!(fine < 0.6 * coarse && fine < 0.1, "{coarse} {fine}");
    }

    #[test]
    fn confidence_is_bounded_and_does_not_know_the_scale() {
        for scale in [1e-150, 1.0, 1e150] {
            assert_eq!(confidence(scale, 0.0, 0.0), 1.0);
            assert_eq!(confidence(scale, -scale, 0.0), 1.0);
            assert_eq!(confidence(scale, scale, 0.0), 0.0);
        }
        assert_eq!(confidence(0.0, 0.0, 0.0), 0.0);
        assert!(confidence(1e-9, 0.0, 1.0) < 1e-17);
    }
}
