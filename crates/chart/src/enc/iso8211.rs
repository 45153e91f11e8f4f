//! Records of ISO 8211: a leader, a directory of fields, their bytes.

use crate::enc::Invalid;

/// Ends a field, and the directory.
pub(crate) const FIELD_END: u8 = 0x1e;
/// Ends a subfield of text.
pub(crate) const UNIT_END: u8 = 0x1f;
const LEADER: usize = 24;

/// One record: tags of four characters and the bytes of their fields, terminators included.
pub(crate) struct Record<'a> {
    /// Index in the file, from 0: the data descriptive record.
    pub number: usize,
    fields: Vec<(&'a [u8], &'a [u8])>,
}

impl<'a> Record<'a> {
    /// The bytes of the first field of a tag.
    pub(crate) fn field(&self, tag: &str) -> Option<&'a [u8]> {
        self.fields.iter().find(|(own, _)| *own == tag.as_bytes()).map(|(_, bytes)| *bytes)
    }

    /// All fields.
    pub(crate) fn fields(&self) -> impl Iterator<Item = (&'a [u8], &'a [u8])> + '_ {
        self.fields.iter().copied()
    }
}

/// All records of a file: the data descriptive record, then data records.
pub(crate) fn records(file: &[u8]) -> Result<Vec<Record<'_>>, Invalid> {
    first_records(file, usize::MAX)
}

/// The first `most` records of a file, or all if there are fewer.
pub(crate) fn first_records(file: &[u8], most: usize) -> Result<Vec<Record<'_>>, Invalid> {
    let mut records = Vec::new();
    let mut at = 0;
    while at < file.len() && records.len() < most {
        let (record, length) = record(&file[at..], records.len(), at)?;
        records.push(record);
        at += length;
    }
    match records.is_empty() {
        true => Err(no_leader("an empty file")),
        false => Ok(records),
    }
}

/// The record at the beginning of `rest`, and its length.
fn record(rest: &[u8], number: usize, at: usize) -> Result<(Record<'_>, usize), Invalid> {
    let leader = Leader::read(rest, number).ok_or_else(|| match (number, rest.len() < LEADER) {
        (0, _) => no_leader("none at its beginning"),
        (_, true) => cut(number, at, format!("{} bytes of a leader", rest.len())),
        (_, false) => cut(number, at, "no leader".to_owned()),
    })?;
    let whole = |to: usize| rest.get(..to).ok_or_else(|| short(number, at, to, rest.len()));
    let directory = whole(leader.base)?.get(LEADER..).unwrap_or_default();
    let broken = || cut(number, at, "a directory that leads out of the record".to_owned());
    let entries = directory.strip_suffix(&[FIELD_END]).ok_or_else(broken)?;
    let width = 4 + leader.length_digits + leader.place_digits;
    let mut fields = Vec::with_capacity(entries.len() / width);
    let mut end = leader.base;
    for entry in entries.chunks(width) {
        let (length, place) = leader.entry(entry).ok_or_else(broken)?;
        let from = leader.base + place;
        end = end.max(from + length);
        let to = from + length;
        if leader.length > 0 && to > leader.length {
            return Err(broken());
        }
        fields.push((&entry[..4], &whole(to)?[from..]));
    }
    // Records of 100,000 bytes and more do not state their length.
    let length = if leader.length > 0 { leader.length } else { end };
    whole(length)?;
    Ok((Record { number, fields }, length))
}

/// The leader at the beginning of a record.
struct Leader {
    length: usize,
    /// Where the fields begin.
    base: usize,
    length_digits: usize,
    place_digits: usize,
}

impl Leader {
    /// `None` where there is none of the right kind: the first record is descriptive, all others are data.
    fn read(rest: &[u8], number: usize) -> Option<Self> {
        let leader = rest.get(..LEADER)?;
        let kind = if number == 0 { b'L' } else { b'D' };
        let digit = |k: usize| decimal(&leader[k..=k]);
        let own = Self {
            length: decimal(&leader[..5])?,
            base: decimal(&leader[12..17])?,
            length_digits: digit(20)?,
            place_digits: digit(21)?,
        };
        let sound = leader[6] == kind && digit(23) == Some(4) && own.base > LEADER;
        sound.then_some(own)
    }

    /// Length and offset of a field, from its entry in the directory.
    fn entry(&self, entry: &[u8]) -> Option<(usize, usize)> {
        let length = decimal(entry.get(4..4 + self.length_digits)?)?;
        let place = decimal(entry.get(4 + self.length_digits..4 + self.length_digits + self.place_digits)?)?;
        Some((length, place))
    }
}

fn decimal(digits: &[u8]) -> Option<usize> {
    let digits = std::str::from_utf8(digits).ok()?;
    digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok())?
}

fn no_leader(found: &str) -> Invalid {
    Invalid::new(
        "leader of ISO 8211",
        format!("{found} (encrypted by S-63, compressed, or no chart)"),
        "a cell of an electronic chart (S-57) that is not encrypted",
        "decrypt it with the permit of its data server, or take the producer's open cell",
    )
}

fn short(number: usize, at: usize, wanted: usize, found: usize) -> Invalid {
    cut(number, at, format!("{found} of at least {wanted} bytes: the file is cut off"))
}

fn cut(number: usize, at: usize, found: String) -> Invalid {
    let thing = format!("record {number} at byte {at}");
    Invalid::new(thing, found, "a whole record of ISO 8211", "download or copy the file again")
}
