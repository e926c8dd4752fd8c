//! `graticule cite`: the papers behind the commands.

use clap::{Args, ValueEnum};
use graticule::papers::{
    BS07, DMA02, FLO03, HG00, LPRM02, MTAD08, PGP06, Paper, SS15, SSGH01, TUT63,
};
use serde::Serialize;
use serde_json::json;

use crate::failure::Failure;
use crate::outcome::{Outcome, Plan};
use crate::report::Report;
use crate::session::Session;

/// Options of `graticule cite`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    /// Only the papers behind this command
    #[arg(value_name = "COMMAND", value_enum)]
    command: Option<Cited>,
    /// How to print them
    #[arg(long, value_enum, default_value_t = Style::Plain)]
    style: Style,
}

/// A command with papers behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Cited {
    Demo,
    Field,
    Flatten,
    Measure,
    Parameterize,
}

/// How to print a paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Style {
    /// For people
    Plain,
    /// For LaTeX
    Bibtex,
}

/// The papers whose methods each command runs.
const PAPERS: [(&[Cited], Paper); 10] = [
    (&[Cited::Demo, Cited::Flatten], DMA02),
    (&[Cited::Demo, Cited::Flatten], LPRM02),
    (&[Cited::Flatten], MTAD08),
    (&[Cited::Flatten], FLO03),
    (&[Cited::Flatten], TUT63),
    (&[Cited::Flatten], BS07),
    (&[Cited::Demo, Cited::Flatten, Cited::Measure], SSGH01),
    (&[Cited::Demo, Cited::Flatten, Cited::Measure], HG00),
    (&[Cited::Demo, Cited::Flatten, Cited::Measure], SS15),
    (&[Cited::Field, Cited::Parameterize], PGP06),
];

/// Prints the papers.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let plan = Plan::without_picture(&session.common, "cite")?;
    let papers = papers_behind(options.command);
    let texts = papers.iter().map(|paper| match options.style {
        Style::Plain => plain(paper),
        Style::Bibtex => bibtex(paper),
    });
    let mut outcome = Outcome::of(Report::new("cite", session.options_to_report(options)?));
    outcome.text = texts.collect::<Vec<_>>().join("\n");
    let figures = papers.iter().map(|paper| {
        json!({
            "key": paper.key,
            "authors": paper.authors,
            "title": paper.title,
            "published": paper.published,
            "doi": paper.doi,
        })
    });
    outcome.report.result = json!({ "papers": figures.collect::<Vec<_>>() });
    plan.finish(session, outcome)
}

fn papers_behind(command: Option<Cited>) -> Vec<&'static Paper> {
    let papers = PAPERS.iter();
    papers
        .filter(|(commands, _)| command.is_none_or(|command| commands.contains(&command)))
        .map(|(_, paper)| paper)
        .collect()
}

fn plain(paper: &Paper) -> String {
    let Paper {
        key,
        authors,
        title,
        published,
        doi,
    } = paper;
    let address = if doi.is_empty() {
        String::new()
    } else {
        format!("        https://doi.org/{doi}\n")
    };
    format!("[{key}] {authors}: {title}. {published}.\n{address}")
}

fn bibtex(paper: &Paper) -> String {
    let mut fields = vec![
        ("author", paper.authors.replace(", ", " and ")),
        ("title", format!("{{{}}}", paper.title)),
        ("howpublished", paper.published.to_owned()),
    ];
    fields.extend(year(paper.published).map(|year| ("year", year.to_owned())));
    if !paper.doi.is_empty() {
        fields.push(("doi", paper.doi.to_owned()));
    }
    let lines: Vec<String> = fields
        .iter()
        .map(|(name, value)| format!("  {name} = {{{value}}},"))
        .collect();
    format!("@misc{{{},\n{}\n}}\n", paper.key, lines.join("\n"))
}

/// The first number of four digits.
fn year(published: &str) -> Option<&str> {
    let mut numbers = published.split(|c: char| !c.is_ascii_digit());
    numbers.find(|digits| digits.len() == 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bibtex_has_authors_year_and_balanced_braces() {
        let text = bibtex(&DMA02);
        assert!(text.contains("author = {Mathieu Desbrun and Mark Meyer and Pierre Alliez}"));
        assert!(text.contains("year = {2002}"));
        assert_eq!(text.matches('{').count(), text.matches('}').count());
    }
}
