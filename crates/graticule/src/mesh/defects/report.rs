use std::cmp::Reverse;
use std::fmt::{self, Display};

use serde::Serialize;

use super::Defects;
use crate::mesh::sentence::{Sentence, of_components, of_edges, of_polygons, of_vertices};

/// What a finding means for the use of the soup.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Nothing is wrong; it may matter to some.
    Note,
    /// Not sound, but `repair` has an answer.
    Repairable,
    /// `repair` refuses it, unless told otherwise.
    Refused,
}

/// One kind of defect that was found, in words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Stable kebab-case name, for programs.
    pub code: &'static str,
    /// What it means.
    pub severity: Severity,
    /// How many elements.
    pub count: usize,
    /// One sentence of fact.
    pub message: String,
}

impl Display for Finding {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)
    }
}

/// A kind of finding: its code, its severity, and what there is to say.
type Row = (&'static str, Severity, Option<Sentence>);

impl Defects {
    /// What was found, one entry for each kind that occurs, the gravest first.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        let sections = [
            self.vertex_rows(),
            self.polygon_rows(),
            self.shape_rows(),
            self.topology_rows(),
            self.gap_rows(),
        ];
        let rows = sections.into_iter().flatten();
        let mut findings: Vec<_> = rows
            .filter_map(|(code, severity, sentence)| {
                sentence.map(|Sentence { count, text }| Finding {
                    code,
                    severity,
                    count,
                    message: text,
                })
            })
            .collect();
        findings.sort_by_key(|finding| Reverse(finding.severity));
        findings
    }

    fn vertex_rows(&self) -> Vec<Row> {
        vec![
            (
                "non-finite-vertices",
                Severity::Refused,
                of_vertices(
                    &self.non_finite_vertices,
                    "vertex with a position that is not finite|vertices with positions that are not finite",
                ),
            ),
            (
                "non-finite-unused-vertices",
                Severity::Note,
                of_vertices(
                    &self.non_finite_unused_vertices,
                    "unused vertex with a position that is not finite|unused vertices with positions that are not finite",
                ),
            ),
            (
                "isolated-vertices",
                Severity::Note,
                of_vertices(
                    &self.isolated_vertices,
                    "vertex without polygon|vertices without polygon",
                ),
            ),
            (
                "duplicate-vertices",
                Severity::Note,
                of_vertices(
                    &self.duplicate_vertices,
                    "vertex at the position of an earlier one|vertices at the position of an earlier one",
                ),
            ),
        ]
    }

    fn polygon_rows(&self) -> Vec<Row> {
        vec![
            (
                "out-of-range",
                Severity::Refused,
                of_polygons(
                    &self.out_of_range,
                    "polygon naming a vertex that is not there|polygons naming vertices that are not there",
                ),
            ),
            (
                "too-few-corners",
                Severity::Repairable,
                of_polygons(
                    &self.too_few_corners,
                    "polygon with less than three corners|polygons with less than three corners",
                ),
            ),
            (
                "repeated-corners",
                Severity::Repairable,
                of_polygons(
                    &self.repeated_corners,
                    "polygon that repeats a corner|polygons that repeat a corner",
                ),
            ),
            (
                "duplicate-polygons",
                Severity::Repairable,
                of_polygons(
                    &self.duplicate_polygons,
                    "polygon over the vertices of an earlier one|polygons over the vertices of an earlier one",
                ),
            ),
        ]
    }

    fn shape_rows(&self) -> Vec<Row> {
        vec![
            (
                "zero-length-edges",
                Severity::Repairable,
                of_polygons(
                    &self.zero_length_edges,
                    "polygon with an edge of no length|polygons with an edge of no length",
                ),
            ),
            (
                "zero-area",
                Severity::Repairable,
                of_polygons(
                    &self.zero_area,
                    "polygon without area|polygons without area",
                ),
            ),
            (
                "slivers",
                Severity::Note,
                of_polygons(&self.slivers, "very thin triangle|very thin triangles"),
            ),
            ("polygons", Severity::Note, self.large_polygons()),
        ]
    }

    fn topology_rows(&self) -> Vec<Row> {
        vec![
            (
                "non-orientable",
                Severity::Refused,
                of_components(
                    &self.non_orientable,
                    "non-orientable piece|non-orientable pieces",
                ),
            ),
            (
                "non-manifold-edges",
                Severity::Repairable,
                of_edges(
                    &self.non_manifold_edges,
                    "edge with more than two polygons|edges with more than two polygons",
                ),
            ),
            (
                "non-manifold-vertices",
                Severity::Repairable,
                of_vertices(
                    &self.non_manifold_vertices,
                    "vertex that joins separate fans (bow-tie)|vertices that join separate fans (bow-ties)",
                ),
            ),
            (
                "inconsistent-orientation",
                Severity::Repairable,
                of_edges(
                    &self.inconsistent_edges,
                    "edge with inconsistent orientation|edges with inconsistent orientation",
                ),
            ),
            (
                "inside-out",
                Severity::Repairable,
                of_components(
                    &self.inside_out,
                    "closed component facing inward|closed components facing inward",
                ),
            ),
        ]
    }

    fn gap_rows(&self) -> Vec<Row> {
        vec![
            (
                "open-seams",
                Severity::Note,
                of_edges(
                    &self.open_seams,
                    "pair of boundary edges at the same place|pairs of boundary edges at the same place",
                ),
            ),
            (
                "t-junctions",
                Severity::Note,
                of_vertices(
                    &self.t_junctions,
                    "T-junction (a crack)|T-junctions (cracks)",
                ),
            ),
            (
                "tiny-components",
                Severity::Note,
                of_components(&self.tiny_components, "tiny component|tiny components"),
            ),
        ]
    }

    fn large_polygons(&self) -> Option<Sentence> {
        let sizes: Vec<_> = self
            .polygon_sizes
            .iter()
            .filter(|&(&size, _)| size > 3)
            .collect();
        let count: usize = sizes.iter().map(|(_, count)| **count).sum();
        let (smallest, largest) = (sizes.first()?.0, sizes.last()?.0);
        let text = match count {
            1 => format!("1 polygon with {largest} corners"),
            _ if smallest == largest => format!("{count} polygons with {largest} corners"),
            _ => format!("{count} polygons with {smallest} to {largest} corners"),
        };
        Some(Sentence { count, text })
    }
}
