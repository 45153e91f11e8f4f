//! Logs of ROS 2 in bags of MCAP: the messages of one topic, fields of which are columns (`twist.twist.linear.x`).
//!
//! The crate `mcap` reads the file; its chunks are decompressed here by the libraries that are there for tables anyway.
//! Messages are decoded by the definition that the bag has of them (`ros2msg`), or they are JSON.

mod cdr;
mod decoder;
mod definition;
mod fields;
mod json;
mod records;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::sync::Arc;

use mcap::records::{MessageHeader, Record};
use refusal::{Invalid, nearest};

use crate::{Cells, Columns, Content, LogError, Plan, Store};
use decoder::Decoder;
use records::each_record;

/// The times that every message has beside its fields.
pub const LOG_TIME: &str = "log_time";
/// See [`LOG_TIME`].
pub const PUBLISH_TIME: &str = "publish_time";

/// Reads the fields of messages that `plan` wants of the topic of group `group`; numbers are put aside in `store`. Rows are
/// numbered as the topic's messages.
///
/// # Errors
/// Bytes that cannot be read or are no bag, a topic that there is not, an encoding that is not known, a field that there is
/// not, messages shorter than their definition.
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
        schemas: BTreeMap::new(),
        decoders: BTreeMap::new(),
        topics: BTreeSet::new(),
    };
    each_record(bytes, &mut |record| reading.take(record))?;
    reading.finish()
}

/// Where a message's time comes from.
#[derive(Clone, Copy, PartialEq)]
enum Time {
    Logged,
    Published,
    /// Two fields, seconds and nanoseconds.
    Stamp,
    /// A field like others.
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
    /// Name, encoding and text by number.
    schemas: BTreeMap<u16, (String, String, Vec<u8>)>,
    /// Decoders of the topic's channels.
    decoders: BTreeMap<u16, Decoder>,
    topics: BTreeSet<String>,
}

impl Reading<'_> {
    fn take(&mut self, record: Record) -> Result<(), LogError> {
        match record {
            Record::Schema { header, data } => {
                self.schemas.insert(header.id, (header.name, header.encoding, data.into_owned()));
            }
            Record::Channel(channel) => {
                if channel.topic == self.topic && !self.decoders.contains_key(&channel.id) {
                    let schema = self.schemas.get(&channel.schema_id);
                    let schema =
                        schema.map(|(name, encoding, text)| (name.as_str(), encoding.as_str(), &text[..]));
                    let decoder = Decoder::new(self.topic, &channel.message_encoding, schema, &self.paths)?;
                    self.decoders.insert(channel.id, decoder);
                }
                self.topics.insert(channel.topic);
            }
            Record::Message { header, data } => self.message(&header, &data)?,
            _ => {}
        }
        Ok(())
    }

    fn message(&mut self, header: &MessageHeader, data: &[u8]) -> Result<(), LogError> {
        let Some(decoder) = self.decoders.get_mut(&header.channel_id) else { return Ok(()) };
        let number = self.made.lines.rows() + 1;
        if number > self.plan.most_rows {
            return Err(LogError::Invalid(self.plan.too_many_rows(number)));
        }
        self.row.fill(f64::NAN);
        if let Err((found, expected)) = decoder.decode(data, &mut self.row) {
            let thing = format!("message {number} of topic `{}`", self.topic);
            let remedy = "the bag is damaged, or its definitions are of another version: record again";
            return Err(LogError::Invalid(Invalid::new(thing, found, expected, remedy)));
        }
        let (time, fields) = match self.clock {
            Time::Logged => (seconds(header.log_time), &self.row[..]),
            Time::Published => (seconds(header.publish_time), &self.row[..]),
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
        if self.decoders.is_empty() {
            let known: Vec<&str> = self.topics.iter().map(String::as_str).collect();
            let near = nearest(self.topic, known.iter().copied());
            let remedy = near.map_or("correct `topic`".to_owned(), |near| format!("did you mean `{near}`?"));
            let expected = match known.is_empty() {
                true => "a bag with topics".to_owned(),
                false => format!("one of {}", known.join(", ")),
            };
            return Err(LogError::Invalid(Invalid::new(
                "topic",
                format!("no `{}`", self.topic),
                expected,
                remedy,
            )));
        }
        for decoder in self.decoders.values() {
            decoder.check_found(&self.paths, self.made.lines.rows())?;
        }
        Ok(self.made)
    }
}

/// Seconds of whole nanoseconds since 1970, which have more digits than a number has in all.
fn seconds(nanoseconds: u64) -> f64 {
    const SECOND: u64 = 1_000_000_000;
    (nanoseconds / SECOND) as f64 + 1e-9 * (nanoseconds % SECOND) as f64
}
