use files::{Columns, Error, TableReader};
use trial::rounds::{Arm, Outcome, Row, Shared};

/// Schema id.
pub const ID: &str = "sequential";
/// Version of the schema.
pub const VERSION: u32 = 1;

/// Reads the whole table.
///
/// # Errors
/// Missing columns, damaged blocks.
pub fn rows(reader: &TableReader, rate_hz: f64) -> Result<Vec<Row>, Error> {
    let blank = Row {
        arm: Arm::Sequential,
        realization: 0,
        round: 0,
        samples: 0,
        shared: Shared::Designed,
        outcome: Outcome::Identified,
        parameter_error: None,
        predicted_error: None,
        expected_error: None,
    };
    columns(rate_hz).read(reader, &blank)
}

/// The table of an arm of a realization at the end of a round, one per row, of runs at `rate_hz`.
pub fn columns(rate_hz: f64) -> Columns<Row> {
    Columns::<Row>::new(ID, VERSION)
        .choice("arm", |r| r.arm, |r, arm: Arm| r.arm = arm)
        .integer("realization", "1", |r| r.realization as i32, |r, number| r.realization = number as u32)
        .integer("round", "1", |r| r.round as i32, |r, round| r.round = round as u32)
        .number(
            "time",
            "s",
            move |r| r.samples as f64 / rate_hz,
            move |r, time| r.samples = (time * rate_hz).round() as usize,
        )
        .choice("shares", |r| r.shared, |r, shared: Shared| r.shared = shared)
        .choice("status", |r| r.outcome, |r, outcome: Outcome| r.outcome = outcome)
        .optional("parameter_error", "1", |r| r.parameter_error, |r, error| r.parameter_error = error)
        .optional("predicted_error", "1", |r| r.predicted_error, |r, error| r.predicted_error = error)
        .optional("expected_error", "1", |r| r.expected_error, |r, error| r.expected_error = error)
}
