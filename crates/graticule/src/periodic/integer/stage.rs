use std::sync::Arc;

use glam::DVec2;

use super::components::{Component, drafts};
use super::net::{Net, Solved, nets};
use super::solver::Solver;
use super::{GridDensity, IntegerGridError, IntegerGridOptions, IntegerGridReport};
use crate::field::{CrossField, Symmetry};
use crate::geometry::{Similarity, normalized};
use crate::mesh::{FaceId, PerCorner, PerFace, Surface, TriangleMesh};
use crate::periodic::GridMap;
use crate::watch::Watch;

/// A map without a triangle left out, and the figures.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegerGridMap {
    /// The map.
    pub map: GridMap,
    /// The figures.
    pub report: IntegerGridReport,
}

/// Makes an integer grid map along a cross field.
///
/// Singular vertices get whole coordinates; so does the coordinate that is constant along each
/// boundary loop and feature line. Elsewhere the gradients of the coordinates follow the field as
/// closely as these allow.
///
/// Takes any surface: any genus, boundary and number of components. Scaling it changes nothing, nor
/// does the order of the components: each has equations of its own.
///
/// Cost: one factorisation of a real matrix of two unknowns per vertex, whatever the density, and up
/// to three more where triangles would be squeezed; with thousands of whole numbers a dozen for each
/// density.
///
/// # Errors
/// [`IntegerGridError`].
pub fn integer_grid_map(
    surface: &Surface,
    field: &CrossField,
    options: &IntegerGridOptions,
    watch: &Watch,
) -> Result<IntegerGridMap, IntegerGridError> {
    let made = IntegerGrid::of(surface, field, options, watch)?.map(options.density, watch)?;
    made.report.warn(watch);
    Ok(made)
}

/// Everything about integer grid maps of a surface that does not depend on their density.
pub struct IntegerGrid {
    mesh: Arc<TriangleMesh>,
    components: Vec<Component>,
    nets: Vec<Net>,
    similarity: Similarity,
    untangling_rounds: usize,
    relaxation_rounds: usize,
}

impl IntegerGrid {
    /// Prepares maps along a cross field; the density of `options` plays no part.
    ///
    /// Cost: most of that of [`integer_grid_map`].
    ///
    /// # Errors
    /// [`IntegerGridError`].
    pub fn of(
        surface: &Surface,
        field: &CrossField,
        options: &IntegerGridOptions,
        watch: &Watch,
    ) -> Result<Self, IntegerGridError> {
        let _stage = watch.stage("integer grid");
        let mesh = surface.mesh();
        options.check(mesh.vertex_count(), mesh.edge_count())?;
        check_field(surface, field)?;
        let (unit, similarity) = normalized(surface);
        let (components, drafts) = drafts(&unit, field, options, watch)?;
        Ok(Self {
            mesh: surface.shared_mesh(),
            components,
            nets: nets(drafts, watch)?,
            similarity,
            untangling_rounds: options.untangling_rounds,
            relaxation_rounds: options.relaxation_rounds,
        })
    }

    /// The triangles that are flipped once the whole numbers are rounded, before anything is done
    /// about them.
    ///
    /// Cost: a solution with what is factored already; with thousands of whole numbers a dozen
    /// factorisations.
    ///
    /// # Errors
    /// [`IntegerGridError`].
    pub(crate) fn crumpled(
        &self,
        density: GridDensity,
        watch: &Watch,
    ) -> Result<Vec<FaceId>, IntegerGridError> {
        density.check()?;
        let nets = self.solve(self.first_density(density), watch)?;
        Ok(self.on_whole(nets.iter().map(|solved| solved.net.flipped())))
    }

    /// The map of a density. What its report tells of is left to the caller to warn of.
    ///
    /// Where triangles stay flipped, lines are drawn closer together, and stay so for maps made
    /// later.
    ///
    /// Cost: a handful of solutions with what is factored already, and the removal of flips.
    ///
    /// # Errors
    /// [`IntegerGridError`].
    pub fn map(
        &mut self,
        density: GridDensity,
        watch: &Watch,
    ) -> Result<IntegerGridMap, IntegerGridError> {
        let _stage = watch.stage("integer grid map");
        density.check()?;
        let mut best: Option<IntegerGridMap> = None;
        let mut in_vain = 0;
        loop {
            let settled = self.settle(density, watch)?;
            let flips = |made: &IntegerGridMap| made.report.flips;
            let before = best.as_ref().map_or(usize::MAX, flips);
            let now = flips(&settled.made);
            in_vain = if now < before - before / PROGRESS {
                0
            } else {
                in_vain + 1
            };
            if now < before {
                best = Some(settled.made);
            }
            if in_vain == MOST_IN_VAIN || !self.densify(&settled.flipped, settled.density)? {
                break;
            }
        }
        Ok(best.unwrap_or_else(|| unreachable!("a map was settled in the first round")))
    }

