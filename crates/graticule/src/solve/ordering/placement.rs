//! Where the unknowns of a system lie.

use glam::DVec3;

use super::{Graph, Ordering};
use crate::solve::{Pattern, SolveError};

/// What is known of where unknowns lie in space, from which orderings are made.
///
/// With `block` unknowns per point, those of point `p` are numbered `block * p + k`.
#[derive(Clone, Copy, Debug)]
pub struct Placement<'a> {
    points: Option<&'a [DVec3]>,
    block: usize,
}

impl<'a> Placement<'a> {
    /// Nothing is known: orderings come from the matrix alone.
    #[must_use]
    pub fn unknown() -> Self {
        Self {
            points: None,
            block: 1,
        }
    }

    /// One unknown per point.
    #[must_use]
    pub fn at(points: &'a [DVec3]) -> Self {
        Self {
            points: Some(points),
            block: 1,
        }
    }

    /// `block` unknowns per point, at least one, numbered `block * point + k`.
    #[must_use]
    pub fn with_block(self, block: usize) -> Self {
        Self {
            block: block.max(1),
            ..self
        }
    }

    /// An ordering for a square matrix with this pattern, or with its lower triangle.
    ///
    /// Unknowns of one point stay together.
    ///
    /// # Errors
    /// [`SolveError::NotSquare`], or [`SolveError::LengthMismatch`] unless there are `block`
    /// unknowns for each point.
    pub fn ordering(self, pattern: &Pattern) -> Result<Ordering, SolveError> {
        let all: Vec<u32> = (0..pattern.columns() as u32).collect();
        if let Some(points) = self.points {
            let expected = points.len() * self.block;
            SolveError::check_length("unknowns", pattern.columns(), expected)?;
        }
        self.ordering_of(pattern, &all)
    }

    /// The same for a matrix whose unknowns are the given, ascending, ones of this placement.
    pub(in crate::solve) fn ordering_of(
        self,
        pattern: &Pattern,
        unknowns: &[u32],
    ) -> Result<Ordering, SolveError> {
        SolveError::check_square(pattern.rows(), pattern.columns())?;
        let mut group_of = Vec::with_capacity(unknowns.len());
        let mut groups: Vec<u32> = Vec::new();
        for &unknown in unknowns {
            let point = unknown / self.block as u32;
            if groups.last() != Some(&point) {
                groups.push(point);
            }
            group_of.push(groups.len() as u32 - 1);
        }
        let Some(points) = self.points else {
            let graph = Graph::of_groups(pattern, groups.len(), &group_of);
            return Ok(Ordering::minimum_degree(&graph).expanded_to(&group_of));
        };
        let points: Vec<DVec3> = groups.iter().map(|&g| points[g as usize]).collect();
        Ok(Ordering::of_groups(pattern, &group_of, &points))
    }
}
