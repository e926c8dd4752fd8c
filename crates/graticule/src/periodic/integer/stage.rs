use glam::DVec2;

use super::alignment::{Alignment, ends_of, marked_edges, wanted_edges, wished_indices};
use super::cut::{Cut, DualForest};
use super::energy::SideEnergy;
use super::form::Form;
use super::frames::FaceFrames;
use super::guard::Guard;
use super::lattice::solve_whole;
use super::separation::separations;
use super::sizing::Sizing;
use super::solver::{Parts, Solver};
use super::stiffening::stiffen;
use super::unknowns::{Slot, Unknowns};
use super::untangle::SettledNet;
use super::{GridDensity, IntegerGridError, IntegerGridOptions, IntegerGridReport};
use crate::field::{CrossField, Singularities, Symmetry};
use crate::geometry::{IntrinsicTriangulation, Similarity, normalized};
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerFace, PerVertex, Surface, VertexId};
use crate::periodic::{GridMap, QuarterTurn, Transition};
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
/// Takes any surface: any genus, boundary and number of components. Scaling it changes nothing.
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
    net: Net,
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
        Ok(Self {
            net: Net::of(unit, field, options, watch)?,
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
        let density = self.net.first_density(density, &self.similarity);
        Ok(self.net.solve(density, watch)?.net.flipped())
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
            let is_local = settled.flipped.len() <= most_flips_mended(&self.net.surface);
            let may_go_on = is_local && self.net.denser_rounds < self.net.most_denser_rounds();
            if in_vain == MOST_IN_VAIN
                || !may_go_on
                || !self.net.densify(&settled.flipped, settled.density)?
            {
                break;
            }
        }
        Ok(best.unwrap_or_else(|| unreachable!("a map was settled in the first round")))
    }

    fn settle(&self, density: GridDensity, watch: &Watch) -> Result<SettledMap, IntegerGridError> {
        let (mut solved, densities) = self.net.dense(density, &self.similarity, watch)?;
        let flips = solved.net.flipped().len();
        {
            let _stage = watch.stage("untangling");
            solved.net.untangle(self.untangling_rounds, watch)?;
            solved.net.relax_squeezed(self.relaxation_rounds, watch)?;
        }
        let report = self
            .net
            .report(&solved, &self.similarity, [densities, flips]);
        let map = self.net.grid_map(&solved)?;
        Ok(SettledMap {
            made: IntegerGridMap { map, report },
            flipped: solved.net.flipped(),
            density: solved.density,
        })
    }
}

/// A map, where it is flipped, and the density that met the number of quads.
struct SettledMap {
    made: IntegerGridMap,
    flipped: Vec<FaceId>,
    density: f64,
}

/// Times that lines are drawn closer together, at most.
const MOST_DENSER_ROUNDS: usize = 8;

/// The same where each density takes a dozen factorisations.
const MOST_DENSER_ROUNDS_IN_BATCHES: usize = 2;

/// The most flipped triangles round which lines are drawn closer together. Where there are more,
/// the density is too low for the whole surface, and each round would cost as much as the map.
fn most_flips_mended(surface: &Surface) -> usize {
    (surface.mesh().face_count() / 100).max(200)
}

/// Times in a row that this may leave nearly as many triangles flipped.
const MOST_IN_VAIN: usize = 2;

/// The one part of so many of the flipped triangles that has to go in a round for it not to be in
/// vain.
const PROGRESS: usize = 10;

/// The share of flipped triangles above which a net has no room: the area of its map says little of
/// the number of its cells then, and no further density is tried for it.
const CRUMPLED_NET: f64 = 0.1;

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

/// The same, on a surface of unit extent.
pub(super) struct Net {
    surface: Surface,
    frames: FaceFrames,
    cut: Cut,
    alignment: Alignment,
    unknowns: Unknowns,
    energy: SideEnergy,
    /// The weights of the energy before squeezed triangles were made to count more.
    plain_weights: PerCorner<f64>,
    sizing: Sizing,
    /// Times that lines were drawn closer together.
    denser_rounds: usize,
    pub(super) solver: Solver,
    pub(super) rows: Vec<Form>,
    guard: Guard,
    pub(super) parameters: usize,
    field_singularities: usize,
}

