use glam::{DVec2, DVec3};
use serde::Serialize;

use super::diffusion::{Diffusion, Nodes, System};
use super::hierarchy::Hierarchy;
use super::{CrossField, FieldError, Guidance};
use crate::geometry::IntrinsicTriangulation;
use crate::mesh::PerVertex;
use crate::tolerance::{FIELD_AT_REST, FREE_FIELD_AT_REST, SWEPT_FIELD_AT_REST};
use crate::watch::Watch;

/// How a field is smoothed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothingOptions {
    /// The share of smoothness against guidance, ρ of [PGP06] Eq. 21, in `0.0..1.0`.
    ///
    /// [PGP06]: crate::papers::PGP06
    pub smoothing: f64,
    /// Most steps of diffusion and normalisation; ten times as many where next to nothing guides the
    /// field, for singularities need that long to spread.
    pub steps: usize,
    /// Chooses the directions to start from where there is no guidance.
    pub seed: u64,
}

impl Default for SmoothingOptions {
    fn default() -> Self {
        Self {
            smoothing: 0.8,
            steps: 15,
            seed: 0,
        }
    }
}

/// A smooth field and how it was found.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothField {
    /// The field.
    pub field: CrossField,
    /// The figures.
    pub report: SmoothingReport,
}

/// Figures of a smoothing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SmoothingReport {
    /// Steps of diffusion and normalisation on the coarsest level.
    pub steps: usize,
    /// Levels from coarse to fine; 1 where the surface itself was coarse enough.
    pub levels: usize,
    /// Mean change of the free unit vectors in the last step or, with more levels, sweep.
    pub last_change: f64,
    /// How much the field turns, `Σ w |uⱼ - r uᵢ|²`; without unit.
    pub smoothness_energy: f64,
    /// How far it is from its guidance, `Σ weight |u - target|²`, areas in mean vertex areas.
    pub guidance_energy: f64,
    /// Relative residual of the linear solves, all of which have the same matrix.
    pub residual: f64,
}

/// The smoothest field that follows its guidance: minimises [PGP06] Eq. 21 over unit vectors.
///
/// From coarse to fine: neighbours are grouped, each turned by the rotation that links it to its
/// group, until the form has few unknowns. The norm penalty of the paper keeps vectors from
/// vanishing; here each step on the coarsest level diffuses and then normalises:
/// `u ← normalise((A + τM)⁻¹ (f + τM u))` with the matrix `A` and the right side `f` of the quadratic
/// form. That descends the same functional with one matrix for all steps, factored once, and without
/// a start from an eigenvector. Without any guidance the first steps, from seeded phases, are inverse
/// iterations for the smoothest field there is. On each finer level every vector is moved in turn to
/// its best place among its neighbours, which never raises the functional.
///
/// A mirrored surface gets a mirrored field, as far as guidance reaches: groups are mirrored, and
/// images take their turns at once. With one level it is mirrored to rounding, with more to some
/// thousandths of a radian, as sweeps end before the last digit is at rest.
///
/// `positions` order vertices and the factorisation; they have no other influence on the field.
///
/// Fixed vertices are eliminated. Cost: linear, and a small factorisation.
///
/// # Errors
/// [`FieldError`].
///
/// [PGP06]: crate::papers::PGP06
pub fn smooth_field(
    triangulation: &IntrinsicTriangulation,
    positions: &PerVertex<DVec3>,
    guidance: &Guidance,
    options: &SmoothingOptions,
    watch: &Watch,
) -> Result<SmoothField, FieldError> {
    check_share(options.smoothing)?;
    let _stage = watch.stage("field smoothing");
    let system = System::new(triangulation, positions, guidance, options.smoothing)?;
    let found = Found::from_coarse(&system, positions, options, watch)?;
    let powers = system.with_fixed(&found.values);
    Ok(SmoothField {
        report: SmoothingReport {
            steps: found.steps,
            levels: found.levels,
            last_change: found.last_change,
            smoothness_energy: system.connection.energy(&powers),
            guidance_energy: system.guidance_energy(&powers),
            residual: found.residual,
        },
        field: CrossField::from_angles(
            guidance.symmetry(),
            powers.map(|&power| guidance.symmetry().root(power)),
        ),
    })
}

/// Most nodes of the coarsest level. Coarse links are stiff against guidance: with few nodes a field
/// has few singularities, and the sweeps on finer levels bring it back to its guidance.
const COARSEST: usize = 800;

/// Most sweeps on each finer level, forth and back.
const SWEEPS: usize = 15;

