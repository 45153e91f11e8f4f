//! `report`: a study on one page; many studies in tables; a picture of one.

use std::path::{Path, PathBuf};

use crate::cli::{Common, beside};
use crate::failure::Failure;
use crate::stage::{Either, Summary, Task};
use artifact::{Staged, commit};
use clap::{Args, Parser, Subcommand};
use report::results::{Folders, tables};
use report::{Rendered, Sources, load, picture, render};
use serde_json::json;

/// A study's page, or a subcommand.
pub type Arguments = Either<Page, Study>;

/// What `report` does besides pages.
#[derive(Subcommand)]
pub enum Study {
    /// Writes the results of many studies as tables in Markdown
    Results(ResultsArguments),
    /// Draws a plan's map beside two histograms
    Picture(PictureArguments),
}

/// The command line of `report results`.
#[derive(Args)]
#[command(
    after_help = "Example:\n  report results --studies out/paper out/helsinki/planned --scenarios out/scenarios/white \
    --rounds out/sequential --written pipelines --out docs/results.md"
)]
pub struct ResultsArguments {
    /// Simulated trials of designs (validation.json)
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    studies: Vec<PathBuf>,
    /// Studies that compare estimators (validation.json)
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    scenarios: Vec<PathBuf>,
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
    #[command(flatten)]
    common: Common,
}

/// The command line of `report picture`.
#[derive(Args)]
#[command(
    after_help = "Example:\n  report picture --plan out/helsinki --study out/paper --out docs/trial.svg"
)]
pub struct PictureArguments {
    /// Folder of the report with the map
    #[arg(long, value_name = "FOLDER")]
    plan: PathBuf,
    /// Folder of the report with the histograms
    #[arg(long, value_name = "FOLDER")]
    study: PathBuf,
    #[command(flatten)]
    common: Common,
}

/// Puts a study's results on one self-contained HTML page, with its figures as SVG beside it in figures/
#[derive(Parser)]
#[command(
    name = "report",
    version,
    after_help = "Example:\n  report --study pipelines/paper --results out/paper --out out/paper/report.html"
)]
pub struct Page {
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
    #[command(flatten)]
    common: Common,
}

impl Task for Page {
    fn common(&self) -> &Common {
        &self.common
    }

    fn run(&self) -> Result<Summary, Failure> {
        stage(self)
    }
}

impl Task for Study {
    fn common(&self) -> &Common {
        match self {
            Self::Results(a) => &a.common,
            Self::Picture(a) => &a.common,
        }
    }

    fn run(&self) -> Result<Summary, Failure> {
        match self {
            Self::Results(a) => results(a),
            Self::Picture(a) => draw(a),
        }
    }
}

fn results(a: &ResultsArguments) -> Result<Summary, Failure> {
    let text = tables(&Folders {
        written: a.written.clone(),
        studies: a.studies.clone(),
        scenarios: a.scenarios.clone(),
        rounds: a.rounds.clone(),
        selections: a.selections.clone(),
        logs: a.logs.clone(),
    })?;
    let out = a.common.main_output("results.md", &[])?;
    commit(vec![Staged::bytes(&out, text.as_bytes())?])?;
    let rows = text.lines().filter(|line| line.starts_with('|')).count();
    Ok(Summary {
        line: format!("{}: {rows} lines of tables", out.display()),
        json: json!({"out": out, "lines": rows}),
    })
}

fn draw(a: &PictureArguments) -> Result<Summary, Failure> {
    let figure = |folder: &Path, name: &str| {
        let path = folder.join("figures").join(name);
        std::fs::read_to_string(&path).map_err(|e| artifact::Error::io(&path, "read", e))
    };
    let map = figure(&a.plan, "map.svg")?;
    let histograms = [figure(&a.study, "parameter-error.svg")?, figure(&a.study, "simulation-error.svg")?];
    let text = picture(&map, &histograms.each_ref().map(String::as_str));
    let out = a.common.main_output("picture.svg", &[])?;
    commit(vec![Staged::bytes(&out, text.as_bytes())?])?;
    Ok(Summary {
        line: format!("{}: {} bytes", out.display(), text.len()),
        json: json!({"out": out, "bytes": text.len()}),
    })
}

fn stage(a: &Page) -> Result<Summary, Failure> {
    let sources = Sources {
        study: a.study.clone(),
        dictionary: a.dictionary.clone(),
        results: a.results.clone(),
        scenarios: a.scenarios.clone(),
    };
    let study = load(&sources)?;
    let page = render(&study);
    let out = a.common.main_output("report.html", &[])?;
    let figures = beside(&out, "figures");
    let existed = figures.is_dir();
    write(&page, &out, &figures).inspect_err(|_| {
        if !existed {
            // Only an empty folder goes; the failure itself is reported.
            let _ = std::fs::remove_dir(&figures);
        }
    })?;
    Ok(Summary {
        line: format!("{}: {} figures", out.display(), page.figures.len()),
        json: json!({"out": out, "figures": page.figures.len()}),
    })
}

fn write(page: &Rendered, out: &Path, figures: &Path) -> Result<(), Failure> {
    if !figures.is_dir() {
        std::fs::create_dir(figures).map_err(|e| artifact::Error::io(figures, "create", e))?;
    }
    let mut staged = Vec::new();
    for (name, svg) in &page.figures {
        staged.push(Staged::bytes(figures.join(name), svg.as_bytes())?);
    }
    staged.push(Staged::bytes(out, page.html.as_bytes())?);
    Ok(commit(staged)?)
}
