//! One run of the command: its options, its watch, its terminal, and the guards that stop it.

use std::mem;
use std::process;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, TryLockError, mpsc};
use std::thread;
use std::time::Duration;

use graticule::watch::{Stopped, Watch};
use serde::Serialize;
use serde_json::Value;

use crate::arguments::{Command, CommonOptions};
use crate::console::{Console, lock};
use crate::failure::Failure;
use crate::output::write_whole;
use crate::report::{Report, to_value};
use crate::signals;

/// How long a computation that was told to stop may go on before the program ends anyway.
/// Factorisations cannot be asked to stop; everything else answers within milliseconds.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Share of a time limit by which it may be overrun for the same reason.
const OVERRUN: f64 = 0.1;

/// What every command needs beside its own options.
pub(crate) struct Session {
    pub(crate) common: CommonOptions,
    pub(crate) console: Arc<Console>,
    pub(crate) watch: Watch,
    writing: Arc<Mutex<()>>,
}

impl Session {
    /// Starts the threads and the guards that the options ask for.
    pub(crate) fn start(common: CommonOptions, console: Arc<Console>) -> Result<Self, Failure> {
        set_threads(&common)?;
        let listener = Arc::clone(&console);
        let mut watch = Watch::new().with_listener(move |event| listener.hear(event));
        let writing = Arc::new(Mutex::new(()));
        if let Some(seconds) = common.max_seconds {
            let limit = Duration::from_secs_f64(seconds);
            watch = watch.with_time_limit(limit);
            end_after(
                limit + limit.mul_f64(OVERRUN).min(PATIENCE),
                Stopped::OutOfTime { limit },
                &console,
                &writing,
            );
        }
        end_on_interrupt(&watch, &console, &writing)?;
        Ok(Self {
            common,
            console,
            watch,
            writing,
        })
    }

    /// A session for a command that runs as a part of this one. The guards of this session stop it,
    /// but between its files, too: they do not see when it is writing.
    pub(crate) fn part(&self, common: CommonOptions) -> Self {
        Self {
            common,
            console: Arc::clone(&self.console),
            watch: self.watch.part(),
            writing: Arc::default(),
        }
    }

    /// Asks whether to go on.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        self.watch.check().map_err(stopped)
    }

    /// What the report tells of the options: those of the command, then the common ones.
    pub(crate) fn options_to_report(&self, options: &impl Serialize) -> Result<Value, Failure> {
        let mut report = to_value(options)?;
        if let (Value::Object(own), Value::Object(common)) = (&mut report, to_value(&self.common)?)
        {
            own.extend(common);
            own.insert("threads".into(), rayon::current_num_threads().into());
        }
        Ok(report)
    }

    /// Writes the report of a run that failed, unless the user stopped it, to where the report was
    /// to go. What goes wrong with that is not told: the failure is.
    pub(crate) fn report_failure(&self, command: &Command, failure: &Failure) {
        if self.watch.check() == Err(Stopped::Cancelled) {
            return;
        }
        let Ok(Value::Object(named)) = to_value(command) else {
            return;
        };
        for (name, options) in named {
            let report = self
                .options_to_report(&options)
                .and_then(|options| Report::failed(name, options, failure).into_json(&self.watch));
            let Ok(json) = report else {
                continue;
            };
            if let Some(path) = &self.common.report {
                let _ = write_whole(path, |out| out.write_all(json.as_bytes()));
            }
            if self.common.json {
                let _ = self.console.data(json.as_bytes());
            }
        }
    }

    /// Asks for the last time whether to go on, then holds off every guard until the program
    /// ends: what is written from here on appears whole.
    pub(crate) fn begin_writing(&self) -> Result<(), Failure> {
        self.check()?;
        mem::forget(lock(&self.writing));
        Ok(())
    }

    /// Whether [`begin_writing`](Self::begin_writing) has succeeded.
    pub(crate) fn is_writing(&self) -> bool {
        is_held(&self.writing)
    }
}

/// The failure that stopping leads to.
fn stopped(reason: Stopped) -> Failure {
    match reason {
        Stopped::Cancelled => Failure::new("interrupted", "nothing was written; run it again"),
        Stopped::OutOfTime { .. } => reason.into(),
    }
}

fn set_threads(common: &CommonOptions) -> Result<(), Failure> {
    let threads = common.threads.unwrap_or(0).into();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build_global().map_err(|error| {
        Failure::new(
            format!("the threads could not be started: {error}"),
            "ask for fewer with --threads",
        )
    })
}

/// Ends the program with `reason` after `delay`, unless results are being written by then.
fn end_after(delay: Duration, reason: Stopped, console: &Arc<Console>, writing: &Arc<Mutex<()>>) {
    let (console, writing) = (Arc::clone(console), Arc::clone(writing));
    thread::spawn(move || {
        thread::sleep(delay);
        let _held = lock(&writing);
        console.failure(&stopped(reason));
        process::exit(1);
    });
}

/// On the first Ctrl-C the computation is asked to stop and made to soon, unless results are being
/// written; on the second the program ends at once, whatever it is doing: files appear by being
/// moved to their place, so that none is half there.
fn end_on_interrupt(
    watch: &Watch,
    console: &Arc<Console>,
    writing: &Arc<Mutex<()>>,
) -> Result<(), Failure> {
    let (sender, receiver) = mpsc::channel();
    let cancel = watch.cancel_handle();
    signals::on_each(move || {
        cancel.cancel();
        let _ = sender.send(());
    })
    .map_err(|error| {
        Failure::new(
            format!("signals such as Ctrl-C could not be listened to: {error}"),
            "run the command outside the program that started it",
        )
    })?;
    let (console, writing) = (Arc::clone(console), Arc::clone(writing));
    thread::spawn(move || {
        if receiver.recv().is_ok() {
            await_end(&receiver, &writing);
            console.failure(&stopped(Stopped::Cancelled));
            process::exit(1);
        }
    });
    Ok(())
}

/// Returns once a second signal came, or the patience is over and nothing is being written.
fn await_end(signals: &Receiver<()>, writing: &Mutex<()>) {
    while signals.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
        if !is_held(writing) {
            return;
        }
    }
}

fn is_held(mutex: &Mutex<()>) -> bool {
    matches!(mutex.try_lock(), Err(TryLockError::WouldBlock))
}
