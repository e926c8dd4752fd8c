//! Checks the tables `papers/*.md`: every function and test that a row names exists, and every
//! equation that the source cites has a row.
//!
//! A table has a column *Test* and, for equations, one called *Function*; they hold names in
//! backticks, or the word `planned`. A name may leave out modules: `geometry::cotangents` finds
//! `geometry/corners.rs: cotangents`.

use std::collections::BTreeSet;
use std::path::Path;

use proc_macro2::{Delimiter, TokenTree};

use crate::Trouble;
use crate::source::{files_below, identifier, module_path, read, tokens};

/// An item of the source with the names around it, outermost first.
#[derive(Debug, PartialEq, Eq)]
struct Item {
    path: Vec<String>,
    is_test: bool,
}

/// A row of a table.
#[derive(Debug, Default, PartialEq, Eq)]
struct Row {
    line: usize,
    place: String,
    functions: Vec<String>,
    tests: Vec<String>,
}

/// Checks all tables of the workspace at `root` and returns what was checked, in a sentence.
pub(crate) fn check(root: &Path) -> Result<String, Trouble> {
    let sources = Sources::read(root)?;
    let mut faults = Vec::new();
    let mut rows_checked = 0;
    for table in files_below(&root.join("papers"), "md")? {
        let key = table.file_stem().unwrap_or_default().to_string_lossy();
        let rows = rows(&read(&table)?);
        faults.extend(row_faults(&key, &rows, &sources.items));
        faults.extend(citation_faults(&key, &rows, &sources.texts));
        rows_checked += rows.len();
    }
    if faults.is_empty() {
        Ok(format!(
            "papers: {rows_checked} rows name what exists, and every cited equation has a row"
        ))
    } else {
        Err(Trouble(faults.join("\n")))
    }
}

/// Every Rust file of the crates: its items, and its text with the file's name.
struct Sources {
    items: Vec<Item>,
    texts: Vec<(String, String)>,
}

impl Sources {
    fn read(root: &Path) -> Result<Self, Trouble> {
        let (mut items, mut texts) = (Vec::new(), Vec::new());
        for file in files_below(&root.join("crates"), "rs")? {
            let text = read(&file)?;
            let path = module_path(&file, &root.join("crates"));
            let mut found = Vec::new();
            collect_items(&tokens(&text, &file)?, &path, &mut found);
            items.extend(found);
            let name = file.strip_prefix(root).unwrap_or(&file).display();
            texts.push((name.to_string(), text));
        }
        Ok(Self { items, texts })
    }
}

/// Adds every named item below `tokens`, whose surroundings are called `path`.
fn collect_items(tokens: &[TokenTree], path: &[String], items: &mut Vec<Item>) {
    let mut around: Vec<String> = Vec::new();
    for (index, token) in tokens.iter().enumerate() {
        match token {
            TokenTree::Ident(word) if is_item_word(&word.to_string()) => {
                let Some(name) = identifier(tokens.get(index + 1)) else {
                    continue;
                };
                around = vec![name.clone()];
                let mut item = path.to_vec();
                item.push(name);
                let is_test = has_test_attribute(&tokens[..index]);
                items.push(Item {
                    path: item,
                    is_test,
                });
            }
            TokenTree::Ident(word) if word == "impl" => around.clear(),
            TokenTree::Ident(word) => around.push(word.to_string()),
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                let path: Vec<String> = path.iter().chain(&around).cloned().collect();
                collect_items(&inner, &path, items);
                around.clear();
            }
            _ => {}
        }
    }
}

fn is_item_word(word: &str) -> bool {
    ["fn", "struct", "enum", "const", "trait", "mod", "type"].contains(&word)
}

/// Whether the attributes right before an item, at the end of `before`, hold `#[test]`.
fn has_test_attribute(before: &[TokenTree]) -> bool {
    let mut rest = before;
    while let [head @ .., TokenTree::Punct(hash), TokenTree::Group(group)] = rest {
        if hash.as_char() != '#' {
            return false;
        }
        if group.stream().to_string() == "test" {
            return true;
        }
        rest = head;
    }
    false
}

