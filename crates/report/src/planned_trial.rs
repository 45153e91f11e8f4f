//! A planned trial with its drawing.

use files::{Digest, Error, Work, budget, exists, read};
use study::documents::{MapDocument, PlanDocument};

use super::drawing::refused;
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
    if !exists(&path) {
        return Ok((drawn, document));
    }
    let bytes = read(&path)?;
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
