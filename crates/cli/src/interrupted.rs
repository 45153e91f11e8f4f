//! Ctrl-C and a request to end: unfinished files go, then the process ends as the signal says.

use crate::said::on_stderr;

/// From now on signals that ask to end remove what is unfinished first.
#[cfg(unix)]
pub fn listen() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    // Where the system gives no handler, the signal ends the process as ever; the next start sweeps what it leaves.
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP]) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            artifact::abandon();
            crate::compiler::abandon();
            on_stderr("error: interrupted");
            std::process::exit(128 + signal);
        }
    });
}

#[cfg(not(unix))]
pub fn listen() {}