/// A net at one density.
pub(super) struct Solved<'a> {
    density: f64,
    net: SettledNet<'a>,
    wholes: Vec<i64>,
    pub(super) cells: f64,
}

impl Net {
    pub(super) fn of(
        surface: Surface,
        field: &CrossField,
        options: &IntegerGridOptions,
        watch: &Watch,
    ) -> Result<Self, IntegerGridError> {
        let mesh = surface.mesh();
        let triangulation = IntrinsicTriangulation::of(&surface)?;
        let wanted = wanted_edges(mesh, &options.features, options.align_boundary);
        let on_lines = ends_of(mesh, &wanted);
        let indices = wished_indices(mesh, &triangulation, &wanted);
        let wished = PerVertex::from_fn(mesh.vertex_count(), |vertex| {
            on_lines[vertex].then_some(indices[vertex])
        });
        let mut frames = FaceFrames::of(mesh, &triangulation, field, &wished);
        let forest = DualForest::of(mesh, &marked_edges(mesh, &wanted));
        frames.straighten(mesh, &forest);
        check_turns(&surface, &frames)?;
        let cut = Cut::of(mesh, &forest, &frames.steps);
        let alignment = Alignment::of(mesh, &triangulation, &frames, &wanted);
        alignment.snap(mesh, &triangulation, &mut frames);
        let unknowns = Unknowns::of(mesh, &frames, &cut, &alignment);
        let field_singularities = Singularities::of(field, mesh, &triangulation).count();
        let mut shapes = triangulation;
        shapes.mollify();
        let mut energy = SideEnergy::along_frames(&shapes, &frames, options);
        watch.check()?;
        let (rows, parameters) = {
            let after_chains = unknowns.after_chains;
            let rank = |column| u32::from(column >= after_chains);
            solve_whole(unknowns.wholes, &unknowns.equations, rank)
        };
        let parts = Parts {
            mesh,
            positions: surface.positions(),
            unknowns: &unknowns,
            energy: &energy,
        };
        let mut solver = Solver::new(parts, (&rows, parameters), watch)?;
        let plain_weights = energy.weights.clone();
        energy.weights = {
            let _stage = watch.stage("stiffening");
            stiffen(&mut solver, parts, (&rows, parameters), watch)?
        };
        let guard = Guard::new(&separations(mesh, &unknowns, &energy), &rows, parameters);
        Ok(Self {
            sizing: Sizing::as_asked(surface.mesh(), &energy),
            denser_rounds: 0,
            surface,
            frames,
            cut,
            alignment,
            unknowns,
            energy,
            plain_weights,
            solver,
            rows,
            guard,
            parameters,
            field_singularities,
        })
    }

    /// Draws lines closer together round triangles; tells whether there is any place for that.
    fn densify(&mut self, faces: &[FaceId], density: f64) -> Result<bool, IntegerGridError> {
        let mesh = self.surface.mesh();
        if !self.sizing.raise_at(mesh, faces, density) {
            return Ok(false);
        }
        self.denser_rounds += 1;
        self.energy.wishes = self.sizing.wishes(mesh);
        let found = separations(mesh, &self.unknowns, &self.energy);
        self.guard = Guard::new(&found, &self.rows, self.parameters);
        let parts = Parts {
            mesh,
            positions: self.surface.positions(),
            unknowns: &self.unknowns,
            energy: &self.energy,
        };
        self.solver.wish(parts, (&self.rows, self.parameters))?;
        Ok(true)
    }

