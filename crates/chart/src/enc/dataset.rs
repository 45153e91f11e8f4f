//! A file's description of itself: its cell, edition, update and units.

use refusal::foreign;

use crate::enc::iso8211::{Cursor, Lexical, Record, UNIT_END, expanded, format_of, other_product, records};
use crate::enc::{Datums, Invalid};

/// The purpose of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A whole cell (`.000`).
    Base,
    /// Changes to one.
    Update,
}

/// The cell that a file belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// What the file is for.
    pub purpose: Purpose,
    /// Name of the file that it was issued as.
    pub name: String,
    /// Edition; an update is for the cell of the same one.
    pub edition: String,
    /// Number of the last update that it includes: 0 for a new edition.
    pub update: u32,
    /// Date of issue, as YYYYMMDD.
    pub issued: String,
}

/// The units of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parameters {
    /// Units of coordinates per degree.
    pub per_degree: f64,
    /// Units of depths per metre.
    pub per_metre: f64,
    /// Compilation scale: 1 to this.
    pub scale: u32,
    /// The datums of heights and depths.
    pub datums: Datums,
}

/// The contents of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Structure {
    /// How national text is written.
    pub national: Lexical,
    /// Records of objects, isolated nodes, connected nodes, edges.
    pub records: [u32; 4],
}

/// Reads the record that identifies a file and describes its contents.
pub(crate) fn identity(record: &Record<'_>) -> Result<(Identity, Structure), Invalid> {
    let mut cursor = Cursor::needed(record, "DSID")?;
    cursor.u8()?;
    cursor.u32()?;
    let purpose = cursor.u8()?;
    cursor.u8()?;
    let mut text = || cursor.text(Lexical::Latin);
    let (name, edition, update) = (text()?, text()?, text()?);
    cursor.letters::<8>()?;
    let issued = cursor.letters::<8>()?;
    let standard = cursor.letters::<4>()?;
    let product = cursor.u8()?;
    if product != 1 {
        return Err(other_product(&format!("product {product} of S-57 {standard}")));
    }
    let refuse = |thing: &str, found: String, expected: &str| {
        Invalid::new(thing, found, expected, "download the cell again")
    };
    let update = update.trim();
    let number = if update.is_empty() { Ok(0) } else { update.parse() };
    let update =
        number.map_err(|_| refuse("number of the update (UPDN)", format!("`{update}`"), "a whole number"))?;
    let purpose = match purpose {
        1 => Purpose::Base,
        2 => Purpose::Update,
        other => return Err(refuse("purpose (EXPP)", other.to_string(), "1, a new cell, or 2, a revision")),
    };
    let identity = Identity { purpose, name, edition: edition.trim().to_owned(), update, issued };
    Ok((identity, structure(record)?))
}

fn structure(record: &Record<'_>) -> Result<Structure, Invalid> {
    let mut cursor = Cursor::needed(record, "DSSI")?;
    let (topology, _, national) = (cursor.u8()?, cursor.u8()?, cursor.u8()?);
    if topology != 2 {
        let structure = format!("structure {topology}");
        let remedy = "take the cell of the ENC product";
        return Err(Invalid::new("topology (DSTR)", structure, "2, chain-node, as in every ENC", remedy));
    }
    let [meta, cartographic, geo, collections] = [cursor.u32()?, cursor.u32()?, cursor.u32()?, cursor.u32()?];
    let objects = [cartographic, geo, collections].iter().fold(meta, |sum, n| sum.saturating_add(*n));
    let national = if national == 2 { Lexical::Ucs2 } else { Lexical::Latin };
    Ok(Structure { national, records: [objects, cursor.u32()?, cursor.u32()?, cursor.u32()?] })
}

/// The record of a cell that states its units.
pub(crate) fn parameters(record: &Record<'_>) -> Result<Parameters, Invalid> {
    let mut cursor = Cursor::needed(record, "DSPM")?;
    cursor.u8()?;
    cursor.u32()?;
    let datum = cursor.u8()?;
    let datums = Datums { heights: cursor.u8()?, depths: cursor.u8()? };
    let scale = cursor.u32()?;
    let [depths, heights, positions, coordinates] = [cursor.u8()?, cursor.u8()?, cursor.u8()?, cursor.u8()?];
    let (per_degree, per_metre) = (cursor.u32()?, cursor.u32()?);
    let one = |thing: &str, found: u8, expected: u8, what: &str| match found == expected {
        true => Ok(()),
        false => Err(refuse(thing, found.to_string(), &format!("{expected}, {what}"))),
    };
    one("horizontal datum (HDAT)", datum, 2, "WGS84, as in every ENC")?;
    one("unit of depths (DUNI)", depths, 1, "metres")?;
    one("unit of heights (HUNI)", heights, 1, "metres")?;
    one("unit of positions (PUNI)", positions, 1, "metres")?;
    one("unit of coordinates (COUN)", coordinates, 1, "longitude and latitude")?;
    if per_degree == 0 || per_metre == 0 {
        let units = format!("{per_degree} and {per_metre}");
        return Err(refuse("factors of coordinates and soundings (COMF, SOMF)", units, "numbers above 0"));
    }
    Ok(Parameters { per_degree: per_degree.into(), per_metre: per_metre.into(), scale, datums })
}

fn refuse(thing: &str, found: String, expected: &str) -> Invalid {
    Invalid::new(thing, found, expected, "take the cell of the ENC product")
}

// The catalogue of an exchange set (`CATALOG.031`; S-57 edition 3.1, part 3, 7.4.1): which files belong to it, and their checksums.

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
        self.crc.is_none_or(|stated| stated == crc(bytes))
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
    let files = data.iter().filter(|record| record.field(CATD).is_some());
    files.map(|record| subfields.listed(record)).collect()
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
            parts.get(1).map_or(String::new(), |part| part.iter().map(|b| char::from(*b)).collect());
        let place = |label: &str| labels.split('!').position(|other| other == label);
        let Some(file) = place("FILE") else { return refuse(format!("`{}`", foreign(&labels))) };
        let lengths = expanded(&format_of(described)).iter().map(|code| fixed(code)).collect();
        Ok(Self { lengths, file, crc: place("CRCS") })
    }

    fn listed(&self, record: &Record<'_>) -> Result<Listed, Invalid> {
        let mut cursor = Cursor::needed(record, CATD)?;
        let texts: Vec<String> =
            self.lengths.iter().map(|length| cursor.text_of(*length)).collect::<Result<_, _>>()?;
        let text = |index: usize| texts.get(index).map_or("", |text| text.trim());
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
