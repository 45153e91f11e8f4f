//! `report`: a study on one page; many studies in tables; a picture of one.

use std::path::{Path, PathBuf};

use crate::cli::{Common, folder_of, given, in_folder};
use crate::failure::Failure;
use crate::stage::{Summary, Task};
use clap::Parser;
use files::{Staged, commit};
use report::results::{Folders, tables};
use report::{EXPLORE, Sources, explore, load, maneuvers_picture, picture, render};
use serde_json::json;

/// Inputs that an output could overwrite: none, since only folders are read.
const NO_FILES: [&Path; 0] = [];

/// Writes the results of many studies as tables in Markdown
#[derive(Parser)]
#[command(
    name = "results",
    after_help = "Example:\n  report results --studies out/paper out/helsinki/planned --scenarios out/scenarios/white \
    --rounds out/sequential --written pipelines --out docs/results.md"
)]
pub struct Results {
    /// Simulated trials of designs (validation.json)
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    studies: Vec<PathBuf>,
    /// Studies that compare estimators (validation.json)
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    scenarios: Vec<PathBuf>,
    /// The same with a current as an unknown (validation.json, estimate.json)
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    unknown: Vec<PathBuf>,
    /// Trials in rounds (sequential.json)
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    rounds: Vec<PathBuf>,
    /// Picks of sub-experiments (selection.json)
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    selections: Vec<PathBuf>,
    /// Measured logs (crossval.json)
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    logs: Vec<PathBuf>,
    /// Folder of the studies' hand-written files, for published results
    #[arg(long, value_name = "FOLDER")]
    written: Option<PathBuf>,
}

/// Draws a plan's map beside two histograms, or the tracks of standard maneuvers
#[derive(Parser)]
#[command(
    name = "picture",
    after_help = "Example:\n  report picture --plan out/helsinki --study out/paper --out docs/trial.svg"
)]
pub struct Picture {
    /// Folder of the report with the map
    #[arg(long, value_name = "FOLDER", requires = "study", required_unless_present = "merit")]
    plan: Option<PathBuf>,
    /// Folder of the report with the histograms
    #[arg(long, value_name = "FOLDER", requires = "plan")]
    study: Option<PathBuf>,
    /// Figures of merit: draws the track of the first standard maneuver of each kind instead
    #[arg(long, value_name = "merit.json", conflicts_with_all = ["plan", "study"])]
    merit: Option<PathBuf>,
}

/// Puts a study's results on one page in HTML, with explore.html to zoom and filter and its figures as SVG beside it
#[derive(Parser)]
#[command(
    name = "report",
    after_help = "Example:\n  report --study pipelines/paper --results out/paper --out out/paper/report.html"
)]
pub struct ReportArguments {
    /// Folder of the study's hand-written files
    #[arg(long, value_name = "FOLDER")]
    study: PathBuf,
    /// The maneuvers, where they are not in the study's folder
    #[arg(long, value_name = "dictionary.toml")]
    dictionary: Option<PathBuf>,
    /// Folder that the stages wrote into; what is missing there is said on the page
    #[arg(long, value_name = "FOLDER")]
    results: PathBuf,
    /// Results of studies that compare estimators, to be put side by side
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    scenarios: Vec<PathBuf>,
}

impl Task for ReportArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let study = load(&Sources {
            study: self.study.clone(),
            dictionary: self.dictionary.clone(),
            results: self.results.clone(),
            scenarios: self.scenarios.clone(),
            allow_mixed: common.allow_mixed,
            changes: common.changes(),
        })?;
        let page = render(&study);
        let out = common.main_output("report.html", NO_FILES)?;
        let name = out.file_name().unwrap_or_default().to_string_lossy();
        let beside = explore(&study, &name);
        let folder = folder_of(&out);
        let figures = folder.join("figures");
        in_folder(&figures, || {
            let html = std::iter::once_with(|| Staged::bytes(&out, page.html.as_bytes()));
            let beside = std::iter::once_with(|| Staged::bytes(folder.join(EXPLORE), beside.as_bytes()));
            let svg =
                page.figures.iter().map(|(name, svg)| Staged::bytes(figures.join(name), svg.as_bytes()));
            Ok(commit(html.chain(beside).chain(svg).collect::<Result<_, _>>()?)?)
        })?;
        let figures = page.figures.len();
        Ok(Summary::of(&out, format!("{figures} figures"), json!({"figures": figures})))
    }
}

impl Task for Results {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let text = tables(&Folders {
            written: self.written.clone(),
            studies: self.studies.clone(),
            scenarios: self.scenarios.clone(),
            unknown: self.unknown.clone(),
            rounds: self.rounds.clone(),
            selections: self.selections.clone(),
            logs: self.logs.clone(),
        })?;
        let out = common.main_output("results.md", NO_FILES)?;
        commit(vec![Staged::bytes(&out, text.as_bytes())?])?;
        let rows = text.lines().filter(|line| line.starts_with('|')).count();
        Ok(Summary::of(&out, format!("{rows} lines of tables"), json!({"lines": rows})))
    }
}

impl Task for Picture {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let figure = |folder: &Path, name: &str| {
            let path = folder.join("figures").join(name);
            files::read_to_string(&path)
        };
        let text = match &self.merit {
            Some(merit) => maneuvers_picture(&files::read_document(merit)?.data),
            None => {
                let (plan, study) = (given(&self.plan, "plan")?, given(&self.study, "study")?);
                let map = figure(plan, "map.svg")?;
                let histograms =
                    [figure(study, "parameter-error.svg")?, figure(study, "simulation-error.svg")?];
                picture(&map, &histograms.each_ref().map(String::as_str))
            }
        };
        let out = common.main_output("picture.svg", &self.merit)?;
        commit(vec![Staged::bytes(&out, text.as_bytes())?])?;
        Ok(Summary::of(&out, format!("{} bytes", text.len()), json!({"bytes": text.len()})))
    }
}
