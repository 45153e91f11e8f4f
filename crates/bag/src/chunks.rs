//! Compressed chunks of bags. Their declared sizes are not trusted.

use std::io::Read;

use refusal::{Invalid, foreign};

/// Most bytes of a record or chunk in memory.
pub(crate) const LARGEST: usize = 1 << 27;

/// Most times that the chunks of a file may expand, beyond a fixed minimum: messages do not compress further.
const EXPANSION: u64 = 200;
const IN_ANY_CASE: u64 = 1 << 28;

/// A chunk as a bag has it; `crc` is 0 where there is none.
pub(crate) struct Chunk<'a> {
    pub(crate) compression: &'a str,
    pub(crate) size: u64,
    pub(crate) crc: u32,
    pub(crate) data: &'a [u8],
}

/// Bytes of chunks so far, compressed and decompressed; what a refusal expects, and its remedy.
pub(crate) struct Unpacking {
    packed: u64,
    unpacked: u64,
    whole: &'static str,
    mend: &'static str,
}

impl Unpacking {
    /// No chunks yet. Damaged ones are refused: expected is `whole`, the remedy is `mend`.
    pub(crate) fn new(whole: &'static str, mend: &'static str) -> Self {
        Self { packed: 0, unpacked: 0, whole, mend }
    }

    /// The decompressed bytes of a chunk, checked for size and checksum.
    ///
    /// # Errors
    /// Chunks that are too large, expand too much, are compressed in another way or damaged.
    pub(crate) fn whole(&mut self, chunk: &Chunk) -> Result<Vec<u8>, Invalid> {
        self.packed += chunk.data.len() as u64;
        self.unpacked += chunk.size.min(LARGEST as u64);
        if chunk.size > LARGEST as u64 {
            let found = format!("{} bytes", chunk.size);
            return Err(Invalid::new(
                "chunk",
                found,
                format!("at most {LARGEST}"),
                "record in smaller chunks",
            ));
        }
        if self.unpacked > EXPANSION * self.packed + IN_ANY_CASE {
            let found = format!("{} bytes, of {} in the file", self.unpacked, self.packed);
            let expected = format!("at most {EXPANSION} times as many");
            let remedy = "record again: these hold nothing, or are damaged";
            return Err(Invalid::new("chunks", found, expected, remedy));
        }
        let bytes = unpacked(chunk)?.filter(|bytes| bytes.len() as u64 == chunk.size);
        let Some(bytes) = bytes else {
            return Err(Invalid::new("chunk", "bytes that cannot be unpacked", self.whole, self.mend));
        };
        if chunk.crc != 0 && crc32fast::hash(&bytes) != chunk.crc {
            let found = "bytes that do not fit their checksum";
            return Err(Invalid::new("chunk", found, self.whole, self.mend));
        }
        Ok(bytes)
    }
}

/// At most `chunk.size` bytes of it, `None` where they are damaged.
fn unpacked(chunk: &Chunk) -> Result<Option<Vec<u8>>, Invalid> {
    let Chunk { compression, size, data, .. } = *chunk;
    let mut bytes = Vec::with_capacity(size as usize);
    let read = match compression {
        "" | "none" => data.take(size).read_to_end(&mut bytes),
        "zstd" => {
            zstd::stream::read::Decoder::new(data).and_then(|all| all.take(size).read_to_end(&mut bytes))
        }
        "lz4" => lz4_flex::frame::FrameDecoder::new(data).take(size).read_to_end(&mut bytes),
        "bz2" => bzip2::read::BzDecoder::new(data).take(size).read_to_end(&mut bytes),
        other => {
            let (found, remedy) = (format!("`{}`", foreign(other)), "convert the bag to one of these");
            return Err(Invalid::new("compression", found, "zstd, lz4, bz2 or none", remedy));
        }
    };
    Ok(read.is_ok().then_some(bytes))
}
