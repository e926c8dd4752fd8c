//! What the corpus itself expects of its hostile files.

use std::collections::BTreeMap;
use std::path::Path;

use super::jobs::REPAIR;
use super::table::{Table, Verdict};
use crate::Trouble;
use crate::source::read;

/// The verdicts that `broken/expected.csv` allows, by file relative to the corpus.
pub(super) fn expectations(folder: &Path) -> Result<BTreeMap<String, String>, Trouble> {
    let mut expectations = BTreeMap::new();
    for prefix in ["", "broken/"] {
        let table = folder.join(prefix).join("expected.csv");
        if !table.is_file() {
            continue;
        }
        for line in read(&table)?.lines().skip(1) {
            let mut cells = line.splitn(4, ',');
            if let (Some(file), Some(verdict)) = (cells.next(), cells.nth(1)) {
                expectations.insert(format!("{prefix}{file}"), verdict.to_owned());
            }
        }
    }
    Ok(expectations)
}

/// Files that `repair` did not treat as expected: `accept` and `repair` want a mesh, the latter
/// one that is told of, `refuse` a refusal.
pub(super) fn unmet_expectations(
    table: &Table,
    expectations: &BTreeMap<String, String>,
) -> Vec<String> {
    let mut faults = Vec::new();
    for row in &table.rows {
        let Some(expected) = expectations.get(&row.file) else {
            continue;
        };
        let repaired = row.cells.iter().find(|cell| cell.run == REPAIR.name);
        let Some(cell) = repaired.filter(|cell| cell.verdict != Verdict::Bad) else {
            continue;
        };
        let meets = |word: &str| match word {
            "accept" => cell.verdict != Verdict::Refused,
            "repair" => cell.verdict == Verdict::OkWithRemarks,
            "refuse" => cell.verdict == Verdict::Refused,
            _ => false,
        };
        if !expected.split('|').any(meets) {
            faults.push(format!(
                "{}: expected {expected}, but repair ended '{}' {}",
                row.file, cell.verdict, cell.reason
            ));
        }
    }
    faults
}
