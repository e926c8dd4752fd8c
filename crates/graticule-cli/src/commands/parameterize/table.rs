//! Periodic coordinates at a glance.

use graticule::periodic::{Parameterization, RegularDistortion};

use crate::tables::{Table, counted, figure};

/// What is worth knowing of the coordinates.
pub(super) fn table(map: &Parameterization) -> Table {
    let report = &map.report;
    let mut table = Table::new();
    let size = figure(report.chart_size);
    let edges = figure(report.chart_edges);
    let charts = figure(report.charts.round());
    table.row(
        "charts",
        format!("about {charts}, each {size} wide: {edges} mean edges"),
    );
    let minimization = &report.minimization;
    let energy = figure(minimization.energy);
    table.row("energy", format!("{energy} ({})", minimization.method));
    let kinds = [
        (report.field_singular_faces, "of the field"),
        (report.phase_singular_faces, "where a line ends"),
        (report.inverted_faces, "inverted"),
    ];
    let kinds = kinds.map(|(count, what)| format!("{count} {what}"));
    let share = figure(100.0 * report.singular_share);
    table.row(
        "singular triangles",
        format!("{share} %: {}", kinds.join(", ")),
    );
    let whole = counted(report.whole_coordinates, "coordinate", "coordinates");
    let released = report.released_coordinates;
    let unaligned = counted(report.unaligned_edges, "edge", "edges");
    table.row(
        "kept on lines",
        format!("{whole}; {released} released, {unaligned} not aligned"),
    );
    let sentence = |distortion: &RegularDistortion| {
        format!(
            "stretch {} ({} at the scale wanted), shear {}, without {} % of the area",
            figure(distortion.stretch),
            figure(distortion.stretch_at_scale),
            figure(distortion.shear),
            figure(100.0 * distortion.left_out_area)
        )
    };
    table.row("distortion", sentence(&report.distortion));
    table.row("two rings apart", sentence(&report.distortion_apart));
    if let Some(deviation) = report.field_deviation {
        table.row(
            "off the field",
            format!("{}° on average", figure(deviation)),
        );
    }
    table
}