/// Unit vectors found from coarse to fine.
struct Found {
    values: Vec<DVec2>,
    steps: usize,
    levels: usize,
    last_change: f64,
    residual: f64,
}

impl Found {
    fn from_coarse(
        system: &System,
        positions: &PerVertex<DVec3>,
        options: &SmoothingOptions,
        watch: &Watch,
    ) -> Result<Self, FieldError> {
        let graph = system.graph();
        let hierarchy = Hierarchy::new(&graph, COARSEST, watch)?;
        let nodes = Nodes {
            weights: hierarchy.sums(system.at_free(&system.weights)),
            points: hierarchy.points(system.at_free(positions)),
        };
        let (at_rest, patience) = if system.is_unguided() {
            (FREE_FIELD_AT_REST, 10)
        } else {
            (FIELD_AT_REST, 1)
        };
        let mut run = Diffusion::new(hierarchy.coarsest(), &nodes, at_rest, watch)?;
        let start = run.start(options.seed)?;
        let steps = options.steps.saturating_mul(patience);
        let coarse = run.descend(start, steps, watch)?;
        let mut last_change = run.last_change;
        let values = hierarchy.carried_down(coarse, watch, |graph, values| {
            for _ in 0..SWEEPS {
                watch.check()?;
                last_change = graph.relax_units(values);
                if last_change < SWEPT_FIELD_AT_REST {
                    break;
                }
            }
            Ok::<_, FieldError>(())
        })?;
        Ok(Self {
            values,
            steps: run.steps,
            levels: hierarchy.depth() + 1,
            last_change,
            residual: run.residual,
        })
    }
}

/// Refuses a share of smoothness that is none.
pub(super) fn check_share(smoothing: f64) -> Result<(), FieldError> {
    if (0.0..1.0).contains(&smoothing) {
        return Ok(());
    }
    Err(FieldError::Option {
        name: "smoothing",
        value: smoothing,
        range: "0 to below 1",
    })
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "exactness is what is tested")]
mod tests {
    use super::*;
    use crate::field::{CurvatureOptions, Singularities, Strength, Symmetry, principal_curvatures};
    use crate::geometry::intrinsic_delaunay;
    use crate::mesh::Surface;
    use graticule_fixtures::{Fixture, cube, disk, grid, icosphere, torus};

    struct Example {
        surface: Surface,
        original: IntrinsicTriangulation,
        delaunay: IntrinsicTriangulation,
    }

    impl Example {
        fn new(fixture: Fixture) -> Self {
            let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
            let original = IntrinsicTriangulation::of(&surface).unwrap();
            let (delaunay, _) = intrinsic_delaunay(&surface, &Watch::new()).unwrap();
            Self {
                surface,
                original,
                delaunay,
            }
        }

        fn unguided(&self, symmetry: Symmetry) -> Guidance {
            Guidance::none(symmetry, self.surface.mesh().vertex_count())
        }

        fn smooth(&self, guidance: &Guidance) -> SmoothField {
            let positions = self.surface.positions();
            let options = SmoothingOptions {
                steps: 20,
                ..Default::default()
            };
            smooth_field(&self.delaunay, positions, guidance, &options, &Watch::new()).unwrap()
        }

        fn singularities(&self, field: &CrossField) -> Singularities {
            Singularities::of(field, self.surface.mesh(), &self.original)
        }
    }

    #[test]
    fn a_sphere_has_two_poles_four_half_poles_or_eight_quarter_poles_well_spread() {
        // [PGP06] Fig. 9. Least angles between them: opposite, tetrahedron, cube or antiprism.
        let sphere = Example::new(icosphere(4));
        for (symmetry, count, least_angle) in [
            (Symmetry::Vector, 2, 150.0),
            (Symmetry::Line, 4, 90.0),
            (Symmetry::Cross, 8, 55.0),
        ] {
            let found = sphere.smooth(&sphere.unguided(symmetry));
            let singular = sphere.singularities(&found.field);
            assert_eq!(singular.count(), count, "{symmetry:?}: {:?}", found.report);
            assert!((singular.index_sum() - 2.0).abs() < 1e-9);
            let middles: Vec<_> = singular
                .faces
                .iter()
                .map(|s| {
                    sphere
                        .surface
                        .corner_positions(s.face)
                        .iter()
                        .sum::<DVec3>()
                        .normalize()
                })
                .collect();
            for (index, a) in middles.iter().enumerate() {
                for b in &middles[..index] {
                    let angle = a.angle_between(*b).to_degrees();
                    assert!(angle > least_angle, "{symmetry:?}: {angle}");
                }
            }
        }
    }

