//! The minimisation of the field's energy as it was published, to compare with.

use glam::{DMat2, DVec2, DVec3};

use super::diffusion::{Diffusion, Nodes, System};
use super::smoothing::check_share;
use super::{CrossField, FieldError, Guidance, SmoothField, SmoothingReport};
use crate::geometry::IntrinsicTriangulation;
use crate::mesh::PerVertex;
use crate::solve::{Cholesky, Placement, SymmetricMatrix};
use crate::tolerance::{FIELD_AT_REST, FREE_FIELD_AT_REST};
use crate::watch::Watch;

/// How [`smooth_field_by_newton`] smooths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
    /// The share of smoothness against guidance, ρ of [PGP06] Eq. 21, in `0.0..1.0`.
    ///
    /// [PGP06]: crate::papers::PGP06
    pub smoothing: f64,
    /// Weight ε of the norm penalty against weights of edges near 1, above 0.
    pub penalty: f64,
    /// Most steps.
    pub steps: usize,
    /// Chooses the directions to start from where there is no guidance.
    pub seed: u64,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self {
            smoothing: 0.8,
            penalty: 0.1,
            steps: 60,
            seed: 0,
        }
    }
}

/// The smoothest field that follows its guidance, by Newton's method on the energy of [PGP06] §4.2:
/// that of Eq. 21 and a penalty `ε Σ mass (|u|² - 1)²` on the norms.
///
/// Of use to compare with [`smooth_field`](super::smooth_field()), which reaches like energies with
/// one factorisation for all steps where this takes one or several of twice the size in each. Where
/// the Hessian is not positive definite, a multiple of the masses is added to it; steps are halved
/// until the energy falls.
///
/// Energies of the report are those of the unit vectors.
///
/// # Errors
/// [`FieldError`].
///
/// [PGP06]: crate::papers::PGP06
pub fn smooth_field_by_newton(
    triangulation: &IntrinsicTriangulation,
    positions: &PerVertex<DVec3>,
    guidance: &Guidance,
    options: &NewtonOptions,
    watch: &Watch,
) -> Result<SmoothField, FieldError> {
    check_share(options.smoothing)?;
    if !(f64::MIN_POSITIVE..=f64::MAX).contains(&options.penalty) {
        return Err(FieldError::Option {
            name: "norm penalty",
            value: options.penalty,
            range: "above 0, finite",
        });
    }
    let _stage = watch.stage("field smoothing by Newton's method");
    let system = System::new(triangulation, positions, guidance, options.smoothing)?;
    let graph = system.graph();
    let nodes = Nodes {
        weights: system.at_free(&system.weights),
        points: system.at_free(positions),
    };
    let start = Diffusion::new(&graph, &nodes, FIELD_AT_REST, watch)?.start(options.seed)?;
    let mut run = Newton {
        penalty: options.penalty,
        points: nodes.points,
        unknowns: start,
        residual: 0.0,
        system: &system,
    };
    let (mut steps, mut moved) = (0, f64::INFINITY);
    while steps < options.steps && moved > FREE_FIELD_AT_REST && !run.unknowns.is_empty() {
        watch.check()?;
        moved = run.step()?;
        steps += 1;
    }
    let unit = run.unknowns.iter().map(|u| u.normalize_or(DVec2::X));
    let powers = system.with_fixed(&unit.collect::<Vec<_>>());
    let symmetry = guidance.symmetry();
    Ok(SmoothField {
        report: SmoothingReport {
            steps,
            levels: 1,
            last_change: if steps > 0 { moved } else { 0.0 },
            smoothness_energy: system.connection.energy(&powers),
            guidance_energy: system.guidance_energy(&powers),
            residual: run.residual,
        },
        field: CrossField::from_angles(symmetry, powers.map(|&power| symmetry.root(power))),
    })
}

/// Halvings of a step before it is given up.
const MOST_HALVINGS: u32 = 12;

/// The first multiple of the masses that is added to an indefinite Hessian; then ten times that.
const FIRST_SHIFT: f64 = 1e-2;

struct Newton<'a> {
    system: &'a System,
    penalty: f64,
    points: Vec<DVec3>,
    /// The vectors of the free vertices.
    unknowns: Vec<DVec2>,
    residual: f64,
}

