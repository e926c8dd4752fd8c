use glam::{DVec2, DVec3};

use super::IntegerGridError;
use super::batches::BatchSystem;
use super::energy::SideEnergy;
use super::form::Form;
use super::guard::Guard;
use super::rounding::Rounding;
use super::system::{NetSystem, differences};
use super::unknowns::Unknowns;
use crate::mesh::{PerCorner, PerVertex, TriangleMesh};
use crate::watch::Watch;

/// What the equations of a net are made of.
#[derive(Clone, Copy)]
pub(super) struct Parts<'a> {
    pub(super) mesh: &'a TriangleMesh,
    pub(super) positions: &'a PerVertex<DVec3>,
    pub(super) unknowns: &'a Unknowns,
    pub(super) energy: &'a SideEnergy,
}

/// Finds whole numbers for any density, and the real ones that go with them.
pub(super) enum Solver {
    /// With a dense matrix over the whole unknowns.
    Dense {
        system: Box<NetSystem>,
        rounding: Rounding,
    },
    /// Without.
    Batches(BatchSystem),
}

/// The most whole unknowns of a dense matrix: 72 MB, and about a second.
const MOST_DENSE: usize = 3000;

impl Solver {
    pub(super) fn new(
        parts: Parts<'_>,
        (rows, parameters): (&[Form], usize),
        watch: &Watch,
    ) -> Result<Self, IntegerGridError> {
        watch.check()?;
        if parts.unknowns.wholes > MOST_DENSE {
            return Self::in_batches(parts, (rows, parameters));
        }
        let system = NetSystem::new(parts)?;
        watch.check()?;
        let rounding = Rounding::new(system.over_parameters(rows, parameters))
            .ok_or(IntegerGridError::Undetermined { parameters })?;
        Ok(Self::Dense {
            system: Box::new(system),
            rounding,
        })
    }

    pub(super) fn in_batches(
        parts: Parts<'_>,
        parameters: (&[Form], usize),
    ) -> Result<Self, IntegerGridError> {
        BatchSystem::new(parts, parameters).map(Self::Batches)
    }

    /// Takes over other weights; the order of elimination stays.
    pub(super) fn reweigh(
        &mut self,
        parts: Parts<'_>,
        (rows, parameters): (&[Form], usize),
        watch: &Watch,
    ) -> Result<(), IntegerGridError> {
        match self {
            Self::Dense { system, rounding } => {
                system.reweigh(parts)?;
                watch.check()?;
                *rounding = Rounding::new(system.over_parameters(rows, parameters))
                    .ok_or(IntegerGridError::Undetermined { parameters })?;
            }
            Self::Batches(system) => *system = BatchSystem::new(parts, (rows, parameters))?,
        }
        Ok(())
    }

    /// Takes over other wishes; what is factored stays.
    pub(super) fn wish(
        &mut self,
        parts: Parts<'_>,
        (rows, parameters): (&[Form], usize),
    ) -> Result<(), IntegerGridError> {
        match self {
            Self::Dense { system, rounding } => {
                system.wish(parts)?;
                rounding.load(system.parameter_loads(rows, parameters));
            }
            Self::Batches(system) => system.wish(parts),
        }
        Ok(())
    }

    /// The differences of coordinates along halfedges where the energy is least, the whole unknowns
    /// being real, at a density of one line per unit of length; `None` where that is not known.
    pub(super) fn relaxed(
        &self,
        parts: Parts<'_>,
        rows: &[Form],
    ) -> Result<Option<PerCorner<DVec2>>, IntegerGridError> {
        let Self::Dense { system, rounding } = self else {
            return Ok(None);
        };
        let wholes = rows.iter().map(|row| row.real_value(rounding.relaxed()));
        let wholes: Vec<f64> = wholes.collect();
        let mut values = system.reals(1.0, &wholes)?;
        values.extend(wholes);
        Ok(Some(differences(parts, &values)))
    }

    /// The whole unknowns and the real ones at a density.
    pub(super) fn at(
        &self,
        density: f64,
        rows: &[Form],
        guard: &Guard,
        watch: &Watch,
    ) -> Result<(Vec<i64>, Vec<f64>), IntegerGridError> {
        let wholes = |parameters: &[i64]| rows.iter().map(|row| row.value(parameters)).collect();
        match self {
            Self::Dense { system, rounding } => {
                let wholes: Vec<i64> = wholes(&rounding.at(density, guard, watch)?);
                let given: Vec<f64> = wholes.iter().map(|&whole| whole as f64).collect();
                let reals = system.reals(density, &given)?;
                Ok((wholes, reals))
            }
            Self::Batches(system) => {
                let (parameters, reals) = system.at(density, guard, watch)?;
                Ok((wholes(&parameters), reals))
            }
        }
    }
}
