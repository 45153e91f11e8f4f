//! Bags of robots: files with topics, each of which has messages. [`crate::read_bag`] reads
//! the numbers at the wanted paths, [`bag_census`] says what is in a file. Each kind of file has a reader that passes
//! parts on: MCAP, bags of ROS 1, those of ROS 2 in SQLite, ULog.
//!
//! The crate `mcap` finds the records of MCAP, SQLite the rows of a `.db3`; all others are parsed and chunks decompressed
//! here, where their lengths are not trusted. What a bag may cost is counted in one place, [`Effort`]. Messages are decoded by the definition in the bag, or they are JSON.

mod binary;
pub(crate) mod channels;
pub(crate) mod database;
mod decoder;
mod definition;
mod rosbag;
pub(crate) mod stream;

use std::cell::Cell;

use refusal::Invalid;

pub use channels::{Topic, bag_census, database_census};
pub use database::DatabaseFile;

/// Most pairs in a record.
const MOST_PAIRS: usize = 1 << 12;

/// Unread bytes.
struct Rest<'a>(pub(crate) &'a [u8]);

impl<'a> Rest<'a> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.take().map(u8::from_le_bytes)
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    pub(crate) fn bytes(&mut self, length: u64) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(usize::try_from(length).ok()?)?;
        self.0 = rest;
        Some(taken)
    }

    /// Text after its length.
    pub(crate) fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()?;
        std::str::from_utf8(self.bytes(u64::from(length))?).ok()
    }

    /// Pairs of texts after the length of all; `None` where there are more than channels have.
    pub(crate) fn pairs(&mut self) -> Option<Vec<(&'a str, &'a str)>> {
        let length = self.u32()?;
        let mut inner = Rest(self.bytes(u64::from(length))?);
        let mut pairs = Vec::new();
        while !inner.0.is_empty() && pairs.len() <= MOST_PAIRS {
            pairs.push((inner.text()?, inner.text()?));
        }
        inner.0.is_empty().then_some(pairs)
    }
}

// What is in a bag of any kind; and the records of MCAP, as bytes of the format.
// <https://mcap.dev/spec#records>

/// A part of a bag.
#[derive(Debug, PartialEq)]
pub(crate) enum BagPart<'a> {
    /// A message definition.
    Schema { id: u32, name: &'a str, encoding: &'a str, data: &'a [u8] },
    /// Messages of a topic from one publisher, which `number` names.
    Channel {
        id: u32,
        number: u32,
        schema: u32,
        topic: &'a str,
        encoding: &'a str,
        metadata: Vec<(&'a str, &'a str)>,
    },
    /// A message of a channel; times in nanoseconds since 1970.
    Message { channel: u32, log_time: u64, publish_time: u64, data: &'a [u8] },
    /// Other records, compressed.
    Chunk { size: u64, crc: u32, compression: &'a str, data: &'a [u8] },
    /// Anything that is not needed.
    Other,
}

/// The record in the bytes `data`; `None` where it ends too early.
fn part(opcode: u8, data: &[u8]) -> Option<BagPart<'_>> {
    let mut rest = Rest(data);
    Some(match opcode {
        0x03 => {
            let (id, name, encoding) = (u32::from(rest.u16()?), rest.text()?, rest.text()?);
            let length = rest.u32()?;
            BagPart::Schema { id, name, encoding, data: rest.bytes(u64::from(length))? }
        }
        0x04 => {
            let (id, schema) = (u32::from(rest.u16()?), u32::from(rest.u16()?));
            let (topic, encoding, metadata) = (rest.text()?, rest.text()?, rest.pairs()?);
            BagPart::Channel { id, number: id, schema, topic, encoding, metadata }
        }
        0x05 => {
            let (channel, _sequence) = (u32::from(rest.u16()?), rest.u32()?);
            BagPart::Message { channel, log_time: rest.u64()?, publish_time: rest.u64()?, data: rest.0 }
        }
        0x06 => {
            let (_first, _last, size, crc) = (rest.u64()?, rest.u64()?, rest.u64()?, rest.u32()?);
            let (compression, length) = (rest.text()?, rest.u64()?);
            BagPart::Chunk { size, crc, compression, data: rest.bytes(length)? }
        }
        _ => BagPart::Other,
    })
}

// What a bag may cost, whatever it announces: memory by what there is, work by the bytes that were read. One counter for
// every format, and for every way to look at a bag.

/// Most bytes of a record, a chunk or a message in memory, and least ones that are allowed with little memory.
const LARGEST: f64 = (1 << 27) as f64;
const LEAST: f64 = (1 << 23) as f64;

/// Share of the memory that one record may take: it may be in memory compressed, decompressed and on its way.
const SHARE: f64 = 0.25;

/// Most times that chunks or messages may expand, beyond a fixed minimum: messages do not compress further.
const EXPANSION: u64 = 200;
const IN_ANY_CASE: u64 = 1 << 28;

