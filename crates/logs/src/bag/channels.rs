//! The channels of a topic: who publishes it, and how messages are laid out.

use std::collections::BTreeMap;
use std::io::Read;

use refusal::{Invalid, foreign};

use crate::bag::database::DatabaseFile;
use crate::bag::decoder::{Decoder, json_leaves, shape};
use crate::bag::definition::{LONGEST, leaves};
use crate::bag::stream::each_part;
use crate::bag::{BagPart, Effort, database};
use crate::{Format, LogError};

/// Bytes of a definition or a channel besides its texts.
const ENTRY: usize = 256;

/// Definitions by their ids.
#[derive(Default)]
pub(crate) struct Schemas(BTreeMap<u32, Schema>);

/// Name, encoding and text of a definition.
#[derive(Clone, PartialEq)]
pub(crate) struct Schema {
    name: String,
    encoding: String,
    text: Vec<u8>,
}

impl Schema {
    /// Name, encoding and text.
    pub(crate) fn parts(&self) -> (&str, &str, &[u8]) {
        (&self.name, &self.encoding, &self.text)
    }
}

impl Schemas {
    /// Keeps a definition; of one that is too long, only enough to show that.
    pub(crate) fn add(
        &mut self,
        id: u32,
        [name, encoding]: [&str; 2],
        text: &[u8],
        effort: &Effort,
    ) -> Result<(), Invalid> {
        if self.0.contains_key(&id) {
            return Ok(());
        }
        let text = &text[..text.len().min(LONGEST + 1)];
        effort.keep(ENTRY + name.len() + encoding.len() + text.len())?;
        let schema = Schema { name: name.to_owned(), encoding: encoding.to_owned(), text: text.to_vec() };
        self.0.insert(id, schema);
        Ok(())
    }

    pub(crate) fn get(&self, id: u32) -> Option<&Schema> {
        self.0.get(&id)
    }
}

/// A channel of the topic.
struct Channel {
    schema: Option<Schema>,
    encoding: String,
    metadata: Vec<(String, String)>,
    decoder: Decoder,
    /// Whether a message of it came.
    is_heard: bool,
}

impl Channel {
    /// Whether it continues another channel that ended: both have the same properties.
    fn is_same(&self, other: &Self) -> bool {
        (&self.schema, &self.encoding, &self.metadata) == (&other.schema, &other.encoding, &other.metadata)
    }
}

/// The channels of the topic that is read.
pub(crate) struct TopicChannels<'a> {
    /// The wanted publisher.
    publisher: Option<&'a str>,
    known: BTreeMap<u32, Channel>,
    /// Names of all publishers of the topic, also of those that are not wanted.
    called: BTreeMap<u32, String>,
    /// The one whose message came last.
    last: Option<u32>,
    effort: &'a Effort,
}

impl<'a> TopicChannels<'a> {
    /// No channels yet; all of the topic count, or those of one publisher.
    pub(crate) fn new(publisher: Option<&'a str>, effort: &'a Effort) -> Self {
        Self { publisher, known: BTreeMap::new(), called: BTreeMap::new(), last: None, effort }
    }

    /// Adds a channel of the topic, whose messages are to yield the fields at `paths`; `number` names its publisher.
    pub(crate) fn add(
        &mut self,
        [id, number]: [u32; 2],
        schema: Option<&Schema>,
        encoding: &str,
        metadata: Vec<(&str, &str)>,
        (topic, paths): (&str, &[String]),
    ) -> Result<(), Invalid> {
        if self.called.contains_key(&id) {
            return Ok(());
        }
        // Qualities of service are long, and not a name.
        let names = metadata.iter().filter(|(key, _)| !key.contains("qos") && *key != "topic_type_hash");
        let names: Vec<String> = names.map(|(key, value)| format!("{key} {value}")).collect();
        let called =
            if names.is_empty() { String::new() } else { format!(" ({})", foreign(&names.join(", "))) };
        let text = |schema: &Schema| schema.text.len();
        self.effort.keep(ENTRY + 2 * called.len() + schema.map_or(0, text))?;
        self.called.insert(id, format!("`{number}`{called}"));
        let is_meant = self.publisher.is_none_or(|publisher| {
            publisher == number.to_string() || metadata.iter().any(|(_, value)| *value == publisher)
        });
        if is_meant {
            let parts = schema.map(Schema::parts);
            let decoder = Decoder::new(topic, encoding, parts, paths, self.effort)?;
            let owned = |(key, value): (&str, &str)| (key.to_owned(), value.to_owned());
            let metadata = metadata.into_iter().map(owned).collect();
            let (schema, encoding) = (schema.cloned(), encoding.to_owned());
            self.known.insert(id, Channel { schema, encoding, metadata, decoder, is_heard: false });
        }
        Ok(())
    }

