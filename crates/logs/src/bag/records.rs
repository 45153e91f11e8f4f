//! The records of a bag, one at a time, including those within chunks.

use std::io::Read;

use mcap::McapError;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use refusal::{Invalid, foreign};

use super::parts::{Part, part};
use crate::LogError;

/// Most bytes of a record or chunk in memory.
const LARGEST: usize = 1 << 27;

/// Most times that the chunks of a file may expand, beyond a fixed minimum: messages do not compress further.
const EXPANSION: u64 = 200;
const IN_ANY_CASE: u64 = 1 << 28;

/// Passes every record of `bytes` that is read to `each`.
///
/// # Errors
/// Bytes that cannot be read or are not a bag; refusals of `each`.
pub(super) fn each_record(
    mut bytes: impl Read,
    each: &mut dyn FnMut(Part) -> Result<(), LogError>,
) -> Result<(), LogError> {
    Walk { each, packed: 0, unpacked: 0 }.through(&mut bytes, false)
}

/// The state of a pass over records.
struct Walk<'a> {
    each: &'a mut dyn FnMut(Part) -> Result<(), LogError>,
    /// Bytes of chunks so far, compressed and decompressed.
    packed: u64,
    unpacked: u64,
}

impl Walk<'_> {
    /// Goes through a file, or through the records `within` a chunk.
    fn through(&mut self, bytes: &mut dyn Read, within: bool) -> Result<(), LogError> {
        let options = LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(LARGEST);
        let options = options.with_skip_start_magic(within).with_skip_end_magic(within);
        let mut reader = LinearReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            match event.map_err(|error| damaged(&error))? {
                LinearReadEvent::ReadRequest(need) => {
                    let read = bytes.read(reader.insert(need))?;
                    reader.notify_read(read);
                }
                LinearReadEvent::Record { opcode, data } => match part(opcode, data) {
                    Some(Part::Chunk { size, crc, compression, data }) if !within => {
                        let bytes = self.unpacked(compression, [size, u64::from(crc)], data)?;
                        self.through(&mut bytes.as_slice(), true)?;
                    }
                    Some(part) => (self.each)(part)?,
                    None => return Err(refused("file", "an end within a record".to_owned(), WHOLE, COPY)),
                },
            }
        }
        Ok(())
    }

    /// The decompressed bytes of a chunk, checked for size and checksum.
    fn unpacked(
        &mut self,
        compression: &str,
        [size, crc]: [u64; 2],
        data: &[u8],
    ) -> Result<Vec<u8>, LogError> {
        self.packed += data.len() as u64;
        self.unpacked += size.min(LARGEST as u64);
        if size > LARGEST as u64 {
            let expected = format!("at most {LARGEST}");
            return Err(refused("chunk", format!("{size} bytes"), &expected, "record in smaller chunks"));
        }
        if self.unpacked > EXPANSION * self.packed + IN_ANY_CASE {
            let found = format!("{} bytes, of {} in the file", self.unpacked, self.packed);
            let expected = format!("at most {EXPANSION} times as many");
            return Err(refused(
                "chunks",
                found,
                &expected,
                "record again: these hold nothing, or are damaged",
            ));
        }
        let bytes = whole(compression, size, data)?;
        if crc != 0 && u64::from(crc32fast::hash(&bytes)) != crc {
            return Err(refused("chunk", "bytes that do not fit their checksum".to_owned(), WHOLE, COPY));
        }
        Ok(bytes)
    }
}

/// Decompresses a chunk into `size` bytes.
fn whole(compression: &str, size: u64, data: &[u8]) -> Result<Vec<u8>, LogError> {
    let mut bytes = Vec::with_capacity(size as usize);
    let read = match compression {
        "" => data.take(size).read_to_end(&mut bytes),
        "zstd" => {
            zstd::stream::read::Decoder::new(data).and_then(|all| all.take(size).read_to_end(&mut bytes))
        }
        "lz4" => lz4_flex::frame::FrameDecoder::new(data).take(size).read_to_end(&mut bytes),
        other => {
            let (found, remedy) = (format!("`{}`", foreign(other)), "convert the bag to one of these");
            return Err(refused("compression", found, "zstd, lz4 or none", remedy));
        }
    };
    if read.is_err() || bytes.len() as u64 != size {
        return Err(refused("chunk", "bytes that cannot be unpacked".to_owned(), WHOLE, COPY));
    }
    Ok(bytes)
}

const WHOLE: &str = "a whole MCAP file";

const COPY: &str = "the file is truncated or damaged: copy it again, or mend it with `mcap recover`";

fn damaged(error: &McapError) -> LogError {
    let found = match error {
        McapError::BadMagic => "bytes of another format".to_owned(),
        McapError::UnexpectedEof | McapError::UnexpectedEoc => "an end within a record".to_owned(),
        error => error.to_string().replace('\n', " "),
    };
    refused("file", found, WHOLE, COPY)
}

fn refused(thing: &str, found: String, expected: &str, remedy: &str) -> LogError {
    LogError::Invalid(Invalid::new(thing, found, expected, remedy))
}
