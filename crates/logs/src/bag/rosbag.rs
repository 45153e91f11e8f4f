//! Bags of ROS 1, version 2.0 of their format: records, each a header of named fields and data, many of them within
//! chunks. <http://wiki.ros.org/Bags/Format/2.0>

use std::collections::BTreeSet;
use std::io::Read;

use refusal::{Invalid, foreign};

use super::{BagPart, Effort, Rest};
use crate::LogError;

const MAGIC: &[u8; 13] = b"#ROSBAG V2.0\n";

const WHOLE: &str = "a whole bag of ROS 1";

const COPY: &str = "the file is truncated or damaged: copy it again, or mend it with `rosbag reindex`";

/// The name of the message encoding, and that of its definitions, as MCAP has them.
pub(crate) const ENCODING: [&str; 2] = ["ros1", "ros1msg"];

/// Most bytes of a record's header.
const LONGEST_HEADER: u32 = 1 << 20;

/// Passes every connection and message of `bytes` to `each`.
pub(crate) fn each_part(
    bytes: &mut dyn Read,
    effort: &Effort,
    each: &mut dyn FnMut(BagPart) -> Result<(), LogError>,
) -> Result<(), LogError> {
    let mut magic = Vec::new();
    bytes.take(MAGIC.len() as u64).read_to_end(&mut magic)?;
    if magic != MAGIC {
        let begin = String::from_utf8_lossy(&magic).trim().to_owned();
        let remedy = "convert an older one with `rosbag fix`, or copy the file again";
        return Err(Invalid::new("file", format!("`{}`", foreign(&begin)), "`#ROSBAG V2.0`", remedy).into());
    }
    let unpacking = Unpacking { effort, whole: WHOLE, mend: COPY };
    let mut walk =
        RosbagWalk { each, unpacking, known: BTreeSet::new(), at: MAGIC.len() as u64, index_at: None };
    walk.through(bytes, false)?;
    walk.check_closed()
}

/// The state of a pass over records.
struct RosbagWalk<'a> {
    each: &'a mut dyn FnMut(BagPart) -> Result<(), LogError>,
    unpacking: Unpacking<'a>,
    /// Connections so far.
    known: BTreeSet<u32>,
    /// Bytes of the file so far.
    at: u64,
    /// Where the index begins: 0 if the bag was never closed.
    index_at: Option<u64>,
}

impl RosbagWalk<'_> {
    /// Goes through a file, or through the records `within` a chunk.
    fn through(&mut self, bytes: &mut dyn Read, within: bool) -> Result<(), LogError> {
        while let Some((header, data)) = record(bytes, self.unpacking.effort.largest)? {
            if !within {
                self.at += 8 + header.len() as u64 + data.len() as u64;
            }
            let fields = Fields::new(&header).ok_or_else(cut)?;
            match fields.byte("op").ok_or_else(cut)? {
                0x02 => self.message(&fields, &data)?,
                0x03 => self.index_at = Some(fields.number("index_pos").ok_or_else(cut)?),
                0x05 if !within => {
                    let size = fields.number("size").ok_or_else(cut)?;
                    let compression = fields.text("compression").ok_or_else(cut)?;
                    let chunk = Chunk { compression, size, crc: 0, data: &data };
                    let bytes = self.unpacking.whole(&chunk)?;
                    self.through(&mut bytes.as_slice(), true)?;
                }
                0x07 => self.connection(&fields, &data)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn connection(&mut self, fields: &Fields, data: &[u8]) -> Result<(), LogError> {
        let id = fields.number("conn").and_then(|id| u32::try_from(id).ok()).ok_or_else(cut)?;
        let topic = fields.text("topic").ok_or_else(cut)?;
        let content = Fields::new(data).ok_or_else(cut)?;
        if !self.known.insert(id) {
            return Ok(());
        }
        let [encoding, kind] = ENCODING;
        let text = content.get("message_definition").unwrap_or_default();
        (self.each)(BagPart::Schema {
            id,
            name: content.text("type").ok_or_else(cut)?,
            encoding: kind,
            data: text,
        })?;
        let metadata = content.text("callerid").map(|name| ("callerid", name)).into_iter().collect();
        (self.each)(BagPart::Channel { id, number: id, schema: id, topic, encoding, metadata })
    }

    fn message(&mut self, fields: &Fields, data: &[u8]) -> Result<(), LogError> {
        let channel = fields.number("conn").and_then(|id| u32::try_from(id).ok()).ok_or_else(cut)?;
        if !self.known.contains(&channel) {
            let message = format!("a message of connection {channel}, which the bag does not describe");
            return Err(Invalid::new("file", message, WHOLE, COPY).into());
        }
        let time = fields.number("time").ok_or_else(cut)?;
        // Seconds stand in the lower four bytes, nanoseconds in the upper ones.
        let log_time = (time & 0xFFFF_FFFF) * 1_000_000_000 + (time >> 32);
        (self.each)(BagPart::Message { channel, log_time, publish_time: log_time, data })
    }

    /// Refuses a bag that the recorder did not close, and one that ends before its index.
    fn check_closed(&self) -> Result<(), LogError> {
        let state = match self.index_at {
            None => "no record that heads the bag".to_owned(),
            Some(0) => "a bag that was not closed".to_owned(),
            Some(index_at) if index_at > self.at => format!("an end {} bytes early", index_at - self.at),
            Some(_) => return Ok(()),
        };
        Err(Invalid::new("file", state, WHOLE, COPY).into())
    }
}

/// Header and data of a record.
type Record = (Vec<u8>, Vec<u8>);

/// The next record, of at most `largest` bytes; `None` at the end.
fn record(bytes: &mut dyn Read, largest: usize) -> Result<Option<Record>, LogError> {
    let Some(header_length) = length(bytes)? else { return Ok(None) };
    if header_length > LONGEST_HEADER {
        let header = format!("a header of {header_length} bytes");
        return Err(Invalid::new("record", header, format!("at most {LONGEST_HEADER}"), COPY).into());
    }
    let header = exactly(bytes, header_length)?;
    let data_length = length(bytes)?.ok_or_else(cut)?;
    if data_length as usize > largest {
        let size = format!("{data_length} bytes");
        let remedy = "record in smaller chunks, raise --memory-mib, or copy the file again";
        return Err(Invalid::new("record", size, format!("at most {largest}"), remedy).into());
    }
    Ok(Some((header, exactly(bytes, data_length)?)))
}

/// The length before a header or data; `None` at the end of the file.
fn length(bytes: &mut dyn Read) -> Result<Option<u32>, LogError> {
    let mut length = Vec::new();
    bytes.take(4).read_to_end(&mut length)?;
    match *length.as_slice() {
        [] => Ok(None),
        [a, b, c, d] => Ok(Some(u32::from_le_bytes([a, b, c, d]))),
        _ => Err(cut().into()),
    }
}

fn exactly(bytes: &mut dyn Read, length: u32) -> Result<Vec<u8>, LogError> {
    let mut all = Vec::new();
    bytes.take(u64::from(length)).read_to_end(&mut all)?;
    if all.len() as u64 == u64::from(length) { Ok(all) } else { Err(cut().into()) }
}

fn cut() -> Invalid {
    Invalid::new("file", "an end within a record", WHOLE, COPY)
}

/// The fields of a header: `name=value`, each after its length.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    /// Checks that all of `header` is fields.
    fn new(header: &'a [u8]) -> Option<Self> {
        let fields = Self(header);
        fields.all().all(|field| field.is_some()).then_some(fields)
    }

    /// Name and value of each field; `None` where there is none.
    fn all(&self) -> impl Iterator<Item = Option<(&'a [u8], &'a [u8])>> + use<'a> {
        let mut rest = Rest(self.0);
        std::iter::from_fn(move || {
            if rest.0.is_empty() {
                return None;
            }
            let field = rest.u32().and_then(|length| rest.bytes(u64::from(length)));
            Some(field.and_then(|field| {
                let equals = field.iter().position(|byte| *byte == b'=')?;
                Some((&field[..equals], &field[equals + 1..]))
            }))
        })
    }

    fn get(&self, name: &str) -> Option<&'a [u8]> {
        self.all().flatten().find(|(key, _)| *key == name.as_bytes()).map(|(_, value)| value)
    }

    fn text(&self, name: &str) -> Option<&'a str> {
        std::str::from_utf8(self.get(name)?).ok()
    }

    fn byte(&self, name: &str) -> Option<u8> {
        self.get(name)?.first().copied()
    }

    /// A number of four or eight bytes.
    fn number(&self, name: &str) -> Option<u64> {
        match self.get(name)? {
            value if value.len() == 8 => Rest(value).u64(),
            value => Rest(value).u32().map(u64::from),
        }
    }
}

