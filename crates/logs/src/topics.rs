//! Bags: a topic is a table, whose rows are its messages and whose columns are their fields (`twist.twist.linear.x`).

use std::io::Read;
use std::sync::Arc;

use crate::bag::{BagError, DatabaseFile, Message, Topic, Wanted};
use refusal::Invalid;

use crate::{Cells, Columns, Content, FileSpec, Format, LogError, Plan, Store};

/// The times that every message has besides its fields.
pub const LOG_TIME: &str = "log_time";
/// See [`LOG_TIME`].
pub const PUBLISH_TIME: &str = "publish_time";

/// Reads the fields of messages that `plan` wants of the topic of group `group`; `store` takes blocks of
/// numbers. Rows are numbered like the topic's messages. `format` is one of those that are read from beginning to end.
///
/// # Errors
/// What [`crate::bag::each_message`] refuses; too many messages.
pub fn read_bag(
    mut bytes: impl Read,
    format: Format,
    plan: &Plan,
    group: usize,
    store: Option<&Arc<dyn Store>>,
) -> Result<Columns, LogError> {
    read(plan, group, store, |wanted, each| crate::bag::each_message(&mut bytes, kind(format), wanted, each))
}

/// As [`read_bag`], of a bag in SQLite.
///
/// # Errors
/// As [`read_bag`].
pub fn read_database(
    file: &DatabaseFile,
    plan: &Plan,
    group: usize,
    store: Option<&Arc<dyn Store>>,
) -> Result<Columns, LogError> {
    read(plan, group, store, |wanted, each| crate::bag::each_message_of_database(file, wanted, each))
}

/// Reads the wanted fields of a topic, whose messages `pass` passes on.
fn read(
    plan: &Plan,
    group: usize,
    store: Option<&Arc<dyn Store>>,
    pass: impl FnOnce(&Wanted, &mut dyn FnMut(Message) -> Result<(), Invalid>) -> Result<(), BagError>,
) -> Result<Columns, LogError> {
    let (clock, paths) = columns(plan, group);
    let mut reading = Reading::new(plan, clock, store, group);
    let spec = &plan.setup.files[group];
    let topic = spec.topic.as_deref().unwrap_or_default();
    let wanted = Wanted { topic, publisher: spec.publisher.as_deref(), paths: &paths, memory: plan.memory };
    pass(&wanted, &mut |message| reading.take(&message))?;
    Ok(reading.made)
}

/// The topics of a bag and the first of their messages, by means of `memory` bytes; `format` as in [`read_bag`].
///
/// # Errors
/// Bytes that cannot be read or are not a bag.
pub fn bag_census(mut bytes: impl Read, format: Format, memory: f64) -> Result<Vec<Topic>, LogError> {
    Ok(crate::bag::census(&mut bytes, kind(format), memory)?)
}

/// As [`bag_census`], of a bag in SQLite.
///
/// # Errors
/// As [`bag_census`].
pub fn database_census(file: &DatabaseFile, memory: f64) -> Result<Vec<Topic>, LogError> {
    Ok(crate::bag::census_of_database(file, memory)?)
}

fn kind(format: Format) -> crate::bag::Format {
    match format {
        Format::Bag => crate::bag::Format::Ros1,
        Format::Ulg => crate::bag::Format::ULog,
        _ => crate::bag::Format::Mcap,
    }
}

/// The clock of group `group`, and the paths to the fields of its time and of its channels.
fn columns(plan: &Plan, group: usize) -> (Time, Vec<String>) {
    let clock = Time::of(&plan.setup.files[group]);
    let mut paths: Vec<String> = plan.wanted(group).into_iter().map(|wanted| wanted.column).collect();
    match clock {
        Time::Logged | Time::Published => drop(paths.remove(0)),
        Time::Stamp => {
            let stamp = paths.remove(0);
            paths.splice(0..0, [format!("{stamp}.sec"), format!("{stamp}.nanosec")]);
        }
        Time::Field => {}
    }
    (clock, paths)
}

/// The source of a message's time.
#[derive(Clone, Copy, PartialEq)]
enum Time {
    Logged,
    Published,
    /// Two fields, seconds and nanoseconds.
    Stamp,
    /// An ordinary field.
    Field,
}

impl Time {
    fn of(spec: &FileSpec) -> Self {
        match spec.time.column.as_str() {
            LOG_TIME => Self::Logged,
            PUBLISH_TIME => Self::Published,
            _ if spec.time.unit.is_none() => Self::Stamp,
            _ => Self::Field,
        }
    }
}

struct Reading<'a> {
    plan: &'a Plan,
    clock: Time,
    made: Columns,
}

impl<'a> Reading<'a> {
    fn new(plan: &'a Plan, clock: Time, store: Option<&Arc<dyn Store>>, group: usize) -> Self {
        let cells = plan.wanted(group).iter().map(|_| Cells::none(Content::Numbers, store)).collect();
        Self { plan, clock, made: Columns { cells, ..Columns::default() } }
    }

    fn take(&mut self, message: &Message) -> Result<(), Invalid> {
        let number = self.made.lines.rows() + 1;
        if number > self.plan.most_rows {
            return Err(self.plan.too_many_rows(number));
        }
        let row = message.values;
        let (time, fields) = match self.clock {
            Time::Logged => (seconds(message.log_time), row),
            Time::Published => (seconds(message.publish_time), row),
            Time::Stamp => (row[0] + 1e-9 * row[1], &row[2..]),
            Time::Field => (row[0], &row[1..]),
        };
        self.made.lines.push(number);
        for (cells, value) in self.made.cells.iter_mut().zip([&time].into_iter().chain(fields)) {
            if let Cells::Numbers(numbers) = cells {
                numbers.push(*value);
            }
        }
        Ok(())
    }
}

/// Whole nanoseconds since 1970 in seconds: a number cannot hold all of their digits at once.
fn seconds(nanoseconds: u64) -> f64 {
    const SECOND: u64 = 1_000_000_000;
    (nanoseconds / SECOND) as f64 + 1e-9 * (nanoseconds % SECOND) as f64
}
