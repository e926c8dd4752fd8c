//! The road from a soup to quads, with a check after every stage.

use std::time::Duration;

use graticule::field::{FieldOptions, cross_field};
use graticule::flatten::{NaturalOptions, Patch, natural_map};
use graticule::measure::{compare_to_reference, measure_quads};
use graticule::mesh::{PolygonSoup, RepairOptions, Repaired, Weld, repair};
use graticule::periodic::{GridDensity, ParameterizeOptions, parameterize};
use graticule::quads::{Carry, RemeshOptions, remesh};
use graticule::watch::Watch;
use graticule_fixtures::HostileSoup;

/// No stage takes long on a soup of some hundred polygons, even on a busy machine and unoptimised.
const TIME_LIMIT: Duration = Duration::from_mins(1);
/// Where a longer one may be told, in seconds, for a very busy machine.
const TIME_LIMIT_VARIABLE: &str = "GRATICULE_TIME_LIMIT";
/// Quads to ask for: more than some surfaces have triangles, fewer than others.
const QUADS: usize = 150;

/// Sends a soup through every stage.
///
/// # Panics
/// If a stage runs out of time, or gives a result that is not sound. A refusal is an answer.
pub(crate) fn check_stages(soup: &HostileSoup) {
    let mut input = PolygonSoup {
        positions: soup.positions.clone(),
        ..PolygonSoup::default()
    };
    for polygon in &soup.polygons {
        input.polygons.push(polygon);
    }
    let Ok(repaired) = repair(&input, &RepairOptions::default(), &watch()) else {
        return;
    };
    check_repair(&repaired);
    check_flat_map(&repaired);
    check_coordinates(&repaired);
    check_quads(&input, &repaired);
}

fn watch() -> Watch {
    let told = std::env::var(TIME_LIMIT_VARIABLE).ok();
    let seconds = told.and_then(|text| text.parse().ok());
    Watch::new().with_time_limit(seconds.map_or(TIME_LIMIT, Duration::from_secs))
}

/// Whatever an error is, it is not the time limit.
fn refused(error: &dyn std::fmt::Display) {
    let text = error.to_string();
    assert!(!text.contains("time"), "{text}");
}

/// Repairing again changes nothing. What no repair can help is told each time.
fn check_repair(repaired: &Repaired) {
    let mesh = repaired.surface.mesh();
    let mut again = PolygonSoup {
        positions: repaired.surface.positions().iter().copied().collect(),
        ..PolygonSoup::default()
    };
    for face in mesh.faces() {
        again
            .polygons
            .push(&mesh.triangle(face).map(|vertex| vertex.0));
    }
    let options = RepairOptions {
        weld: Weld::Never,
        ..RepairOptions::default()
    };
    let twice = repair(&again, &options, &watch()).expect("a sound surface");
    let mut changes = twice.changes.sentences();
    changes.retain(|sentence| !sentence.contains("left in place"));
    assert!(changes.is_empty(), "repaired twice: {changes:?}");
}

fn check_flat_map(repaired: &Repaired) {
    let Ok(patch) = Patch::new(repaired.surface.clone(), &watch()) else {
        return;
    };
    match natural_map(&patch, &NaturalOptions::default(), &watch()) {
        Ok(map) => assert!(map.uv.iter().all(|place| place.is_finite())),
        Err(error) => refused(&error),
    }
}

fn check_coordinates(repaired: &Repaired) {
    let surface = &repaired.surface;
    let field = match cross_field(surface, &FieldOptions::default(), &watch()) {
        Ok(field) => field,
        Err(error) => return refused(&error),
    };
    let options = ParameterizeOptions::default();
    match parameterize(surface, &field.field, None, &options, &watch()) {
        Ok(coordinates) => {
            let mut corners = coordinates.layout.coordinates.iter();
            assert!(corners.all(|place| place.is_finite()));
        }
        Err(error) => refused(&error),
    }
}

fn check_quads(input: &PolygonSoup, repaired: &Repaired) {
    let options = RemeshOptions {
        density: GridDensity::Quads(QUADS),
        ..RemeshOptions::default()
    };
    let quads = match remesh(&repaired.surface, &options, &watch()) {
        Ok(quads) => quads,
        Err(error) => return refused(&error),
    };
    let carry = Carry {
        original: input,
        repaired,
        polygons: &quads.mesh.polygons,
        origins: &quads.mesh.origins,
    };
    let soup = carry.to_soup();
    let measure = match measure_quads(&soup, &watch()) {
        Ok(measure) => measure,
        Err(error) => return refused(&error),
    };
    let connections = &measure.connections;
    assert!(connections.manifold && connections.unused_vertices == 0);
    assert_eq!(measure.polygons.quads, measure.polygons.total);
    let against = compare_to_reference(&soup, &repaired.surface, &watch());
    assert!(against.expect("a surface of sane extent").topology_kept);
}