    #[cfg(test)]
    pub(super) fn parts(&self) -> Parts<'_> {
        Parts {
            mesh: self.surface.mesh(),
            positions: self.surface.positions(),
            unknowns: &self.unknowns,
            energy: &self.energy,
        }
    }

    /// The net at the density asked for, and the number of densities tried.
    fn dense(
        &self,
        density: GridDensity,
        similarity: &Similarity,
        watch: &Watch,
    ) -> Result<(Solved<'_>, usize), IntegerGridError> {
        let first = self.first_density(density, similarity);
        match density {
            GridDensity::EdgeLength(_) => Ok((self.solve(first, watch)?, 1)),
            GridDensity::Quads(quads) => self.with_cells(quads as f64, first, watch),
        }
    }

    /// Lines per unit of length, as far as known before any map is made.
    fn first_density(&self, density: GridDensity, similarity: &Similarity) -> f64 {
        match density {
            GridDensity::EdgeLength(length) => 1.0 / libm::ldexp(length, similarity.exponent()),
            GridDensity::Quads(quads) => (quads as f64 / self.wished_area()).sqrt(),
        }
    }

    /// The net whose area is nearest to the number asked for, of a few that come ever closer.
    fn with_cells(
        &self,
        wanted: f64,
        mut density: f64,
        watch: &Watch,
    ) -> Result<(Solved<'_>, usize), IntegerGridError> {
        let mut best: Option<Solved<'_>> = None;
        let off = |solved: &Solved<'_>| (solved.cells / wanted - 1.0).abs();
        let most = self.most_densities();
        for tried in 1..=most {
            let solved = self.solve(density, watch)?;
            let ratio = (wanted / solved.cells.max(wanted / 16.0)).sqrt();
            density *= ratio;
            if best.as_ref().is_none_or(|best| off(&solved) < off(best)) {
                best = Some(solved);
            }
            let is_last = tried == most || best.as_ref().is_some_and(|best| self.is_crumpled(best));
            if let Some(good) = best.take_if(|best| off(best) < CELLS_AGREEMENT || is_last) {
                return Ok((good, tried));
            }
        }
        unreachable!("the last density tried ends the search")
    }

    fn is_crumpled(&self, solved: &Solved<'_>) -> bool {
        let most = CRUMPLED_NET * self.surface.mesh().face_count() as f64;
        solved.net.flipped().len() as f64 > most
    }

    fn most_densities(&self) -> usize {
        match self.solver {
            Solver::Dense { .. } => MOST_DENSITIES,
            Solver::Batches(_) => MOST_DENSITIES_IN_BATCHES,
        }
    }

    fn most_denser_rounds(&self) -> usize {
        match self.solver {
            Solver::Dense { .. } => MOST_DENSER_ROUNDS,
            Solver::Batches(_) => MOST_DENSER_ROUNDS_IN_BATCHES,
        }
    }

    /// The area of the map that the wishes have at a density of 1.
    fn wished_area(&self) -> f64 {
        let faces = self.surface.mesh().faces();
        let area = |face: FaceId| {
            let [first, second, _] = face.halfedges();
            0.5 * self.energy.wishes[first].perp_dot(self.energy.wishes[second])
        };
        faces.map(area).sum()
    }

    pub(super) fn solve(
        &self,
        density: f64,
        watch: &Watch,
    ) -> Result<Solved<'_>, IntegerGridError> {
        let (wholes, reals) = self.solver.at(density, &self.rows, &self.guard, watch)?;
        watch.check()?;
        let net = self.settled(density, &reals, &wholes);
        let faces = self.surface.mesh().faces();
        let cells = faces.map(|face| net.map_area(face)).sum();
        Ok(Solved {
            density,
            net,
            wholes,
            cells,
        })
    }

    fn settled(&self, density: f64, reals: &[f64], wholes: &[i64]) -> SettledNet<'_> {
        let mesh = self.surface.mesh();
        let place = |vertex: VertexId| {
            let [x, y] = self.unknowns.slots[vertex].map(|slot| match slot {
                Slot::Real(column) => reals[column as usize],
                Slot::Whole(sum) => self.unknowns.sums[sum as usize].value(wholes) as f64,
            });
            DVec2::new(x, y)
        };
        let corner = |corner: HalfedgeId| {
            let jump = &self.unknowns.jumps[corner];
            let shift = [0, 1].map(|c| saturated(Unknowns::shift(jump, c).value(wholes)));
            Transition {
                turn: jump.turn,
                shift,
            }
        };
        let is_real = |slot| matches!(slot, Slot::Real(_));
        let mut is_singular = PerVertex::filled(mesh.vertex_count(), false);
        for &vertex in &self.unknowns.singular {
            is_singular[vertex] = true;
        }
        SettledNet {
            mesh,
            corners: PerCorner::from_fn(mesh.halfedge_count(), corner),
            is_free: self.unknowns.slots.map(|slots| slots.map(is_real)),
            is_singular,
            released: 0,
            wishes: self.energy.wishes.map(|wish| *wish * density),
            places: PerVertex::from_fn(mesh.vertex_count(), place),
        }
    }

    fn grid_map(&self, solved: &Solved<'_>) -> Result<GridMap, IntegerGridError> {
        let mesh = self.surface.mesh();
        let transitions = PerCorner::from_fn(mesh.halfedge_count(), |halfedge: HalfedgeId| {
            mesh.twin(halfedge)?;
            let turn = self.frames.turns[halfedge];
            let Some(crossing) = self.cut.crossings[halfedge] else {
                return Some(Transition {
                    turn,
                    shift: [0; 2],
                });
            };
            let shift = chain_shift(&solved.wholes, crossing.chain).map(saturated);
            Some(if crossing.is_forward {
                Transition { turn, shift }
            } else {
                Transition {
                    turn: turn.inverse(),
                    shift,
                }
                .inverse()
            })
        });
        let left_out = PerFace::filled(mesh.face_count(), false);
        let coordinates = PerCorner::from_fn(mesh.halfedge_count(), |corner| {
            solved.net.coordinate(corner)
        });
        Ok(GridMap::new(mesh, coordinates, transitions, left_out)?)
    }

    fn report(
        &self,
        solved: &Solved<'_>,
        similarity: &Similarity,
        [densities, flips_before]: [usize; 2],
    ) -> IntegerGridReport {
        let mesh = self.surface.mesh();
        IntegerGridReport {
            field_singularities: self.field_singularities,
            singular_vertices: self.unknowns.singular.len(),
            chains: self.cut.chains,
            whole_parameters: self.parameters,
            aligned_edges: self.alignment.lines(mesh).count(),
            dropped_edges: self.alignment.dropped.len(),
            edge_length: similarity.invert_length(1.0 / solved.density),
            cells: solved.cells,
            gradient_error: self.gradient_error(solved),
            flips_before,
            flips: solved.net.flipped().len(),
            released_vertices: solved.net.released,
            denser_rounds: self.denser_rounds,
            densities,
        }
    }

    pub(super) fn gradient_error(&self, solved: &Solved<'_>) -> f64 {
        let mesh = self.surface.mesh();
        let [mut error, mut whole] = [0.0; 2];
        for halfedge in mesh.halfedges() {
            let difference =
                solved.net.coordinate(halfedge.next()) - solved.net.coordinate(halfedge);
            let wish = solved.net.wishes[halfedge];
            let weight = self.plain_weights[halfedge];
            error += weight * difference.distance_squared(wish);
            whole += weight * wish.length_squared();
        }
        (error.max(0.0) / whole).sqrt()
    }
}

