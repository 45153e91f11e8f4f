//! Fault injection: places where a test makes writing fail, or the process end. A release build has none.

use std::io;

/// The effect at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// The system refuses.
    Error,
    /// The process is killed.
    Kill,
}

/// Triggers `fault` when the process reaches its `count`-th place, counted from 1, or from the previously
/// requested fault. Only in builds with debug assertions.
pub fn inject(fault: Fault, count: u32) {
    #[cfg(debug_assertions)]
    place::add(fault, count);
    #[cfg(not(debug_assertions))]
    let _ = (fault, count);
}

/// A place: `create`, `write`, `put aside`, `seal`, `flush`, `keep`, `rename`, `give back`, `forget`.
#[cfg(debug_assertions)]
pub(crate) fn point(name: &str) -> io::Result<()> {
    match place::next() {
        None => Ok(()),
        Some(Fault::Error) => Err(io::Error::other(format!("a fault put there by a test ({name})"))),
        Some(Fault::Kill) => std::process::abort(),
    }
}

#[cfg(not(debug_assertions))]
#[inline(always)]
pub(crate) fn point(_: &str) -> io::Result<()> {
    Ok(())
}

#[cfg(debug_assertions)]
mod place {
    use std::collections::VecDeque;
    use std::sync::Mutex;

    use super::Fault;

    static NEXT: Mutex<VecDeque<(Fault, u32)>> = Mutex::new(VecDeque::new());

    pub fn add(fault: Fault, count: u32) {
        NEXT.lock().unwrap_or_else(|e| e.into_inner()).push_back((fault, count));
    }

    /// The fault of the place that is now reached.
    pub fn next() -> Option<Fault> {
        let mut next = NEXT.lock().unwrap_or_else(|e| e.into_inner());
        let (fault, left) = next.front_mut()?;
        *left = left.saturating_sub(1);
        let fault = (*left == 0).then_some(*fault);
        if fault.is_some() {
            next.pop_front();
        }
        fault
    }
}
