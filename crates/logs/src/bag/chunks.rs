//! Compressed chunks of bags. Their declared sizes are not trusted.

use std::io::Read;

use refusal::{Invalid, foreign};

use crate::bag::effort::Effort;

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
    ///
    /// # Errors
    /// Chunks that are too large, expand too much, are compressed in another way or damaged.
    pub(crate) fn whole(&self, chunk: &Chunk) -> Result<Vec<u8>, Invalid> {
        self.effort.unpack(chunk.data.len(), chunk.size)?;
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
            let (found, remedy) = (format!("`{}`", foreign(other)), "convert the bag to one of these");
            return Err(Invalid::new("compression", found, "zstd, lz4, bz2 or none", remedy));
        }
    };
    Ok(read.is_ok().then_some(bytes))
}
