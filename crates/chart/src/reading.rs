//! The limits of reading a chart, and how it may end.

use std::fmt;

use crate::{Bounds, Invalid, Plane};

/// The requested part of a chart, and the limits of reading it.
#[derive(Clone, Copy)]
pub struct Reading<'a> {
    /// The area on its plane; without it the whole chart.
    pub area: Option<(&'a Plane, &'a Bounds)>,
    /// Most bytes of memory.
    pub bytes: f64,
    /// Polled regularly; reading stops once it returns false.
    pub keep_going: &'a (dyn Fn() -> bool + Sync),
}

/// Why a chart was not read.
#[derive(Clone, Debug, PartialEq)]
pub enum Unread {
    /// Its file is refused.
    Invalid(Invalid),
    /// It exceeds the memory.
    TooLarge {
        /// What needs it.
        found: String,
        /// How much \[bytes\].
        bytes: f64,
    },
    /// The time limit was reached.
    OutOfTime,
}

impl Reading<'static> {
    /// The whole chart, in a gibibyte.
    pub fn whole() -> Self {
        Self { area: None, bytes: f64::from(1 << 30), keep_going: &|| true }
    }
}

impl Reading<'_> {
    /// Stops reading at the time limit.
    pub(crate) fn check_time(&self) -> Result<(), Unread> {
        if (self.keep_going)() { Ok(()) } else { Err(Unread::OutOfTime) }
    }

    /// Refuses to use `bytes` for `found` if they exceed the limit.
    pub(crate) fn check_memory(&self, bytes: f64, found: impl FnOnce() -> String) -> Result<(), Unread> {
        if bytes <= self.bytes { Ok(()) } else { Err(Unread::TooLarge { found: found(), bytes }) }
    }
}

impl Unread {
    /// As a refusal, where memory and time normally suffice.
    pub(crate) fn into_invalid(self) -> Invalid {
        match self {
            Self::Invalid(invalid) => invalid,
            unread => Invalid::new("chart", unread.to_string(), "a smaller area", "cut it to the area"),
        }
    }
}

impl From<Invalid> for Unread {
    fn from(invalid: Invalid) -> Self {
        Self::Invalid(invalid)
    }
}

impl fmt::Display for Unread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Invalid(invalid) => invalid.fmt(f),
            Self::TooLarge { found, bytes } => {
                write!(f, "{found}: {bytes} bytes of memory, more than are available")
            }
            Self::OutOfTime => f.write_str("the time limit was reached while reading the chart"),
        }
    }
}

impl std::error::Error for Unread {}
