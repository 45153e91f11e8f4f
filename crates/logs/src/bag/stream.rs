//! Files that are read from beginning to end.

use std::collections::BTreeMap;
use std::io::Read;

use mcap::McapError;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use refusal::Invalid;

use crate::bag::rosbag::{Chunk, Unpacking};
use crate::bag::{BagPart, Effort, Rest, part, rosbag};
use crate::{Format, LogError};

/// Passes every part of `bytes` that is read to `each`.
pub(crate) fn each_part(
    bytes: &mut dyn Read,
    format: Format,
    effort: &Effort,
    each: &mut dyn FnMut(BagPart) -> Result<(), LogError>,
) -> Result<(), LogError> {
    match format {
        Format::Bag => rosbag::each_part(bytes, effort, each),
        Format::Ulg => each_part_of_ulog(bytes, each),
        _ => {
            McapWalk { each, unpacking: Unpacking { effort, whole: WHOLE, mend: COPY } }.through(bytes, false)
        }
    }
}

/// The state of a pass over the records of an MCAP file, one at a time, including those within chunks.
struct McapWalk<'a> {
    each: &'a mut dyn FnMut(BagPart) -> Result<(), LogError>,
    unpacking: Unpacking<'a>,
}

impl McapWalk<'_> {
    /// Goes through a file, or through the records `within` a chunk.
    fn through(&mut self, bytes: &mut dyn Read, within: bool) -> Result<(), LogError> {
        let most = self.unpacking.effort.largest;
        let options = LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(most);
        let options = options.with_skip_start_magic(within).with_skip_end_magic(within);
        let options =
            options.with_validate_data_section_crc(!within).with_validate_summary_section_crc(!within);
        let mut reader = LinearReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            match event.map_err(|error| damaged(&error))? {
                LinearReadEvent::ReadRequest(need) => {
                    let read = bytes.read(reader.insert(need))?;
                    reader.notify_read(read);
                }
                LinearReadEvent::Record { opcode, data } => match part(opcode, data) {
                    Some(BagPart::Chunk { size, crc, compression, data }) if !within => {
                        let bytes = self.unpacking.whole(&Chunk { compression, size, crc, data })?;
                        self.through(&mut bytes.as_slice(), true)?;
                    }
                    Some(part) => (self.each)(part)?,
                    None => return Err(refused("file", "an end within a record".to_owned(), WHOLE, COPY)),
                },
            }
        }
        Ok(())
    }
}

const WHOLE: &str = "a whole MCAP file";

const COPY: &str = "the file is truncated or damaged: copy it again, or mend it with `mcap recover`";

fn damaged(error: &McapError) -> LogError {
    let problem = match error {
        McapError::BadMagic => "bytes of another format".to_owned(),
        McapError::RecordTooLarge { len, .. } => {
            let expected = "at most a quarter of the memory, and 128 MiB";
            let remedy = "record smaller messages, raise --memory-mib, or copy the file again";
            return refused("record", format!("{len} bytes"), expected, remedy);
        }
        McapError::UnexpectedEof | McapError::UnexpectedEoc => "an end within a record".to_owned(),
        error => error.to_string().replace('\n', " "),
    };
    refused("file", problem, WHOLE, COPY)
}

fn refused(thing: &str, found: String, expected: &str, remedy: &str) -> LogError {
    LogError::Invalid(Invalid::new(thing, found, expected, remedy))
}

// ULog, the logs of PX4: definitions of messages, subscriptions of topics, then their messages.
// <https://docs.px4.io/main/en/dev_log/ulog_file_format.html>

const MAGIC: &[u8; 7] = b"ULog\x01\x12\x35";

/// The name of the message encoding, and of its definitions.
pub(crate) const ENCODING: &str = "ulog";

/// Bytes before the first message.
const HEADER: u64 = 16;

/// Kinds of messages that are not read: information, parameters, removals, text, synchronization, dropouts.
const OTHERS: &[u8] = b"IMPQRLCSO";

/// Most bytes of all definitions.
const MOST_BYTES: usize = 1 << 20;

/// Most sections that are appended.
const MOST_APPENDED: usize = 3;

/// Passes every subscription and message of `bytes` to `each`.
fn each_part_of_ulog(
    bytes: &mut dyn Read,
    each: &mut dyn FnMut(BagPart) -> Result<(), LogError>,
) -> Result<(), LogError> {
    let mut header = Vec::new();
    bytes.take(HEADER).read_to_end(&mut header)?;
    if !header.starts_with(MAGIC) || header.len() < HEADER as usize {
        let remedy = "copy the file again";
        return Err(Invalid::new("file", "bytes of another format", "a ULog of PX4", remedy).into());
    }
    let mut log = Log::default();
    let mut at = HEADER;
    while let Some((kind, message)) = log.next(bytes, &mut at)? {
        log.take(kind, &message, at, each)?;
    }
    Ok(())
}

