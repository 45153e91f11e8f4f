//! Fault injection: a place where a test makes writing fail, or the process end. A release build has none.

use std::io;

/// The effect at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// The system refuses.
    Error,
    /// The process is killed.
    Kill,
}

#[cfg(debug_assertions)]
static NEXT: std::sync::Mutex<Option<(Fault, u32)>> = std::sync::Mutex::new(None);

/// Triggers `fault` when the process reaches its `count`-th place, counted from 1. Only in builds with debug assertions.
pub fn inject(fault: Fault, count: u32) {
    #[cfg(debug_assertions)]
    if let Ok(mut next) = NEXT.lock() {
        *next = Some((fault, count));
    }
    #[cfg(not(debug_assertions))]
    let _ = (fault, count);
}

/// A place: `create`, `write`, `put aside`, `seal`, `flush`, `rename`.
#[cfg(debug_assertions)]
pub(crate) fn point(name: &str) -> io::Result<()> {
    let Ok(mut next) = NEXT.lock() else { return Ok(()) };
    let Some((_, left)) = next.as_mut() else { return Ok(()) };
    *left = left.saturating_sub(1);
    if *left > 0 {
        return Ok(());
    }
    match next.take() {
        Some((Fault::Kill, _)) => std::process::abort(),
        _ => Err(io::Error::other(format!("a fault put there by a test ({name})"))),
    }
}

#[cfg(not(debug_assertions))]
#[inline(always)]
pub(crate) fn point(_: &str) -> io::Result<()> {
    Ok(())
}
