//! `sweep`: the cells of a grid over a study, and their summary.

use std::path::PathBuf;

use artifact::{commit, stage_document};
use clap::Parser;
use serde_json::json;
use study::documents::CellsDocument;
use study::sweep::{SweepFile, cells, collected};

use crate::cli::Common;
use crate::failure::Failure;
use crate::inputs;
use crate::stage::{Summary, Task};

/// Repeats a study over a grid of its own values
#[derive(Parser)]
#[command(
    name = "sweep",
    after_help = "Example:\n  sweep cells --config pipelines/sweep/sweep.toml --out cells.json"
)]
pub struct Arguments {}

/// Lists the cells of the grid and what is set in each; writes cells.json
#[derive(Parser)]
#[command(
    name = "cells",
    after_help = "A cell that the study's files refuse is listed with the refusal.\n\n\
    Example:\n  sweep cells --config pipelines/sweep/sweep.toml --out cells.json"
)]
pub struct Cells {
    /// The study, the grid, how many runs
    #[arg(long, value_name = "sweep.toml")]
    config: PathBuf,
}

/// Puts the results of the cells side by side; writes sweep.json
#[derive(Parser)]
#[command(
    name = "collect",
    after_help = "Example:\n  sweep collect --cells out/sweep/cells.json --tallies out/sweep/cells --out sweep.json"
)]
pub struct Collect {
    /// The cells
    #[arg(long, value_name = "cells.json")]
    cells: PathBuf,
    /// Holds a folder for each cell, with its tally.json or the refusal in its place
    #[arg(long, value_name = "FOLDER")]
    tallies: PathBuf,
}

impl Task for Cells {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let out = common.main_output("cells.json", [&self.config])?;
        let mut provenance = common.provenance("sweep");
        let file = SweepFile::read(&self.config, &mut provenance)?;
        let found = cells(&self.config, &file, &mut provenance)?;
        commit(vec![stage_document(&out, &provenance, &found)?])?;
        let refused = found.cells.iter().filter(|cell| cell.refused.is_some()).count();
        let details = json!({"cells": found.cells.len(), "refused": refused});
        Ok(Summary::of(&out, format!("{} cells, {refused} refused", found.cells.len()), details))
    }
}

impl Task for Collect {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let out = common.main_output("sweep.json", [&self.cells])?;
        let mut provenance = common.provenance("sweep");
        let grid: CellsDocument = inputs::document(&self.cells, "cells", &mut provenance)?;
        let found = collected(&grid, &self.tallies, &mut provenance)?;
        commit(vec![stage_document(&out, &provenance, &found)?])?;
        let details = json!({"cells": found.cells.len(), "refused": found.refused.len()});
        Ok(Summary::of(&out, found.statements.join(" ").trim_end_matches('.'), details))
    }
}