/// Steps that no byte of a message pays for: beyond them, every message pays for as many as it has bytes, and some more.
const UNPAID: u64 = 1 << 24;
const PER_MESSAGE: u64 = 16;

/// Bytes of a text that are read in one step.
const TEXT: usize = 16;

/// The counter of a pass through a bag.
pub(crate) struct Effort {
    /// Most bytes of a record, a chunk or a message.
    pub(crate) largest: usize,
    /// Bytes of chunks and messages so far, compressed and decompressed.
    packed: Cell<u64>,
    unpacked: Cell<u64>,
    /// Bytes that may still be kept to the end.
    room: Cell<usize>,
    /// Steps that are left.
    steps: Cell<u64>,
}

impl Effort {
    /// No effort yet, with `memory` bytes.
    pub(crate) fn new(memory: f64) -> Self {
        let largest = (SHARE * memory).clamp(LEAST, LARGEST) as usize;
        let [packed, unpacked] = [0, 0].map(Cell::new);
        Self { largest, packed, unpacked, room: Cell::new(2 * largest), steps: Cell::new(UNPAID) }
    }

    /// Counts `packed` bytes that become `unpacked` ones.
    pub(crate) fn unpack(&self, packed: usize, unpacked: u64) -> Result<(), Invalid> {
        if unpacked > self.largest as u64 {
            let (size, expected) = (format!("{unpacked} bytes"), format!("at most {}", self.largest));
            let remedy = "record in smaller chunks, or raise --memory-mib";
            return Err(Invalid::new("chunk", size, expected, remedy));
        }
        self.packed.set(self.packed.get() + packed as u64);
        self.unpacked.set(self.unpacked.get() + unpacked);
        let [packed, unpacked] = [&self.packed, &self.unpacked].map(Cell::get);
        if unpacked > EXPANSION * packed + IN_ANY_CASE {
            let sizes = format!("{unpacked} bytes, of {packed} in the file");
            let expected = format!("at most {EXPANSION} times as many");
            let remedy = "record again: these hold nothing, or are damaged";
            return Err(Invalid::new("chunks", sizes, expected, remedy));
        }
        Ok(())
    }

    /// Counts `bytes` that are kept to the end.
    pub(crate) fn keep(&self, bytes: usize) -> Result<(), Invalid> {
        self.room.set(self.room.get().checked_sub(bytes).ok_or_else(|| {
            let expected = format!("at most {} bytes", 2 * self.largest);
            let remedy = "record fewer topics, or raise --memory-mib: the bag may be damaged";
            Invalid::new("definitions", "more than fit in memory", expected, remedy)
        })?);
        Ok(())
    }

    /// Counts `bytes` that are kept to the end if there is plenty of room; says whether there is.
    pub(crate) fn may_keep(&self, bytes: usize) -> bool {
        let left = self.room.get().checked_sub(bytes).filter(|left| *left >= self.largest);
        left.map(|left| self.room.set(left)).is_some()
    }

    /// A message of `bytes` bytes pays for its steps.
    pub(crate) fn earn(&self, bytes: usize) {
        self.steps.set(self.steps.get().saturating_add(bytes as u64 + PER_MESSAGE));
    }

    /// One step: an element that takes no bytes. `None` where no step is left.
    pub(crate) fn step(&self) -> Option<()> {
        self.steps.set(self.steps.get().checked_sub(1)?);
        Some(())
    }

    /// Counts a text of `bytes` bytes that is read or made.
    pub(crate) fn text(&self, bytes: usize) -> Result<(), Invalid> {
        let left = self.steps.get().checked_sub((1 + bytes / TEXT) as u64);
        self.steps.set(left.ok_or_else(Self::endless)?);
        Ok(())
    }

    /// Whether no step is left.
    pub(crate) fn is_spent(&self) -> bool {
        self.steps.get() == 0
    }

    fn endless() -> Invalid {
        let excess = "definitions of more elements than the bag has bytes";
        let remedy = "record again: the bag is damaged, or was made to keep its readers busy";
        Invalid::new("definitions", excess, "elements that take bytes", remedy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_read_and_lengths_beyond_their_end_are_refused() {
        let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
        let pairs = [text("callerid"), text("/gps")].concat();
        let length = (pairs.len() as u32).to_le_bytes().to_vec();
        let channel = [vec![7, 0, 3, 0], text("/fix"), text("cdr"), length, pairs].concat();
        let metadata = vec![("callerid", "/gps")];
        let expected =
            BagPart::Channel { id: 7, number: 7, schema: 3, topic: "/fix", encoding: "cdr", metadata };
        assert_eq!(part(0x04, &channel), Some(expected));
        assert_eq!(part(0x0F, &[1]), Some(BagPart::Other));
        for end in 0..channel.len() {
            assert_eq!(part(0x04, &channel[..end]), None, "{end}");
        }
        let lies = [vec![7, 0], text("a/A"), text("ros2msg"), vec![0xFF; 4], vec![b'x'; 30]].concat();
        assert_eq!(part(0x03, &lies), None);
    }
}
