//! The results of many studies as tables in Markdown, for documentation: every number is one of a document.

mod designs;
mod estimators;
mod folder;
mod logs;
mod rounds;
mod selections;
mod table;
mod unknown;

use std::path::PathBuf;

use files::Error;

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
        designs::section(&folders.studies, folders.written.as_deref())?,
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