/// The rows of the tables with a column *Test* in a Markdown text.
fn rows(text: &str) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut columns: Option<(Option<usize>, usize)> = None;
    for (index, line) in text.lines().enumerate() {
        let Some(cells) = cells(line) else {
            columns = None;
            continue;
        };
        let column = |name: &str| {
            cells
                .iter()
                .position(|cell| cell.eq_ignore_ascii_case(name))
        };
        if let Some(test) = column("test") {
            columns = Some((column("function"), test));
        } else if let (Some((function, test)), false) = (columns, is_rule(&cells)) {
            let names =
                |column: usize| cells.get(column).map(|c| backticked(c)).unwrap_or_default();
            rows.push(Row {
                line: index + 1,
                place: cells.first().cloned().unwrap_or_default(),
                functions: function.map(names).unwrap_or_default(),
                tests: names(test),
            });
        }
    }
    rows
}

/// The cells of a row; `\|` is a bar inside a cell.
fn cells(line: &str) -> Option<Vec<String>> {
    let inner = line.trim().strip_prefix('|')?.strip_suffix('|')?;
    let inner = inner.replace("\\|", "\0");
    let cells = inner.split('|').map(|cell| cell.trim().replace('\0', "|"));
    Some(cells.collect())
}

fn is_rule(cells: &[String]) -> bool {
    cells
        .iter()
        .all(|cell| cell.chars().all(|c| c == '-' || c == ':'))
}

fn backticked(cell: &str) -> Vec<String> {
    let names = cell.split('`').skip(1).step_by(2);
    names
        .map(|name| name.trim_end_matches("()").to_owned())
        .collect()
}

fn row_faults(key: &str, rows: &[Row], items: &[Item]) -> Vec<String> {
    let mut faults = Vec::new();
    for row in rows {
        let place = format!("papers/{key}.md:{} ({})", row.line, row.place);
        for name in &row.functions {
            if !items.iter().any(|item| answers_to(item, name)) {
                faults.push(format!("{place}: `{name}` does not exist"));
            }
        }
        for name in &row.tests {
            if !items
                .iter()
                .any(|item| item.is_test && answers_to(item, name))
            {
                faults.push(format!("{place}: no test is called `{name}`"));
            }
        }
        if !row.functions.is_empty() && row.tests.is_empty() {
            faults.push(format!("{place}: names a function but no test"));
        }
    }
    faults
}

/// Whether `name`, a path that may leave out modules, names the item.
fn answers_to(item: &Item, name: &str) -> bool {
    let wanted: Vec<&str> = name.split("::").collect();
    let last_agrees = item.path.last().map(String::as_str) == wanted.last().copied();
    let mut parts = item.path.iter();
    last_agrees
        && wanted
            .iter()
            .all(|part| parts.any(|p| p.replace('-', "_") == *part))
}

/// Equations of `key` that the sources cite but no row holds.
fn citation_faults(key: &str, rows: &[Row], texts: &[(String, String)]) -> Vec<String> {
    let known: BTreeSet<u32> = rows
        .iter()
        .flat_map(|row| equation_numbers(&row.place))
        .collect();
    let mut faults = Vec::new();
    for (file, text) in texts {
        for number in cited_equations(text, key) {
            if !known.contains(&number) {
                faults.push(format!(
                    "{file}: [{key}] Eq. {number} has no row in papers/{key}.md"
                ));
            }
        }
    }
    faults
}

/// The numbers of all equations cited as ``[`KEY`] Eq. N`` in a source text.
fn cited_equations(text: &str, key: &str) -> BTreeSet<u32> {
    let words = text.split_whitespace();
    let prose: Vec<String> = words
        .filter(|word| !word.starts_with("//"))
        .map(|word| word.replace('`', ""))
        .collect();
    let prose = prose.join(" ");
    let citation = format!("[{key}] ");
    let citations = prose.split(&citation).skip(1);
    citations.flat_map(equation_numbers).collect()
}