impl Newton<'_> {
    /// One step; returns by how much the vectors change in the mean.
    fn step(&mut self) -> Result<f64, FieldError> {
        let (gradient, blocks) = self.derivatives();
        let right_side: Vec<f64> = gradient.iter().flat_map(|g| [-g.x, -g.y]).collect();
        let direction = self.descent(&blocks, &right_side)?;
        let slope: f64 = (direction.iter().zip(&gradient))
            .map(|(d, g)| d.dot(*g))
            .sum();
        let before = self.energy(&self.unknowns);
        let mut length = 1.0;
        for _ in 0..MOST_HALVINGS {
            let there: Vec<DVec2> = (self.unknowns.iter().zip(&direction))
                .map(|(u, d)| *u + *d * length)
                .collect();
            if self.energy(&there) <= before + 1e-4 * length * slope {
                let moved: f64 = direction.iter().map(|d| length * d.length()).sum();
                self.unknowns = there;
                return Ok(moved / direction.len() as f64);
            }
            length /= 2.0;
        }
        Ok(0.0)
    }

    /// Solves with the Hessian, shifted until it is positive definite.
    fn descent(&mut self, blocks: &[DMat2], side: &[f64]) -> Result<Vec<DVec2>, FieldError> {
        let mut shift = 0.0;
        loop {
            let matrix = self.hessian(blocks, shift)?;
            let placement = Placement::at(&self.points).with_block(2);
            let ordering = placement.ordering(matrix.lower().pattern())?;
            match Cholesky::new(&matrix, &ordering) {
                Ok(factor) => {
                    let solution = factor.solve(side)?;
                    self.residual = self.residual.max(solution.residual);
                    let (pairs, _) = solution.values.as_chunks::<2>();
                    return Ok(pairs.iter().map(|&pair| DVec2::from_array(pair)).collect());
                }
                // Far above every negative part that the penalty can bring.
                Err(error) if shift > 1e3 * (1.0 + self.penalty) => return Err(error.into()),
                Err(_) => {
                    shift = if shift > 0.0 {
                        10.0 * shift
                    } else {
                        FIRST_SHIFT
                    }
                }
            }
        }
    }

    /// Half the gradient, and half the diagonal blocks of the Hessian.
    fn derivatives(&self) -> (Vec<DVec2>, Vec<DMat2>) {
        let system = self.system;
        let all = system.with_fixed(&self.unknowns);
        let mut gradient = Vec::with_capacity(self.unknowns.len());
        let mut blocks = Vec::with_capacity(self.unknowns.len());
        for (&vertex, &u) in system.free.iter().zip(&self.unknowns) {
            let penalty = 2.0 * self.penalty * system.masses[vertex];
            let miss = u.length_squared() - 1.0;
            let fit = u * system.weights[vertex] - system.pulls[vertex];
            gradient.push(fit + u * (penalty * miss));
            let outer = DMat2::from_cols(u * u.x, u * u.y);
            blocks.push(
                DMat2::from_diagonal(DVec2::splat(system.weights[vertex] + penalty * miss))
                    + outer * (2.0 * penalty),
            );
        }
        for edge in &system.connection.edges {
            let weight = system.smoothing * edge.weight;
            let [i, j] = edge.ends;
            let turned = edge.rotation.rotate(all[i]);
            for (vertex, off) in [
                (i, all[i] - edge.conjugate().rotate(all[j])),
                (j, all[j] - turned),
            ] {
                if let Some(place) = system.place(vertex) {
                    gradient[place] += off * weight;
                    blocks[place] += DMat2::IDENTITY * weight;
                }
            }
        }
        (gradient, blocks)
    }

    /// Half the Hessian, with a multiple of the masses on its diagonal.
    fn hessian(&self, blocks: &[DMat2], shift: f64) -> Result<SymmetricMatrix, FieldError> {
        let system = self.system;
        let mut entries = Vec::with_capacity(3 * blocks.len() + 4 * system.connection.edges.len());
        for (place, block) in blocks.iter().enumerate() {
            let extra = shift * system.masses[system.free[place]];
            let [x, y] = [2 * place, 2 * place + 1];
            entries.extend([
                (x, x, block.x_axis.x + extra),
                (y, y, block.y_axis.y + extra),
                (x, y, block.x_axis.y),
            ]);
        }
        for edge in &system.connection.edges {
            let [i, j] = edge.ends.map(|vertex| system.place(vertex));
            let (Some(i), Some(j)) = (i, j) else { continue };
            let turn = edge.rotation * (system.smoothing * edge.weight);
            let [x, y] = [2 * i, 2 * i + 1];
            let [p, q] = [2 * j, 2 * j + 1];
            entries.extend([
                (p, x, -turn.x),
                (q, y, -turn.x),
                (p, y, turn.y),
                (q, x, -turn.y),
            ]);
        }
        Ok(SymmetricMatrix::from_triplets(2 * blocks.len(), entries)?)
    }

    /// Half the energy, up to a constant.
    fn energy(&self, unknowns: &[DVec2]) -> f64 {
        let system = self.system;
        let all = system.with_fixed(unknowns);
        let own = system.free.iter().zip(unknowns).map(|(&vertex, u)| {
            let miss = u.length_squared() - 1.0;
            let fit =
                0.5 * system.weights[vertex] * u.length_squared() - u.dot(system.pulls[vertex]);
            fit + 0.5 * self.penalty * system.masses[vertex] * miss * miss
        });
        own.sum::<f64>() + 0.5 * system.smoothing * system.connection.energy(&all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{
        CurvatureOptions, FieldDomain, SmoothingOptions, Symmetry, principal_curvatures,
        smooth_field,
    };
    use crate::mesh::Surface;
    use graticule_fixtures::{Fixture, ellipsoid, torus, vase};

    /// The energies of Eq. 21 that diffusion and Newton's method reach.
    fn energies(fixture: Fixture, is_guided: bool) -> [f64; 2] {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let watch = Watch::new();
        let domain = FieldDomain::of(&surface, &watch).unwrap();
        let options = CurvatureOptions::default();
        let curvatures =
            principal_curvatures(&surface, domain.triangulation(), &options, &watch).unwrap();
        let guidance = if is_guided {
            Guidance::from_curvature(Symmetry::Cross, &curvatures)
        } else {
            Guidance::none(Symmetry::Cross, surface.mesh().vertex_count())
        };
        let positions = surface.positions();
        let triangulation = domain.delaunay();
        let diffused = SmoothingOptions {
            steps: 60,
            ..Default::default()
        };
        let diffused =
            smooth_field(triangulation, positions, &guidance, &diffused, &watch).unwrap();
        let newton = NewtonOptions {
            penalty: 1.0,
            ..Default::default()
        };
        let newton =
            smooth_field_by_newton(triangulation, positions, &guidance, &newton, &watch).unwrap();
        assert!(newton.report.last_change < 1e-3, "{:?}", newton.report);
        [diffused, newton]
            .map(|found| 0.8 * found.report.smoothness_energy + found.report.guidance_energy)
    }

    #[test]
    fn options_out_of_range_are_refused() {
        let surface = torus(2.0, 0.7, 12, 6);
        let surface = Surface::from_triangles(surface.positions, &surface.triangles).unwrap();
        let watch = Watch::new();
        let domain = FieldDomain::of(&surface, &watch).unwrap();
        let guidance = Guidance::none(Symmetry::Cross, surface.mesh().vertex_count());
        let refused = |options: NewtonOptions| {
            let positions = surface.positions();
            let found =
                smooth_field_by_newton(domain.delaunay(), positions, &guidance, &options, &watch);
            assert!(matches!(found, Err(FieldError::Option { .. })));
        };
        let good = NewtonOptions::default();
        for smoothing in [-0.1, 1.0, f64::NAN] {
            refused(NewtonOptions { smoothing, ..good });
        }
        for penalty in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            refused(NewtonOptions { penalty, ..good });
        }
    }

    #[test]
    fn newton_as_published_reaches_like_energies() {
        for (fixture, is_guided, share) in [
            (torus(2.0, 0.7, 30, 12), true, 0.02),
            (vase(0.3, 36, 24), true, 0.05),
            // Since curvature draws three times as strongly, diffusion comes to rest 13 % above what
            // Newton's method reaches.
            (ellipsoid(DVec3::new(1.0, 1.4, 2.0), 3), true, 0.15),
            (ellipsoid(DVec3::new(1.0, 1.4, 2.0), 3), false, 0.15),
        ] {
            let [diffused, newton] = energies(fixture, is_guided);
            assert!(
                (diffused - newton).abs() <= share * newton.max(1e-6),
                "guided {is_guided}, share {share}: {diffused} {newton}"
            );
        }
    }
}
