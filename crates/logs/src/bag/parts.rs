//! What is in a bag of any kind; and the records of MCAP, as bytes of the format.
//! <https://mcap.dev/spec#records>

use crate::bag::rest::Rest;

/// A part of a bag.
#[derive(Debug, PartialEq)]
pub(crate) enum Part<'a> {
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
pub(crate) fn part(opcode: u8, data: &[u8]) -> Option<Part<'_>> {
    let mut rest = Rest(data);
    Some(match opcode {
        0x03 => {
            let (id, name, encoding) = (u32::from(rest.u16()?), rest.text()?, rest.text()?);
            let length = rest.u32()?;
            Part::Schema { id, name, encoding, data: rest.bytes(u64::from(length))? }
        }
        0x04 => {
            let (id, schema) = (u32::from(rest.u16()?), u32::from(rest.u16()?));
            let (topic, encoding, metadata) = (rest.text()?, rest.text()?, rest.pairs()?);
            Part::Channel { id, number: id, schema, topic, encoding, metadata }
        }
        0x05 => {
            let (channel, _sequence) = (u32::from(rest.u16()?), rest.u32()?);
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
            Part::Channel { id: 7, number: 7, schema: 3, topic: "/fix", encoding: "cdr", metadata };
        assert_eq!(part(0x04, &channel), Some(expected));
        assert_eq!(part(0x0F, &[1]), Some(Part::Other));
        for end in 0..channel.len() {
            assert_eq!(part(0x04, &channel[..end]), None, "{end}");
        }
        let lies = [vec![7, 0], text("a/A"), text("ros2msg"), vec![0xFF; 4], vec![b'x'; 30]].concat();
        assert_eq!(part(0x03, &lies), None);
    }
}
