//! Which texture coordinates are measured.

use glam::DVec2;
use graticule::mesh::{CornerAttribute, PolygonSoup};

use super::Options;
use crate::failure::Failure;
use crate::mesh_input::Input;

/// The set of texture coordinates that the options ask for; `None` if the mesh has none.
pub(super) fn choose(
    input: &Input,
    options: &Options,
) -> Result<Option<CornerAttribute<DVec2>>, Failure> {
    let sets = &input.soup.attributes.uv_sets;
    let Some(wanted) = &options.uv_set else {
        return Ok(sets.first().cloned());
    };
    if sets.is_empty() {
        return Ok(None);
    }
    let by_name = sets.iter().find(|set| set.name == *wanted);
    let by_number = || {
        wanted
            .parse()
            .ok()
            .and_then(|number: usize| sets.get(number))
    };
    let chosen = by_name.or_else(by_number).cloned();
    chosen
        .map(Some)
        .ok_or_else(|| no_such_set(wanted, sets).at(input.path.display()))
}

fn no_such_set(wanted: &str, sets: &[CornerAttribute<DVec2>]) -> Failure {
    let name = |name: &str| {
        if name.is_empty() {
            "no name".into()
        } else {
            format!("'{name}'")
        }
    };
    let names: Vec<String> = sets.iter().map(|set| name(&set.name)).collect();
    Failure::new(
        format!("there is no set of texture coordinates '{wanted}'"),
        format!(
            "it has {}, from number 0 on: {}",
            sets.len(),
            names.join(", ")
        ),
    )
}

/// The x and y of each vertex as its coordinates in the plane.
pub(super) fn positions_as_uvs(soup: &PolygonSoup) -> CornerAttribute<DVec2> {
    CornerAttribute {
        name: "positions".into(),
        values: soup.positions.iter().map(|p| p.truncate()).collect(),
        corner_values: soup.polygons.corner_vertices().to_vec(),
    }
}
