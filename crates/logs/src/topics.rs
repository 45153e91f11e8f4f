//! Bags: a topic is a table, whose rows are its messages and whose columns are their fields (`twist.twist.linear.x`).

use std::collections::BTreeSet;
use std::io::Read;
use std::sync::Arc;

use refusal::{Invalid, foreign, nearest, some_of};

use crate::bag::channels::{Schemas, TopicChannels};
use crate::bag::stream::each_part;
use crate::bag::{BagPart, DatabaseFile, Effort, database};
use crate::{Cells, Columns, Content, FileSpec, Format, LogError, Plan, Store};

/// The times that every message has besides its fields.
pub const LOG_TIME: &str = "log_time";
/// See [`LOG_TIME`].
pub const PUBLISH_TIME: &str = "publish_time";

/// Reads the fields of messages that `plan` wants of the topic of group `group`; `store` takes blocks of
/// numbers. Rows are numbered like the topic's messages. `format` is one of those that are read from beginning to end.
///
/// # Errors
/// Bytes that cannot be read or are not a bag, an unknown topic, encoding or field, messages shorter than
/// their definition, several publishers of which none is named; too many messages.
pub fn read_bag(
    mut bytes: impl Read,
    format: Format,
    plan: &Plan,
    group: usize,
    store: Option<&Arc<dyn Store>>,
) -> Result<Columns, LogError> {
    read(plan, group, store, |_, effort, each| each_part(&mut bytes, format, effort, each))
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
    read(plan, group, store, |topic, effort, each| database::each_part(file, Some(topic), effort, each))
}

/// Reads the wanted fields of a topic, the parts of whose bag `pass` passes on.
fn read(
    plan: &Plan,
    group: usize,
    store: Option<&Arc<dyn Store>>,
    pass: impl FnOnce(&str, &Effort, &mut dyn FnMut(BagPart) -> Result<(), LogError>) -> Result<(), LogError>,
) -> Result<Columns, LogError> {
    let (clock, paths) = columns(plan, group);
    let spec = &plan.setup.files[group];
    let topic = spec.topic.as_deref().unwrap_or_default();
    let effort = Effort::new(plan.memory);
    let cells = plan.wanted(group).iter().map(|_| Cells::none(Content::Numbers, store)).collect();
    let mut reading = TopicReading {
        plan,
        topic,
        paths: &paths,
        clock,
        row: vec![f64::NAN; paths.len()],
        messages: 0,
        schemas: Schemas::default(),
        channels: TopicChannels::new(spec.publisher.as_deref(), &effort),
        topics: BTreeSet::new(),
        effort: &effort,
        made: Columns { cells, ..Columns::default() },
    };
    pass(topic, &effort, &mut |part| reading.take(part))?;
    reading.finish()
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

/// Whole nanoseconds since 1970 in seconds: a number cannot hold all of their digits at once.
fn seconds(nanoseconds: u64) -> f64 {
    const SECOND: u64 = 1_000_000_000;
    (nanoseconds / SECOND) as f64 + 1e-9 * (nanoseconds % SECOND) as f64
}

/// The messages of a topic, as far as they are read.
struct TopicReading<'a> {
    plan: &'a Plan,
    topic: &'a str,
    /// Paths to the numbers that are wanted.
    paths: &'a [String],
    clock: Time,
    /// The values of a message, one per path; NaN where it has none.
    row: Vec<f64>,
    messages: usize,
    schemas: Schemas,
    channels: TopicChannels<'a>,
    topics: BTreeSet<String>,
    effort: &'a Effort,
    made: Columns,
}

/// Most topics of a bag whose names are kept; also the most channels.
const MOST_TOPICS: usize = 1 << 16;

impl TopicReading<'_> {
    fn take(&mut self, part: BagPart) -> Result<(), LogError> {
        match part {
            BagPart::Schema { id, name, encoding, data } => {
                self.schemas.add(id, [name, encoding], data, self.effort)?;
            }
            BagPart::Channel { id, number, schema, topic, encoding, metadata } => {
                if topic == self.topic {
                    let (schema, paths) = (self.schemas.get(schema), self.paths);
                    self.channels.add([id, number], schema, encoding, metadata, (topic, paths))?;
                }
                if self.topics.len() < MOST_TOPICS && !self.topics.contains(topic) {
                    self.effort.keep(topic.len())?;
                    self.topics.insert(topic.to_owned());
                }
            }
            BagPart::Message { channel, log_time, publish_time, data } => {
                self.message(channel, [log_time, publish_time], data)?;
            }
            BagPart::Chunk { .. } | BagPart::Other => {}
        }
        Ok(())
    }

    fn message(&mut self, channel: u32, times: [u64; 2], data: &[u8]) -> Result<(), Invalid> {
        let Some(decoder) = self.channels.heard(channel, self.topic)? else { return Ok(()) };
        self.messages += 1;
        self.row.fill(f64::NAN);
        if let Err((found, expected)) = decoder.decode(data, &mut self.row, self.effort) {
            let thing = format!("message {} of topic `{}`", self.messages, foreign(self.topic));
            let remedy = "the bag is damaged, or its definitions are of another version: record again";
            return Err(Invalid::new(thing, found, expected, remedy));
        }
        self.append(times)
    }

    /// Appends the row of a message with the times when it was logged and published.
    fn append(&mut self, [logged, published]: [u64; 2]) -> Result<(), Invalid> {
        let number = self.made.lines.rows() + 1;
        if number > self.plan.most_rows {
            return Err(self.plan.too_many_rows(number));
        }
        let row = &self.row[..];
        let (time, fields) = match self.clock {
            Time::Logged => (seconds(logged), row),
            Time::Published => (seconds(published), row),
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
            let name = format!("no `{}`", foreign(self.topic));
            return Err(Invalid::new("topic", name, expected, remedy).into());
        }
        self.channels.check_found(self.paths, self.messages)?;
        Ok(self.made)
    }
}
