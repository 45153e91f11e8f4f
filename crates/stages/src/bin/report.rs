//! `report`: a study on one page.

use std::path::PathBuf;
use std::process::ExitCode;

use artifact::{Staged, commit};
use clap::Parser;
use serde_json::json;
use stages::cli::{Common, Summary, beside, run};
use stages::failure::Failure;
use stages::report::{Sources, load, render};

/// Puts a study's results on one self-contained HTML page, with its figures as SVG beside it in figures/
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  report --study pipelines/paper --results out/paper --out out/paper/report.html"
)]
struct Arguments {
    /// Folder of the study's hand-written files
    #[arg(long, value_name = "FOLDER")]
    study: PathBuf,
    /// Folder that the stages wrote into; what is missing there is said on the page
    #[arg(long, value_name = "FOLDER")]
    results: PathBuf,
    #[command(flatten)]
    common: Common,
}

fn main() -> ExitCode {
    run(|a: &Arguments| &a.common, stage)
}

fn stage(a: &Arguments) -> Result<Summary, Failure> {
    let sources = Sources { study: a.study.clone(), results: a.results.clone() };
    let study = load(&sources)?;
    let page = render(&study).map_err(|e| Failure::Failed(format!("figures: {e}")))?;
    let out = a.common.main_output("report.html");
    let figures = beside(&out, "figures");
    std::fs::create_dir_all(&figures).map_err(|e| {
        Failure::Failed(format!(
            "{}: create: found {e}, expected a writable folder; write elsewhere",
            figures.display()
        ))
    })?;
    let mut staged = Vec::new();
    for (name, svg) in &page.figures {
        staged.push(Staged::bytes(figures.join(name), svg.as_bytes())?);
    }
    staged.push(Staged::bytes(&out, page.html.as_bytes())?);
    commit(staged)?;
    Ok(Summary {
        line: format!("{}: {} figures", out.display(), page.figures.len()),
        json: json!({"out": out, "figures": page.figures.len()}),
    })
}
