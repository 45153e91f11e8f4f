//! A planned trial with its drawing.

use files::{Digest, Error, Work, budget, is_written, read_written};
use study::documents::{MapDocument, PlanDocument};

use super::loader::{Loader, document_at};
use super::plan_map::plan_map;

/// Approximate bytes per cell of a map while it is drawn.
const CELL_BYTES: f64 = 24.0;

/// A plan with its map.
#[derive(Clone, Debug)]
pub struct PlannedTrial {
    /// Name of its folder, `plan-4-headings`; empty for the study's own plan.
    pub name: String,
    /// `plan.json`.
    pub plan: PlanDocument,
    /// The map: drawn from `map.json`, or `map.svg`, free of scripts and links.
    pub map: Option<String>,
    /// What `map.json` has; absent beside a plan without one.
    pub document: Option<MapDocument>,
    /// Files of this study that differ from those that the plan was made from.
    pub stale: Vec<String>,
}

/// The map `name` of the results, drawn from its document, else read as a drawing, and notes the file; `None` if
/// there is neither. The document comes with it.
pub(crate) fn map(loader: &mut Loader, name: &str) -> Result<(Option<String>, Option<MapDocument>), Error> {
    let (drawn, document) = drawn(loader, &format!("{name}.json"))?.unzip();
    let name = format!("{name}.svg");
    let path = loader.sources.results.join(&name);
    if !is_written(&path) {
        return Ok((drawn, document));
    }
    let bytes = read_written(&path)?;
    loader.note(&name, "map of the plan", Digest::of_bytes(&bytes));
    if drawn.is_some() {
        return Ok((drawn, document));
    }
    let text = String::from_utf8(bytes).map_err(|_| "bytes that are not UTF-8".to_owned());
    let checked = text.and_then(|text| refused(&text).map_or(Ok(text), Err));
    let svg = checked.map_err(|found| {
        let expected = "a drawing of shapes and text, without scripts, styles or links";
        study::refuse(&path, "map", &found, expected, "run `plan` again, or remove the file")
    })?;
    Ok((Some(svg), None))
}

/// Draws the document `name`, and notes the file; `None` if there is no such file.
fn drawn(loader: &mut Loader, name: &str) -> Result<Option<(String, MapDocument)>, Error> {
    let path = loader.sources.results.join(name);
    let Some(loaded) = document_at::<MapDocument>(path.clone())? else { return Ok(None) };
    let cells = loaded.data.raster_cells();
    let (found, remedy) = (format!("{cells} cells"), "run `plan` again with a coarser raster");
    let work = Work { file: &path, thing: "`raster`", found: &found, remedy };
    budget().memory(work, CELL_BYTES * cells)?;
    let svg = plan_map(&loaded.data).map_err(|invalid| Error::invalid(&path, invalid))?;
    loader.note(name, "what the map of the plan shows", loaded.digest);
    Ok(Some((svg, loaded.data)))
}

// `map.svg` comes from a file and is put on the page unchanged, so it may contain only shapes and text.

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
fn refused(svg: &str) -> Option<String> {
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
