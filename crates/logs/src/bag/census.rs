//! The topics of a bag with the first of their messages, to find out what is in it.

use std::collections::BTreeMap;
use std::io::Read;

use refusal::Invalid;

use crate::bag::channels::Schemas;
use crate::bag::database::DatabaseFile;
use crate::bag::decoder::{Decoder, shape};
use crate::bag::effort::Effort;
use crate::bag::fields::leaves;
use crate::bag::parts::Part;
use crate::bag::stream::each_part;
use crate::bag::{BagError, Format, database};

/// Messages of a topic that are decoded.
const ROWS: usize = 400;

/// Most values of a topic that are decoded.
const CELLS: usize = 40_000;

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
    /// Numbers of its publishers.
    pub publishers: Vec<u32>,
    /// Paths to the numbers in a message; empty where its messages cannot be decoded.
    pub fields: Vec<String>,
    /// Values of the fields in the first messages.
    pub rows: Vec<Vec<f64>>,
    /// When the first and the last message were logged \[s\].
    pub logged_s: [f64; 2],
    /// How many messages it has.
    pub messages: usize,
}

/// The topics of a bag and the first of their messages, by means of `memory` bytes.
///
/// # Errors
/// Bytes that cannot be read or are not a bag.
pub fn census(bytes: &mut dyn Read, format: Format, memory: f64) -> Result<Vec<Topic>, BagError> {
    let effort = Effort::new(memory);
    let mut census = Census::new(&effort);
    each_part(bytes, format, &effort, &mut |part| census.take(part))?;
    Ok(census.topics())
}

/// As [`census`], of a bag in SQLite.
///
/// # Errors
/// As [`census`].
pub fn census_of_database(database: &DatabaseFile, memory: f64) -> Result<Vec<Topic>, BagError> {
    let effort = Effort::new(memory);
    let mut census = Census::new(&effort);
    database::each_part(database, None, &effort, &mut |part| census.take(part))?;
    Ok(census.topics())
}

/// What was found so far.
struct Census<'a> {
    schemas: Schemas,
    /// Topics in the order of their names, with the decoder of each.
    topics: BTreeMap<String, (Topic, Option<Decoder>)>,
    /// The topic of each channel.
    channels: BTreeMap<u32, String>,
    effort: &'a Effort,
}

impl<'a> Census<'a> {
    fn new(effort: &'a Effort) -> Self {
        Self { schemas: Schemas::default(), topics: BTreeMap::new(), channels: BTreeMap::new(), effort }
    }

    /// Takes the next part of a bag.
    fn take(&mut self, part: Part) -> Result<(), BagError> {
        match part {
            Part::Schema { id, name, encoding, data } => {
                self.schemas.add(id, [name, encoding], data, self.effort)?;
            }
            Part::Channel { id, number, schema, topic, encoding, .. } => {
                if self.topics.len() < MOST_TOPICS {
                    self.channel([id, number, schema], topic, encoding)?;
                }
            }
            Part::Message { channel, log_time, data, .. } => self.message(channel, log_time, data),
            Part::Chunk { .. } | Part::Other => {}
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
        self.channels.insert(id, topic.to_owned());
        if !self.topics.contains_key(topic) {
            let parts = self.schemas.get(schema).map(|schema| schema.parts());
            let shape = parts.and_then(|parts| shape(topic, encoding, parts, effort).ok());
            let fields = shape.map_or(Ok(Vec::new()), |shape| leaves(&shape, FEW, effort))?;
            let decoder = Decoder::new(topic, encoding, parts, &fields, effort).ok();
            let kind = parts.map(|(name, ..)| name.to_owned()).unwrap_or_default();
            let own = Topic { name: topic.to_owned(), kind, fields, ..Topic::default() };
            self.topics.insert(topic.to_owned(), (own, decoder));
        }
        self.topics.entry(topic.to_owned()).and_modify(|(own, _)| own.publishers.push(number));
        Ok(())
    }

    fn message(&mut self, channel: u32, log_time: u64, data: &[u8]) {
        let own = self.channels.get(&channel).and_then(|topic| self.topics.get_mut(topic));
        let Some((topic, decoder)) = own else { return };
        let logged_s = 1e-9 * log_time as f64;
        if topic.messages == 0 {
            topic.logged_s[0] = logged_s;
        }
        topic.logged_s[1] = logged_s;
        topic.messages += 1;
        let rows = ROWS.min(CELLS / topic.fields.len().max(1));
        let Some(decoder) = decoder.as_mut().filter(|_| topic.rows.len() < rows) else { return };
        let mut row = vec![f64::NAN; topic.fields.len()];
        // Damage is reported when the bag is ingested.
        if decoder.decode(data, &mut row, self.effort).is_ok()
            && self.effort.may_keep(size_of_val(row.as_slice()))
        {
            topic.rows.push(row);
        }
    }

    /// The topics in the order of their names.
    fn topics(self) -> Vec<Topic> {
        self.topics.into_values().map(|(topic, _)| topic).collect()
    }
}
