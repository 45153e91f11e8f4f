use refusal::Invalid;
use thiserror::Error;

/// Why a trial cannot be simulated, by the part at fault.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Refusal {
    /// The vessel: a parameter without a true value, a motion that diverges.
    #[error("vessel: {0}")]
    Vessel(Invalid),
    /// The dictionary: a motion that the model cannot hold, limits that no maneuver keeps.
    #[error("dictionary: {0}")]
    Dictionary(Invalid),
    /// The campaign's numbers.
    #[error("campaign: {0}")]
    Campaign(Invalid),
    /// The current or the wind, if the vessel diverges only in these.
    #[error("sea: {0}")]
    Sea(Invalid),
    /// The design's shares or order.
    #[error("design: {0}")]
    Design(Invalid),
    /// The design has a maneuver that the dictionary does not have.
    #[error("design: found maneuver `{name}`, which the dictionary does not have")]
    UnknownManeuver {
        /// Its name.
        name: String,
        /// Whether it is in the design's order, or else in its shares.
        ordered: bool,
    },
    /// The design's order is for an experiment of another length.
    #[error("design: found an order of {ordered} samples, expected {samples}")]
    OtherLength {
        /// Samples of the order.
        ordered: usize,
        /// Samples of a run.
        samples: usize,
    },
}
