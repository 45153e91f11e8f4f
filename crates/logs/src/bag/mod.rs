//! Logs of ROS 2 in MCAP bags: the messages of one topic, whose fields are columns (`twist.twist.linear.x`).
//!
//! The crate `mcap` finds the records; they are parsed and chunks decompressed here, where their lengths are
//! not trusted. Messages are decoded by the definition in the bag (`ros2msg`), or they are JSON.

mod cdr;
mod channels;
mod decoder;
mod definition;
mod fields;
mod json;
mod parts;
mod records;

use std::collections::BTreeSet;
use std::io::Read;
use std::sync::Arc;

use refusal::{Invalid, foreign, nearest};

use crate::columns::some_of;
use crate::{Cells, Columns, Content, LogError, Plan, Store};
use channels::{Channels, Schemas};
use parts::Part;
use records::each_record;

/// The times that every message has besides its fields.
pub const LOG_TIME: &str = "log_time";
/// See [`LOG_TIME`].
pub const PUBLISH_TIME: &str = "publish_time";

/// Reads the fields of messages that `plan` wants of the topic of group `group`; `store` takes blocks of
/// numbers. Rows are numbered like the topic's messages.
///
/// # Errors
/// Bytes that cannot be read or are not a bag, an unknown topic, encoding or field, messages shorter than
/// their definition, several publishers of which none is named.
pub fn read_bag(
    bytes: impl Read,
    plan: &Plan,
    group: usize,
    store: Option<&Arc<dyn Store>>,
) -> Result<Columns, LogError> {
    let spec = &plan.setup.files[group];
    let wanted = plan.wanted(group);
    let cells = wanted.iter().map(|_| Cells::none(Content::Numbers, store)).collect();
    let clock = match spec.time.column.as_str() {
        LOG_TIME => Time::Logged,
        PUBLISH_TIME => Time::Published,
        _ if spec.time.unit.is_none() => Time::Stamp,
        _ => Time::Field,
    };
    let mut paths: Vec<String> = wanted.into_iter().map(|wanted| wanted.column).collect();
    match clock {
        Time::Logged | Time::Published => drop(paths.remove(0)),
        Time::Stamp => {
            let stamp = paths.remove(0);
            paths.splice(0..0, [format!("{stamp}.sec"), format!("{stamp}.nanosec")]);
        }
        Time::Field => {}
    }
    let topic = spec.topic.as_deref().unwrap_or_default();
    let made = Columns { cells, ..Columns::default() };
    let row = vec![f64::NAN; paths.len()];
    let mut reading = Reading {
        plan,
        topic,
        clock,
        paths,
        row,
        made,
        schemas: Schemas::default(),
        channels: Channels::new(spec.publisher.as_deref()),
        topics: BTreeSet::new(),
    };
    each_record(bytes, &mut |part| reading.take(part))?;
    reading.finish()
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

struct Reading<'a> {
    plan: &'a Plan,
    topic: &'a str,
    clock: Time,
    paths: Vec<String>,
    /// The values of a message, one per path.
    row: Vec<f64>,
    made: Columns,
    schemas: Schemas,
    channels: Channels<'a>,
    topics: BTreeSet<String>,
}

/// Most topics of a bag whose names are kept; also the most channels.
const MOST_TOPICS: usize = 1 << 16;

impl Reading<'_> {
    fn take(&mut self, part: Part) -> Result<(), LogError> {
        match part {
            Part::Schema { id, name, encoding, data } => self.schemas.add(id, name, encoding, data)?,
            Part::Channel { id, schema, topic, encoding, metadata } => {
                if topic == self.topic {
                    let schema = self.schemas.get(schema);
                    self.channels.add(id, schema, encoding, metadata, (topic, &self.paths))?;
                }
                if self.topics.len() < MOST_TOPICS && !self.topics.contains(topic) {
                    self.topics.insert(topic.to_owned());
                }
            }
            Part::Message { channel, log_time, publish_time, data } => {
                self.message(channel, [log_time, publish_time], data)?;
            }
            Part::Chunk { .. } | Part::Other => {}
        }
        Ok(())
    }

    fn message(&mut self, channel: u16, [logged, published]: [u64; 2], data: &[u8]) -> Result<(), LogError> {
        let Some(decoder) = self.channels.heard(channel, self.topic)? else { return Ok(()) };
        let number = self.made.lines.rows() + 1;
        if number > self.plan.most_rows {
            return Err(LogError::Invalid(self.plan.too_many_rows(number)));
        }
        self.row.fill(f64::NAN);
        if let Err((found, expected)) = decoder.decode(data, &mut self.row) {
            let thing = format!("message {number} of topic `{}`", foreign(self.topic));
            let remedy = "the bag is damaged, or its definitions are of another version: record again";
            return Err(LogError::Invalid(Invalid::new(thing, found, expected, remedy)));
        }
        let (time, fields) = match self.clock {
            Time::Logged => (seconds(logged), &self.row[..]),
            Time::Published => (seconds(published), &self.row[..]),
            Time::Stamp => (self.row[0] + 1e-9 * self.row[1], &self.row[2..]),
            Time::Field => (self.row[0], &self.row[1..]),
        };
        self.made.lines.push(number);
        for (cells, value) in self.made.cells.iter_mut().zip([&time].into_iter().chain(fields)) {
            if let Cells::Numbers(numbers) = cells {
                numbers.push(*value);
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<Columns, LogError> {
        self.channels.check_named(self.topic)?;
        if self.channels.is_empty() {
            let known: Vec<&str> = self.topics.iter().map(String::as_str).collect();
            let near = nearest(self.topic, known.iter().copied());
            let remedy = near
                .map_or("correct `topic`".to_owned(), |near| format!("did you mean `{}`?", foreign(near)));
            let expected = match known.is_empty() {
                true => "a bag with topics".to_owned(),
                false => format!("one of {}", some_of(&known, self.topic)),
            };
            let found = format!("no `{}`", foreign(self.topic));
            return Err(LogError::Invalid(Invalid::new("topic", found, expected, remedy)));
        }
        self.channels.check_found(&self.paths, self.made.lines.rows())?;
        Ok(self.made)
    }
}

/// Whole nanoseconds since 1970 in seconds: a number cannot hold all of their digits at once.
fn seconds(nanoseconds: u64) -> f64 {
    const SECOND: u64 = 1_000_000_000;
    (nanoseconds / SECOND) as f64 + 1e-9 * (nanoseconds % SECOND) as f64
}
