use thiserror::Error;

/// Rows beyond which a clock is taken to have jumped: three years at 1 Hz.
pub(crate) const MOST_ROWS: usize = 100_000_000;

/// Why channels could not be put on one clock.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Unassembled {
    /// A channel is missing.
    #[error("no channel `{0}`")]
    NoChannel(String),
    /// A channel has no value at all.
    #[error("no value in channel `{0}`")]
    Empty(String),
    /// Geographic positions that start beyond 89° of latitude, where a plane has no north.
    #[error("positions that start beyond 89 deg of latitude")]
    NoPlane,
    /// There is no time at which all channels are known: they start after others end, or there is a gap
    /// everywhere.
    #[error("no two neighbouring samples at which all channels are known")]
    NoOverlap,
    /// A thruster leaves its table.
    #[error("{value} in channel `{channel}`")]
    OutsideTable {
        /// The channel of its speed or pitch.
        channel: String,
        /// The value there.
        value: f64,
        /// The table's range.
        range: [f64; 2],
    },
    /// The clocks span more rows than allowed: one of them jumped, or memory does not suffice.
    #[error("clocks that span {rows} rows")]
    TooLong {
        /// Rows that they span.
        rows: usize,
        /// The most rows allowed.
        most: usize,
    },
}
