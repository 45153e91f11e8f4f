use std::path::Path;

use artifact::{Error, Loaded, Provenance, read_document};
use refusal::Invalid;
use serde::Deserialize;

use crate::documents::{
    CellsDocument, RefusedCell, SweepCell, SweepDocument, SweepLine, SweptCell, TallyDocument,
};

/// The `--json` output of a stage that writes nothing, in place of its file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Refusal {
    #[serde(rename = "exit_code")]
    _exit_code: u8,
    error: String,
}

/// The sweep over the cells of `grid`. Their tallies, or the refusals in their place, are in `folder`, each in a
/// folder with the cell's name.
///
/// # Errors
/// A tally that is refused, is a shard or is that of another cell or study; a baseline that a tally does not have.
pub fn collected(
    grid: &CellsDocument,
    folder: &Path,
    provenance: &mut Provenance,
) -> Result<SweepDocument, Error> {
    let (mut cells, mut refused) = (Vec::new(), Vec::new());
    let mut baseline = grid.baseline.clone();
    for cell in &grid.cells {
        let path = folder.join(&cell.name).join("tally.json");
        match found(cell, &path)? {
            Found::Refused(refusal) => refused.push(RefusedCell::new(cell, refusal)),
            Found::Tally(loaded) => {
                check(cell, &path, &loaded)?;
                provenance.inputs.insert(cell.name.clone(), loaded.digest);
                let line = against(&loaded.data, &mut baseline).map_err(|e| crate::invalid(&path, &e))?;
                cells.push(SweptCell::new(cell, &loaded.data, &line));
            }
        }
    }
    Ok(SweepDocument::new(grid, baseline.filter(|_| !cells.is_empty()), cells, refused))
}

enum Found {
    Tally(Box<Loaded<TallyDocument>>),
    Refused(String),
}

fn found(cell: &SweepCell, path: &Path) -> Result<Found, Error> {
    if let Some(refusal) = &cell.refused {
        return Ok(Found::Refused(refusal.clone()));
    }
    let bytes = artifact::read_written(path)?;
    match serde_json::from_slice::<Refusal>(&bytes) {
        Ok(refusal) => Ok(Found::Refused(refusal.error)),
        Err(_) => Ok(Found::Tally(Box::new(read_document(path)?))),
    }
}

/// Refuses the tally at `path` if it is a shard or was made from other files than `cell`.
fn check(cell: &SweepCell, path: &Path, loaded: &Loaded<TallyDocument>) -> Result<(), Error> {
    let from = &loaded.provenance;
    if let Some(shard) = from.shard {
        let (found, expected) = (format!("shard {shard}"), "the whole tally of a cell");
        return Err(crate::refuse(
            path,
            "shard",
            &found,
            expected,
            "gather the shards with monte-carlo --gather",
        ));
    }
    match cell.inputs.iter().find(|(role, digest)| from.inputs.get(*role) != Some(*digest)) {
        Some((role, _)) => {
            let (found, expected) = (format!("another {role}"), format!("that of {}", cell.name));
            let remedy = "make the sweep again (`make sweep` does)";
            Err(crate::refuse(path, &format!("inputs.{role}"), &found, &expected, remedy))
        }
        None => Ok(()),
    }
}

/// The baseline: the first line of the first tally if none is named.
fn against(tally: &TallyDocument, named: &mut Option<SweepLine>) -> Result<SweepLine, Invalid> {
    let lines = tally.tally.counted.iter();
    let mut lines = lines.map(|c| SweepLine { design: c.design.clone(), estimator: c.estimator });
    let Some(line) = named.clone().or_else(|| lines.clone().next()) else {
        return Err(Invalid::new("`counted`", "nothing", "designs and estimators", "write the tally again"));
    };
    if !lines.any(|own| own == line) {
        let designs: Vec<&str> = tally.tally.counted.iter().map(|c| c.design.as_str()).collect();
        return Err(Invalid::unknown("`baseline.design`", &line.design, designs));
    }
    *named = Some(line.clone());
    Ok(line)
}
