//! A field at a glance.

use graticule::field::FieldResult;

use crate::tables::{Table, counted, figure};

/// What is worth knowing of a field.
pub(super) fn table(found: &FieldResult) -> Table {
    let report = &found.report;
    let mut table = Table::new();
    let kinds = report.singularities_by_index.iter();
    let kinds: Vec<String> = kinds
        .map(|kind| format!("{} of {:+}", kind.count, kind.index))
        .collect();
    let mut singular = counted(report.singularities, "triangle", "triangles");
    if !kinds.is_empty() {
        singular = format!("{singular}: {}", kinds.join(", "));
    }
    table.row("singularities", singular);
    let sum = format!("{} = Euler characteristic", report.euler_characteristic);
    table.row("sum of indices", sum);
    if let Some(cancelled) = &report.cancellation {
        let before = cancelled.singularities_before;
        let after = cancelled.singularities_after;
        table.row("cancelled", (before - after).to_string());
    }
    if let Some(deviation) = report.mean_deviation {
        table.row(
            "from curvature",
            format!("{}° in the mean", figure(deviation)),
        );
    }
    let edges = counted(report.feature_edges, "feature edge", "feature edges");
    let fixed = counted(report.fixed_vertices, "vertex", "vertices");
    table.row("kept exactly", format!("{fixed}; {edges}"));
    if let Some(curl) = &report.curl {
        let [low, high] = curl.found_range.map(figure);
        let (before, after) = (figure(curl.curl_before), figure(curl.curl_after));
        let text = format!("{before} before, {after} after, by a scale from {low} to {high}");
        table.row("curl", text);
    }
    table
}
