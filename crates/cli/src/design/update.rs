//! `design update`: what a design promised, and what its trial gave.

use std::path::PathBuf;

use clap::Parser;
use files::{commit, stage_document};
use seatrial::{UpdateError, Updating};
use serde_json::json;
use study::design_files::Promised;

use crate::cli::Common;
use crate::failure::Failure;
use crate::stage::{Summary, Task};

/// Compares what a design promised with what is known after its trial
#[derive(Parser)]
#[command(
    name = "update",
    after_help = "Example:\n  design update --design design.json --moments moments.json --model model.json --out design-update.json"
)]
pub struct Update {
    /// The design whose trial has been run
    #[arg(long, value_name = "design.json")]
    design: PathBuf,
    /// The moments that it was made from
    #[arg(long, value_name = "moments.json")]
    moments: PathBuf,
    /// The estimate of the trial, with its covariance
    #[arg(long, value_name = "model.json")]
    model: PathBuf,
    /// Figures of merit with their slopes, those of the design
    #[arg(long, value_name = "merit.json")]
    figures: Option<PathBuf>,
}

impl Task for Update {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let inputs = [&self.design, &self.moments, &self.model].into_iter().chain(&self.figures);
        let out = common.main_output("design-update.json", inputs)?;
        let mut provenance = common.provenance("design update");
        let of = Promised::read(&self.design, &self.moments, self.figures.as_deref(), &mut provenance)?;
        let model = of.model(&self.model, &mut provenance)?;
        let document = Updating::new(&of).after(&model).map_err(|e| match e {
            UpdateError::Design(e) => Failure::invalid(&self.design, &e),
            UpdateError::Model(e) => Failure::invalid(&self.model, &e),
        })?;
        commit(vec![stage_document(&out, &provenance, &document)?])?;
        Ok(Summary::of(&out, document.summary(), json!({"parameter_error": document.parameter_error})))
    }
}
