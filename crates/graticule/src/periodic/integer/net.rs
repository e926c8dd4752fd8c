//! The net of lines of one component.

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
use super::{IntegerGridError, IntegerGridOptions, IntegerGridReport};
use crate::field::{CrossField, Singularities};
use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerVertex, Surface, VertexId};
use crate::periodic::{QuarterTurn, Transition};
use crate::watch::Watch;

/// A net before its equations are factored.
pub(super) struct Draft {
    surface: Surface,
    frames: FaceFrames,
    cut: Cut,
    alignment: Alignment,
    unknowns: Unknowns,
    energy: SideEnergy,
    /// The whole unknowns in terms of the parameters.
    rows: Vec<Form>,
    parameters: usize,
    field_singularities: usize,
}

impl Draft {
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
        let energy = SideEnergy::along_frames(&shapes, &frames, options);
        watch.check()?;
        let (rows, parameters) = {
            let after_chains = unknowns.after_chains;
            let rank = |column| u32::from(column >= after_chains);
            solve_whole(unknowns.wholes, &unknowns.equations, rank)
        };
        Ok(Self {
            surface,
            frames,
            cut,
            alignment,
            unknowns,
            energy,
            rows,
            parameters,
            field_singularities,
        })
    }

    pub(super) fn parts(&self) -> Parts<'_> {
        Parts {
            mesh: self.surface.mesh(),
            positions: self.surface.positions(),
            unknowns: &self.unknowns,
            energy: &self.energy,
        }
    }

    fn whole_parameters(&self) -> (&[Form], usize) {
        (&self.rows, self.parameters)
    }
}

/// Everything about the net of a component that does not depend on its density, on a surface of unit
/// extent.
pub(super) struct Net {
    draft: Draft,
    /// The weights of the energy before squeezed triangles were made to count more.
    plain_weights: PerCorner<f64>,
    sizing: Sizing,
    /// Times that lines were drawn closer together.
    denser_rounds: usize,
    pub(super) solver: Solver,
    guard: Guard,
}

/// A net at one density.
pub(super) struct Solved<'a> {
    pub(super) net: SettledNet<'a>,
    wholes: Vec<i64>,
    pub(super) cells: f64,
}

/// Factors the equations of all drafts.
pub(super) fn nets(drafts: Vec<Draft>, watch: &Watch) -> Result<Vec<Net>, IntegerGridError> {
    let mut solvers = Vec::with_capacity(drafts.len());
    {
        let _stage = watch.stage("factorisation");
        for draft in &drafts {
            let solver = Solver::new(draft.parts(), draft.whole_parameters(), watch)?;
            solvers.push(solver);
        }
    }
    let _stage = watch.stage("stiffening");
    let stiffened = drafts.into_iter().zip(solvers);
    let stiffened = stiffened.map(|(draft, mut solver)| {
        let parameters = draft.whole_parameters();
        let weights = stiffen(&mut solver, draft.parts(), parameters, watch)?;
        Ok(Net::new(draft, solver, weights))
    });
    stiffened.collect()
}

/// Times that lines are drawn closer together, at most.
const MOST_DENSER_ROUNDS: usize = 8;

/// The same where each density takes a dozen factorisations.
const MOST_DENSER_ROUNDS_IN_BATCHES: usize = 2;

impl Net {
    fn new(mut draft: Draft, solver: Solver, weights: PerCorner<f64>) -> Self {
        let plain_weights = std::mem::replace(&mut draft.energy.weights, weights);
        let mesh = draft.surface.mesh();
        let found = separations(mesh, &draft.unknowns, &draft.energy);
        Self {
            sizing: Sizing::as_asked(mesh, &draft.energy),
            guard: Guard::new(&found, &draft.rows, draft.parameters),
            denser_rounds: 0,
            plain_weights,
            solver,
            draft,
        }
    }

    /// Draws lines closer together round triangles; tells whether there was any place for that, and
    /// it was not done too often.
    pub(super) fn densify(
        &mut self,
        faces: &[FaceId],
        density: f64,
    ) -> Result<bool, IntegerGridError> {
        let draft = &mut self.draft;
        let mesh = draft.surface.mesh();
        if self.denser_rounds == most_denser_rounds(&self.solver)
            || !self.sizing.raise_at(mesh, faces, density)
        {
            return Ok(false);
        }
        self.denser_rounds += 1;
        draft.energy.wishes = self.sizing.wishes(mesh);
        let found = separations(mesh, &draft.unknowns, &draft.energy);
        self.guard = Guard::new(&found, &draft.rows, draft.parameters);
        let draft = &self.draft;
        self.solver.wish(draft.parts(), draft.whole_parameters())?;
        Ok(true)
    }

