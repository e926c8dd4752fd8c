//! The result of every flattening.

use faer::c64;
use glam::DVec2;
use serde::Serialize;

use crate::measure::{box_around, corner_uvs, orientation};
use crate::mesh::{PerCorner, PerVertex, TriangleMesh};
use crate::solve::SolveError;
use crate::tolerance::{COLLAPSED_AREA, LINEAR_RESIDUAL};
use crate::watch::Watch;

use super::energy::point;
use super::{FlattenError, MapEnergy, Patch};

/// How a map was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// [`fixed_map`](super::fixed_map) with cotangent weights.
    FixedConformal,
    /// [`fixed_map`](super::fixed_map) with cotangent weights of the intrinsic Delaunay
    /// triangulation.
    FixedConformalDelaunay,
    /// [`fixed_map`](super::fixed_map) with authalic weights.
    FixedAuthalic,
    /// [`fixed_map`](super::fixed_map) with a mix of conformal and authalic weights.
    FixedMix,
    /// [`fixed_map`](super::fixed_map) with mean value weights.
    FixedMeanValue,
    /// [`fixed_map`](super::fixed_map) with uniform weights.
    FixedUniform,
    /// [`natural_map`](super::natural_map).
    NaturalConformal,
    /// [`spectral_map`](super::spectral_map).
    SpectralConformal,
    /// [`near_optimal_map`](super::near_optimal_map).
    NearOptimal,
    /// [`boundary_optimal_map`](super::boundary_optimal_map).
    BoundaryOptimal,
    /// [`target_map`](super::target_map).
    BoundaryTarget,
    /// [`injective_map`](super::injective_map) or [`improve_map`](super::improve_map).
    Injective,
}

/// Triangles of a map that are not laid down as they should be. Exact: the signs are those of the
/// coordinates as stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FlipCount {
    /// Triangles turned over, their corners clockwise.
    pub flipped: usize,
    /// Triangles whose corners are collinear: their area in the map is exactly zero.
    pub degenerate: usize,
}

impl FlipCount {
    /// Counts with an exact predicate (Shewchuk 1997). Linear time.
    #[must_use]
    pub fn of(mesh: &TriangleMesh, uv: &PerVertex<DVec2>) -> Self {
        let triangles = mesh.faces().map(|face| mesh.triangle(face));
        Self::of_triangles(triangles.map(|triangle| triangle.map(|vertex| uv[vertex])))
    }

    pub(super) fn of_triangles(triangles: impl Iterator<Item = [DVec2; 3]>) -> Self {
        let mut count = Self::default();
        for triangle in triangles {
            let [a, b, c] = triangle;
            match orientation(a, b, c) {
                0 => count.degenerate += 1,
                -1 => count.flipped += 1,
                _ => {}
            }
        }
        count
    }

    /// Whether every triangle is laid down with its corners counter-clockwise.
    #[must_use]
    pub fn is_zero(self) -> bool {
        self == Self::default()
    }
}

/// A patch laid into the plane: one point for each vertex.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlatMap {
    /// Coordinates (u, v), counter-clockwise like the surface seen from outside, in the surface's
    /// own unit of length; each method says where it puts the map.
    pub uv: PerVertex<DVec2>,
    /// How the map was made.
    pub method: Method,
    /// Relative residual of the equations solved, at most
    /// [`LINEAR_RESIDUAL`].
    pub residual: f64,
    /// Triangles turned over or without area.
    pub flips: FlipCount,
    /// Whether theory excludes flips for this method, these weights and this boundary. A flip in
    /// such a map comes from the limited precision of the coordinates.
    pub flip_free_in_theory: bool,
    /// Flips among the triangles of the intrinsic Delaunay triangulation, where one was used: it is
    /// of them that theory speaks. The ends of thin spikes, where two edges have the same ends,
    /// collapse in theory; rounding decides how they are counted.
    pub intrinsic_flips: Option<FlipCount>,
    /// Energies of the map over the area of the patch: `energy.area` is 1 for a map of its area.
    pub energy: MapEnergy,
}

