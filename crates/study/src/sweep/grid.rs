use std::path::{Path, PathBuf};

use artifact::{Change, Changes, Error, Provenance};
use identification::Estimator;
use model::Vessel;
use refusal::Invalid;
use serde_json::json;
use toml::Value;

use super::SweepFile;
use crate::documents::{CellsDocument, SweepAxis, SweepCell, SweepDesign};
use crate::files::{read_any_simulated, read_campaign, read_dictionary};

/// The files that a grid may vary, in the order in which they are read.
const FILES: [&str; 3] = ["vessel", "dictionary", "campaign"];
/// Maximum number of cells of a grid.
const MOST: usize = 100_000;

/// The cells of the sweep in `path`, the last axis running fastest.
///
/// # Errors
/// A file that is refused; a key of no file; a grid whose cells are all refused by the study's files, as for an
/// unknown key.
pub fn cells(path: &Path, file: &SweepFile, provenance: &mut Provenance) -> Result<CellsDocument, Error> {
    let refuse = |invalid: Invalid| crate::invalid(path, &invalid);
    let axes = file.axes().map_err(refuse)?;
    let count = axes.iter().try_fold(1_usize, |all, (_, values)| all.checked_mul(values.len()));
    let Some(count) = count.filter(|count| *count <= MOST) else {
        let (found, expected) = ("more cells", format!("at most {MOST}"));
        return Err(crate::refuse(path, "`grid`", found, &expected, "vary less at once"));
    };
    let files = file.files(path);
    // Read unchanged first: errors in them are not due to a cell.
    let vessel = read(&files, provenance)?;
    let refused = |e| crate::invalid(&files[0], &e);
    file.estimators.iter().try_for_each(|own| own.check(&vessel)).map_err(refused)?;
    let forces = vessel.model.forces.is_some();
    let mut designs = Vec::new();
    let mut cells: Vec<SweepCell> = Vec::with_capacity(count);
    let mut first = None;
    for number in 0..count {
        let at = place(number, &axes);
        let changes = changes(&at, &axes).map_err(refuse)?;
        let mut own = Provenance { changes: changes.clone(), ..Provenance::default() };
        let refused = read(&files, &mut own).err();
        cells.push(SweepCell {
            name: format!("cell-{number:05}"),
            at,
            set: flags(&changes, &FILES),
            design: design(&mut designs, &changes, forces),
            inputs: own.inputs,
            refused: refused.as_ref().map(ToString::to_string),
        });
        first = first.or(refused);
    }
    match first.filter(|_| cells.iter().all(|cell| cell.refused.is_some())) {
        Some(refusal) => Err(refusal),
        None => Ok(CellsDocument {
            study: file.study.clone(),
            dictionary: file.dictionary(),
            axes: axes.into_iter().map(axis).collect(),
            shards: file.shards,
            baseline: file.baseline.clone(),
            moments: with(&file.moments_flags, "--estimator", forces),
            design: with(&file.design_flags, "--for", forces),
            monte_carlo: file.monte_carlo(),
            designs,
            cells,
        }),
    }
}

fn axis((key, values): (String, Vec<Value>)) -> SweepAxis {
    SweepAxis { key, values: values.iter().map(|value| json!(value)).collect() }
}

/// Reads the study's files as the stages do.
fn read([vessel, dictionary, campaign]: &[PathBuf; 3], provenance: &mut Provenance) -> Result<Vessel, Error> {
    let vessel = read_any_simulated(vessel, provenance)?;
    read_dictionary(dictionary, &vessel, provenance)?;
    read_campaign(campaign, provenance)?;
    Ok(vessel)
}

/// `flags`, which take output error by `flag` for a ship with forces.
fn with(flags: &[String], flag: &str, forces: bool) -> Vec<String> {
    let own = [flag, Estimator::OutputError.name()].map(str::to_owned);
    let more = if forces && !flags.iter().any(|given| given == flag) { &own[..] } else { &[] };
    [flags, more].concat()
}

/// The index on each axis of cell `number`.
fn place(mut number: usize, axes: &[(String, Vec<Value>)]) -> Vec<usize> {
    let mut at: Vec<usize> = Vec::with_capacity(axes.len());
    for (_, values) in axes.iter().rev() {
        at.push(number % values.len());
        number /= values.len();
    }
    at.reverse();
    at
}

/// The changes of the cell at `at`.
fn changes(at: &[usize], axes: &[(String, Vec<Value>)]) -> Result<Changes, Invalid> {
    let one = |(place, (key, values)): (&usize, &(String, Vec<Value>))| {
        let change = Change::new(key, values[*place].clone())?;
        match FILES.contains(&change.file()) {
            true => Ok(change),
            false => Err(Invalid::unknown(format!("`grid.{key}`"), change.file(), FILES)),
        }
    };
    Changes::new(at.iter().zip(axes).map(one).collect::<Result<_, _>>()?)
}

/// `--set` flags for the changes in `files`.
fn flags(changes: &Changes, files: &[&str]) -> Vec<String> {
    let own = changes.iter().filter(|change| files.contains(&change.file()));
    own.flat_map(|change| ["--set".to_owned(), change.to_string()]).collect()
}

/// The name of the design for these changes, which is new if no previous one had the same vessel and maneuvers; for a ship with
/// `forces` the same campaign, too, whose noise weighs the information.
fn design(designs: &mut Vec<SweepDesign>, changes: &Changes, forces: bool) -> String {
    let of_moments: &[&str] = if forces { &["vessel", "campaign"] } else { &["vessel"] };
    let [vessel, dictionary] = [of_moments, &FILES[..2]].map(|files| flags(changes, files));
    let same = |known: &&SweepDesign| known.dictionary == dictionary && known.vessel == vessel;
    if let Some(known) = designs.iter().find(same) {
        return known.name.clone();
    }
    let name = format!("design-{:05}", designs.len());
    designs.push(SweepDesign { name: name.clone(), vessel, dictionary });
    name
}
