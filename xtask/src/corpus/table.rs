//! The table of outcomes: printed, written, and compared with the accepted one.

use std::collections::BTreeMap;
use std::fmt;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::Trouble;

/// Largest relative residual of a linear solve that a flattening may report.
const LARGEST_RESIDUAL: f64 = 1e-9;

/// How many of the slowest runs are named.
const SLOWEST: usize = 8;

/// How a run ended, judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Verdict {
    /// The promised result is there and sound.
    Ok,
    /// As `Ok`, and changes or warnings were told of.
    OkWithRemarks,
    /// The command said why it gives no result, and left nothing behind.
    Refused,
    /// Anything else.
    Bad,
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Ok => "ok",
            Self::OkWithRemarks => "ok, told",
            Self::Refused => "refused",
            Self::Bad => "BAD",
        })
    }
}

/// One run of one file.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Cell {
    /// The name of the run, such as `flatten-natural`.
    pub(super) run: &'static str,
    pub(super) verdict: Verdict,
    /// Why, where the verdict is `Refused` or `Bad`.
    pub(super) reason: String,
    pub(super) seconds: f64,
    pub(super) figures: Figures,
    /// Whether theory promises that no triangle is flipped.
    pub(super) promises_no_flip: bool,
}

/// Figures taken from a report.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Figures {
    pub(super) flipped: Option<u64>,
    pub(super) residual: Option<f64>,
    pub(super) peak_mebibytes: Option<u64>,
}

/// All runs of one file.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    pub(super) file: String,
    pub(super) cells: Vec<Cell>,
}

impl fmt::Display for Row {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:<55}", self.file)?;
        for cell in &self.cells {
            write!(formatter, " {:<8}", cell.verdict)?;
        }
        Ok(())
    }
}

/// What is remembered of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Accepted {
    verdict: Verdict,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    flipped: Option<u64>,
}

/// What is remembered of all runs, by file and name.
pub(super) type AcceptedTable = BTreeMap<String, BTreeMap<String, Accepted>>;

/// The outcomes of all files.
pub(super) struct Table {
    pub(super) rows: Vec<Row>,
}

impl Table {
    pub(super) fn new(rows: Vec<Row>) -> Self {
        Self { rows }
    }

    pub(super) fn run_count(&self) -> usize {
        self.rows.iter().map(|row| row.cells.len()).sum()
    }

    fn cells(&self) -> impl Iterator<Item = (&str, &Cell)> {
        self.rows.iter().flat_map(|row| {
            let file = row.file.as_str();
            row.cells.iter().map(move |cell| (file, cell))
        })
    }

    /// The table as Markdown: a row for each run.
    pub(super) fn to_markdown(&self) -> String {
        let mut text = String::from(
            "| file | run | verdict | flipped | residual | s | MiB | reason |\n|---|---|---|---|---|---|---|---|\n",
        );
        for (file, cell) in self.cells() {
            let figures = &cell.figures;
            let _ = writeln!(
                text,
                "| {file} | {} | {} | {} | {} | {:.2} | {} | {} |",
                cell.run,
                cell.verdict,
                figures.flipped.map_or(String::new(), |n| n.to_string()),
                figures
                    .residual
                    .map_or(String::new(), |r| format!("{r:.0e}")),
                cell.seconds,
                figures
                    .peak_mebibytes
                    .map_or(String::new(), |n| n.to_string()),
                cell.reason.replace('|', "\\|"),
            );
        }
        text
    }

    /// The runs that took longest, one a line.
    pub(super) fn slowest(&self) -> String {
        let mut cells: Vec<_> = self.cells().collect();
        cells.sort_by(|a, b| b.1.seconds.total_cmp(&a.1.seconds));
        let line = |(file, cell): &(&str, &Cell)| {
            format!("slow: {file}, {}: {:.1} s\n", cell.run, cell.seconds)
        };
        cells.iter().take(SLOWEST).map(line).collect()
    }

    /// Writes the table as Markdown and JSON into a folder.
    pub(super) fn write(&self, folder: &Path) -> Result<(), Trouble> {
        let json = serde_json::to_string_pretty(&self.rows);
        let json = json.map_err(|error| Trouble(error.to_string()))?;
        fs::create_dir_all(folder)
            .and_then(|()| fs::write(folder.join("corpus.md"), self.to_markdown()))
            .and_then(|()| fs::write(folder.join("corpus.json"), json))
            .map_err(|error| Trouble::reading(folder, &error))
    }

    fn to_accepted(&self) -> AcceptedTable {
        let mut accepted = AcceptedTable::new();
        for (file, cell) in self.cells() {
            let kept = Accepted {
                verdict: cell.verdict,
                flipped: cell.figures.flipped,
            };
            let runs = accepted.entry(file.to_owned()).or_default();
            runs.insert(cell.run.to_owned(), kept);
        }
        accepted
    }

    /// Makes the outcomes of this table the accepted ones; of `kept`, those of other runs stay.
    pub(super) fn accept(&self, mut kept: AcceptedTable, path: &Path) -> Result<(), Trouble> {
        for (file, runs) in self.to_accepted() {
            kept.entry(file).or_default().extend(runs);
        }
        let json = serde_json::to_string_pretty(&kept);
        let json = json.map_err(|error| Trouble(error.to_string()))?;
        fs::write(path, json + "\n").map_err(|error| Trouble::reading(path, &error))
    }

