//! The catalogue of an exchange set (`CATALOG.031`; S-57 edition 3.1, part 3, 7.4.1): which files belong to it, and their checksums.

use refusal::foreign;

use crate::enc::Invalid;
use crate::enc::cursor::Cursor;
use crate::enc::iso8211::{Record, UNIT_END, records};
use crate::enc::layout::{expanded, format_of};

/// A file that a catalogue lists.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Its path below the folder of the catalogue, in capitals, component by component.
    pub place: Vec<String>,
    /// Its CRC-32 (that of IEEE 802.3 and of zip archives; ENC product specification, 5.9); `None` where the catalogue has none.
    pub crc: Option<u32>,
}

impl Listed {
    /// Its name, in capitals.
    pub fn name(&self) -> &str {
        self.place.last().map_or("", String::as_str)
    }

    /// Whether its bytes match the catalogue; true where that has no checksum.
    pub fn agrees(&self, bytes: &[u8]) -> bool {
        self.crc.is_none_or(|own| own == crc(bytes))
    }
}

/// The checksum of a file, as in catalogues.
pub fn crc(file: &[u8]) -> u32 {
    crc32fast::hash(file)
}

/// The files that a catalogue lists, in its order.
///
/// # Errors
/// Files that are not ISO 8211, or cut off; another file than a catalogue; checksums that are not hexadecimal
/// numbers.
pub fn listed(catalogue: &[u8]) -> Result<Vec<Listed>, Invalid> {
    let records = records(catalogue)?;
    let Some((descriptive, data)) = records.split_first() else { return Ok(Vec::new()) };
    let subfields = Subfields::of(descriptive)?;
    let own = data.iter().filter(|record| record.field(CATD).is_some());
    own.map(|record| subfields.listed(record)).collect()
}

const CATD: &str = "CATD";

/// The layout of a catalogue's entries: the length of each subfield, if it is fixed.
struct Subfields {
    lengths: Vec<Option<usize>>,
    file: usize,
    crc: Option<usize>,
}

impl Subfields {
    fn of(descriptive: &Record<'_>) -> Result<Self, Invalid> {
        let refuse = |found: String| {
            let expected = "the field CATD with a subfield FILE";
            Err(Invalid::new("catalogue", found, expected, "copy the exchange set again, as a whole"))
        };
        let Some(described) = descriptive.field(CATD) else { return refuse("no field CATD".to_owned()) };
        let parts: Vec<&[u8]> = described.split(|b| *b == UNIT_END).collect();
        let labels: String =
            parts.get(1).map_or(String::new(), |own| own.iter().map(|b| char::from(*b)).collect());
        let place = |label: &str| labels.split('!').position(|own| own == label);
        let Some(file) = place("FILE") else { return refuse(format!("`{}`", foreign(&labels))) };
        let lengths = expanded(&format_of(described)).iter().map(|code| fixed(code)).collect();
        Ok(Self { lengths, file, crc: place("CRCS") })
    }

    fn listed(&self, record: &Record<'_>) -> Result<Listed, Invalid> {
        let mut cursor = Cursor::needed(record, CATD)?;
        let texts: Vec<String> =
            self.lengths.iter().map(|length| cursor.text_of(*length)).collect::<Result<_, _>>()?;
        let text = |index: usize| texts.get(index).map_or("", |own| own.trim());
        let crc = match self.crc.map_or("", text) {
            "" => None,
            digits => Some(u32::from_str_radix(digits, 16).map_err(|_| {
                let thing = format!("checksum of {} (CRCS)", foreign(text(self.file)));
                let expected = "eight hexadecimal digits, or nothing";
                Invalid::new(
                    thing,
                    format!("`{}`", foreign(digits)),
                    expected,
                    "copy the exchange set again, as a whole",
                )
            })?),
        };
        Ok(Listed { place: place(text(self.file)), crc })
    }
}

/// The components of a path as catalogues write it: with backslashes, and sometimes beginning at `ENC_ROOT`.
fn place(file: &str) -> Vec<String> {
    let parts = file.split(['\\', '/']).map(|part| part.trim().to_ascii_uppercase());
    let mut place: Vec<String> = parts.filter(|part| !part.is_empty() && part != ".").collect();
    if place.len() > 1 && place[0] == "ENC_ROOT" {
        place.remove(0);
    }
    place
}

/// The length of a text with a code such as `A(3)`; `None` for one up to its terminator.
fn fixed(code: &str) -> Option<usize> {
    code.split_once('(')?.1.strip_suffix(')')?.parse().ok()
}
