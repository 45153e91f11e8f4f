//! What this repository shows of its studies: `pages results` writes their results as tables in Markdown, `pages picture` a plan's
//! map beside two histograms, or the tracks of standard maneuvers. `make docs` calls it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Parser;
use report::results::{Folders, tables};
use report::{maneuvers_picture, picture};

#[derive(Parser)]
enum Page {
    /// The results of many studies as tables
    Results {
        /// Simulated trials of designs (validation.json)
        #[arg(long, num_args = 1..)]
        studies: Vec<PathBuf>,
        /// Studies that compare estimators (validation.json)
        #[arg(long, num_args = 1..)]
        scenarios: Vec<PathBuf>,
        /// The same with a current as an unknown (validation.json, estimate.json)
        #[arg(long, num_args = 1..)]
        unknown: Vec<PathBuf>,
        /// Trials in rounds (validation.json)
        #[arg(long, num_args = 1..)]
        rounds: Vec<PathBuf>,
        /// Picks of sub-experiments (picks/validation.json)
        #[arg(long, num_args = 1..)]
        selections: Vec<PathBuf>,
        /// Measured logs (estimate.json with recordings left out)
        #[arg(long, num_args = 1..)]
        logs: Vec<PathBuf>,
        /// Folder of the studies' hand-written files, for published results
        #[arg(long)]
        written: Option<PathBuf>,
        #[arg(long)]
        out: PathBuf,
    },
    /// A map beside two histograms
    Picture {
        /// Folder of the report with the map
        #[arg(long)]
        plan: PathBuf,
        /// Folder of the report with the histograms
        #[arg(long)]
        study: PathBuf,
        #[arg(long)]
        out: PathBuf,
    },
    /// The track of the first standard maneuver of each kind
    Tracks {
        #[arg(long)]
        merit: PathBuf,
        #[arg(long)]
        out: PathBuf,
    },
}

fn main() -> Result<()> {
    let figure = |folder: &Path, name: &str| {
        let file = folder.join("figures").join(name);
        std::fs::read_to_string(&file).with_context(|| file.display().to_string())
    };
    let (text, out) = match Page::parse() {
        Page::Results { studies, scenarios, unknown, rounds, selections, logs, written, out } => {
            (tables(&Folders { written, studies, scenarios, unknown, rounds, selections, logs })?, out)
        }
        Page::Picture { plan, study, out } => {
            let names = ["parameter-error.svg", "simulation-error.svg"];
            let histograms = [figure(&study, names[0])?, figure(&study, names[1])?];
            (picture(&figure(&plan, "map.svg")?, &histograms.each_ref().map(String::as_str)), out)
        }
        Page::Tracks { merit, out } => (maneuvers_picture(&files::read_document(merit)?.data), out),
    };
    std::fs::write(&out, text).with_context(|| out.display().to_string())
}
