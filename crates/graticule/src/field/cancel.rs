use serde::Serialize;

use super::disk::{DiskFinder, DiskVertex};
use super::smoothing::relax;
use super::{CrossField, FieldError, Guidance, Singularities, Singularity, Strength};
use super::{SmoothField, SmoothingOptions};
use crate::geometry::IntrinsicTriangulation;
use crate::mesh::{PerFace, PerVertex, Surface};
use crate::tolerance::DISK_VERTEX_LIMIT;
use crate::watch::Watch;

/// What [`cancel_close_pairs`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Cancellation {
    /// Rounds of search and relaxation.
    pub rounds: usize,
    /// Singular triangles before.
    pub singularities_before: usize,
    /// Singular triangles after.
    pub singularities_after: usize,
}

/// Lets singularities of opposite sign within `distance` of each other cancel.
///
/// Around such a pair the field forgets its guidance, and the disk around both, with its rim fixed,
/// is smoothed anew: opposite singularities attract each other there and meet. Fixed directions
/// stay. Repeated while it helps.
///
/// # Errors
/// [`FieldError`].
pub fn cancel_close_pairs(
    surface: &Surface,
    triangulations: &Triangulations<'_>,
    guidance: &Guidance,
    field: CrossField,
    options: &CancelOptions,
    watch: &Watch,
) -> Result<(CrossField, Cancellation), FieldError> {
    let _stage = watch.stage("cancelling pairs");
    let found =
        |field: &CrossField| Singularities::of(field, surface.mesh(), triangulations.original);
    let mut best = field;
    let mut singular = found(&best);
    let mut report = Cancellation {
        singularities_before: singular.count(),
        ..Default::default()
    };
    while report.rounds < MOST_ROUNDS {
        let Some(released) = release_pairs(surface, &singular, guidance, &best, options.distance)
        else {
            break;
        };
        report.rounds += 1;
        let SmoothField { field, .. } = relax(
            triangulations.delaunay,
            surface.positions(),
            &released,
            &best,
            &options.smoothing,
            watch,
        )?;
        let after = found(&field);
        if after.count() >= singular.count() {
            break;
        }
        (best, singular) = (field, after);
    }
    report.singularities_after = singular.count();
    Ok((best, report))
}

/// The triangulation of the surface as it is, and the one that fields are computed on.
#[derive(Clone, Copy, Debug)]
pub struct Triangulations<'a> {
    /// The triangles of the mesh.
    pub original: &'a IntrinsicTriangulation,
    /// The intrinsic Delaunay triangulation of the same surface.
    pub delaunay: &'a IntrinsicTriangulation,
}

/// Which singularities cancel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CancelOptions {
    /// Largest distance between the two, in the unit of the positions.
    pub distance: f64,
    /// How the field is smoothed in between.
    pub smoothing: SmoothingOptions,
}

const MOST_ROUNDS: usize = 8;

/// Guidance that fixes the field everywhere except around close pairs; `None` if there is no pair.
fn release_pairs(
    surface: &Surface,
    singular: &Singularities,
    guidance: &Guidance,
    field: &CrossField,
    distance: f64,
) -> Option<Guidance> {
    let mut steps = PerFace::filled(surface.mesh().face_count(), 0);
    for singularity in &singular.faces {
        steps[singularity.face] = singularity.steps;
    }
    let mut finder = DiskFinder::new(surface);
    let mut disk = Vec::new();
    let mut is_free = PerVertex::filled(surface.mesh().vertex_count(), false);
    let mut any = false;
    for singularity in &singular.faces {
        let center = surface.mesh().triangle(singularity.face)[0];
        finder.find(center, distance, DISK_VERTEX_LIMIT, &mut disk);
        if has_opposite(surface, &disk, &steps, singularity) {
            any = true;
            finder.find(center, 2.0 * distance, 4 * DISK_VERTEX_LIMIT, &mut disk);
            for entry in &disk {
                is_free[entry.vertex] = guidance.fixed(entry.vertex).is_none();
            }
        }
    }
    any.then(|| {
        let mut released = Guidance::none(field.symmetry(), is_free.len());
        for (vertex, _) in is_free.enumerate().filter(|(_, free)| !**free) {
            released.follow(vertex, field.angle(vertex), Strength::Hard);
        }
        released
    })
}

fn has_opposite(
    surface: &Surface,
    disk: &[DiskVertex],
    steps: &PerFace<i32>,
    singularity: &Singularity,
) -> bool {
    let faces = disk
        .iter()
        .flat_map(|entry| surface.mesh().outgoing(entry.vertex));
    let mut steps = faces.map(|halfedge| steps[halfedge.face()]);
    steps.any(|other| other * singularity.steps < 0)
}
