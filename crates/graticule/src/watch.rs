//! Progress, cancellation, warnings and stage times of a running computation.
//!
//! A [`Watch`] goes by reference through every call that may take long. The callee names its
//! stages, asks now and then whether to go on, and leaves warnings about anything that the result
//! alone does not show, such as a fallback. The caller decides what to do with all that.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;

/// The computation was stopped before it had a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Stopped {
    /// The caller asked for it through a [`CancelHandle`].
    #[error("cancelled")]
    Cancelled,
    /// The time allowed has run out.
    #[error("the time limit of {} s was reached", limit.as_secs_f64())]
    OutOfTime {
        /// The time that was allowed.
        limit: Duration,
    },
}

impl crate::Hint for Stopped {
    fn hint(&self) -> Option<String> {
        match self {
            Self::Cancelled => None,
            Self::OutOfTime { .. } => Some("allow more time, or simplify the mesh first".into()),
        }
    }
}

/// Something about a result that its user should know and cannot see in the result itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// Stable kebab-case name, for programs.
    pub code: &'static str,
    /// One sentence of fact, for people.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)
    }
}

/// Time spent in one named stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageTime {
    /// Name of the stage, as given to [`Watch::stage`].
    pub name: &'static str,
    /// Wall-clock seconds, stages nested inside included.
    pub seconds: f64,
    /// Number of stages around this one.
    pub depth: usize,
}

