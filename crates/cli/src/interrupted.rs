//! Handles Ctrl-C and termination: removes unfinished files, then ends the process by the signal.

use crate::said::on_stderr;

/// Installs the handler, so that signals first remove unfinished files.
#[cfg(unix)]
pub fn listen() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    // Without a handler the signal ends the process as usual; the next start removes the files that it leaves.
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP]) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            files::abandon();
            crate::compiler::abandon();
            on_stderr("error: interrupted");
            std::process::exit(128 + signal);
        }
    });
}

#[cfg(not(unix))]
pub fn listen() {}