impl FlatMap {
    /// The coordinates at each corner of each triangle.
    #[must_use]
    pub fn corner_uv(&self, mesh: &TriangleMesh) -> PerCorner<DVec2> {
        corner_uvs(mesh, &self.uv)
    }

    /// The coordinates moved and scaled, equally in both directions, so that they fill the unit
    /// square as far as they can, from its lower left corner: texture coordinates.
    #[must_use]
    pub fn unit_square_uv(&self) -> PerVertex<DVec2> {
        let [low, high] = box_around(self.uv.iter().copied());
        let extent = (high - low).max_element();
        let extent = if extent > 0.0 { extent } else { 1.0 };
        self.uv.map(|&p| (p - low) / extent)
    }

    /// Leaves a warning if there are flips.
    pub(super) fn warn_of_flips(&self, watch: &Watch) {
        let FlipCount {
            flipped,
            degenerate,
        } = self.flips;
        if self.flips.is_zero() {
            return;
        }
        let cause = if self.flip_free_in_theory {
            ": differences between the coordinates are below double precision there"
        } else {
            ""
        };
        let message =
            format!("triangles turned over: {flipped}, without area: {degenerate}{cause}");
        watch.warn("flipped-triangles", message);
    }
}

/// A map as a solver leaves it: complex positions in unit lengths.
pub(super) struct MapDraft {
    pub(super) positions: Vec<c64>,
    pub(super) method: Method,
    pub(super) residual: f64,
    pub(super) flip_free_in_theory: bool,
    pub(super) intrinsic_flips: Option<FlipCount>,
}

impl MapDraft {
    /// The map scaled about the origin to the area of the patch.
    pub(super) fn scaled_to_patch(mut self, patch: &Patch) -> Result<Self, FlattenError> {
        let energy = MapEnergy::of(patch.mesh(), patch.shapes(), &self.uv());
        let area = energy.area / energy.dirichlet;
        if area.is_nan() || area < COLLAPSED_AREA {
            return Err(FlattenError::Collapsed { area });
        }
        let factor = (patch.unit_area() / energy.area).sqrt();
        for position in &mut self.positions {
            *position *= factor;
        }
        Ok(self)
    }

    /// Checks and measures the map and gives it the patch's unit of length.
    pub(super) fn finish(self, patch: &Patch, watch: &Watch) -> Result<FlatMap, FlattenError> {
        let _stage = watch.stage("check map");
        let residual = self.residual;
        let finite = self
            .positions
            .iter()
            .all(|p| p.re.is_finite() && p.im.is_finite());
        if !finite || residual.is_nan() || residual > LINEAR_RESIDUAL {
            return Err(FlattenError::Solve(SolveError::Inaccurate {
                residual,
                tolerance: LINEAR_RESIDUAL,
            }));
        }
        let unit_uv = self.uv();
        let energy = MapEnergy::of(patch.mesh(), patch.shapes(), &unit_uv);
        let map = FlatMap {
            flips: FlipCount::of(patch.mesh(), &unit_uv),
            uv: unit_uv.map(|&place| place * patch.unit_length()),
            method: self.method,
            residual,
            flip_free_in_theory: self.flip_free_in_theory,
            intrinsic_flips: self.intrinsic_flips,
            energy: energy.over(patch.unit_area()),
        };
        map.warn_of_flips(watch);
        Ok(map)
    }

    fn uv(&self) -> PerVertex<DVec2> {
        PerVertex::new(
            self.positions
                .iter()
                .map(|&position| point(position))
                .collect(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flips_are_told_from_collapses_by_one_unit_in_the_last_place() {
        let mesh = TriangleMesh::new(3, &[[0, 1, 2]]).unwrap();
        let count = |height: f64| {
            let corners = [DVec2::ZERO, DVec2::new(1.0, 1.0), DVec2::new(0.5, height)];
            let FlipCount {
                flipped,
                degenerate,
            } = FlipCount::of(&mesh, &PerVertex::new(corners.into()));
            [flipped, degenerate]
        };
        assert_eq!(count(0.5), [0, 1]);
        assert_eq!(count(0.5_f64.next_up()), [0, 0]);
        assert_eq!(count(0.5_f64.next_down()), [1, 0]);
    }
}
