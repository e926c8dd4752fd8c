use std::fmt::{self, Display};

use serde::Serialize;

use super::Defects;
use crate::mesh::ElementList;

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

impl Defects {
    /// What was found, one entry for each kind that occurs, the gravest first.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        use Severity::{Note, Refused, Repairable};
        let rows = [
            self.vertex_findings(),
            self.polygon_findings(),
            vec![
                row(
                    "non-orientable",
                    Refused,
                    &self.non_orientable,
                    "non-orientable piece|non-orientable pieces",
                    "from polygon",
                ),
                row(
                    "non-manifold-edges",
                    Repairable,
                    &self.non_manifold_edges,
                    "edge with more than two polygons|edges with more than two polygons",
                    "between vertices",
                ),
                row(
                    "non-manifold-vertices",
                    Repairable,
                    &self.non_manifold_vertices,
                    "vertex that joins separate fans (bow-tie)|vertices that join separate fans (bow-ties)",
                    "vertex",
                ),
                row(
                    "inconsistent-orientation",
                    Repairable,
                    &self.inconsistent_edges,
                    "edge with inconsistent orientation|edges with inconsistent orientation",
                    "between vertices",
                ),
                row(
                    "inside-out",
                    Repairable,
                    &self.inside_out,
                    "closed component facing inward|closed components facing inward",
                    "from polygon",
                ),
                row(
                    "open-seams",
                    Note,
                    &self.open_seams,
                    "pair of boundary edges at the same place|pairs of boundary edges at the same place",
                    "between vertices",
                ),
                row(
                    "t-junctions",
                    Note,
                    &self.t_junctions,
                    "T-junction (a crack)|T-junctions (cracks)",
                    "vertex",
                ),
                row(
                    "tiny-components",
                    Note,
                    &self.tiny_components,
                    "tiny component|tiny components",
                    "from polygon",
                ),
            ],
        ];
        let mut findings: Vec<_> = rows.into_iter().flatten().flatten().collect();
        findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
        findings
    }

    fn vertex_findings(&self) -> Vec<Option<Finding>> {
        use Severity::{Note, Refused};
        vec![
            row(
                "non-finite-vertices",
                Refused,
                &self.non_finite_vertices,
                "vertex with a position that is not finite|vertices with positions that are not finite",
                "vertex",
            ),
            row(
                "non-finite-unused-vertices",
                Note,
                &self.non_finite_unused_vertices,
                "unused vertex with a position that is not finite|unused vertices with positions that are not finite",
                "vertex",
            ),
            row(
                "isolated-vertices",
                Note,
                &self.isolated_vertices,
                "vertex without polygon|vertices without polygon",
                "vertex",
            ),
            row(
                "duplicate-vertices",
                Note,
                &self.duplicate_vertices,
                "vertex at the position of an earlier one|vertices at the position of an earlier one",
                "vertex",
            ),
        ]
    }

    fn polygon_findings(&self) -> Vec<Option<Finding>> {
        use Severity::{Note, Refused, Repairable};
        vec![
            row(
                "out-of-range",
                Refused,
                &self.out_of_range,
                "polygon naming a vertex that is not there|polygons naming vertices that are not there",
                "polygon",
            ),
            row(
                "too-few-corners",
                Repairable,
                &self.too_few_corners,
                "polygon with less than three corners|polygons with less than three corners",
                "polygon",
            ),
            row(
                "repeated-corners",
                Repairable,
                &self.repeated_corners,
                "polygon that repeats a corner|polygons that repeat a corner",
                "polygon",
            ),
            row(
                "duplicate-polygons",
                Repairable,
                &self.duplicate_polygons,
                "polygon over the vertices of an earlier one|polygons over the vertices of an earlier one",
                "polygon",
            ),
            row(
                "zero-length-edges",
                Repairable,
                &self.zero_length_edges,
                "polygon with an edge of no length|polygons with an edge of no length",
                "polygon",
            ),
            row(
                "zero-area",
                Repairable,
                &self.zero_area,
                "polygon without area|polygons without area",
                "polygon",
            ),
            row(
                "slivers",
                Note,
                &self.slivers,
                "very thin triangle|very thin triangles",
                "polygon",
            ),
            self.large_polygons(),
        ]
    }

    fn large_polygons(&self) -> Option<Finding> {
        let sizes: Vec<_> = self
            .polygon_sizes
            .iter()
            .filter(|&(&size, _)| size > 3)
            .collect();
        let count: usize = sizes.iter().map(|(_, count)| **count).sum();
        let (smallest, largest) = (sizes.first()?.0, sizes.last()?.0);
        Some(Finding {
            code: "polygons",
            severity: Severity::Note,
            count,
            message: match count {
                1 => format!("1 polygon with {largest} corners"),
                _ if smallest == largest => format!("{count} polygons with {largest} corners"),
                _ => format!("{count} polygons with {smallest} to {largest} corners"),
            },
        })
    }
}

/// An element as a sentence names it.
pub(in crate::mesh) trait Named {
    fn name(&self) -> String;
}

impl Named for u32 {
    fn name(&self) -> String {
        self.to_string()
    }
}

impl Named for [u32; 2] {
    fn name(&self) -> String {
        format!("{} and {}", self[0], self[1])
    }
}

/// `nouns` holds singular and plural, apart by a bar; `place` stands before the first element.
fn row<T: Named>(
    code: &'static str,
    severity: Severity,
    elements: &ElementList<T>,
    nouns: &str,
    place: &str,
) -> Option<Finding> {
    let message = sentence(elements, nouns, place)?;
    Some(Finding {
        code,
        severity,
        count: elements.count(),
        message,
    })
}

/// For example `3 T-junctions: vertex 5, 6, 7`; nothing for an empty list.
pub(in crate::mesh) fn sentence<T: Named>(
    elements: &ElementList<T>,
    nouns: &str,
    place: &str,
) -> Option<String> {
    /// Named in a sentence; the report has more.
    const NAMED: usize = 3;
    let count = elements.count();
    let (singular, plural) = nouns.split_once('|').unwrap_or((nouns, nouns));
    let noun = if count == 1 { singular } else { plural };
    let named: Vec<_> = elements.all().iter().take(NAMED).map(Named::name).collect();
    let more = if count > NAMED { ", …" } else { "" };
    let separator = if place.contains("between") {
        "; "
    } else {
        ", "
    };
    (count > 0).then(|| format!("{count} {noun}: {place} {}{more}", named.join(separator)))
}