    /// Draws lines closer together round the flipped triangles of each component, if there are not
    /// too many in all; tells whether there was any place for that.
    fn densify(&mut self, flipped: &[Vec<FaceId>], density: f64) -> Result<bool, IntegerGridError> {
        let count: usize = flipped.iter().map(Vec::len).sum();
        if count > most_flips_mended(&self.mesh) {
            return Ok(false);
        }
        let mut any = false;
        for (net, faces) in self.nets.iter_mut().zip(flipped) {
            any |= !faces.is_empty() && net.densify(faces, density)?;
        }
        Ok(any)
    }

    fn settle(&self, density: GridDensity, watch: &Watch) -> Result<SettledMap, IntegerGridError> {
        let (mut solved, densities) = self.dense(density, watch)?;
        let flips_before = flips(&solved.nets);
        {
            let _stage = watch.stage("untangling");
            for Solved { net, .. } in &mut solved.nets {
                net.untangle(self.untangling_rounds, watch)?;
                net.relax_squeezed(self.relaxation_rounds, watch)?;
            }
        }
        let report = IntegerGridReport {
            edge_length: self.similarity.invert_length(1.0 / solved.density),
            flips_before,
            densities,
            ..self.report(&solved.nets)
        };
        Ok(SettledMap {
            made: IntegerGridMap {
                map: self.grid_map(&solved.nets)?,
                report,
            },
            flipped: solved.nets.iter().map(|made| made.net.flipped()).collect(),
            density: solved.density,
        })
    }

    /// The nets at the density asked for, and the number of densities tried.
    fn dense(
        &self,
        density: GridDensity,
        watch: &Watch,
    ) -> Result<(SolvedNets<'_>, usize), IntegerGridError> {
        let first = self.first_density(density);
        match density {
            GridDensity::EdgeLength(_) => {
                let nets = self.solve(first, watch)?;
                let solved = SolvedNets {
                    density: first,
                    nets,
                };
                Ok((solved, 1))
            }
            GridDensity::Quads(quads) => self.with_cells(quads as f64, first, watch),
        }
    }

    /// Lines per unit of length, as far as known before any map is made.
    fn first_density(&self, density: GridDensity) -> f64 {
        match density {
            GridDensity::EdgeLength(length) => {
                1.0 / libm::ldexp(length, self.similarity.exponent())
            }
            GridDensity::Quads(quads) => {
                let wished = self.nets.iter().map(Net::wished_area);
                (quads as f64 / sum_in_any_order(wished)).sqrt()
            }
        }
    }