    /// The decoder of a message of channel `id`; `None` where that is not read.
    pub(crate) fn heard(&mut self, id: u32, topic: &str) -> Result<Option<&mut Decoder>, Invalid> {
        if self.last != Some(id) {
            let Some(next) = self.known.get(&id) else { return Ok(None) };
            let continues = |last: &u32| !next.is_heard && self.known[last].is_same(next);
            if !self.last.as_ref().is_none_or(continues) {
                return Err(self.several(topic));
            }
            self.last = Some(id);
        }
        Ok(self.known.get_mut(&id).map(|channel| {
            channel.is_heard = true;
            &mut channel.decoder
        }))
    }

    fn several(&self, topic: &str) -> Invalid {
        let called: Vec<&str> = self.called.values().take(4).map(String::as_str).collect();
        let listed = format!("{} channels, {}", self.called.len(), called.join(", "));
        let first = called.first().and_then(|called| called.split('`').nth(1)).unwrap_or_default();
        Invalid::new(
            format!("publishers of topic `{}`", foreign(topic)),
            listed,
            "messages of one",
            format!("name one by its channel or its metadata: `publisher = \"{first}\"` in its [[file]]"),
        )
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// Refuses a publisher that the topic does not have.
    pub(crate) fn check_named(&self, topic: &str) -> Result<(), Invalid> {
        match self.publisher {
            Some(publisher) if self.known.is_empty() && !self.called.is_empty() => {
                let called: Vec<&str> = self.called.values().take(8).map(String::as_str).collect();
                let thing = format!("`publisher` of topic `{}`", foreign(topic));
                Err(Invalid::new(
                    thing,
                    format!("no `{}`", foreign(publisher)),
                    called.join(", "),
                    "correct it",
                ))
            }
            _ => Ok(()),
        }
    }

    /// Refuses a field that none of the messages had.
    pub(crate) fn check_found(&self, paths: &[String], messages: usize) -> Result<(), Invalid> {
        let mut heard = self.known.values().filter(|channel| channel.is_heard);
        heard.try_for_each(|channel| channel.decoder.check_found(paths, messages))
    }
}

/// Messages of a topic that are kept at least, evenly over all.
const ROWS: usize = crate::by_motion::ROWS;

/// Most values of a topic that are kept, about.
const CELLS: usize = 40_000;

/// Longer messages are pictures and the like \[bytes\].
const LONG: usize = 1 << 16;

/// Clocks further apart count something else \[s\].
const NEAR_S: f64 = 10.0;

/// Most elements of a list that all are columns.
const FEW: usize = 16;

/// Most topics that are looked at.
const MOST_TOPICS: usize = 1000;

/// A topic of a bag.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// The type of its messages.
    pub kind: String,
    /// Numbers of its publishers, the one whose messages these are first.
    pub publishers: Vec<u32>,
    /// Paths to the numbers in a message; empty where its messages cannot be decoded.
    pub fields: Vec<String>,
    /// Values of the fields in one of `every` messages.
    pub rows: Vec<Vec<f64>>,
    /// When each of these was made, or else logged \[s\].
    pub times: Vec<f64>,
    /// See `rows`.
    pub every: usize,
    /// How many messages it has of this publisher.
    pub messages: usize,
}

impl Topic {
    /// The place of a field.
    pub(crate) fn place(&self, field: &str) -> Option<usize> {
        self.fields.iter().position(|name| name == field)
    }

    /// When a message with these values was made that was `logged` then \[s\]: clocks that are far from the logger's do not count.
    fn made_at(&self, row: &[f64], logged: f64) -> f64 {
        let value = |field: &str| Some(row[self.place(field)?]);
        let stamp = || Some(value("header.stamp.sec")? + 1e-9 * value("header.stamp.nanosec")?);
        match logged > 0.0 {
            true => stamp().filter(|time| (time - logged).abs() < NEAR_S).unwrap_or(logged),
            false => value("timestamp").map_or(0.0, |count| 1e-6 * count),
        }
    }
}

/// The topics of a bag and messages from all over them, by means of `memory` bytes; `format` as in [`crate::read_bag`].
///
/// # Errors
/// Bytes that cannot be read or are not a bag.
pub fn bag_census(mut bytes: impl Read, format: Format, memory: f64) -> Result<Vec<Topic>, LogError> {
    census(memory, |effort, each| each_part(&mut bytes, format, effort, each))
}

/// As [`bag_census`], of a bag in SQLite.
///
/// # Errors
/// As [`bag_census`].
pub fn database_census(file: &DatabaseFile, memory: f64) -> Result<Vec<Topic>, LogError> {
    census(memory, |effort, each| database::each_part(file, None, effort, each))
}