    #[cfg(test)]
    pub(super) fn sum_up_in_batches(&mut self) -> Result<(), IntegerGridError> {
        let draft = &self.draft;
        self.solver = Solver::in_batches(draft.parts(), draft.whole_parameters())?;
        Ok(())
    }

    /// The area of the map that the wishes have at a density of 1.
    pub(super) fn wished_area(&self) -> f64 {
        let faces = self.draft.surface.mesh().faces();
        let area = |face: FaceId| {
            let [first, second, _] = face.halfedges();
            0.5 * self.draft.energy.wishes[first].perp_dot(self.draft.energy.wishes[second])
        };
        faces.map(area).sum()
    }

    pub(super) fn solve(
        &self,
        density: f64,
        watch: &Watch,
    ) -> Result<Solved<'_>, IntegerGridError> {
        let (wholes, reals) = self
            .solver
            .at(density, &self.draft.rows, &self.guard, watch)?;
        watch.check()?;
        let net = self.settled(density, &reals, &wholes);
        let faces = self.draft.surface.mesh().faces();
        let cells = faces.map(|face| net.map_area(face)).sum();
        Ok(Solved { net, wholes, cells })
    }

    fn settled(&self, density: f64, reals: &[f64], wholes: &[i64]) -> SettledNet<'_> {
        let Draft {
            surface,
            unknowns,
            energy,
            ..
        } = &self.draft;
        let mesh = surface.mesh();
        let place = |vertex: VertexId| {
            let [x, y] = unknowns.slots[vertex].map(|slot| match slot {
                Slot::Real(column) => reals[column as usize],
                Slot::Whole(sum) => unknowns.sums[sum as usize].value(wholes) as f64,
            });
            DVec2::new(x, y)
        };
        let corner = |corner: HalfedgeId| {
            let jump = &unknowns.jumps[corner];
            let shift = [0, 1].map(|c| saturated(Unknowns::shift(jump, c).value(wholes)));
            Transition {
                turn: jump.turn,
                shift,
            }
        };
        let is_real = |slot| matches!(slot, Slot::Real(_));
        let mut is_singular = PerVertex::filled(mesh.vertex_count(), false);
        for &vertex in &unknowns.singular {
            is_singular[vertex] = true;
        }
        SettledNet {
            mesh,
            corners: PerCorner::from_fn(mesh.halfedge_count(), corner),
            is_free: unknowns.slots.map(|slots| slots.map(is_real)),
            is_singular,
            released: 0,
            wishes: energy.wishes.map(|wish| *wish * density),
            places: PerVertex::from_fn(mesh.vertex_count(), place),
        }
    }

    /// How coordinates change across each halfedge that has a twin.
    pub(super) fn transitions(&self, solved: &Solved<'_>) -> PerCorner<Option<Transition>> {
        let Draft { frames, cut, .. } = &self.draft;
        let mesh = self.draft.surface.mesh();
        PerCorner::from_fn(mesh.halfedge_count(), |halfedge: HalfedgeId| {
            mesh.twin(halfedge)?;
            let turn = frames.turns[halfedge];
            let Some(crossing) = cut.crossings[halfedge] else {
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
        })
    }

    /// The figures that are known of the component alone.
    pub(super) fn report(&self, solved: &Solved<'_>) -> IntegerGridReport {
        let draft = &self.draft;
        IntegerGridReport {
            field_singularities: draft.field_singularities,
            singular_vertices: draft.unknowns.singular.len(),
            chains: draft.cut.chains,
            whole_parameters: draft.parameters,
            aligned_edges: draft.alignment.lines(draft.surface.mesh()).count(),
            dropped_edges: draft.alignment.dropped.len(),
            cells: solved.cells,
            flips: solved.net.flipped().len(),
            released_vertices: solved.net.released,
            denser_rounds: self.denser_rounds,
            ..IntegerGridReport::default()
        }
    }

    /// The squared difference between the gradients of the coordinates and those wished for, and the
    /// square of the latter, over the area.
    pub(super) fn gradient_errors(&self, solved: &Solved<'_>) -> [f64; 2] {
        let mesh = self.draft.surface.mesh();
        let [mut error, mut whole] = [0.0; 2];
        for halfedge in mesh.halfedges() {
            let difference =
                solved.net.coordinate(halfedge.next()) - solved.net.coordinate(halfedge);
            let wish = solved.net.wishes[halfedge];
            let weight = self.plain_weights[halfedge];
            error += weight * difference.distance_squared(wish);
            whole += weight * wish.length_squared();
        }
        [error, whole]
    }
}

fn most_denser_rounds(solver: &Solver) -> usize {
    match solver {
        Solver::Dense { .. } => MOST_DENSER_ROUNDS,
        Solver::Batches(_) => MOST_DENSER_ROUNDS_IN_BATCHES,
    }
}

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
