//! One run of the command: its options, its watch, its terminal, and the guards that stop it.

use std::mem;
use std::process;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread;
use std::time::Duration;

use graticule::watch::{Stopped, Watch};
use serde::Serialize;
use serde_json::Value;

use crate::arguments::CommonOptions;
use crate::console::Console;
use crate::failure::Failure;
use crate::report::to_value;

/// How long a computation that was told to stop may go on before the program ends anyway.
/// Factorisations cannot be asked to stop; everything else answers within milliseconds.
const PATIENCE: Duration = Duration::from_millis(1500);

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
                limit + PATIENCE,
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
        }
        Ok(report)
    }

    /// Asks for the last time whether to go on, then holds off every guard until the program
    /// ends: what is written from here on appears whole.
    pub(crate) fn begin_writing(&self) -> Result<(), Failure> {
        self.check()?;
        mem::forget(lock(&self.writing));
        Ok(())
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

/// On the first Ctrl-C the computation is asked to stop and made to soon; on the second it ends.
fn end_on_interrupt(
    watch: &Watch,
    console: &Arc<Console>,
    writing: &Arc<Mutex<()>>,
) -> Result<(), Failure> {
    let (sender, receiver) = mpsc::channel();
    let cancel = watch.cancel_handle();
    ctrlc::set_handler(move || {
        cancel.cancel();
        let _ = sender.send(());
    })
    .map_err(|error| {
        Failure::new(
            format!("the handler for Ctrl-C could not be set: {error}"),
            "run the command outside the program that started it",
        )
    })?;
    let (console, writing) = (Arc::clone(console), Arc::clone(writing));
    thread::spawn(move || {
        if receiver.recv().is_ok() {
            let _ = receiver.recv_timeout(PATIENCE);
            let _held = lock(&writing);
            console.failure(&stopped(Stopped::Cancelled));
            process::exit(1);
        }
    });
    Ok(())
}

fn lock(mutex: &Mutex<()>) -> MutexGuard<'_, ()> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