/// A chunk as a bag has it; `crc` is 0 where there is none.
pub(crate) struct Chunk<'a> {
    pub(crate) compression: &'a str,
    pub(crate) size: u64,
    pub(crate) crc: u32,
    pub(crate) data: &'a [u8],
}

/// Unpacks the chunks of a file, and what a refusal of one expects, and its remedy.
pub(crate) struct Unpacking<'a> {
    pub(crate) effort: &'a Effort,
    pub(crate) whole: &'static str,
    pub(crate) mend: &'static str,
}

impl Unpacking<'_> {
    /// The decompressed bytes of a chunk, checked for size and checksum.
    pub(crate) fn whole(&self, chunk: &Chunk) -> Result<Vec<u8>, Invalid> {
        self.effort.unpack(chunk.data.len(), chunk.size)?;
        let bytes = unpacked(chunk)?.filter(|bytes| bytes.len() as u64 == chunk.size);
        let Some(bytes) = bytes else {
            return Err(Invalid::new("chunk", "bytes that cannot be unpacked", self.whole, self.mend));
        };
        if chunk.crc != 0 && crc32fast::hash(&bytes) != chunk.crc {
            return Err(Invalid::new("chunk", "bytes that do not fit their checksum", self.whole, self.mend));
        }
        Ok(bytes)
    }
}

/// Its bytes, at most one more than `chunk.size`; `None` where they are damaged: what is read to its end has its checksums
/// checked, those of zstd, LZ4 and bzip2.
fn unpacked(chunk: &Chunk) -> Result<Option<Vec<u8>>, Invalid> {
    let Chunk { compression, data, .. } = *chunk;
    let size = chunk.size + 1;
    let mut bytes = Vec::with_capacity(size as usize);
    let read = match compression {
        "" | "none" => data.take(size).read_to_end(&mut bytes),
        "zstd" => {
            zstd::stream::read::Decoder::new(data).and_then(|all| all.take(size).read_to_end(&mut bytes))
        }
        "lz4" => lz4_flex::frame::FrameDecoder::new(data).take(size).read_to_end(&mut bytes),
        "bz2" => bzip2::read::BzDecoder::new(data).take(size).read_to_end(&mut bytes),
        other => {
            let (name, remedy) = (format!("`{}`", foreign(other)), "convert the bag to one of these");
            return Err(Invalid::new("compression", name, "zstd, lz4, bz2 or none", remedy));
        }
    };
    Ok(read.is_ok().then_some(bytes))
}
