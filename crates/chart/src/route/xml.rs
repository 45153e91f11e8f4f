//! XML documents as indented text.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

use crate::Invalid;

pub(crate) type Xml = Writer<Vec<u8>>;

/// A document whose elements `content` writes.
pub(crate) fn document(content: impl FnOnce(&mut Xml) -> io::Result<()>) -> Result<String, Invalid> {
    let failed = |found: String| Invalid::new("XML", found, "text", "report this as a defect");
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    let declaration = BytesDecl::new("1.0", Some("UTF-8"), None);
    let written = writer.write_event(Event::Decl(declaration)).and_then(|()| content(&mut writer));
    written.map_err(|e| failed(e.to_string()))?;
    let mut text = String::from_utf8(writer.into_inner()).map_err(|e| failed(e.to_string()))?;
    text.push('\n');
    Ok(text)
}

/// An element that holds text.
pub(crate) fn element(xml: &mut Xml, name: &str, text: &str) -> io::Result<()> {
    xml.create_element(name).write_text_content(BytesText::new(text)).map(|_| ())
}

/// A decimal number without exponent and trailing zeros.
pub(crate) fn decimal(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

/// Longitude in [−180, 180) as both formats require, to 10⁻⁹ degrees.
pub(crate) fn longitude(lon_deg: f64) -> String {
    let text = decimal(lon_deg, 9);
    if text == "180" { "-180".to_owned() } else { text }
}

/// Latitude, to 10⁻⁹ degrees (0.1 mm).
pub(crate) fn latitude(lat_deg: f64) -> String {
    decimal(lat_deg, 9)
}
