//! A planned trial with its drawing.

use artifact::{Digest, Error, is_written, read_written};
use study::documents::PlanDocument;

use super::drawing::refused;
use super::loader::Loader;

/// A plan with its map.
#[derive(Clone, Debug)]
pub struct PlannedTrial {
    /// Name of its folder, `plan-4-headings`; empty for the study's own plan.
    pub name: String,
    /// `plan.json`.
    pub plan: PlanDocument,
    /// `map.svg`, free of scripts and links.
    pub map: Option<String>,
    /// Files of this study that are not those that the plan was made from.
    pub stale: Vec<String>,
}

/// The map `name` of the results, noted; none where there is no such file.
pub(crate) fn map(loader: &mut Loader, name: &str) -> Result<Option<String>, Error> {
    let path = loader.sources.results.join(name);
    if !is_written(&path) {
        return Ok(None);
    }
    let bytes = read_written(&path)?;
    let digest = Digest::of_bytes(&bytes);
    let text = String::from_utf8(bytes).map_err(|_| "bytes that are not UTF-8".to_owned());
    let checked = text.and_then(|text| refused(&text).map_or(Ok(text), Err));
    let svg = checked.map_err(|found| {
        let expected = "a drawing of shapes and text, without scripts, styles or links";
        study::refuse(&path, "map", &found, expected, "run `plan` again, or remove the file")
    })?;
    loader.note(name, "map of the plan", digest);
    Ok(Some(svg))
}
