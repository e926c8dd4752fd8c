//! A folder to run the command in, and what came of it.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use graticule_fixtures::Fixture;
use serde_json::Value;
use tempfile::TempDir;

/// A folder of its own, gone when dropped.
pub(crate) struct Bench {
    folder: TempDir,
}

/// A run that is over.
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
        }
    }

    /// A folder with the fixture as `patch.obj`.
    pub(crate) fn with(fixture: &Fixture) -> Self {
        let bench = Self::new();
        bench.write("patch.obj", &fixture.to_obj());
        bench
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// Names of all files, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name());
        let mut names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The command, to be run in the folder.
    pub(crate) fn command(&self) -> Command {
        let mut command = assert_cmd::cargo::cargo_bin_cmd!("graticule");
        command.current_dir(self.folder.path());
        command
    }

    /// Runs the command with these words.
    pub(crate) fn run(&self, words: &str) -> Run {
        let output = self.command().args(words.split_whitespace()).output();
        let output = output.unwrap();
        Run {
            code: output.status.code().unwrap(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs the command and wants it to succeed.
    pub(crate) fn succeed(&self, words: &str) -> Run {
        let run = self.run(words);
        assert_eq!(run.code, 0, "{words}: {}", run.stderr);
        run
    }

    /// Runs the command and wants it to tell of wrong words, with nothing on standard output and no
    /// new file. The parser of the command line has no line of advice.
    pub(crate) fn misuse(&self, words: &str) {
        let before = self.files();
        let run = self.run(words);
        assert_eq!(run.code, 2, "{words}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{words}");
        assert_eq!(self.files(), before, "{words}");
        assert!(run.stderr.starts_with("error: "), "{words}: {}", run.stderr);
    }

    /// Runs the command and wants it to end with this code, one line of fact, one of advice,
    /// nothing on standard output and no new file. Returns the fact.
    pub(crate) fn refuse(&self, code: i32, words: &str) -> String {
        let before = self.files();
        let run = self.run(words);
        assert_eq!(run.code, code, "{words}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{words}");
        assert_eq!(self.files(), before, "{words}");
        let lines: Vec<&str> = run.stderr.lines().collect();
        let [.., error, hint] = lines[..] else {
            panic!("{words}: {}", run.stderr);
        };
        assert!(hint.starts_with("hint: "), "{words}: {}", run.stderr);
        error.strip_prefix("error: ").unwrap().to_owned()
    }
}

/// Whether a file exists and has content.
pub(crate) fn has_content(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| metadata.len() > 0)
}
