//! Files that are read from beginning to end.

use std::io::Read;

use mcap::McapError;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use refusal::Invalid;

use super::rosbag::{Chunk, Unpacking};
use super::{Effort, Part, part};
use crate::Format;
use crate::bag::{BagError, rosbag, ulog};

/// Passes every part of `bytes` that is read to `each`.
///
/// # Errors
/// Bytes that cannot be read or are not of the format; refusals of `each`.
pub(crate) fn each_part(
    bytes: &mut dyn Read,
    format: Format,
    effort: &Effort,
    each: &mut dyn FnMut(Part) -> Result<(), BagError>,
) -> Result<(), BagError> {
    match format {
        Format::Bag => rosbag::each_part(bytes, effort, each),
        Format::Ulg => ulog::each_part(bytes, each),
        _ => each_record(bytes, effort, each),
    }
}

// The records of an MCAP file, one at a time, including those within chunks.

/// Passes every record of `bytes` that is read to `each`.
///
/// # Errors
/// Bytes that cannot be read or are not a bag; refusals of `each`.
fn each_record(
    bytes: &mut dyn Read,
    effort: &Effort,
    each: &mut dyn FnMut(Part) -> Result<(), BagError>,
) -> Result<(), BagError> {
    Walk { each, unpacking: Unpacking { effort, whole: WHOLE, mend: COPY } }.through(bytes, false)
}

/// The state of a pass over records.
struct Walk<'a> {
    each: &'a mut dyn FnMut(Part) -> Result<(), BagError>,
    unpacking: Unpacking<'a>,
}

impl Walk<'_> {
    /// Goes through a file, or through the records `within` a chunk.
    fn through(&mut self, bytes: &mut dyn Read, within: bool) -> Result<(), BagError> {
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
                    Some(Part::Chunk { size, crc, compression, data }) if !within => {
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

fn damaged(error: &McapError) -> BagError {
    let found = match error {
        McapError::BadMagic => "bytes of another format".to_owned(),
        McapError::RecordTooLarge { len, .. } => {
            let expected = "at most a quarter of the memory, and 128 MiB";
            let remedy = "record smaller messages, raise --memory-mib, or copy the file again";
            return refused("record", format!("{len} bytes"), expected, remedy);
        }
        McapError::UnexpectedEof | McapError::UnexpectedEoc => "an end within a record".to_owned(),
        error => error.to_string().replace('\n', " "),
    };
    refused("file", found, WHOLE, COPY)
}

fn refused(thing: &str, found: String, expected: &str, remedy: &str) -> BagError {
    BagError::Invalid(Invalid::new(thing, found, expected, remedy))
}