/// The numbers in `Eq. 3`, `Eqs. 3, 4 and 6`, `Eqs. 18–20` at the beginning of `text`.
fn equation_numbers(text: &str) -> BTreeSet<u32> {
    let mut numbers = BTreeSet::new();
    let Some(rest) = text.strip_prefix("Eq") else {
        return numbers;
    };
    let mut rest = rest.trim_start_matches(['s', '.', ' ']);
    let mut from_last = false;
    while let Some(number) = leading_number(rest) {
        let digits = rest.chars().take_while(char::is_ascii_digit).count();
        let first = if from_last {
            numbers.last().copied()
        } else {
            None
        };
        numbers.extend(first.unwrap_or(number)..=number);
        let separators = [" and ", ", ", "–", "-"];
        let Some(separator) = separators.iter().find(|s| rest[digits..].starts_with(**s)) else {
            break;
        };
        from_last = ["–", "-"].contains(separator);
        rest = &rest[digits + separator.len()..];
    }
    numbers
}

fn leading_number(text: &str) -> Option<u32> {
    let end = text
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(text.len());
    text[..end].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn items(source: &str) -> Vec<Item> {
        let mut items = Vec::new();
        let path = ["graticule", "src", "geometry", "weights"].map(String::from);
        let tokens = tokens(source, Path::new("weights.rs")).unwrap();
        collect_items(&tokens, &path, &mut items);
        items
    }

    #[test]
    fn rows_are_read_below_a_header_with_function_and_test() {
        let text = "| Where | What | Function | Test |\n|---|---|---|---|\n\
            | Eq. 3 | conformal | `geometry::cot` | `rows_sum_to_zero` |\n\
            | Eq. 4 | authalic | planned | planned |\n\n| other | table |\n|---|---|\n| a | `b` |\n";
        let rows = rows(text);
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0].functions, ["geometry::cot"]);
        assert_eq!(rows[0].tests, ["rows_sum_to_zero"]);
        assert_eq!((rows[1].line, rows[1].functions.len()), (4, 0));
    }

    #[test]
    fn names_are_found_by_a_shortened_path_and_only_there() {
        let items = items("pub fn cot() {} impl<T> Patch<T> { pub fn new() {} }");
        let found = |name: &str| items.iter().any(|item| answers_to(item, name));
        assert!(found("geometry::cot") && found("cot") && found("geometry::weights::cot"));
        assert!(found("Patch::new"));
        assert!(!found("solve::cot") && !found("cotangent"));
    }

    #[test]
    fn a_test_needs_its_attribute() {
        let items = items("mod tests { #[test] #[should_panic] fn holds() {} fn helper() {} }");
        let tests: Vec<bool> = items.iter().map(|item| item.is_test).collect();
        assert_eq!(tests, [false, true, false]);
    }

    #[test]
    fn a_missing_function_a_missing_test_and_a_missing_row_are_faults() {
        let rows = rows(
            "| Where | Function | Test |\n|---|---|---|\n| Eq. 1 | `gone` | `cot` |\n| Eq. 2 | `cot` | |\n",
        );
        let items = items("fn cot() {}");
        assert_eq!(row_faults("DMA02", &rows, &items).len(), 3);
        let text = "/// By [`DMA02`] Eqs. 1 and 7.".to_owned();
        let faults = citation_faults("DMA02", &rows, &[("a.rs".into(), text)]);
        assert_eq!(faults.len(), 1);
        assert!(faults[0].contains("Eq. 7"));
    }

    #[test]
    fn citations_are_read_in_every_form_and_across_lines() {
        let numbers = |text: &str| {
            cited_equations(text, "PGP06")
                .into_iter()
                .collect::<Vec<_>>()
        };
        assert_eq!(numbers("//! the turn of [`PGP06`]\n//! Eq. 13, in"), [13]);
        assert_eq!(numbers("[PGP06] Eqs. 18–20"), [18, 19, 20]);
        assert_eq!(numbers("[PGP06] Eqs. 5, 6 and 8; [PGP06] §3.1"), [5, 6, 8]);
        assert_eq!(numbers("[DMA02] Eq. 3"), [0; 0]);
    }
}
