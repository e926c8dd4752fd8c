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
/// Around such a pair the field forgets the curvature, and the disk around both, with its rim fixed,
/// is smoothed anew: opposite singularities attract each other there and meet. Fixed directions
/// stay, and so do soft ones with more weight than curvature ever has. Repeated while it helps.
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

/// The largest weight of a direction of curvature.
const CURVATURE_WEIGHT: f64 = 1.0;

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
        // Round all three corners: none of them has a right to be the middle.
        let corners = surface.mesh().triangle(singularity.face);
        let is_close = corners.iter().any(|&corner| {
            finder.find(corner, distance, DISK_VERTEX_LIMIT, &mut disk);
            has_opposite(surface, &disk, &steps, *singularity)
        });
        for corner in corners.into_iter().filter(|_| is_close) {
            any = true;
            finder.find(corner, 2.0 * distance, 4 * DISK_VERTEX_LIMIT, &mut disk);
            for entry in &disk {
                is_free[entry.vertex] = guidance.fixed(entry.vertex).is_none();
            }
        }
    }
    any.then(|| {
        let mut released = Guidance::none(field.symmetry(), is_free.len());
        for (vertex, &is_free) in is_free.enumerate() {
            if !is_free {
                released.follow(vertex, field.angle(vertex), Strength::Hard);
            } else if guidance.weight(vertex) > CURVATURE_WEIGHT {
                released.take(vertex, guidance);
            }
        }
        released
    })
}

fn has_opposite(
    surface: &Surface,
    disk: &[DiskVertex],
    steps: &PerFace<i32>,
    singularity: Singularity,
) -> bool {
    let faces = disk
        .iter()
        .flat_map(|entry| surface.mesh().outgoing(entry.vertex));
    let mut steps = faces.map(|halfedge| steps[halfedge.face()]);
    steps.any(|other| other * singularity.steps < 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Symmetry;
    use crate::geometry::{intrinsic_delaunay, vertex_frames};
    use crate::mesh::VertexId;
    use glam::{DVec2, DVec3};
    use graticule_fixtures::disk;

    /// A cross field on a flat disk of radius 1 with a quarter-pole of sign `steps` at each place.
    fn poles(surface: &Surface, poles: &[(DVec2, f64)]) -> CrossField {
        let frames = vertex_frames(surface);
        let angles = PerVertex::from_fn(surface.mesh().vertex_count(), |vertex: VertexId| {
            let p = surface.position(vertex).truncate();
            let turned = |(place, steps): &(DVec2, f64)| {
                steps * libm::atan2(p.y - place.y, p.x - place.x) / 4.0
            };
            let angle: f64 = poles.iter().map(turned).sum();
            let along = frames[vertex].project(DVec3::new(angle.cos(), angle.sin(), 0.0));
            libm::atan2(along.y, along.x)
        });
        CrossField::from_angles(Symmetry::Cross, angles)
    }

    /// The signs of the singularities before and after, and the sums of the indices.
    fn cancelled(places: &[(DVec2, f64)], distance: f64) -> ([Vec<i32>; 2], [f64; 2]) {
        let disk = disk(20);
        let surface = Surface::from_triangles(disk.positions, &disk.triangles).unwrap();
        let original = IntrinsicTriangulation::of(&surface).unwrap();
        let (delaunay, _) = intrinsic_delaunay(&surface, &Watch::new()).unwrap();
        let triangulations = Triangulations {
            original: &original,
            delaunay: &delaunay,
        };
        let before = poles(&surface, places);
        let options = CancelOptions {
            distance,
            smoothing: SmoothingOptions::default(),
        };
        let (after, report) = cancel_close_pairs(
            &surface,
            &triangulations,
            &Guidance::none(Symmetry::Cross, surface.mesh().vertex_count()),
            before.clone(),
            &options,
            &Watch::new(),
        )
        .unwrap();
        let found = [&before, &after].map(|f| Singularities::of(f, surface.mesh(), &original));
        assert_eq!(report.singularities_before, found[0].count());
        assert_eq!(report.singularities_after, found[1].count());
        let signs = |found: &Singularities| found.faces.iter().map(|s| s.steps).collect();
        (
            found.each_ref().map(signs),
            found.each_ref().map(Singularities::index_sum),
        )
    }

    #[test]
    fn a_close_pair_vanishes() {
        let pair = [
            (DVec2::new(0.06, 0.011), 1.0),
            (DVec2::new(-0.05, 0.013), -1.0),
        ];
        let (signs, sums) = cancelled(&pair, 0.15);
        assert_eq!(signs[0].len(), 2);
        assert!(signs[1].is_empty(), "{signs:?}");
        assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-9), "{sums:?}");
    }

    #[test]
    fn a_lone_pole_and_a_distant_pair_stay() {
        let pole = [(DVec2::new(0.01, 0.011), 1.0)];
        let pair = [
            (DVec2::new(0.31, 0.011), 1.0),
            (DVec2::new(-0.32, 0.013), -1.0),
        ];
        for places in [&pole[..], &pair] {
            let (signs, sums) = cancelled(places, 0.15);
            assert_eq!(signs[0], signs[1]);
            assert_eq!(signs[0].len(), places.len());
            assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-9), "{sums:?}");
        }
    }

    #[test]
    fn the_third_of_three_poles_stays() {
        let three = [
            (DVec2::new(0.06, 0.011), 1.0),
            (DVec2::new(-0.05, 0.013), -1.0),
            (DVec2::new(0.01, -0.09), 1.0),
        ];
        let (signs, _) = cancelled(&three, 0.15);
        assert_eq!(signs[1], [1]);
    }
}
