//! What the order of components in a file may change, and what not.
//!
//! *Repair* and *info* treat each alone, and so do the maps of `flatten --cut`, to the last bit. A field is one system
//! of equations for all, whose sums come in another order: its singularities stay, its figures but for round-off.
//! Periodic and integer coordinates round one number after another for all components together, by what is nearest to an
//! integer: where two are as near, another order gives another net, as good and as sound, and nothing is compared.

use std::path::Path;

use glam::DVec3;
use graticule_fixtures::{Fixture, block_with_holes, bumpy_sphere, ellipsoid, torus};
use serde_json::Value;

use crate::Trouble;
use crate::runs::{Run, Runner, Surfaces, runs_named};

/// Two orders of the components.
const ORDERS: [[usize; 4]; 2] = [[0, 1, 2, 3], [2, 0, 3, 1]];

/// Relative difference of figures that sum over all components; 7e-12 has been seen.
const SUM_TOLERANCE: f64 = 1e-8;

/// What is compared of a run.
enum Comparison {
    /// The positions of the mesh written, in any order, to the last bit.
    Positions,
    /// The entries of a list in the report, in any order, by these keys, to the last bit.
    List(&'static str, &'static [&'static str]),
    /// Figures of the report.
    Figures(&'static [&'static str]),
}

/// The runs that are compared.
const COMPARED: [(&str, Comparison); 5] = [
    (
        "info",
        Comparison::List(
            "/result/surface/listed_components",
            &["vertices", "edges", "faces", "genus"],
        ),
    ),
    ("repair", Comparison::Positions),
    (
        "cut",
        Comparison::List("/result/islands", &["vertices", "faces", "energy"]),
    ),
    (
        "no-overlap",
        Comparison::List("/result/islands", &["vertices", "faces", "energy"]),
    ),
    (
        "field",
        Comparison::Figures(&[
            "/result/singularities",
            "/result/feature_edges",
            "/result/mean_deviation",
            "/result/smoothing/smoothness_energy",
        ]),
    ),
];

/// What the order of components changes and must not.
pub(super) fn compare(program: &Path, names: &[String]) -> Result<Vec<String>, Trouble> {
    let chosen = runs_named(names);
    let mut faults = Vec::new();
    for (name, comparison) in &COMPARED {
        let Some(run) = chosen.iter().find(|run| run.name == *name) else {
            continue;
        };
        let [first, second] = ORDERS.map(|order| outcome(program, run, order, comparison));
        if !agree(&first?, &second?) {
            faults.push(format!(
                "{name}: the order of components changes the result"
            ));
        }
    }
    Ok(faults)
}

/// The components side by side.
fn components(order: [usize; 4]) -> Fixture {
    let parts = [
        bumpy_sphere(10),
        torus(1.0, 0.4, 40, 20),
        block_with_holes(2),
        ellipsoid(DVec3::new(1.0, 1.4, 2.0), 3),
    ];
    let place = |index: usize| {
        let shift = DVec3::X * 5.0 * index as f64;
        parts[index].clone().map(|position| position + shift)
    };
    let [first, others @ ..] = order.map(place);
    others.iter().fold(first, Fixture::joined)
}

/// What is compared of the run on the components in an order.
fn outcome(
    program: &Path,
    run: &Run,
    order: [usize; 4],
    comparison: &Comparison,
) -> Result<Vec<Value>, Trouble> {
    let folder = tempfile::tempdir().map_err(|error| Trouble(error.to_string()))?;
    let surfaces = Surfaces {
        patch: String::new(),
        closed: components(order).to_obj(),
    };
    surfaces.write(folder.path())?;
    let runner = Runner::new(program, folder.path(), "run", 1)?;
    let report = runner.report(run, &[])?;
    match comparison {
        Comparison::Positions => positions(&runner.folder.join(run.mesh_out())),
        Comparison::List(pointer, keys) => entries(&report, pointer, keys),
        Comparison::Figures(pointers) => pointers
            .iter()
            .map(|pointer| at(&report, pointer).cloned())
            .collect(),
    }
}

/// The lines of an OBJ file that give positions, sorted.
fn positions(mesh: &Path) -> Result<Vec<Value>, Trouble> {
    let text = crate::source::read(mesh)?;
    let mut lines: Vec<&str> = text.lines().filter(|line| line.starts_with("v ")).collect();
    lines.sort_unstable();
    Ok(lines.into_iter().map(Value::from).collect())
}

fn entries(report: &Value, pointer: &str, keys: &[&str]) -> Result<Vec<Value>, Trouble> {
    let list = at(report, pointer)?
        .as_array()
        .map_or(&[][..], Vec::as_slice);
    let mut entries: Vec<String> = Vec::with_capacity(list.len());
    for entry in list {
        let values: Result<Vec<_>, _> = keys
            .iter()
            .map(|key| at(entry, &format!("/{key}")))
            .collect();
        let values: Value = values?.into_iter().cloned().collect();
        entries.push(values.to_string());
    }
    entries.sort_unstable();
    Ok(entries.into_iter().map(Value::from).collect())
}

fn at<'a>(report: &'a Value, pointer: &str) -> Result<&'a Value, Trouble> {
    let found = report.pointer(pointer);
    found.ok_or_else(|| Trouble(format!("the report has no {pointer}")))
}

/// Whether both are the same, numbers with a fraction but for round-off.
fn agree(first: &[Value], second: &[Value]) -> bool {
    let same = |(a, b): (&Value, &Value)| match (a.as_f64(), b.as_f64()) {
        (Some(x), Some(y)) if a.is_f64() => (x - y).abs() <= SUM_TOLERANCE * x.abs(),
        _ => a == b,
    };
    !first.is_empty() && first.len() == second.len() && first.iter().zip(second).all(same)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_agree_exactly_and_figures_but_for_round_off() {
        let list = |text: &str| -> Vec<Value> { serde_json::from_str(text).unwrap() };
        assert!(agree(&list("[3, 1.5]"), &list("[3, 1.500000000001]")));
        assert!(!agree(&list("[3, 1.5]"), &list("[3, 1.6]")));
        assert!(!agree(&list("[3]"), &list("[4]")));
        assert!(!agree(&[], &[]), "nothing compared is no proof");
    }

    #[test]
    fn entries_of_a_list_are_compared_in_any_order() {
        let report = |text: &str| -> Value { serde_json::from_str(text).unwrap() };
        let one = report(r#"{"list": [{"a": 1, "b": 2}, {"a": 3, "b": 4}]}"#);
        let two = report(r#"{"list": [{"a": 3, "b": 5}, {"a": 1, "b": 6}]}"#);
        let keys = |report, keys: &[&str]| entries(report, "/list", keys).unwrap();
        assert_eq!(keys(&one, &["a"]), keys(&two, &["a"]));
        assert_ne!(keys(&one, &["a", "b"]), keys(&two, &["a", "b"]));
        assert!(entries(&one, "/none", &[]).is_err());
    }
}
