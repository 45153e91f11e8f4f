use thiserror::Error;

/// Rows beyond which a clock is taken to have jumped: three years at 1 Hz.
pub(crate) const MOST_ROWS: usize = 100_000_000;

/// Why there is nothing on one clock.
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
    /// There is no moment at which all channels are known: they start after others end, or there is a gap everywhere.
    #[error("no two neighbouring samples at which all channels are known")]
    NoOverlap,
    /// A thruster goes beyond its table.
    #[error("{value} in channel `{channel}`")]
    OutsideTable {
        /// The channel of its speed or pitch.
        channel: String,
        /// The value there.
        value: f64,
        /// What the table spans.
        range: [f64; 2],
    },
    /// The clocks span more rows than may be: one of them jumped, or there is no memory for them.
    #[error("clocks that span {rows} rows")]
    TooLong {
        /// Rows that they span.
        rows: usize,
        /// Rows that may be.
        most: usize,
    },
}