/// The topics of a bag, whose parts `pass` passes on.
fn census(
    memory: f64,
    pass: impl FnOnce(&Effort, &mut dyn FnMut(BagPart) -> Result<(), LogError>) -> Result<(), LogError>,
) -> Result<Vec<Topic>, LogError> {
    let effort = Effort::new(memory);
    let (schemas, topics, channels) = (Schemas::default(), BTreeMap::new(), BTreeMap::new());
    let mut census = Census { schemas, topics, channels, effort: &effort };
    pass(&effort, &mut |part| census.take(part))?;
    Ok(census.topics.into_values().map(|(topic, ..)| topic).collect())
}

/// What was found so far.
struct Census<'a> {
    schemas: Schemas,
    /// Topics in the order of their names, with the decoder of each, the channel that is heard, and most rows that there were.
    topics: BTreeMap<String, (Topic, Option<Decoder>, Option<u32>, usize)>,
    /// The topic of each channel, and its publisher's number.
    channels: BTreeMap<u32, (String, u32)>,
    effort: &'a Effort,
}

impl Census<'_> {
    /// Takes the next part of a bag.
    fn take(&mut self, part: BagPart) -> Result<(), LogError> {
        match part {
            BagPart::Schema { id, name, encoding, data } => {
                self.schemas.add(id, [name, encoding], data, self.effort)?;
            }
            BagPart::Channel { id, number, schema, topic, encoding, .. } => {
                if self.topics.len() < MOST_TOPICS {
                    self.channel([id, number, schema], topic, encoding)?;
                }
            }
            BagPart::Message { channel, log_time, data, .. } => self.message(channel, log_time, data),
            BagPart::Chunk { .. } | BagPart::Other => {}
        }
        Ok(())
    }

    fn channel(
        &mut self,
        [id, number, schema]: [u32; 3],
        topic: &str,
        encoding: &str,
    ) -> Result<(), Invalid> {
        if self.channels.contains_key(&id) {
            return Ok(());
        }
        let effort = self.effort;
        effort.keep(2 * topic.len())?;
        self.channels.insert(id, (topic.to_owned(), number));
        if !self.topics.contains_key(topic) {
            let parts = self.schemas.get(schema).map(|schema| schema.parts());
            let shape = parts.and_then(|parts| shape(topic, encoding, parts, effort).ok());
            let fields = shape.map_or(Ok(Vec::new()), |shape| leaves(&shape, FEW, effort))?;
            let decoder = Decoder::new(topic, encoding, parts, &fields, effort).ok();
            let kind = parts.map(|(name, ..)| name.to_owned()).unwrap_or_default();
            let listed = Topic { name: topic.to_owned(), kind, fields, every: 1, ..Topic::default() };
            self.topics.insert(topic.to_owned(), (listed, decoder, None, 0));
        }
        self.topics.entry(topic.to_owned()).and_modify(|(listed, ..)| listed.publishers.push(number));
        Ok(())
    }

    fn message(&mut self, channel: u32, log_time: u64, data: &[u8]) {
        let Some((name, number)) = self.channels.get(&channel) else { return };
        let Some((topic, decoder, heard, most)) = self.topics.get_mut(name) else { return };
        if *heard.get_or_insert(channel) != channel {
            return;
        }
        if topic.messages == 0 {
            topic.publishers.sort_by_key(|other| other != number);
            if matches!(decoder, Some(Decoder::Json(_))) && data.len() < LONG {
                topic.fields = json_leaves(data, FEW);
                *decoder = Decoder::new(name, "json", None, &topic.fields, self.effort).ok();
            }
        }
        let at = topic.messages;
        topic.messages += 1;
        let is_next = data.len() < LONG && at.is_multiple_of(topic.every);
        let Some(decoder) = decoder.as_mut().filter(|_| is_next) else { return };
        let mut row = vec![f64::NAN; topic.fields.len()];
        // Damage is reported when the bag is ingested.
        let is_read = decoder.decode(data, &mut row, self.effort).is_ok();
        if !is_read || topic.rows.len() >= *most && !self.effort.may_keep(size_of_val(row.as_slice())) {
            return;
        }
        topic.times.push(topic.made_at(&row, 1e-9 * log_time as f64));
        topic.rows.push(row);
        *most = topic.rows.len().max(*most);
        if topic.rows.len() >= 2 * ROWS.min(CELLS / topic.fields.len().max(1)).max(1) {
            let mut places = 0..;
            topic.rows.retain(|_| places.next().is_some_and(|at: usize| at.is_multiple_of(2)));
            let mut places = 0..;
            topic.times.retain(|_| places.next().is_some_and(|at: usize| at.is_multiple_of(2)));
            topic.every *= 2;
        }
    }
}
