use glam::DVec2;

use super::alignment::{Alignment, ends_of, wanted_edges};
use super::cut::{Cut, DualForest};
use super::energy::SideEnergy;
use super::form::Form;
use super::frames::FaceFrames;
use super::lattice::solve_whole;
use super::rounding::Rounding;
use super::system::NetSystem;
use super::unknowns::{Slot, Unknowns};
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
/// Cost: one factorisation of a real matrix of two unknowns per vertex, whatever the density.
///
/// # Errors
/// [`IntegerGridError`].
pub fn integer_grid_map(
    surface: &Surface,
    field: &CrossField,
    options: &IntegerGridOptions,
    watch: &Watch,
) -> Result<IntegerGridMap, IntegerGridError> {
    let _stage = watch.stage("integer grid");
    let mesh = surface.mesh();
    options.check(mesh.vertex_count(), mesh.edge_count())?;
    check_field(surface, field)?;
    let (unit, similarity) = normalized(surface);
    let net = Net::of(&unit, field, options, watch)?;
    let (solved, densities) = net.dense(options.density, &similarity, watch)?;
    let report = net.report(&solved, &similarity, densities);
    let map = net.grid_map(solved)?;
    Ok(IntegerGridMap { map, report })
}

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

/// Everything that does not depend on the density.
struct Net<'a> {
    surface: &'a Surface,
    shapes: IntrinsicTriangulation,
    frames: FaceFrames,
    cut: Cut,
    alignment: Alignment,
    unknowns: Unknowns,
    energy: SideEnergy,
    system: NetSystem,
    rows: Vec<Form>,
    rounding: Rounding,
    parameters: usize,
    field_singularities: usize,
}

/// A net at one density.
struct Solved {
    density: f64,
    coordinates: PerCorner<DVec2>,
    wholes: Vec<i64>,
    cells: f64,
}

impl<'a> Net<'a> {
    fn of(
        surface: &'a Surface,
        field: &CrossField,
        options: &IntegerGridOptions,
        watch: &Watch,
    ) -> Result<Self, IntegerGridError> {
        let mesh = surface.mesh();
        let triangulation = IntrinsicTriangulation::of(surface)?;
        let wanted = wanted_edges(mesh, &options.features, options.align_boundary);
        let on_lines = ends_of(mesh, &wanted);
        let mut frames = FaceFrames::of(mesh, &triangulation, field, &on_lines);
        let forest = DualForest::of(mesh);
        frames.straighten(mesh, &forest);
        check_turns(surface, &frames)?;
        let cut = Cut::of(mesh, &forest, &frames.steps);
        let alignment = Alignment::of(mesh, &triangulation, &frames, &wanted);
        let unknowns = Unknowns::of(mesh, &frames, &cut, &alignment);
        let field_singularities = Singularities::of(field, mesh, &triangulation).count();
        let mut shapes = triangulation;
        shapes.mollify();
        let energy = SideEnergy::along_frames(&shapes, &frames, options.sizing.as_ref());
        watch.check()?;
        let system = {
            let _stage = watch.stage("factorisation");
            NetSystem::new(mesh, surface.positions(), &unknowns, &energy)?
        };
        watch.check()?;
        let _stage = watch.stage("whole numbers");
        let after_chains = unknowns.after_chains;
        let rank = |column| u32::from(column >= after_chains);
        let (rows, parameters) = solve_whole(unknowns.wholes, &unknowns.equations, rank);
        let whole_energy = system.over_parameters(&rows, parameters);
        let rounding =
            Rounding::new(&whole_energy).ok_or(IntegerGridError::Undetermined { parameters })?;
        Ok(Self {
            surface,
            shapes,
            frames,
            cut,
            alignment,
            unknowns,
            energy,
            system,
            rows,
            rounding,
            parameters,
            field_singularities,
        })
    }

    /// The net at the density asked for, and the number of densities tried.
    fn dense(
        &self,
        density: GridDensity,
        similarity: &Similarity,
        watch: &Watch,
    ) -> Result<(Solved, usize), IntegerGridError> {
        match density {
            GridDensity::EdgeLength(length) => {
                let length = libm::ldexp(length, similarity.exponent());
                Ok((self.solve(1.0 / length, watch)?, 1))
            }
            GridDensity::Quads(quads) => self.with_cells(quads as f64, watch),
        }
    }

