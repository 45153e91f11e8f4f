//! `report`: a study on one page.

use std::path::{Path, PathBuf};

use crate::cli::{Common, beside};
use crate::failure::Failure;
use crate::stage::{Summary, Task};
use artifact::{Staged, commit};
use clap::Parser;
use report::{Rendered, Sources, load, render};
use serde_json::json;

/// Puts a study's results on one self-contained HTML page, with its figures as SVG beside it in figures/
#[derive(Parser)]
#[command(
    name = "report",
    version,
    after_help = "Example:\n  report --study pipelines/paper --results out/paper --out out/paper/report.html"
)]
pub struct Arguments {
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

impl Task for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn run(&self) -> Result<Summary, Failure> {
        stage(self)
    }
}

fn stage(a: &Arguments) -> Result<Summary, Failure> {
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
