//! The records of a bag that are read, as bytes of the format. Lengths are not trusted.
//! <https://mcap.dev/spec#records>

/// A record.
#[derive(Debug, PartialEq)]
pub(super) enum Part<'a> {
    /// A message definition.
    Schema { id: u16, name: &'a str, encoding: &'a str, data: &'a [u8] },
    /// Messages of a topic from one publisher.
    Channel { id: u16, schema: u16, topic: &'a str, encoding: &'a str, metadata: Vec<(&'a str, &'a str)> },
    /// A message of a channel.
    Message { channel: u16, log_time: u64, publish_time: u64, data: &'a [u8] },
    /// Other records, compressed.
    Chunk { size: u64, crc: u32, compression: &'a str, data: &'a [u8] },
    /// Anything that is not needed.
    Other,
}

/// The record in the bytes `data`; `None` where it ends too early.
pub(super) fn part(opcode: u8, data: &[u8]) -> Option<Part<'_>> {
    let mut rest = Rest(data);
    Some(match opcode {
        0x03 => {
            let (id, name, encoding) = (rest.u16()?, rest.text()?, rest.text()?);
            let length = rest.u32()?;
            Part::Schema { id, name, encoding, data: rest.bytes(u64::from(length))? }
        }
        0x04 => Part::Channel {
            id: rest.u16()?,
            schema: rest.u16()?,
            topic: rest.text()?,
            encoding: rest.text()?,
            metadata: rest.pairs()?,
        },
        0x05 => {
            let (channel, _sequence) = (rest.u16()?, rest.u32()?);
            Part::Message { channel, log_time: rest.u64()?, publish_time: rest.u64()?, data: rest.0 }
        }
        0x06 => {
            let (_first, _last, size, crc) = (rest.u64()?, rest.u64()?, rest.u64()?, rest.u32()?);
            let (compression, length) = (rest.text()?, rest.u64()?);
            Part::Chunk { size, crc, compression, data: rest.bytes(length)? }
        }
        _ => Part::Other,
    })
}

/// Unread bytes.
struct Rest<'a>(&'a [u8]);

impl<'a> Rest<'a> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    fn bytes(&mut self, length: u64) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(usize::try_from(length).ok()?)?;
        self.0 = rest;
        Some(taken)
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()?;
        std::str::from_utf8(self.bytes(u64::from(length))?).ok()
    }

    fn pairs(&mut self) -> Option<Vec<(&'a str, &'a str)>> {
        let length = self.u32()?;
        let mut own = Rest(self.bytes(u64::from(length))?);
        let mut pairs = Vec::new();
        while !own.0.is_empty() {
            pairs.push((own.text()?, own.text()?));
        }
        Some(pairs)
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
        let expected = Part::Channel { id: 7, schema: 3, topic: "/fix", encoding: "cdr", metadata };
        assert_eq!(part(0x04, &channel), Some(expected));
        assert_eq!(part(0x0F, &[1]), Some(Part::Other));
        for end in 0..channel.len() {
            assert_eq!(part(0x04, &channel[..end]), None, "{end}");
        }
        let lies = [vec![7, 0], text("a/A"), text("ros2msg"), vec![0xFF; 4], vec![b'x'; 30]].concat();
        assert_eq!(part(0x03, &lies), None);
    }
}
