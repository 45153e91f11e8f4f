//! Charts that are text, in any encoding.

use chart::Invalid;

/// Byte order marks: UTF-32 before UTF-16, whose mark is its prefix.
const UTF_32: [&[u8]; 2] = [&[0xff, 0xfe, 0, 0], &[0, 0, 0xfe, 0xff]];

/// The text of a file: in UTF-8, with or without a byte order mark, or in UTF-16 with one.
///
/// # Errors
/// Bytes that are not such text; names UTF-16 without a mark, and UTF-32.
pub fn chart_text(bytes: Vec<u8>) -> Result<String, Invalid> {
    if UTF_32.iter().any(|mark| bytes.starts_with(mark)) {
        return Err(refuse("text in UTF-32".to_owned()));
    }
    match bytes.get(..2) {
        Some([0xff, 0xfe]) => wide(&bytes[2..], u16::from_le_bytes),
        Some([0xfe, 0xff]) => wide(&bytes[2..], u16::from_be_bytes),
        _ => narrow(bytes),
    }
}

fn narrow(mut bytes: Vec<u8>) -> Result<String, Invalid> {
    if bytes.starts_with(&[0xef, 0xbb, 0xbf]) {
        bytes.drain(..3);
    }
    let zeros = bytes.iter().take(64).filter(|byte| **byte == 0).count();
    if zeros > 16 {
        return Err(refuse("text in UTF-16 without a byte order mark".to_owned()));
    }
    String::from_utf8(bytes).map_err(|e| refuse(e.to_string()))
}

fn wide(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String, Invalid> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    if !rest.is_empty() {
        return Err(refuse("text in UTF-16 that is cut off".to_owned()));
    }
    let decoded = char::decode_utf16(pairs.iter().map(|pair| unit(*pair)));
    decoded.collect::<Result<_, _>>().map_err(|_| refuse("half a character of UTF-16".to_owned()))
}

fn refuse(found: String) -> Invalid {
    let expected = "text in UTF-8, or in UTF-16 with a byte order mark";
    Invalid::new("file", found, expected, "export it again, or convert it with `iconv -t UTF-8`")
}