#[derive(Default)]
struct Log {
    /// Definitions so far, a line each: `name:type field;type field`.
    formats: String,
    /// Topic and instance by the number of a subscription.
    topics: BTreeMap<u16, (String, u8)>,
    /// Where sections begin that were appended after a crash; the message before each may be cut.
    appended: Vec<u64>,
}

impl Log {
    /// The next message with its kind; `None` at the end.
    fn next(&self, bytes: &mut dyn Read, at: &mut u64) -> Result<Option<(u8, Vec<u8>)>, LogError> {
        loop {
            let start = *at;
            let mut head = Vec::new();
            // A message that an appended section cuts ends where that begins.
            let end = self.appended.iter().copied().find(|end| *end > start).unwrap_or(u64::MAX);
            bytes.take(3.min(end - start)).read_to_end(&mut head)?;
            if head.is_empty() {
                return Ok(None);
            }
            let (size, is_whole) = match *head.as_slice() {
                [low, high, _] => (u64::from(u16::from_le_bytes([low, high])), true),
                _ => (0, false),
            };
            let mut message = Vec::new();
            let wanted = size.min(end - start - head.len() as u64);
            bytes.take(wanted).read_to_end(&mut message)?;
            *at = start + (head.len() + message.len()) as u64;
            if is_whole && message.len() as u64 == size {
                return Ok(Some((head[2], message)));
            }
            if *at != end {
                return Err(cut(start).into());
            }
        }
    }

    fn take(
        &mut self,
        kind: u8,
        message: &[u8],
        at: u64,
        each: &mut dyn FnMut(BagPart) -> Result<(), LogError>,
    ) -> Result<(), LogError> {
        let wrong = || cut_message(kind, at);
        match kind {
            b'B' => self.flags(message).ok_or_else(wrong)?,
            b'F' => {
                self.formats += std::str::from_utf8(message).map_err(|_| wrong())?;
                self.formats.push('\n');
                if self.formats.len() > MOST_BYTES {
                    return Err(wrong().into());
                }
            }
            b'A' => {
                let mut rest = Rest(message);
                let number = rest.u8().ok_or_else(wrong)?;
                let id = rest.u16().ok_or_else(wrong)?;
                let topic = std::str::from_utf8(rest.0).map_err(|_| wrong())?;
                let subscription = (topic.to_owned(), number);
                if self.topics.insert(id, subscription.clone()).is_some_and(|before| before != subscription) {
                    return Err(wrong().into());
                }
                self.subscribe(id, each)?;
            }
            b'D' => {
                let mut rest = Rest(message);
                let id = rest.u16().filter(|id| self.topics.contains_key(id)).ok_or_else(wrong)?;
                each(BagPart::Message {
                    channel: u32::from(id),
                    log_time: 0,
                    publish_time: 0,
                    data: rest.0,
                })?;
            }
            kind if OTHERS.contains(&kind) => {}
            _ => return Err(wrong().into()),
        }
        Ok(())
    }

    /// Notes where appended sections begin; `None` where the log has something that is not known.
    fn flags(&mut self, message: &[u8]) -> Option<()> {
        let mut rest = Rest(message);
        let _compatible = rest.u64()?;
        let incompatible = rest.u64()?;
        // The first bit says that sections are appended.
        if incompatible > 1 {
            return None;
        }
        while let (1, Some(start)) = (incompatible, rest.u64()) {
            self.appended.push(start);
        }
        (self.appended.len() <= MOST_APPENDED).then_some(())
    }

    fn subscribe(
        &self,
        id: u16,
        each: &mut dyn FnMut(BagPart) -> Result<(), LogError>,
    ) -> Result<(), LogError> {
        let (topic, number) = &self.topics[&id];
        let id = u32::from(id);
        let data = self.formats.as_bytes();
        each(BagPart::Schema { id, name: topic, encoding: ENCODING, data })?;
        let (number, metadata) = (u32::from(*number), Vec::new());
        each(BagPart::Channel { id, number, schema: id, topic, encoding: ENCODING, metadata })
    }
}

/// The refusal of a log whose last whole message ends at byte `whole`.
fn cut(whole: u64) -> Invalid {
    let remedy = format!(
        "copy the file again; if the logger lost its power, keep what is whole: `head -c {whole} FILE > WHOLE.ulg`"
    );
    Invalid::new("file", format!("an end within a message, after byte {whole}"), "a whole ULog", remedy)
}

fn cut_message(kind: u8, at: u64) -> Invalid {
    let kind = char::from(kind).escape_default();
    let place = format!("a message `{kind}` before byte {at} that cannot be read");
    Invalid::new("file", place, "a whole ULog", "the file is damaged: copy it again")
}
