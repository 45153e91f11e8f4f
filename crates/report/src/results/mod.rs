//! The results of many studies as tables in Markdown, for documentation: every number is one of a document.

mod estimators;
mod logs;
mod rounds;
mod selections;
mod unknown;

use std::path::{Component, Path, PathBuf};

use files::{Document, Error, Loaded, Provenance, TableReader};
use serde_json::Value;
use study::documents::{Bounds, PublishedShare, Quantiles, Reference, ValidationDocument};
use study::files::{read_campaign, read_reference};
use study::trajectories;

use crate::loader::{document_at, existing};
use crate::number::{exact, or_dash, percent_within, published, three_within};

/// Folders that the stages wrote into. Missing ones are reported.
#[derive(Clone, Debug, Default)]
pub struct Folders {
    /// Folder of the studies' hand-written files, one per study: their reference.toml has published results.
    pub written: Option<PathBuf>,
    /// Simulated trials of designs: validation.json, estimate.json.
    pub studies: Vec<PathBuf>,
    /// The same, with a comparison of estimators.
    pub scenarios: Vec<PathBuf>,
    /// For each scenario, in a subfolder, estimates with a current as an unknown: validation.json, estimate.json.
    pub unknown: Vec<PathBuf>,
    /// Trials in rounds: sequential.json.
    pub rounds: Vec<PathBuf>,
    /// Picks of sub-experiments: selection.json.
    pub selections: Vec<PathBuf>,
    /// Measured logs: crossval.json.
    pub logs: Vec<PathBuf>,
}

/// The requested tables, a section each.
///
/// # Errors
/// An existing document is refused.
pub fn tables(folders: &Folders) -> Result<String, Error> {
    let sections = [
        section(&folders.studies, folders.written.as_deref())?,
        estimators::section(&folders.scenarios)?,
        unknown::section(&folders.unknown)?,
        rounds::section(&folders.rounds)?,
        selections::section(&folders.selections, folders.written.as_deref())?,
        logs::section(&folders.logs)?,
    ];
    Ok(format!("{HEAD}\n{}", sections.into_iter().flatten().collect::<Vec<_>>().join("\n")))
}

const HEAD: &str = "# Results

Written by `make results` from the documents of the studies; not to be edited. In brackets stands the 95 % confidence
interval of what endless trials would give: of 100 studies, each with other noise, the intervals of about 95 hold it. The value of a
repeated study falls into the interval printed here less often, some 83 times of 100. A dash stands where a document has none.
";

// Shares of good models and median errors, by study and design.

fn section(folders: &[PathBuf], written: Option<&Path>) -> Result<Option<String>, Error> {
    let (found, missing) = documents::<ValidationDocument>(folders, "validation.json")?;
    let (mut rows, mut bounds, mut used) = (Vec::new(), Vec::new(), String::new());
    for (folder, Loaded { data: validation, .. }) in &found {
        let (name, seed) = (label(folder), seed(folder)?);
        let of = (name.clone(), length_s(written, &name)?);
        let reference = reference(written, &name)?;
        let Bounds { parameter_error, simulation_error } = validation.bounds;
        bounds.push(format!("{name} {} and {}", exact(parameter_error), exact(simulation_error)));
        if let Some(own) = reference.as_ref().and_then(|r| r.used.as_ref()) {
            used += &format!("\nOf the published numbers of {name}: {own}\n");
        }
        let published = |design: &str| reference.as_ref()?.designs.get(design).copied();
        rows.extend(validation.designs.iter().map(|d| (of.clone(), seed, d, published(&d.design))));
    }
    let table = Table::of(rows)
        .column("study", |((name, _), ..)| name.clone())
        .column("length, s", |((_, length_s), ..)| or_dash(length_s.map(exact)))
        .column("design", |(_, _, d, _)| d.design.clone())
        .column("trials", |(_, _, d, _)| d.runs.to_string())
        .column("seed", |(_, seed, ..)| or_dash(*seed))
        .column("parameter error below the bound", |(_, _, d, published)| {
            share(d.parameter_error_share, d.parameter_error_share_interval)
                + &published_share(published.map(|p| p.parameter_error_share))
        })
        .column("simulation error below the bound", |(_, _, d, published)| {
            share(d.simulation_error_share, d.simulation_error_share_interval)
                + &published_share(published.map(|p| p.simulation_error_share))
        })
        .column("median parameter error", |(_, _, d, _)| median(&d.parameter_error))
        .column("median simulation error", |(_, _, d, _)| median(&d.simulation_error));
    let note = left_out(&missing, "not computed");
    if found.iter().any(|(_, v)| v.data.designs.iter().any(|d| d.design == "practice")) {
        used = format!("\n{PRACTICE}\n{used}");
    }
    Ok(table.text().map(|table| {
        let bounds = bounds.join(", ");
        format!("## Designs\n\n{table}\nBounds on parameter and simulation error: {bounds}.\n{used}{note}")
    }))
}

