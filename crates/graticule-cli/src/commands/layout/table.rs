//! A layout at a glance.

use graticule::charts::LaidOut;

use crate::tables::{Table, counted, figure};

/// What is worth knowing of a layout.
pub(super) fn table(found: &LaidOut) -> Table {
    let report = &found.report;
    let mut table = Table::new();
    let nodes = counted(report.nodes, "node", "nodes");
    let arcs = counted(report.arcs, "arc", "arcs");
    let characteristic = report.euler_characteristic;
    table.row(
        "charts",
        format!(
            "{}, {arcs}, {nodes}: Euler characteristic {characteristic}",
            report.charts
        ),
    );
    let share = figure(100.0 * report.singular_share);
    table.row(
        "regular",
        format!(
            "{}; {} others with four sides, {} without ({share} % in all)",
            report.regular, report.singular, report.polygonal
        ),
    );
    let [three, four, five, six, more] = report.side_counts;
    table.row(
        "sides",
        format!("three {three}, four {four}, five {five}, six {six}, more {more}"),
    );
    table.row(
        "T-junctions",
        format!(
            "{}, {} pieces of lines taken away",
            report.t_junctions, report.pruned_pieces
        ),
    );
    table.row(
        "no disks at first",
        format!(
            "{}; cut along edges {}",
            report.refined_charts, report.split_charts
        ),
    );
    table.row(
        "triangles",
        format!(
            "{}, {} of the input singular",
            report.triangles, report.left_out_triangles
        ),
    );
    table
}
