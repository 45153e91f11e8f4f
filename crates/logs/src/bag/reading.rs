//! The messages of one topic.

use std::collections::BTreeSet;
use std::io::Read;

use refusal::{Invalid, foreign, nearest, some_of};

use crate::bag::channels::{Channels, Schemas};
use crate::bag::database::DatabaseFile;
use crate::bag::effort::Effort;
use crate::bag::parts::Part;
use crate::bag::stream::each_part;
use crate::bag::{BagError, Format, database};

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
    let mut reading = Reading::new(wanted, &effort, each);
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
    let mut reading = Reading::new(wanted, &effort, each);
    database::each_part(database, Some(wanted.topic), &effort, &mut |part| reading.take(part))?;
    reading.finish()
}

struct Reading<'a, 'b> {
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

impl<'a, 'b> Reading<'a, 'b> {
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
