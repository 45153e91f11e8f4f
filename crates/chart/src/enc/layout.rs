//! Checks the data descriptive record against the fields of S-57 (3.1, part 3, 7.3, binary).

use crate::enc::Invalid;
use crate::enc::iso8211::{FIELD_END, Record, UNIT_END};

/// Fields that are read, and their layout: `b12` an unsigned number of two bytes, `b24` a signed one of four,
/// `B(40)` forty bits, `A` text.
const FIELDS: [(&str, &str); 16] = [
    ("DSID", "b11,b14,2b11,3A,2A(8),R(4),b11,2A,b11,b12,A"),
    ("DSSI", "3b11,8b14"),
    ("DSPM", "b11,b14,3b11,b14,4b11,2b14,A"),
    ("VRID", "b11,b14,b12,b11"),
    ("ATTV", "b12,A"),
    ("VRPC", "b11,2b12"),
    ("VRPT", "B(40),4b11"),
    ("SGCC", "b11,2b12"),
    ("SG2D", "2b24"),
    ("SG3D", "3b24"),
    ("FRID", "b11,b14,2b11,2b12,b11"),
    ("FOID", "b12,b14,b12"),
    ("ATTF", "b12,A"),
    ("NATF", "b12,A"),
    ("FSPC", "b11,2b12"),
    ("FSPT", "B(40),3b11"),
];
/// Fields that only other products have.
const OTHERS: [(&[u8], &str); 3] =
    [(b"CATD", "a catalogue of an exchange set"), (b"ATCS", "S-101"), (b"CSID", "S-101")];

/// Refuses files of another product, and fields with another layout.
pub(crate) fn check(descriptive: &Record<'_>) -> Result<(), Invalid> {
    for (tag, product) in OTHERS {
        if descriptive.fields().any(|(own, _)| own == tag) {
            return Err(other_product(product));
        }
    }
    if descriptive.field("DSID").is_none() {
        return Err(other_product("ISO 8211 without the field DSID"));
    }
    for (tag, expected) in FIELDS {
        let Some(described) = descriptive.field(tag) else { continue };
        let found = format_of(described);
        if expanded(&found) != expanded(expected) {
            let remedy = "take the binary form of the cell (S-57, implementation `b`)";
            return Err(Invalid::new(
                format!("field {tag}"),
                format!("`{found}`"),
                format!("`({expected})`"),
                remedy,
            ));
        }
    }
    Ok(())
}

pub(crate) fn other_product(found: &str) -> Invalid {
    Invalid::new(
        "product",
        found,
        "a cell of an electronic chart by S-57 (ENC)",
        "take the S-57 cell (`.000`) of the same waters",
    )
}

/// The format at the end of a field's description.
pub(crate) fn format_of(described: &[u8]) -> String {
    let last = described.rsplit(|b| *b == UNIT_END).next().unwrap_or_default();
    last.iter().filter(|b| **b != FIELD_END).map(|b| char::from(*b)).collect()
}

/// The codes of a format, one per subfield: `(b11,2b12)` is b11, b12, b12.
pub(crate) fn expanded(format: &str) -> Vec<String> {
    let inside = format.strip_prefix('(').and_then(|f| f.strip_suffix(')')).unwrap_or(format);
    inside.split(',').flat_map(repeated).collect()
}

fn repeated(part: &str) -> impl Iterator<Item = String> {
    let digits = part.bytes().take_while(u8::is_ascii_digit).count();
    let (count, code) = part.split_at(digits);
    // No field of the table has more subfields.
    let count = count.parse().unwrap_or(1_usize).min(64);
    std::iter::repeat_n(code.to_owned(), count)
}
