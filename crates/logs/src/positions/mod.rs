//! Positions of a ship under way, from a table or from sentences: when and where she was, and what she knew of her
//! heading and speed there.

mod table;

use std::io::BufRead;

use refusal::Invalid;

use crate::nmea::positions_in_sentences;
use crate::position::LoggedPositions;
use crate::{Format, LogError};
use table::positions_in_table;

/// Reads positions from CSV with the columns `time`, `longitude_deg`, `latitude_deg` and, if known, `heading_deg`,
/// `speed_m_s` and the `inputs` of the vessel; or from the sentences RMC, GGA, GNS or GLL of NMEA 0183, with headings from HDT and THS.
///
/// # Errors
/// Bytes that cannot be read, another format, columns that are missing or unknown, numbers out of range, times that do
/// not ascend, no position, positions that end before the log, two receivers.
pub fn read_positions(
    bytes: impl BufRead,
    format: Format,
    inputs: &[&str],
) -> Result<LoggedPositions, LogError> {
    match format {
        Format::Csv => positions_in_table(bytes, inputs),
        Format::Nmea => positions_in_sentences(bytes),
        Format::Parquet | Format::Mcap | Format::Bag | Format::Db3 | Format::Ulg => {
            let expected = "positions as CSV, or as NMEA 0183 in a file called .nmea";
            let remedy = "export longitude and latitude over time";
            Err(Invalid::new("format", "a table or a bag", expected, remedy).into())
        }
    }
}
