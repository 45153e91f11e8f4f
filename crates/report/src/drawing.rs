//! `map.svg` comes from a file and is put on the page unchanged, so it may contain only shapes and text.

/// The allowed elements of a map: those that this crate writes.
const ELEMENTS: [&str; 8] = ["svg", "g", "title", "desc", "path", "rect", "circle", "text"];
/// The allowed attributes: none of them loads, links, runs or names anything.
const ATTRIBUTES: [&str; 25] = [
    "aria-label",
    "cx",
    "cy",
    "d",
    "dy",
    "fill",
    "fill-opacity",
    "font-family",
    "font-size",
    "font-weight",
    "height",
    "r",
    "role",
    "stroke",
    "stroke-dasharray",
    "stroke-linecap",
    "stroke-linejoin",
    "stroke-opacity",
    "stroke-width",
    "text-anchor",
    "transform",
    "viewBox",
    "width",
    "x",
    "y",
];
const NAMESPACE: &str = "http://www.w3.org/2000/svg";

/// The reason to refuse `svg`; `None` if it is one plain drawing with balanced tags.
pub(crate) fn refused(svg: &str) -> Option<String> {
    if !svg.starts_with("<svg ") || !svg.trim_end().ends_with("</svg>") {
        return Some("text that is not one <svg> element".to_owned());
    }
    let mut open: Vec<&str> = Vec::new();
    for (index, piece) in svg.split('<').skip(1).enumerate() {
        if index > 0 && open.is_empty() {
            return Some("more than one element".to_owned());
        }
        let tag = piece.split_once('>').map(|(tag, _)| tag);
        let step = tag.map_or(Err("a tag that is not closed".to_owned()), |tag| enter(tag, &mut open));
        if let Err(found) = step {
            return Some(found);
        }
    }
    open.last().map(|name| format!("<{name}> without its end"))
}

/// Processes one tag.
fn enter<'a>(tag: &'a str, open: &mut Vec<&'a str>) -> Result<(), String> {
    if let Some(name) = tag.strip_prefix('/') {
        return if open.pop() == Some(name) { Ok(()) } else { Err(format!("</{name}> out of place")) };
    }
    let (tag, closed) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
    let (name, attributes) = tag.split_once(' ').unwrap_or((tag, ""));
    if !ELEMENTS.contains(&name) {
        return Err(format!("<{name}>"));
    }
    check(attributes).map_err(|found| format!("{found} in <{name}>"))?;
    open.extend((!closed).then_some(name));
    Ok(())
}

fn check(attributes: &str) -> Result<(), String> {
    let mut rest = attributes.trim();
    while !rest.is_empty() {
        let parts = rest.split_once("=\"").and_then(|(name, after)| Some((name, after.split_once('"')?)));
        let Some((name, (value, after))) = parts else {
            return Err("an attribute without quotes".to_owned());
        };
        let known = ATTRIBUTES.contains(&name) || (name == "xmlns" && value == NAMESPACE);
        if !known || value.to_ascii_lowercase().contains("url(") {
            return Err(format!("the attribute `{name}=\"{value}\"`"));
        }
        if !after.is_empty() && !after.starts_with(' ') {
            return Err("attributes that touch".to_owned());
        }
        rest = after.trim_start();
    }
    Ok(())
}
