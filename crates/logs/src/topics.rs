//! Bags: a topic is a table, whose rows are its messages and whose columns are their fields (`twist.twist.linear.x`).

use std::collections::BTreeSet;
use std::io::Read;
use std::sync::Arc;

use refusal::{Invalid, foreign, nearest, some_of};

use crate::bag::channels::{Channels, Schemas};
use crate::bag::stream::each_part;
use crate::bag::{BagError, DatabaseFile, Effort, Part, Topic, database};
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
    read(plan, group, store, |wanted, each| crate::bag::each_message(&mut bytes, format, wanted, each))
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
    Ok(crate::bag::census(&mut bytes, format, memory)?)
}

/// As [`bag_census`], of a bag in SQLite.
///
/// # Errors
/// As [`bag_census`].
pub fn database_census(file: &DatabaseFile, memory: f64) -> Result<Vec<Topic>, LogError> {
    Ok(crate::bag::census_of_database(file, memory)?)
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

// The messages of one topic.

/// What is wanted of a bag.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// The topic.
    pub topic: &'a str,
    /// Its publisher, where several are: a number, or a value of its metadata.
    pub publisher: Option<&'a str>,
    /// Paths to numbers in its messages.
    pub paths: &'a [String],
    /// Bytes of memory that reading may take.
    pub memory: f64,
}

/// A message of the topic.
#[derive(Clone, Copy, Debug)]
pub struct Message<'a> {
    /// When it was logged \[ns since 1970\]; 0 in a ULog.
    pub log_time: u64,
    /// When it was published; where that is not known, when it was logged.
    pub publish_time: u64,
    /// The numbers at the wanted paths, NaN where the message has none.
    pub values: &'a [f64],
}

/// Passes the messages of a topic to `each`.
///
/// # Errors
/// Bytes that cannot be read or are not a bag, an unknown topic, encoding or field, messages shorter than
/// their definition, several publishers of which none is named; refusals of `each`.
pub fn each_message(
    bytes: &mut dyn Read,
    format: Format,
    wanted: &Wanted,
    each: &mut dyn FnMut(Message) -> Result<(), Invalid>,
) -> Result<(), BagError> {
    let effort = Effort::new(wanted.memory);
    let mut reading = TopicReading::new(wanted, &effort, each);
    each_part(bytes, format, &effort, &mut |part| reading.take(part))?;
    reading.finish()
}

/// As [`each_message`], of a bag in SQLite.
///
/// # Errors
/// As [`each_message`].
pub fn each_message_of_database(
    database: &DatabaseFile,
    wanted: &Wanted,
    each: &mut dyn FnMut(Message) -> Result<(), Invalid>,
) -> Result<(), BagError> {
    let effort = Effort::new(wanted.memory);
    let mut reading = TopicReading::new(wanted, &effort, each);
    database::each_part(database, Some(wanted.topic), &effort, &mut |part| reading.take(part))?;
    reading.finish()
}

struct TopicReading<'a, 'b> {
    wanted: &'a Wanted<'a>,
    each: &'b mut dyn FnMut(Message) -> Result<(), Invalid>,
    /// The values of a message, one per path.
    row: Vec<f64>,
    messages: usize,
    schemas: Schemas,
    channels: Channels<'a>,
    topics: BTreeSet<String>,
    effort: &'a Effort,
}

/// Most topics of a bag whose names are kept; also the most channels.
const MOST_TOPICS: usize = 1 << 16;

impl<'a, 'b> TopicReading<'a, 'b> {
    fn new(
        wanted: &'a Wanted<'a>,
        effort: &'a Effort,
        each: &'b mut dyn FnMut(Message) -> Result<(), Invalid>,
    ) -> Self {
        Self {
            wanted,
            each,
            row: vec![f64::NAN; wanted.paths.len()],
            messages: 0,
            schemas: Schemas::default(),
            channels: Channels::new(wanted.publisher, effort),
            topics: BTreeSet::new(),
            effort,
        }
    }

    fn take(&mut self, part: Part) -> Result<(), BagError> {
        match part {
            Part::Schema { id, name, encoding, data } => {
                self.schemas.add(id, [name, encoding], data, self.effort)?;
            }
            Part::Channel { id, number, schema, topic, encoding, metadata } => {
                if topic == self.wanted.topic {
                    let (schema, paths) = (self.schemas.get(schema), self.wanted.paths);
                    self.channels.add([id, number], schema, encoding, metadata, (topic, paths))?;
                }
                if self.topics.len() < MOST_TOPICS && !self.topics.contains(topic) {
                    self.effort.keep(topic.len())?;
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

    fn message(
        &mut self,
        channel: u32,
        [log_time, publish_time]: [u64; 2],
        data: &[u8],
    ) -> Result<(), Invalid> {
        let Some(decoder) = self.channels.heard(channel, self.wanted.topic)? else { return Ok(()) };
        self.messages += 1;
        self.row.fill(f64::NAN);
        if let Err((found, expected)) = decoder.decode(data, &mut self.row, self.effort) {
            let thing = format!("message {} of topic `{}`", self.messages, foreign(self.wanted.topic));
            let remedy = "the bag is damaged, or its definitions are of another version: record again";
            return Err(Invalid::new(thing, found, expected, remedy));
        }
        (self.each)(Message { log_time, publish_time, values: &self.row })
    }

    fn finish(self) -> Result<(), BagError> {
        let topic = self.wanted.topic;
        self.channels.check_named(topic)?;
        if self.channels.is_empty() {
            let known: Vec<&str> = self.topics.iter().map(String::as_str).collect();
            let near = nearest(topic, known.iter().copied());
            let remedy = near
                .map_or("correct `topic`".to_owned(), |near| format!("did you mean `{}`?", foreign(near)));
            let expected = match known.is_empty() {
                true => "a bag with topics".to_owned(),
                false => format!("one of {}", some_of(&known, topic)),
            };
            let found = format!("no `{}`", foreign(topic));
            return Err(Invalid::new("topic", found, expected, remedy).into());
        }
        Ok(self.channels.check_found(self.wanted.paths, self.messages)?)
    }
}