/// What a listener hears.
#[derive(Clone, Debug, PartialEq)]
pub enum Event<'a> {
    /// A stage begins.
    StageBegan(&'static str),
    /// A stage ended.
    StageEnded(&'a StageTime),
    /// Share of the innermost stage that is done, in `0.0..=1.0`.
    Progress(f64),
    /// A warning was left.
    Warned(&'a Warning),
}

/// Stops a computation from another thread.
#[derive(Clone, Debug, Default)]
pub struct CancelHandle(Arc<AtomicBool>);

impl CancelHandle {
    /// Asks the computation to stop at its next [`Watch::check`].
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

type Listener = Box<dyn Fn(&Event<'_>) + Send + Sync>;

#[derive(Default)]
struct Journal {
    warnings: Vec<Warning>,
    stages: Vec<StageTime>,
    open: usize,
}

/// The observer of a running computation. See the [module](self).
#[derive(Default)]
pub struct Watch {
    cancel: CancelHandle,
    deadline: Option<(Instant, Duration)>,
    listener: Option<Listener>,
    journal: Mutex<Journal>,
}

impl Watch {
    /// A watch without listener and time limit; it still keeps warnings and times.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sends every event to `listener`, which must be quick.
    #[must_use]
    pub fn with_listener(mut self, listener: impl Fn(&Event<'_>) + Send + Sync + 'static) -> Self {
        self.listener = Some(Box::new(listener));
        self
    }

    /// Makes [`check`](Self::check) fail once `limit` has passed from now.
    #[must_use]
    pub fn with_time_limit(mut self, limit: Duration) -> Self {
        self.deadline = Some((Instant::now(), limit));
        self
    }

    /// A handle that stops this computation.
    #[must_use]
    pub fn cancel_handle(&self) -> CancelHandle {
        self.cancel.clone()
    }

    /// A watch that stops when this one does, with stages and warnings of its own: for one of many
    /// small parts.
    pub(crate) fn of_part(&self) -> Self {
        Self {
            cancel: self.cancel.clone(),
            deadline: self.deadline,
            ..Self::default()
        }
    }

    /// Asks whether to go on. Cheap: call it at least every few milliseconds of work.
    ///
    /// # Errors
    /// [`Stopped`] once the computation was cancelled or its time has run out.
    pub fn check(&self) -> Result<(), Stopped> {
        if self.cancel.0.load(Ordering::Relaxed) {
            return Err(Stopped::Cancelled);
        }
        match self.deadline {
            Some((start, limit)) if start.elapsed() > limit => Err(Stopped::OutOfTime { limit }),
            _ => Ok(()),
        }
    }

    /// Begins a named stage, which ends when the returned guard is dropped.
    #[must_use = "the stage ends when the guard is dropped"]
    pub fn stage(&self, name: &'static str) -> Stage<'_> {
        self.tell(&Event::StageBegan(name));
        let depth = self.with_journal(|journal| {
            journal.open += 1;
            journal.open - 1
        });
        Stage {
            watch: self,
            name,
            depth,
            start: Instant::now(),
        }
    }

    /// Tells which share of the innermost stage is done, in `0.0..=1.0`.
    pub fn progress(&self, share: f64) {
        self.tell(&Event::Progress(share));
    }

    /// Leaves a warning. `code` is a stable kebab-case name.
    pub fn warn(&self, code: &'static str, message: impl Into<String>) {
        let warning = Warning {
            code,
            message: message.into(),
        };
        self.tell(&Event::Warned(&warning));
        self.with_journal(|journal| journal.warnings.push(warning));
    }

    /// The warnings left so far, oldest first.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        self.with_journal(|journal| journal.warnings.clone())
    }

    /// The stages that have ended so far, in the order they ended.
    #[must_use]
    pub fn stage_times(&self) -> Vec<StageTime> {
        self.with_journal(|journal| journal.stages.clone())
    }

    fn tell(&self, event: &Event<'_>) {
        if let Some(listener) = &self.listener {
            listener(event);
        }
    }

    fn with_journal<T>(&self, action: impl FnOnce(&mut Journal) -> T) -> T {
        // A panic of another holder cannot leave the journal half-written: every action is one push.
        action(&mut self.journal.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl fmt::Debug for Watch {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Watch")
            .field("deadline", &self.deadline)
            .finish_non_exhaustive()
    }
}

/// A running stage; see [`Watch::stage`].
#[derive(Debug)]
pub struct Stage<'a> {
    watch: &'a Watch,
    name: &'static str,
    depth: usize,
    start: Instant,
}

impl Drop for Stage<'_> {
    fn drop(&mut self) {
        let seconds = self.start.elapsed().as_secs_f64();
        let time = StageTime {
            name: self.name,
            seconds,
            depth: self.depth,
        };
        self.watch.tell(&Event::StageEnded(&time));
        self.watch.with_journal(|journal| {
            journal.open -= 1;
            journal.stages.push(time);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_stages_know_their_depth_and_end_inside_out() {
        let watch = Watch::new();
        {
            let _outer = watch.stage("outer");
            let _inner = watch.stage("inner");
        }
        let ended: Vec<_> = watch
            .stage_times()
            .iter()
            .map(|s| (s.name, s.depth))
            .collect();
        assert_eq!(ended, [("inner", 1), ("outer", 0)]);
    }

    #[test]
    fn cancelling_stops_the_next_check() {
        let watch = Watch::new();
        assert_eq!(watch.check(), Ok(()));
        watch.cancel_handle().cancel();
        assert_eq!(watch.check(), Err(Stopped::Cancelled));
    }

    #[test]
    fn a_limit_of_nothing_is_over_at_once() {
        let watch = Watch::new().with_time_limit(Duration::ZERO);
        assert_eq!(
            watch.check(),
            Err(Stopped::OutOfTime {
                limit: Duration::ZERO
            })
        );
    }

    #[test]
    fn the_listener_hears_warnings_and_the_journal_keeps_them() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let ear = Arc::clone(&heard);
        let watch = Watch::new().with_listener(move |event| {
            if let Event::Warned(warning) = event {
                ear.lock().unwrap().push(warning.code);
            }
        });
        watch.warn("test-warning", "something happened");
        assert_eq!(*heard.lock().unwrap(), ["test-warning"]);
        assert_eq!(watch.warnings()[0].message, "something happened");
    }
}