    /// The nets whose area is nearest to the number asked for, of a few that come ever closer.
    fn with_cells(
        &self,
        wanted: f64,
        mut density: f64,
        watch: &Watch,
    ) -> Result<(SolvedNets<'_>, usize), IntegerGridError> {
        let mut best: Option<(f64, SolvedNets<'_>)> = None;
        let most = self.most_densities();
        for tried in 1..=most {
            let nets = self.solve(density, watch)?;
            let cells = sum_in_any_order(nets.iter().map(|solved| solved.cells));
            let off = (cells / wanted - 1.0).abs();
            if best.as_ref().is_none_or(|(least, _)| off < *least) {
                best = Some((off, SolvedNets { density, nets }));
            }
            density *= (wanted / cells.max(wanted / 16.0)).sqrt();
            let is_crumpled = |nets: &[Solved<'_>]| self.is_crumpled(nets);
            let is_last = tried == most || best.as_ref().is_some_and(|b| is_crumpled(&b.1.nets));
            if let Some((_, good)) = best.take_if(|(off, _)| *off < CELLS_AGREEMENT || is_last) {
                return Ok((good, tried));
            }
        }
        unreachable!("the last density tried ends the search")
    }

    fn is_crumpled(&self, nets: &[Solved<'_>]) -> bool {
        flips(nets) as f64 > CRUMPLED_NET * self.mesh.face_count() as f64
    }

    fn most_densities(&self) -> usize {
        let is_dense = |net: &Net| matches!(net.solver, Solver::Dense { .. });
        if self.nets.iter().all(is_dense) {
            MOST_DENSITIES
        } else {
            MOST_DENSITIES_IN_BATCHES
        }
    }

    fn solve(&self, density: f64, watch: &Watch) -> Result<Vec<Solved<'_>>, IntegerGridError> {
        self.nets
            .iter()
            .map(|net| net.solve(density, watch))
            .collect()
    }

    /// Triangles of the whole surface, from those of each component.
    fn on_whole(&self, faces: impl Iterator<Item = Vec<FaceId>>) -> Vec<FaceId> {
        let of_components = self.components.iter().zip(faces);
        let named = of_components.flat_map(|(component, faces)| {
            let named = faces.into_iter().map(|face| component.face(face));
            named.collect::<Vec<FaceId>>()
        });
        let mut all: Vec<FaceId> = named.collect();
        all.sort_unstable();
        all
    }

    fn grid_map(&self, solved: &[Solved<'_>]) -> Result<GridMap, IntegerGridError> {
        let halfedges = self.mesh.halfedge_count();
        let mut coordinates = PerCorner::filled(halfedges, DVec2::ZERO);
        let mut transitions = PerCorner::filled(halfedges, None);
        for ((component, net), solved) in self.components.iter().zip(&self.nets).zip(solved) {
            let own = net.transitions(solved);
            for (corner, transition) in own.enumerate() {
                let whole = component.corner(corner);
                coordinates[whole] = solved.net.coordinate(corner);
                transitions[whole] = *transition;
            }
        }
        let left_out = PerFace::filled(self.mesh.face_count(), false);
        Ok(GridMap::new(
            &self.mesh,
            coordinates,
            transitions,
            left_out,
        )?)
    }

    /// The figures of all components together, but for those of the density.
    fn report(&self, solved: &[Solved<'_>]) -> IntegerGridReport {
        let mut sum = IntegerGridReport::default();
        let [mut error, mut whole] = [0.0; 2];
        for (net, solved) in self.nets.iter().zip(solved) {
            sum.add(&net.report(solved));
            let own = net.gradient_errors(solved);
            error += own[0];
            whole += own[1];
        }
        IntegerGridReport {
            gradient_error: (error.max(0.0) / whole).sqrt(),
            ..sum
        }
    }
}

/// The nets at one density.
struct SolvedNets<'a> {
    density: f64,
    nets: Vec<Solved<'a>>,
}

/// A map, where it is flipped, by component, and the density that met the number of quads.
struct SettledMap {
    made: IntegerGridMap,
    flipped: Vec<Vec<FaceId>>,
    density: f64,
}

fn flips(nets: &[Solved<'_>]) -> usize {
    nets.iter().map(|solved| solved.net.flipped().len()).sum()
}

/// A sum that does not depend on the order of its terms.
fn sum_in_any_order(terms: impl Iterator<Item = f64>) -> f64 {
    let mut terms: Vec<f64> = terms.collect();
    terms.sort_by(f64::total_cmp);
    terms.into_iter().sum()
}

/// The most flipped triangles round which lines are drawn closer together. Where there are more,
/// the density is too low for the whole surface, and each round would cost as much as the map.
fn most_flips_mended(mesh: &TriangleMesh) -> usize {
    (mesh.face_count() / 100).max(200)
}

/// Times in a row that this may leave nearly as many triangles flipped.
const MOST_IN_VAIN: usize = 2;

/// The one part of so many of the flipped triangles that has to go in a round for it not to be in
/// vain.
const PROGRESS: usize = 10;

/// The share of flipped triangles above which a net has no room: the area of its map says little of
/// the number of its cells then, and no further density is tried for it.
const CRUMPLED_NET: f64 = 0.1;

/// Densities tried at most for a number of quads.
const MOST_DENSITIES: usize = 6;

/// The same where each takes a dozen factorisations.
const MOST_DENSITIES_IN_BATCHES: usize = 3;

/// The share by which the number of cells may miss the one asked for.
const CELLS_AGREEMENT: f64 = 0.02;

fn check_field(surface: &Surface, field: &CrossField) -> Result<(), IntegerGridError> {
    let (given, needed) = (field.angles().len(), surface.mesh().vertex_count());
    if field.symmetry() == Symmetry::Cross && given == needed {
        return Ok(());
    }
    let order = field.symmetry().order();
    Err(IntegerGridError::Field {
        order,
        given,
        needed,
    })
}
