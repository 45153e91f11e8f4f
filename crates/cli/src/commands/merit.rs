//! `validate merit`: figures of merit of standard maneuvers.

use std::path::PathBuf;

use clap::Parser;
use estimation::pooled::Covariance;
use files::{TableWriter, commit, encode_block, stage_set_document};
use seatrial::{Merits, Unsimulated};
use serde_json::json;
use study::documents::merit_rows;
use study::files::{read_any_simulated, read_dictionary, read_model};

use crate::cli::{Common, member};
use crate::failure::Failure;
use crate::inputs;
use crate::stage::{Summary, Task};

/// Measures overshoots, turning circles and stopping distances against IMO MSC.137(76); writes merit.json, merit.parquet
#[derive(Parser)]
#[command(
    name = "merit",
    after_help = "Example:\n  validate merit --vessel pipelines/coaster/vessel.toml \
    --dictionary pipelines/coaster/dictionary.toml --length-m 100 --out merit.json"
)]
pub struct MeritArguments {
    /// The ship, or a model of it
    #[arg(long, visible_alias = "model", value_name = "vessel.toml|model.json")]
    vessel: PathBuf,
    /// The maneuvers; without it the logs show which they are
    #[arg(long, value_name = "dictionary.toml", required_unless_present = "trajectories")]
    dictionary: Option<PathBuf>,
    /// Runs of these maneuvers, simulated or measured; without them the ship is simulated, undisturbed
    #[arg(long, value_name = "trajectories.parquet")]
    trajectories: Option<PathBuf>,
    /// Length between perpendiculars [m]; that of the ship's forces without it
    #[arg(long, value_name = "M")]
    length_m: Option<f64>,
    /// Simulates a model with so many draws of its parameters from their covariance
    #[arg(long, value_name = "N", conflicts_with = "trajectories", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    draws: Option<u32>,
    /// Adds the derivative of every figure by every parameter of the model, for `design --criterion figures`
    #[arg(long)]
    slopes: bool,
}

/// What the document is usually called.
const MAIN: &str = "merit.json";

impl Task for MeritArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("validate");
        let read = || [&self.vessel].into_iter().chain(&self.dictionary).chain(&self.trajectories);
        let out = common.main_output(MAIN, read())?;
        let table = member(&out, MAIN, "merit.parquet", read())?;
        let vessel = read_any_simulated(&self.vessel, &mut provenance)?;
        let of_forces = || vessel.model.forces.as_ref().map(|own| own.forces.description().ship.length_m);
        let length_m = self.length_m.or_else(of_forces);
        let Some(length_m) = length_m.filter(|length_m| *length_m > 0.0 && *length_m <= 1e3) else {
            let found = length_m.map_or("none".to_owned(), |own| own.to_string());
            let expected = "more than 0, at most 1000 m";
            return Err(Failure::Usage(format!(
                "--length-m: found {found}, expected {expected}; correct it"
            )));
        };
        let length = vessel.check_length(length_m, "--length-m", None);
        length.map_err(|e| Failure::invalid(&self.vessel, &e))?;
        let read = |file: &PathBuf| read_dictionary(file, &vessel, &mut provenance);
        let generator = self.dictionary.as_ref().map(read).transpose()?;
        let file = self.dictionary.as_ref().or(self.trajectories.as_ref()).unwrap_or(&self.vessel);
        let refused = |e| Failure::invalid(file, &e);
        let mut merits = Merits::new(&vessel, generator.as_ref(), length_m).map_err(refused)?;
        match (&self.trajectories, self.draws) {
            (Some(file), _) => {
                let reader = inputs::trajectories(file, "trajectories", &vessel, &mut provenance)?;
                let are_logged = !reader.true_states();
                if self.dictionary.is_none() && !are_logged {
                    let expected = "logs, as `ingest` writes them";
                    return Err(Failure::refuse(
                        file,
                        "trajectories",
                        "simulated ones",
                        expected,
                        "give --dictionary",
                    ));
                }
                for block in 0..reader.blocks() {
                    merits.add(&reader.runs(block)?, reader.poses(block)?.as_deref(), are_logged);
                }
            }
            (None, None) => merits.simulate().map_err(|e| match e {
                Unsimulated::Unheld(e) => refused(e),
                Unsimulated::Diverged(e) => Failure::invalid(&self.vessel, &e),
            })?,
            (None, Some(draws)) => {
                let seed = common.seed.unwrap_or(1);
                merits.simulate_drawn(&self.covariance()?, draws, seed).map_err(refused)?;
            }
        }
        if self.slopes {
            merits.differentiate().map_err(|e| Failure::invalid(&self.vessel, &e))?;
        }
        let given = [("length_m", json!(length_m)), ("draws", json!(self.draws))];
        provenance.settings.extend(given.map(|(key, value)| (key.to_owned(), value)));
        let file = self.trajectories.as_ref().unwrap_or(file);
        let found = merits.found().map_err(|e| Failure::NoAnswer(format!("{}: {e}", file.display())));
        let ((document, rows), columns) = (found?, merit_rows());
        let mut writer = TableWriter::create(&table, columns.schema(), &provenance)?.with_document(&out);
        writer.push(encode_block(columns.schema(), &columns.table(&rows))?)?;
        let members = vec![writer.finish()?];
        let main = stage_set_document(&out, &provenance, &document, &members)?;
        commit([main].into_iter().chain(members).collect())?;
        let statements = &document.statements;
        let details = json!({"maneuvers": document.maneuvers.len(), "statements": statements});
        Ok(Summary::of(&out, document.in_short(), details))
    }
}

impl MeritArguments {
    /// What the model's file says of its parameters.
    fn covariance(&self) -> Result<Covariance, Failure> {
        read_model(&self.vessel)?.and_then(|model| model.errors_of_parameters().cloned()).ok_or_else(|| {
            let expected = "a model with one, as `estimate pool` writes it";
            Failure::refuse(&self.vessel, "`covariance`", "none", expected, "leave out --draws")
        })
    }
}
