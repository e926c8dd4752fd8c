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

/// Time spent in one named stage, or in all of this name within the same stage around them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageTime {
    /// Name of the stage, as given to [`Watch::stage`].
    pub name: &'static str,
    /// Wall-clock seconds, stages nested inside included.
    pub seconds: f64,
    /// Number of stages around this one.
    pub depth: usize,
    /// How many stages these are the seconds of.
    pub runs: usize,
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

type Listener = Arc<dyn Fn(&Event<'_>) + Send + Sync>;

#[derive(Default)]
struct Journal {
    warnings: Vec<Warning>,
    /// Stages that ended inside no other one.
    ended: Vec<Ended>,
    /// Stages that have not ended, outermost first.
    open: Vec<Open>,
    begun: usize,
}

/// A stage that has not ended.
struct Open {
    number: usize,
    inside: Vec<Ended>,
}

/// Stages of one name that have ended, each a run; what ran inside them is merged likewise, so that
/// a journal is as long as there are different stages, however often they run.
struct Ended {
    name: &'static str,
    seconds: f64,
    runs: usize,
    inside: Vec<Ended>,
}

impl Journal {
    fn begin(&mut self) -> (usize, usize) {
        let (number, depth) = (self.begun, self.open.len());
        self.begun += 1;
        self.open.push(Open {
            number,
            inside: Vec::new(),
        });
        (number, depth)
    }

    fn end(&mut self, number: usize, name: &'static str, seconds: f64) {
        // Stages of several threads need not end in the order they began.
        let place = self.open.iter().rposition(|open| open.number == number);
        let Some(place) = place else { return };
        let Open { inside, .. } = self.open.remove(place);
        let around = match place.checked_sub(1) {
            Some(outer) => &mut self.open[outer].inside,
            None => &mut self.ended,
        };
        let runs = 1;
        merge(
            around,
            Ended {
                name,
                seconds,
                runs,
                inside,
            },
        );
    }

    fn times(&self) -> Vec<StageTime> {
        let mut times = Vec::new();
        list(&self.ended, 0, &mut times);
        for (depth, open) in self.open.iter().enumerate() {
            list(&open.inside, depth + 1, &mut times);
        }
        times
    }
}

fn merge(stages: &mut Vec<Ended>, stage: Ended) {
    let Some(same) = stages.iter_mut().find(|other| other.name == stage.name) else {
        stages.push(stage);
        return;
    };
    same.seconds += stage.seconds;
    same.runs += stage.runs;
    for inner in stage.inside {
        merge(&mut same.inside, inner);
    }
}

/// Lists stages after those inside them.
fn list(stages: &[Ended], depth: usize, times: &mut Vec<StageTime>) {
    for stage in stages {
        list(&stage.inside, depth + 1, times);
        times.push(StageTime {
            name: stage.name,
            seconds: stage.seconds,
            depth,
            runs: stage.runs,
        });
    }
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
        self.listener = Some(Arc::new(listener));
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

    /// A watch over a part of the work: it stops when this one does and tells the same listener, but
    /// keeps warnings and times of its own.
    #[must_use]
    pub fn part(&self) -> Self {
        Self {
            cancel: self.cancel.clone(),
            deadline: self.deadline,
            listener: self.listener.clone(),
            journal: Mutex::default(),
        }
    }

    /// The same without a listener: for one of many small parts.
    pub(crate) fn quiet_part(&self) -> Self {
        Self {
            listener: None,
            ..self.part()
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
        let (number, depth) = self.with_journal(Journal::begin);
        Stage {
            watch: self,
            name,
            number,
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

    /// The stages that have ended so far, each after those inside it, else in the order of their
    /// first ends; those of one name inside one stage, or inside several of one name, are one entry.
    #[must_use]
    pub fn stage_times(&self) -> Vec<StageTime> {
        self.with_journal(|journal| journal.times())
    }

    fn tell(&self, event: &Event<'_>) {
        if let Some(listener) = &self.listener {
            listener(event);
        }
    }

    fn with_journal<T>(&self, action: impl FnOnce(&mut Journal) -> T) -> T {
        // A panic of another holder leaves no more than a stage out.
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
    number: usize,
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
            runs: 1,
        };
        self.watch.tell(&Event::StageEnded(&time));
        self.watch
            .with_journal(|journal| journal.end(self.number, self.name, seconds));
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
    fn stages_that_run_often_are_told_once() {
        let watch = Watch::new();
        for island in 0..1000 {
            let _map = watch.stage("map");
            let _start = watch.stage("start");
            drop(watch.stage("factor"));
            if island % 2 == 0 {
                drop(watch.stage("again"));
            }
        }
        let _open = watch.stage("write");
        drop(watch.stage("factor"));
        let times = watch.stage_times();
        let told: Vec<_> = times.iter().map(|s| (s.name, s.depth, s.runs)).collect();
        let expected = [
            ("factor", 2, 1000),
            ("again", 2, 500),
            ("start", 1, 1000),
            ("map", 0, 1000),
            ("factor", 1, 1),
        ];
        assert_eq!(told, expected);
        let [start, map] = [times[2].seconds, times[3].seconds];
        assert!(0.0 < start && start <= map, "{start} {map}");
    }

    #[test]
    fn stages_that_end_out_of_order_are_all_told() {
        let watch = Watch::new();
        let [first, second] = [watch.stage("first"), watch.stage("second")];
        drop(first);
        drop(second);
        let names: Vec<_> = watch.stage_times().iter().map(|s| s.name).collect();
        assert_eq!(names, ["first", "second"]);
    }

    #[test]
    fn cancelling_stops_the_next_check() {
        let watch = Watch::new();
        assert_eq!(watch.check(), Ok(()));
        watch.cancel_handle().cancel();
        assert_eq!(watch.check(), Err(Stopped::Cancelled));
    }

    #[test]
    fn a_part_stops_with_the_whole_and_keeps_its_own_warnings() {
        let whole = Watch::new();
        whole.warn("whole", "before");
        let part = whole.part();
        part.warn("part", "within");
        assert_eq!(part.warnings()[0].code, "part");
        assert_eq!(whole.warnings().len(), 1);
        whole.cancel_handle().cancel();
        assert_eq!(part.check(), Err(Stopped::Cancelled));
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