/// What the design of that name is.
const PRACTICE: &str = "Practice is today's practice: the maneuvers of the dictionary, one after another, for the same \
     seconds and by the same estimator. Dashes stand where they tell no model, since some parameter is not excited.";

/// The published share.
fn published_share(share: Option<PublishedShare>) -> String {
    match share {
        Some(PublishedShare::Value(value)) => format!("; published {}", published(value)),
        Some(PublishedShare::Above { above }) => format!("; published > {}", published(above)),
        None => String::new(),
    }
}

// A folder that the stages wrote into.

/// Folders with the documents read there, and the names of those without.
type Read<D> = (Vec<(PathBuf, Loaded<D>)>, Vec<String>);

/// The folders with a document `name`, and the names of those without.
fn documents<D: Document>(folders: &[PathBuf], name: &str) -> Result<Read<D>, Error> {
    let (mut found, mut missing) = (Vec::new(), Vec::new());
    for folder in folders {
        match document_at(folder.join(name))? {
            Some(document) => found.push((folder.clone(), document)),
            None => missing.push(label(folder)),
        }
    }
    Ok((found, missing))
}

/// A note on what is not in the table.
fn left_out(missing: &[String], why: &str) -> String {
    if missing.is_empty() { String::new() } else { format!("\nNot here: {} ({why}).\n", missing.join(", ")) }
}

/// A study's name: its folder below `out`, without common parts.
fn label(folder: &Path) -> String {
    let names = folder.components().filter_map(|component| match component {
        Component::Normal(name) => name.to_str(),
        _ => None,
    });
    names.filter(|name| !["out", "trials", "seeds", "measured"].contains(name)).collect::<Vec<_>>().join(" ")
}

/// The seed of the simulated trials in `folder`.
fn seed(folder: &Path) -> Result<Option<u64>, Error> {
    let mut names = ["campaign.parquet", "trajectories.parquet"].into_iter();
    let Some(path) = names.find_map(|name| existing(folder.join(name))) else {
        // Trials in memory leave no table.
        let validation = document_at::<ValidationDocument>(folder.join("validation.json"))?;
        return Ok(validation.and_then(|loaded| loaded.data.seed));
    };
    Ok(seed_of(TableReader::open(&path, trajectories::ID, trajectories::VERSION)?.provenance()))
}

/// The seed in the provenance of a file.
fn seed_of(provenance: &Provenance) -> Option<u64> {
    provenance.settings.get("seed").and_then(Value::as_u64)
}

/// The length \[s\] of the trials of the study `name`, whose folder is in `written`; `None` of a plan's, which are of another length.
fn length_s(written: Option<&Path>, name: &str) -> Result<Option<f64>, Error> {
    let path = written.and_then(|written| existing(written.join(name).join("campaign.toml")));
    let campaign = path.map(|path| read_campaign(&path, &mut Provenance::default())).transpose()?;
    Ok(campaign.map(|campaign| campaign.duration_s))
}

/// The published results of the study `name`, whose folder is in `written`.
fn reference(written: Option<&Path>, name: &str) -> Result<Option<Reference>, Error> {
    let study = name.split(' ').next().unwrap_or(name);
    let path = written.map(|written| written.join(study).join("reference.toml"));
    path.and_then(existing)
        .map(|path| read_reference(&path, "reference", &mut Provenance::default()))
        .transpose()
}

// A table in Markdown.

/// A table that is written column by column.
struct Table<R> {
    heads: Vec<String>,
    rows: Vec<(R, Vec<String>)>,
}

impl<R> Table<R> {
    /// A row for each of `rows`.
    fn of(rows: impl IntoIterator<Item = R>) -> Self {
        Self { heads: Vec::new(), rows: rows.into_iter().map(|row| (row, Vec::new())).collect() }
    }

    /// Adds a column with its head and its cells.
    fn column(mut self, head: &str, cell: impl Fn(&R) -> String) -> Self {
        self.heads.push(head.to_owned());
        self.rows.iter_mut().for_each(|(row, cells)| cells.push(cell(row)));
        self
    }

    /// The whole table, or `None` without rows.
    fn text(self) -> Option<String> {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rows: String = self.rows.iter().map(|(_, cells)| line(cells)).collect();
        let head = format!("{}|{}\n", line(&self.heads), "---|".repeat(self.heads.len()));
        (!rows.is_empty()).then(|| head + &rows)
    }
}

/// A share and its interval; a dash if the document has none.
fn share(value: f64, interval: Option<[f64; 2]>) -> String {
    percent_within(value, interval) + if interval.is_some() { "" } else { " (–)" }
}

/// A quantile and its interval; a dash if the document has none.
fn quantile(value: Option<f64>, interval: Option<[Option<f64>; 2]>) -> String {
    three_within(value, interval) + if interval.is_some() { "" } else { " (–)" }
}

/// The median and its interval.
fn median(errors: &Quantiles) -> String {
    quantile(errors.median, errors.median_interval)
}
