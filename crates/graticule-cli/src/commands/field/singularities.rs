//! Where the field is to be singular, by the polygons of the file.

use graticule::field::{Singularity, SingularityPlan, Symmetry};
use graticule::mesh::{FaceId, Repaired};
use serde::Deserialize;

use super::guides::{read_list, triangles_of_polygons};
use super::options::Options;
use crate::failure::Failure;

/// What the options say of singularities.
pub(super) enum Places {
    /// Nothing.
    Any,
    /// Polygons and indices of all of them.
    Given(Vec<(u32, f64)>),
    /// From which polygon to which they are moved.
    Moved(Vec<(u32, u32)>),
}

/// One singularity as a file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    polygon: u32,
    index: f64,
}

impl Places {
    /// Reads the file, if there is one.
    pub(super) fn of(options: &Options) -> Result<Self, Failure> {
        if let Some(path) = &options.singularities {
            let example = "[{\"polygon\": 7, \"index\": 0.25}]";
            let entries: Vec<Entry> = read_list(path, "singularities", example)?;
            let entries = entries.iter().map(|entry| (entry.polygon, entry.index));
            return Ok(Self::Given(entries.collect()));
        }
        Ok(
            match (&options.singularity[..], &options.move_singularity[..]) {
                ([], []) => Self::Any,
                ([], moves) => Self::Moved(moves.to_vec()),
                (given, _) => Self::Given(given.to_vec()),
            },
        )
    }

    /// The same by triangles of the surface: the first of each polygon.
    pub(super) fn plan(
        &self,
        symmetry: Symmetry,
        repaired: &Repaired,
    ) -> Result<SingularityPlan, Failure> {
        let triangles = triangles_of_polygons(repaired);
        let face = |polygon: u32| -> Result<FaceId, Failure> {
            let first = triangles.get(&polygon).and_then(|faces| faces.first());
            first.copied().ok_or_else(|| {
                Failure::new(
                    format!("polygon {polygon} is no part of the surface"),
                    "polygons are numbered from 0 in the order of the mesh file",
                )
            })
        };
        Ok(match self {
            Self::Any => SingularityPlan::Found,
            Self::Given(given) => {
                let singular = given.iter().map(|&(polygon, index)| {
                    let steps = steps(polygon, index, symmetry)?;
                    Ok(Singularity {
                        face: face(polygon)?,
                        steps,
                    })
                });
                SingularityPlan::Given(singular.collect::<Result<_, Failure>>()?)
            }
            Self::Moved(moves) => {
                let moves = moves.iter().map(|&(from, to)| Ok([face(from)?, face(to)?]));
                SingularityPlan::Moved(moves.collect::<Result<_, Failure>>()?)
            }
        })
    }
}

/// The index in steps of the symmetry.
fn steps(polygon: u32, index: f64, symmetry: Symmetry) -> Result<i32, Failure> {
    let order = f64::from(symmetry.order());
    let steps = (index * order).round();
    if (index * order - steps).abs() > 1e-6 || steps.abs() > 1e6 {
        return Err(Failure::usage(
            format!("the index {index} of polygon {polygon} is no multiple of 1/{order}"),
            format!("give a multiple of {}", 1.0 / order),
        ));
    }
    Ok(steps as i32)
}
