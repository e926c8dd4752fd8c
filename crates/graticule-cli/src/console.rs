//! What goes to the terminal: progress, warnings, errors on standard error, data on standard
//! output.

use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use graticule::watch::Event;
use indicatif::{ProgressBar, ProgressStyle};

use crate::failure::Failure;

/// Steps of a progress bar from nothing to all.
const BAR_STEPS: u64 = 1000;

/// Standard error and standard output, as the user wants them.
pub(crate) struct Console {
    quiet: bool,
    color: bool,
    start: Instant,
    depth: AtomicUsize,
    bar: Option<ProgressBar>,
    /// Whether a failure was told, which is the last line.
    ended: Mutex<bool>,
}

impl Console {
    /// Looks at the terminal and at `NO_COLOR`.
    pub(crate) fn new(quiet: bool) -> Self {
        let terminal = io::stderr().is_terminal() && !is_set("TERM", "dumb");
        let no_color = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        Self {
            quiet,
            color: terminal && !no_color,
            start: Instant::now(),
            depth: AtomicUsize::new(0),
            bar: (terminal && !quiet).then(|| ProgressBar::new(BAR_STEPS).with_style(spinner())),
            ended: Mutex::new(false),
        }
    }

    /// Shows what a running computation tells.
    pub(crate) fn hear(&self, event: &Event<'_>) {
        match event {
            Event::StageBegan(name) => self.stage_began(name),
            Event::StageEnded(_) => {
                self.depth.fetch_sub(1, Ordering::Relaxed);
            }
            Event::Progress(share) => self.progressed(*share),
            Event::Warned(warning) => self.labelled("warning", "33", &warning.message),
        }
    }

    fn stage_began(&self, name: &'static str) {
        let depth = self.depth.fetch_add(1, Ordering::Relaxed);
        if let Some(bar) = &self.bar {
            bar.set_style(spinner());
            bar.set_position(0);
            bar.reset_eta();
            bar.set_message(name);
            bar.enable_steady_tick(Duration::from_millis(120));
        } else if depth == 0 {
            self.line(&format!(
                "[{:7.2} s] {name}",
                self.start.elapsed().as_secs_f64()
            ));
        }
    }

    fn progressed(&self, share: f64) {
        if let Some(bar) = &self.bar {
            if bar.position() == 0 {
                bar.set_style(shares());
            }
            #[allow(clippy::cast_sign_loss)] // clamped
            bar.set_position((share.clamp(0.0, 1.0) * BAR_STEPS as f64) as u64);
        }
    }

    /// A line to standard error, unless the user wants quiet.
    pub(crate) fn line(&self, text: &str) {
        let ended = lock(&self.ended);
        if !self.quiet && !*ended {
            self.above_bar(|| eprintln_lossy(text));
        }
    }

    /// Tells of a failure: one line of fact, one of advice, even to a user who wants quiet.
    ///
    /// A guard that ends the program and the work that it ends may both come here: the first is
    /// heard, and nothing after it.
    pub(crate) fn failure(&self, failure: &Failure) {
        let mut ended = lock(&self.ended);
        if std::mem::replace(&mut *ended, true) {
            return;
        }
        self.finish();
        eprintln_lossy(&self.label("error", "1;31", &failure.fact));
        eprintln_lossy(&self.label("hint", "36", &failure.hint));
    }

    fn labelled(&self, label: &str, color: &str, text: &str) {
        self.line(&self.label(label, color, text));
    }

    fn label(&self, label: &str, color: &str, text: &str) -> String {
        if self.color {
            format!("\x1b[{color}m{label}:\x1b[0m {text}")
        } else {
            format!("{label}: {text}")
        }
    }

    /// Takes the progress bar away.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn above_bar(&self, action: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(action),
            None => action(),
        }
    }

    /// Data to standard output. A reader that has gone away, such as `head`, is no failure.
    pub(crate) fn data(&self, bytes: &[u8]) -> Result<(), Failure> {
        self.finish();
        let mut out = io::stdout().lock();
        match out.write_all(bytes).and_then(|()| out.flush()) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::new(
                format!("standard output could not be written: {error}"),
                "send it to another place, or name an output file",
            )),
            _ => Ok(()),
        }
    }
}

/// A line to standard error. Where nobody can read it there is nobody to tell so either.
fn eprintln_lossy(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

fn is_set(variable: &str, value: &str) -> bool {
    std::env::var_os(variable).is_some_and(|found| found == value)
}

fn spinner() -> ProgressStyle {
    style("{spinner} {msg} {elapsed}")
}

fn shares() -> ProgressStyle {
    style("{spinner} {msg} {bar:30} {percent:>3} %, about {eta} left")
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// What a panic under the lock left is taken as it is.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
