//! One run of the command under limits.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// How often a running process is looked at.
const POLL: Duration = Duration::from_millis(5);

/// What one run may use.
pub(super) struct Limits {
    pub(super) time: Duration,
    pub(super) mebibytes: u64,
}

/// The program under test.
pub(super) struct Program {
    pub(super) path: PathBuf,
    pub(super) limits: Limits,
}

/// How a run ended.
pub(super) enum End {
    /// By itself, with this code.
    Code(i32),
    /// By a signal: it crashed or was out of memory.
    Signal,
    /// It was ended when its time was over.
    Timeout,
    /// It could not be started.
    NotStarted(String),
}

/// A run that is over.
pub(super) struct Run {
    pub(super) end: End,
    pub(super) seconds: f64,
    pub(super) stdout: Vec<u8>,
    pub(super) stderr: String,
}

impl Program {
    /// Runs the command with `arguments` in `folder`, where its outputs go too.
    pub(super) fn run(&self, arguments: &[&str], folder: &Path) -> Run {
        let start = Instant::now();
        let (out, err) = (folder.join(".stdout"), folder.join(".stderr"));
        let end = match self.start(arguments, folder, &out, &err) {
            Ok(child) => wait(child, self.limits.time),
            Err(error) => End::NotStarted(error.to_string()),
        };
        let run = Run {
            end,
            seconds: start.elapsed().as_secs_f64(),
            stdout: fs::read(&out).unwrap_or_default(),
            stderr: String::from_utf8_lossy(&fs::read(&err).unwrap_or_default()).into_owned(),
        };
        // Left-over files are counted by the judge: these two are not among them.
        let _ = (fs::remove_file(out), fs::remove_file(err));
        run
    }

    /// Starts the process below a shell that sets the limit of memory and then becomes it.
    fn start(
        &self,
        arguments: &[&str],
        folder: &Path,
        out: &Path,
        err: &Path,
    ) -> std::io::Result<Child> {
        let limit = format!("ulimit -v {}; exec \"$@\"", self.limits.mebibytes * 1024);
        Command::new("sh")
            .args(["-c", &limit, "sh"])
            .arg(&self.path)
            .args(arguments)
            .current_dir(folder)
            .env_remove("RUST_BACKTRACE")
            .stdin(Stdio::null())
            .stdout(File::create(out)?)
            .stderr(File::create(err)?)
            .spawn()
    }
}

fn wait(mut child: Child, limit: Duration) -> End {
    let start = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return ended(status),
            Ok(None) if start.elapsed() < limit => thread::sleep(POLL),
            Ok(None) => {
                let _ = (child.kill(), child.wait());
                return End::Timeout;
            }
            Err(error) => return End::NotStarted(error.to_string()),
        }
    }
}

fn ended(status: ExitStatus) -> End {
    status.code().map_or(End::Signal, End::Code)
}
