//! What reading a chart may take, and how it may end.

use std::fmt;

use crate::{Bounds, Invalid, Plane};

/// The part of a chart that is wanted, and what reading it may take.
#[derive(Clone, Copy)]
pub struct Reading<'a> {
    /// The area on its plane; all of the chart without it.
    pub area: Option<(&'a Plane, &'a Bounds)>,
    /// Most bytes that it may take.
    pub bytes: f64,
    /// Asked every moment or so whether there is time left.
    pub go_on: &'a (dyn Fn() -> bool + Sync),
}

/// Why a chart was not read.
#[derive(Clone, Debug, PartialEq)]
pub enum Unread {
    /// Its file is refused.
    Invalid(Invalid),
    /// It takes more memory than there is.
    TooLarge {
        /// What takes it.
        found: String,
        /// How much \[bytes\].
        bytes: f64,
    },
    /// There was no time left.
    OutOfTime,
}

impl Reading<'static> {
    /// All of a chart, in a gibibyte.
    pub fn whole() -> Self {
        Self { area: None, bytes: f64::from(1 << 30), go_on: &|| true }
    }
}

impl Reading<'_> {
    /// Ends the reading where there is no time left.
    pub(crate) fn check_time(&self) -> Result<(), Unread> {
        if (self.go_on)() { Ok(()) } else { Err(Unread::OutOfTime) }
    }

    /// Refuses what takes more memory than there is, and is called `found`.
    pub(crate) fn check_memory(&self, bytes: f64, found: impl FnOnce() -> String) -> Result<(), Unread> {
        if bytes <= self.bytes { Ok(()) } else { Err(Unread::TooLarge { found: found(), bytes }) }
    }
}

impl Unread {
    /// The same where memory and time are enough as a rule.
    pub(crate) fn into_invalid(self) -> Invalid {
        match self {
            Self::Invalid(invalid) => invalid,
            unread => Invalid::new("chart", unread.to_string(), "less of it", "cut it to the area"),
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
                write!(f, "{found}: {bytes} bytes of memory, more than there are")
            }
            Self::OutOfTime => f.write_str("no time left to read the chart"),
        }
    }
}

impl std::error::Error for Unread {}
