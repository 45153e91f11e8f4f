//! The records of a bag, one at a time, those within chunks among them.

use std::io::Read;

use mcap::records::{ChunkHeader, Record};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, parse_record};
use refusal::Invalid;

use crate::LogError;

/// Bytes beyond which no record and no chunk is held in memory.
const LARGEST: usize = 1 << 27;

/// Gives `each` record of `bytes`.
///
/// # Errors
/// Bytes that cannot be read or are no bag; what `each` refuses.
pub(super) fn each_record(
    mut bytes: impl Read,
    each: &mut dyn FnMut(Record) -> Result<(), LogError>,
) -> Result<(), LogError> {
    walk(&mut bytes, false, each)
}

/// Goes through a file, or through the records `within` a chunk.
fn walk(
    bytes: &mut dyn Read,
    within: bool,
    each: &mut dyn FnMut(Record) -> Result<(), LogError>,
) -> Result<(), LogError> {
    let options = LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(LARGEST);
    let options = options.with_skip_start_magic(within).with_skip_end_magic(within);
    let mut reader = LinearReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| damaged(&error))? {
            LinearReadEvent::ReadRequest(need) => {
                let read = bytes.read(reader.insert(need))?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { opcode, data } => {
                match parse_record(opcode, data).map_err(|error| damaged(&error))? {
                    Record::Chunk { header, data } if !within => {
                        walk(&mut unpacked(&header, &data)?.as_slice(), true, each)?;
                    }
                    record => each(record)?,
                }
            }
        }
    }
    Ok(())
}

/// What a chunk holds.
fn unpacked(header: &ChunkHeader, data: &[u8]) -> Result<Vec<u8>, LogError> {
    let size = header.uncompressed_size;
    if size > LARGEST as u64 {
        let expected = format!("at most {LARGEST}");
        return Err(refused("chunk", format!("{size} bytes"), &expected, "record in smaller chunks"));
    }
    let mut bytes = Vec::with_capacity(size as usize);
    let read = match header.compression.as_str() {
        "" => data.take(size).read_to_end(&mut bytes),
        "zstd" => {
            zstd::stream::read::Decoder::new(data).and_then(|all| all.take(size).read_to_end(&mut bytes))
        }
        "lz4" => lz4_flex::frame::FrameDecoder::new(data).take(size).read_to_end(&mut bytes),
        other => {
            let found = format!("`{other}`");
            return Err(refused(
                "compression",
                found,
                "zstd, lz4 or none",
                "convert the bag to one of these",
            ));
        }
    };
    let whole = read.is_ok() && bytes.len() as u64 == size;
    let stated = header.uncompressed_crc;
    if !whole || stated != 0 && crc32fast::hash(&bytes) != stated {
        return Err(refused("chunk", "bytes that do not fit their checksum".to_owned(), "a whole bag", COPY));
    }
    Ok(bytes)
}

const COPY: &str = "the file is truncated or damaged: copy it again, or mend it with `mcap recover`";

fn damaged(error: &McapError) -> LogError {
    let found = match error {
        McapError::BadMagic => "bytes of another format".to_owned(),
        McapError::UnexpectedEof | McapError::UnexpectedEoc => "an end within a record".to_owned(),
        error => error.to_string().replace('\n', " "),
    };
    refused("file", found, "a whole MCAP file", COPY)
}

fn refused(thing: &str, found: String, expected: &str, remedy: &str) -> LogError {
    LogError::Invalid(Invalid::new(thing, found, expected, remedy))
}