/// Densities tried at most for a number of quads.
const MOST_DENSITIES: usize = 6;

/// The same where each takes a dozen factorisations.
const MOST_DENSITIES_IN_BATCHES: usize = 3;

/// The share by which the number of cells may miss the one asked for.
const CELLS_AGREEMENT: f64 = 0.02;

fn saturated(whole: i64) -> i32 {
    i32::try_from(whole).unwrap_or(i32::MAX)
}

fn chain_shift(wholes: &[i64], chain: u32) -> [i64; 2] {
    let first = 2 * chain as usize;
    [wholes[first], wholes[first + 1]]
}

pub(super) fn check_turns(surface: &Surface, frames: &FaceFrames) -> Result<(), IntegerGridError> {
    let mesh = surface.mesh();
    for vertex in mesh
        .vertices()
        .filter(|&vertex| !mesh.is_boundary_vertex(vertex))
    {
        let turns = mesh.outgoing(vertex).map(|h| frames.turns[h.previous()]);
        let found = turns.fold(QuarterTurn::NONE, QuarterTurn::then);
        let expected = QuarterTurn::of_quarters(frames.steps[vertex]);
        if found != expected {
            let [found, expected] = [found, expected].map(QuarterTurn::quarters);
            return Err(IntegerGridError::Turns {
                vertex,
                found,
                expected,
            });
        }
    }
    Ok(())
}