    #[test]
    fn a_torus_follows_its_curvature_without_singularity() {
        let torus = Example::new(torus(2.0, 0.7, 60, 24));
        let options = CurvatureOptions::default();
        let curvatures =
            principal_curvatures(&torus.surface, &torus.original, &options, &Watch::new()).unwrap();
        for symmetry in [Symmetry::Line, Symmetry::Cross] {
            let guidance = Guidance::from_curvature(symmetry, &curvatures);
            let found = torus.smooth(&guidance);
            assert_eq!(torus.singularities(&found.field).count(), 0);
            for (vertex, curvature) in curvatures.enumerate() {
                let (off, _) = symmetry.reduce(found.field.angle(vertex) - curvature.direction);
                assert!(off.abs() < 0.05, "{vertex}: {off}");
            }
        }
    }

    #[test]
    fn a_rectangle_held_at_its_boundary_is_straight() {
        let rectangle = Example::new(grid(3.0, 2.0, 15, 10));
        for strength in [Strength::Hard, Strength::Soft(10.0)] {
            let mut guidance = rectangle.unguided(Symmetry::Cross);
            let mesh = rectangle.surface.mesh();
            guidance.follow_boundary(mesh, &rectangle.original, strength);
            let found = rectangle.smooth(&guidance);
            assert_eq!(rectangle.singularities(&found.field).count(), 0);
            assert!(found.report.smoothness_energy < 1e-9, "{:?}", found.report);
        }
    }

    #[test]
    fn a_disk_held_at_its_boundary_has_the_index_of_a_disk() {
        let disk = Example::new(disk(20));
        for (symmetry, count) in [
            (Symmetry::Vector, 1),
            (Symmetry::Line, 2),
            (Symmetry::Cross, 4),
        ] {
            let mut guidance = disk.unguided(symmetry);
            if symmetry == Symmetry::Vector {
                for &halfedge in disk
                    .surface
                    .mesh()
                    .boundary_loop(crate::mesh::BoundaryLoopId(0))
                {
                    let vertex = disk.surface.mesh().origin(halfedge);
                    let angle = disk.original.direction(halfedge);
                    guidance.follow(vertex, angle, Strength::Hard);
                }
            } else {
                guidance.follow_boundary(disk.surface.mesh(), &disk.original, Strength::Hard);
            }
            let found = disk.smooth(&guidance);
            let singular = disk.singularities(&found.field);
            assert_eq!(singular.count(), count, "{symmetry:?}");
            assert!(singular.boundary_indices[0].abs() < 1e-6);
        }
    }

    #[test]
    fn a_cube_gets_a_quarter_pole_at_each_corner() {
        let cube = Example::new(cube().subdivided().subdivided().subdivided());
        let mesh = cube.surface.mesh();
        let dihedrals = crate::geometry::dihedral_angles(&cube.surface);
        let sharp = mesh.edges().filter(|&edge| dihedrals[edge] > 1.0);
        let mut guidance = cube.unguided(Symmetry::Cross);
        guidance.follow_edges(&cube.original, sharp, Strength::Hard);
        let singular = cube.singularities(&cube.smooth(&guidance).field);
        assert_eq!(
            singular.faces.iter().map(|s| s.steps).collect::<Vec<_>>(),
            [1; 8]
        );
        for singularity in &singular.faces {
            let touches_corner = cube
                .surface
                .corner_positions(singularity.face)
                .iter()
                .any(|p| p.to_array().iter().all(|x| *x == 0.0 || *x == 1.0));
            assert!(touches_corner);
        }
    }

    #[test]
    fn scaling_by_a_power_of_two_changes_no_digit() {
        let field = |scale: f64| {
            let torus = Example::new(torus(2.0, 0.7, 30, 12).map(|p| p * scale));
            torus.smooth(&torus.unguided(Symmetry::Cross)).field
        };
        let reference = field(1.0);
        for exponent in [-40, 40] {
            assert_eq!(field(2.0_f64.powi(exponent)), reference);
        }
    }

    #[test]
    fn options_out_of_range_are_refused() {
        let disk = Example::new(disk(3));
        for smoothing in [-0.1, 1.0, f64::NAN] {
            let options = SmoothingOptions {
                smoothing,
                ..Default::default()
            };
            let positions = disk.surface.positions();
            let guidance = disk.unguided(Symmetry::Cross);
            let refusal = smooth_field(
                &disk.delaunay,
                positions,
                &guidance,
                &options,
                &Watch::new(),
            );
            assert!(matches!(
                refusal,
                Err(FieldError::Option {
                    name: "smoothing",
                    ..
                })
            ));
        }
    }
}
