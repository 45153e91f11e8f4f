use thiserror::Error;

/// Why the available maneuvers are not enough for an experiment.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Scarce {
    /// Segments are limited, and the experiment has none.
    #[error("whole segments are limited, but the experiment has none")]
    NoSegments,
    /// Seconds are limited, and the length of the experiment is not known.
    #[error("seconds are limited, but the length of the experiment is not known")]
    NoLength,
    /// All maneuvers together do not fill the experiment.
    #[error("what is available fills {share} of the experiment")]
    Time {
        /// The share of the experiment that they fill, below 1.
        share: f64,
    },
    /// All maneuvers together have too few whole segments.
    #[error("{found} of {expected} whole segments are available")]
    Segments {
        /// Whole segments that are available.
        found: u128,
        /// Whole segments of the experiment.
        expected: u64,
    },
}
