use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use artifact::{Error, Provenance};
use identification::Estimator;
use refusal::{Invalid, check_numbers, check_ranges, foreign, one_line};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::{Table, Value};

use crate::documents::SweepLine;

/// `sweep.toml` as written.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepFile {
    /// Folder of the study's hand-written files, relative to that of this file.
    pub study: String,
    /// The maneuvers, if they are not in that folder.
    pub dictionary: Option<String>,
    /// Runs per design and cell, instead of the campaign's.
    pub realizations: Option<u32>,
    /// Each cell continues until no share's 95 % interval has a larger half-width than this.
    pub half_width: Option<f64>,
    /// Number of shards of each cell's runs.
    #[serde(default = "one")]
    pub shards: u32,
    /// The estimators, all on the same runs.
    #[serde(default = "iv")]
    pub estimators: Vec<Estimator>,
    /// The baseline.
    pub baseline: Option<SweepLine>,
    /// Flags of `moments`.
    #[serde(default)]
    pub moments_flags: Vec<String>,
    /// Flags of `design`.
    #[serde(default)]
    pub design_flags: Vec<String>,
    /// The values of dotted keys, each of which begins with its file's name.
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub grid: Table,
}

fn one() -> u32 {
    1
}

fn iv() -> Vec<Estimator> {
    vec![Estimator::Iv]
}

impl SweepFile {
    /// Reads the file and notes its digest.
    ///
    /// # Errors
    /// A file that is refused.
    pub fn read(path: &Path, provenance: &mut Provenance) -> Result<Self, Error> {
        let file: Self = provenance.read_toml("config", "sweep", path)?;
        let refuse = |e| crate::invalid(path, &e);
        check_path("--config", &path.to_string_lossy()).map_err(refuse)?;
        file.check().map_err(refuse)?;
        Ok(file)
    }

    fn check(&self) -> Result<(), Invalid> {
        check_path("`study`", &self.study)?;
        check_path("`dictionary`", &self.dictionary())?;
        let positive = [
            ("realizations", f64::from(self.realizations.unwrap_or(1))),
            ("shards", f64::from(self.shards)),
            ("half_width", self.half_width.unwrap_or(1.0)),
        ];
        check_numbers(positive, "more than zero", |value| value > 0.0)?;
        check_ranges([
            ("shards", f64::from(self.shards), 1.0..=1e5, "parts"),
            ("half_width", self.half_width.unwrap_or(0.1), 1e-6..=0.5, ""),
        ])?;
        if self.half_width.is_some() && (self.realizations.is_some() || self.shards > 1) {
            let (expected, remedy) = ("it alone", "remove `realizations` and `shards`, or `half_width`");
            return Err(Invalid::new(
                "`half_width`",
                "it beside `realizations` or `shards`",
                expected,
                remedy,
            ));
        }
        let Some(estimator) = self.estimators.first() else {
            return Err(Invalid::new("`estimators`", "none", "at least one", "name one"));
        };
        let known = || self.estimators.iter().map(|estimator| estimator.name());
        match self.baseline.as_ref().filter(|baseline| !self.estimators.contains(&baseline.estimator)) {
            Some(baseline) => {
                Err(Invalid::unknown("`baseline.estimator`", baseline.estimator.name(), known()))
            }
            None if !Estimator::OF_RUNS.contains(estimator) => {
                let all = Estimator::OF_RUNS.iter().map(|estimator| estimator.name());
                Err(Invalid::unknown("`estimators`", estimator.name(), all))
            }
            None => Ok(()),
        }
    }

    /// The maneuvers, relative to the file's folder.
    pub fn dictionary(&self) -> String {
        self.dictionary.clone().unwrap_or_else(|| format!("{}/dictionary.toml", self.study))
    }

    /// The study's vessel, maneuvers and campaign, of a sweep.toml at `path`.
    pub fn files(&self, path: &Path) -> [PathBuf; 3] {
        let folder = path.parent().unwrap_or(Path::new(""));
        let own = |name: &str| folder.join(&self.study).join(name);
        [own("vessel.toml"), folder.join(self.dictionary()), own("campaign.toml")]
    }

    /// Flags of `monte-carlo` for every cell.
    pub fn monte_carlo(&self) -> Vec<String> {
        let names: Vec<&str> = self.estimators.iter().map(|estimator| estimator.name()).collect();
        let realizations = self.realizations.map(|runs| ["--realizations".to_owned(), runs.to_string()]);
        let until = self.half_width.map(|width| ["--until".to_owned(), width.to_string()]);
        let estimators = ["--estimator".to_owned(), names.join(",")];
        [Some(estimators), realizations, until].into_iter().flatten().flatten().collect()
    }

    /// The dotted keys of the grid in alphabetic order, with their values.
    ///
    /// # Errors
    /// A key without a list of different values.
    pub fn axes(&self) -> Result<Vec<(String, Vec<Value>)>, Invalid> {
        let mut axes = Vec::new();
        flatten(&self.grid, "", &mut axes)?;
        match axes.is_empty() {
            true => Err(Invalid::new("`grid`", "no key", "at least one", "name what is to be varied")),
            false => Ok(axes),
        }
    }
}

/// Refuses names of files that Snakemake would take for a pattern, or with line breaks.
fn check_path(thing: &str, path: &str) -> Result<(), Invalid> {
    match path.contains(['{', '}']) || one_line(path) != path {
        true => {
            let expected = "a name in one line, without { and }";
            Err(Invalid::new(thing, foreign(path), expected, "rename the folder or file"))
        }
        false => Ok(()),
    }
}

/// Keys may be written with dots, in quotes or as tables: a list is where a key ends.
fn flatten(table: &Table, before: &str, axes: &mut Vec<(String, Vec<Value>)>) -> Result<(), Invalid> {
    for (key, value) in table {
        let key = format!("{before}{key}");
        let refuse = |found: String, expected: &str| -> Result<(), Invalid> {
            Err(Invalid::new(format!("`grid.{key}`"), found, expected, "correct it"))
        };
        match value {
            Value::Table(below) => flatten(below, &format!("{key}."), axes)?,
            Value::Array(values) if values.is_empty() => return refuse("no value".into(), "at least one"),
            Value::Array(values) => match values.iter().enumerate().find(|(i, v)| values[..*i].contains(v)) {
                Some((_, twice)) => return refuse(format!("{twice} twice"), "each value once"),
                None => axes.push((key, values.clone())),
            },
            other => return refuse(other.to_string(), "a list of values"),
        }
    }
    Ok(())
}
