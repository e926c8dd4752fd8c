//! Why the command ends without its result.

use std::error::Error;
use std::process::ExitCode;

use graticule::Hint;

/// A failure, told as one sentence of fact and one of advice.
#[derive(Debug)]
pub(crate) struct Failure {
    kind: Kind,
    /// What is the case.
    pub(crate) fact: String,
    /// What to do about it.
    pub(crate) hint: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The promised result could not be written.
    NoResult,
    /// The arguments are wrong, told before any work.
    Usage,
}

impl Failure {
    /// The promised result could not be written: exit code 1.
    pub(crate) fn new(fact: impl Into<String>, hint: impl Into<String>) -> Self {
        Self {
            kind: Kind::NoResult,
            fact: one_line(&fact.into()),
            hint: one_line(&hint.into()),
        }
    }

    /// The arguments are wrong: exit code 2.
    pub(crate) fn usage(fact: impl Into<String>, hint: impl Into<String>) -> Self {
        Self {
            kind: Kind::Usage,
            ..Self::new(fact, hint)
        }
    }

    /// The same failure with the place where it arose before the fact.
    pub(crate) fn at(mut self, place: impl std::fmt::Display) -> Self {
        self.fact = one_line(&format!("{place}: {}", self.fact));
        self
    }

    /// Whether work was begun and gave no result; wrong arguments are told before any.
    pub(crate) fn is_of_the_work(&self) -> bool {
        self.kind == Kind::NoResult
    }

    /// The exit code of the command.
    pub(crate) fn exit_code(&self) -> ExitCode {
        match self.kind {
            Kind::NoResult => ExitCode::from(1),
            Kind::Usage => ExitCode::from(2),
        }
    }
}

impl<E: Error + Hint> From<E> for Failure {
    fn from(error: E) -> Self {
        let hint = error.hint().unwrap_or_else(|| {
            "run 'graticule info' on the file to see what it holds and what is wrong with it".into()
        });
        Self::new(error.to_string(), hint)
    }
}

fn one_line(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ")
}
