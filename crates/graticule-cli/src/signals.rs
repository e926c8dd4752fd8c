//! Signals that ask the program to end.

use std::io;

/// Calls `react` on each such signal, on a thread of its own. Signals that the program was started
/// to ignore stay ignored: `nohup` does that for the one of a closed terminal.
#[cfg(unix)]
pub(crate) fn on_each(react: impl Fn() + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = ignored_signals();
    let heeded = [SIGHUP, SIGINT, SIGTERM].into_iter();
    let heeded = heeded.filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let mut signals = signal_hook::iterator::Signals::new(heeded)?;
    std::thread::spawn(move || signals.forever().for_each(|_| react()));
    Ok(())
}

/// Calls `react` on each Ctrl-C.
#[cfg(not(unix))]
pub(crate) fn on_each(react: impl Fn() + Send + 'static) -> io::Result<()> {
    ctrlc::set_handler(react).map_err(io::Error::other)
}

/// A bit for each signal that is ignored, the first one lowest, where the system tells (Linux).
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}
