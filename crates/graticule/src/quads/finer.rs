//! Smaller triangles for surfaces that are coarser than the quads wanted of them.

use super::RemeshOptions;
use super::remesh::side_length;
use crate::field::CurvatureOptions;
use crate::geometry::{EdgeLengths, face_shapes, total_area};
use crate::mesh::{Refinement, Surface, refine, refined_count};
use crate::periodic::GridDensity;
use crate::tolerance::{LONGEST_EDGE_IN_QUADS, TRIANGLES_PER_QUAD};
use crate::watch::{Stopped, Watch};

/// A surface with smaller triangles.
pub(super) struct Finer {
    pub(super) refinement: Refinement,
    /// Mean edge length before over that after.
    ratio: f64,
}

/// The surface with triangles that are small beside the quads wanted; `None` if it has such itself.
///
/// On needles, of which there would be too many, the cut is coarser.
pub(super) fn finer_surface(
    surface: &Surface,
    options: &RemeshOptions,
    finest: GridDensity,
    watch: &Watch,
) -> Result<Option<Finer>, Stopped> {
    let side = side_length(surface, finest) * options.sizing.shortest_side();
    let lengths = EdgeLengths::of(surface);
    let longest_now = lengths.as_slice().iter().copied().fold(0.0, f64::max);
    let mut longest = LONGEST_EDGE_IN_QUADS * side;
    if side <= 0.0 {
        return Ok(None);
    }
    let quads = total_area(&face_shapes(surface)) / (side * side);
    let most = surface.mesh().face_count() as f64 + TRIANGLES_PER_QUAD * quads;
    while longest < longest_now && refined_count(surface, longest) > most {
        longest *= 1.5;
    }
    if longest >= longest_now {
        return Ok(None);
    }
    let refinement = refine(surface, longest, watch)?;
    let ratio = lengths.mean() / EdgeLengths::of(&refinement.refined.surface).mean();
    Ok(Some(Finer { refinement, ratio }))
}

impl Finer {
    /// The options for the new surface: the same features, and the same disks for the curvature, the same
    /// sizes.
    /// Vertices and triangles have their numbers still.
    pub(super) fn translated(&self, options: &RemeshOptions, original: &Surface) -> RemeshOptions {
        let mut options = options.clone();
        options.sizing = options.sizing.on_finer(original, &self.refinement.refined);
        let field = &mut options.field;
        field.curvature = field.curvature.map(|curvature| CurvatureOptions {
            radius: curvature.radius * self.ratio,
            ..curvature
        });
        field.features.edges = self.refinement.edges_of(&field.features.edges);
        options
    }
}