    /// The net whose area is nearest to the number asked for, of a few that come ever closer.
    fn with_cells(&self, wanted: f64, watch: &Watch) -> Result<(Solved, usize), IntegerGridError> {
        let mut density = (wanted / self.wished_area()).sqrt();
        let mut best: Option<Solved> = None;
        let off = |solved: &Solved| (solved.cells / wanted - 1.0).abs();
        for tried in 1..=MOST_DENSITIES {
            let solved = self.solve(density, watch)?;
            let ratio = (wanted / solved.cells.max(wanted / 16.0)).sqrt();
            density *= ratio;
            if best.as_ref().is_none_or(|best| off(&solved) < off(best)) {
                best = Some(solved);
            }
            if let Some(good) =
                best.take_if(|best| off(best) < CELLS_AGREEMENT || tried == MOST_DENSITIES)
            {
                return Ok((good, tried));
            }
        }
        unreachable!("the last density tried ends the search")
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

    fn solve(&self, density: f64, watch: &Watch) -> Result<Solved, IntegerGridError> {
        let parameters = self.rounding.at(density, watch)?;
        let wholes: Vec<i64> = self.rows.iter().map(|row| row.value(&parameters)).collect();
        let reals = self.system.reals(density, &wholes)?;
        watch.check()?;
        let coordinates = self.coordinates(&reals, &wholes);
        let cells = self
            .surface
            .mesh()
            .faces()
            .map(|face| map_area(&coordinates, face))
            .sum();
        Ok(Solved {
            density,
            coordinates,
            wholes,
            cells,
        })
    }

    fn coordinates(&self, reals: &[f64], wholes: &[i64]) -> PerCorner<DVec2> {
        let mesh = self.surface.mesh();
        let own = |vertex: VertexId| {
            let [x, y] = self.unknowns.slots[vertex].map(|slot| match slot {
                Slot::Real(column) => reals[column as usize],
                Slot::Whole(sum) => self.unknowns.sums[sum as usize].value(wholes) as f64,
            });
            DVec2::new(x, y)
        };
        let own = PerVertex::from_fn(mesh.vertex_count(), own);
        PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
            let jump = &self.unknowns.jumps[corner];
            let shifts = jump.shifts.iter().map(|shift| {
                let [x, y] = chain_shift(wholes, shift.chain);
                shift.turn.apply(DVec2::new(x as f64, y as f64))
            });
            jump.turn.apply(own[mesh.origin(corner)]) + shifts.sum::<DVec2>()
        })
    }

    fn grid_map(&self, solved: Solved) -> Result<GridMap, IntegerGridError> {
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
        Ok(GridMap::new(
            mesh,
            solved.coordinates,
            transitions,
            left_out,
        )?)
    }

    fn report(
        &self,
        solved: &Solved,
        similarity: &Similarity,
        densities: usize,
    ) -> IntegerGridReport {
        let mesh = self.surface.mesh();
        let flips = mesh
            .faces()
            .filter(|&face| map_area(&solved.coordinates, face) <= 0.0)
            .count();
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
            flips_before: flips,
            flips,
            densities,
        }
    }

    fn gradient_error(&self, solved: &Solved) -> f64 {
        let mesh = self.surface.mesh();
        let [mut error, mut whole] = [0.0; 2];
        for halfedge in mesh.halfedges() {
            let difference = solved.coordinates[halfedge.next()] - solved.coordinates[halfedge];
            let wish = self.energy.wishes[halfedge] * solved.density;
            let weight = self.energy.weights[halfedge];
            error += weight * difference.distance_squared(wish);
            whole += weight * wish.length_squared();
        }
        (error.max(0.0) / whole).sqrt()
    }
}

/// Densities tried at most for a number of quads.
const MOST_DENSITIES: usize = 6;

/// The share by which the number of cells may miss the one asked for.
const CELLS_AGREEMENT: f64 = 0.01;

fn saturated(whole: i64) -> i32 {
    i32::try_from(whole).unwrap_or(i32::MAX)
}

fn chain_shift(wholes: &[i64], chain: u32) -> [i64; 2] {
    let first = 2 * chain as usize;
    [wholes[first], wholes[first + 1]]
}

/// The signed area of the image of a triangle.
fn map_area(coordinates: &PerCorner<DVec2>, face: FaceId) -> f64 {
    let [a, b, c] = face.halfedges().map(|corner| coordinates[corner]);
    0.5 * (b - a).perp_dot(c - a)
}

fn check_turns(surface: &Surface, frames: &FaceFrames) -> Result<(), IntegerGridError> {
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