    /// Reads an accepted table.
    pub(super) fn accepted(json: &str) -> Result<AcceptedTable, Trouble> {
        serde_json::from_str(json)
            .map_err(|error| Trouble(format!("the accepted table of the corpus: {error}")))
    }

    /// Every run that ended otherwise than accepted, for worse or for better; where the whole
    /// corpus was run, also what is new and what is gone.
    pub(super) fn differences(&self, accepted: &AcceptedTable, whole: bool) -> Vec<String> {
        let now = self.to_accepted();
        let mut faults = Vec::new();
        for (file, runs) in &now {
            for (run, outcome) in runs {
                match accepted.get(file).and_then(|runs| runs.get(run)) {
                    Some(before) if before == outcome => {}
                    Some(before) => faults.push(format!(
                        "{file}, {run}: {outcome}, accepted is {before}; \
                         if that is right: cargo xtask corpus --accept"
                    )),
                    None => faults.push(format!(
                        "{file}, {run}: {outcome}, not in the accepted table"
                    )),
                }
            }
        }
        if whole {
            let gone = accepted.keys().filter(|file| !now.contains_key(*file));
            faults.extend(gone.map(|file| format!("{file}: in the accepted table, but not run")));
        }
        faults
    }

    /// What no table can make acceptable: bad ends, large residuals, flips that theory excludes.
    pub(super) fn broken_promises(&self) -> Vec<String> {
        let mut faults = Vec::new();
        for (file, cell) in self.cells() {
            let Figures {
                flipped, residual, ..
            } = cell.figures;
            if cell.verdict == Verdict::Bad {
                faults.push(format!("{file}, {}: {}", cell.run, cell.reason));
            }
            if residual.is_some_and(|r| r.is_nan() || r > LARGEST_RESIDUAL) {
                faults.push(format!("{file}, {}: residual {residual:?}", cell.run));
            }
            if cell.promises_no_flip && flipped.is_some_and(|n| n > 0) {
                faults.push(format!(
                    "{file}, {}: {flipped:?} flips that theory excludes",
                    cell.run
                ));
            }
        }
        faults
    }
}

impl fmt::Display for Accepted {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.verdict)?;
        match self.flipped {
            Some(flipped) => write!(formatter, " with {flipped} flipped"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(verdict: Verdict, flipped: u64) -> Table {
        let cell = Cell {
            run: "flatten",
            verdict,
            reason: String::new(),
            seconds: 0.1,
            figures: Figures {
                flipped: Some(flipped),
                ..Figures::default()
            },
            promises_no_flip: false,
        };
        Table::new(vec![Row {
            file: "a.obj".into(),
            cells: vec![cell],
        }])
    }

    #[test]
    fn an_unexpected_success_is_a_difference_as_is_a_regression() {
        let json = serde_json::to_string(&table(Verdict::Refused, 0).to_accepted()).unwrap();
        let accepted = Table::accepted(&json).unwrap();
        assert_eq!(
            table(Verdict::Refused, 0)
                .differences(&accepted, true)
                .len(),
            0
        );
        assert_eq!(table(Verdict::Ok, 0).differences(&accepted, true).len(), 1);
        assert_eq!(table(Verdict::Bad, 0).differences(&accepted, true).len(), 1);
        assert_eq!(
            table(Verdict::Refused, 2)
                .differences(&accepted, true)
                .len(),
            1
        );
    }

    #[test]
    fn what_is_gone_or_new_is_a_difference() {
        let accepted = table(Verdict::Ok, 0).to_accepted();
        assert_eq!(Table::new(vec![]).differences(&accepted, true).len(), 1);
        assert_eq!(Table::new(vec![]).differences(&accepted, false).len(), 0);
        assert_eq!(
            table(Verdict::Ok, 0)
                .differences(&AcceptedTable::new(), true)
                .len(),
            1
        );
    }

    #[test]
    fn accepting_a_part_keeps_what_was_not_run() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("accepted.json");
        let mut kept = table(Verdict::Refused, 0).to_accepted();
        let other = kept["a.obj"].clone();
        kept.insert("b.obj".into(), other);
        table(Verdict::Ok, 0).accept(kept, &path).unwrap();
        let accepted = Table::accepted(&fs::read_to_string(&path).unwrap()).unwrap();
        assert_eq!(accepted["a.obj"]["flatten"].verdict, Verdict::Ok);
        assert_eq!(accepted["b.obj"]["flatten"].verdict, Verdict::Refused);
    }

    #[test]
    fn flips_that_theory_excludes_break_a_promise() {
        let mut flipped = table(Verdict::Ok, 3);
        assert!(flipped.broken_promises().is_empty());
        flipped.rows[0].cells[0].promises_no_flip = true;
        assert_eq!(flipped.broken_promises().len(), 1);
        assert_eq!(table(Verdict::Bad, 0).broken_promises().len(), 1);
    }
}
