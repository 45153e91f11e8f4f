//! `validate merit`: figures of merit of standard maneuvers.

use std::path::{Path, PathBuf};

use artifact::{Provenance, TableWriter, commit, encode_block, stage_set_document};
use clap::Parser;
use maneuver::Generator;
use model::Vessel;
use serde_json::json;
use study::documents::{MeritDocument, MeritTableRow, merit_rows};
use study::files::{read_dictionary, read_model, read_simulated};
use validation::merit::{Merit, Uncertain};

use crate::cli::{Common, member};
use crate::failure::Failure;
use crate::inputs;
use crate::stage::{Summary, Task};

/// Figures of merit of standard maneuvers, with the criteria of IMO MSC.137(76); writes merit.json and merit.parquet
#[derive(Parser)]
#[command(
    name = "merit",
    after_help = "Example:\n  validate merit --vessel pipelines/coaster/vessel.toml \
    --dictionary pipelines/coaster/dictionary.toml --length-m 7 --out merit.json"
)]
pub struct Arguments {
    /// The ship, or a model of it
    #[arg(long, visible_alias = "model", value_name = "vessel.toml|model.json")]
    vessel: PathBuf,
    /// The maneuvers
    #[arg(long, value_name = "dictionary.toml")]
    dictionary: PathBuf,
    /// Runs of these maneuvers, simulated or measured; without them the ship is simulated, undisturbed
    #[arg(long, value_name = "trajectories.parquet")]
    trajectories: Option<PathBuf>,
    /// Length between perpendiculars [m]
    #[arg(long, value_name = "M")]
    length_m: f64,
    /// Simulates a model with so many draws of its parameters from their covariance
    #[arg(long, value_name = "N", conflicts_with = "trajectories", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    draws: Option<u32>,
}

/// What the document is usually called.
const MAIN: &str = "merit.json";

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("validate");
        let read = || [&self.vessel, &self.dictionary].into_iter().chain(&self.trajectories);
        let out = common.main_output(MAIN, read())?;
        let table = member(&out, MAIN, "merit.parquet", read())?;
        if !(self.length_m > 0.0 && self.length_m <= 1e3) {
            return Err(Failure::Usage(format!(
                "--length-m: found {}, expected more than 0, at most 1000 m; correct it",
                self.length_m
            )));
        }
        let vessel = read_simulated(&self.vessel, &mut provenance)?;
        let generator = read_dictionary(&self.dictionary, &vessel, &mut provenance)?;
        let refused = |e| Failure::invalid(&self.dictionary, &e);
        let mut merit = Merit::new(&vessel, &generator, self.length_m).map_err(refused)?;
        match &self.trajectories {
            Some(file) => recorded(&mut merit, file, &vessel, &mut provenance)?,
            None => self.simulated(&mut merit, &vessel, &generator, common.seed.unwrap_or(1))?,
        }
        let given = [("length_m", json!(self.length_m)), ("draws", json!(self.draws))];
        provenance.settings.extend(given.map(|(key, value)| (key.to_owned(), value)));
        let file = self.trajectories.as_ref().unwrap_or(&self.dictionary);
        let found = merit.summary(self.draws.is_some());
        let found = found.map_err(|e| Failure::NoAnswer(format!("{}: {e}", file.display())))?;
        let document = MeritDocument::new(&vessel.name, self.length_m, self.draws.is_some(), found);
        let columns = merit_rows();
        let rows: Vec<MeritTableRow> = merit.rows().iter().map(MeritTableRow::from).collect();
        let mut writer = TableWriter::create(&table, columns.schema(), &provenance)?.with_document(&out);
        writer.push(encode_block(columns.schema(), &columns.table(&rows))?)?;
        let members = vec![writer.finish()?];
        let main = stage_set_document(&out, &provenance, &document, &members)?;
        commit([main].into_iter().chain(members).collect())?;
        let statements = &document.statements;
        let details = json!({"maneuvers": document.maneuvers.len(), "statements": statements});
        Ok(Summary::of(&out, statements.join("; "), details))
    }
}

impl Arguments {
    fn simulated(
        &self,
        merit: &mut Merit,
        vessel: &Vessel,
        generator: &Generator,
        seed: u64,
    ) -> Result<(), Failure> {
        let refused = |e| Failure::invalid(&self.dictionary, &e);
        let Some(draws) = self.draws else {
            let source = vessel.best_known();
            let parameters = vessel.parameters(source).map_err(|e| Failure::invalid(&self.vessel, &e))?;
            return merit.simulate(&parameters, 0).map_err(refused);
        };
        let covariance = read_model(&self.vessel)?.and_then(|model| model.covariance);
        let uncertain = covariance
            .and_then(|covariance| Uncertain::new(vessel, generator.parameters().to_vec(), &covariance));
        let uncertain = uncertain.ok_or_else(|| {
            let found = "no covariance of its parameters";
            let expected = "a model with one, as `estimate pool` writes it";
            Failure::refuse(&self.vessel, "`covariance`", found, expected, "leave out --draws")
        })?;
        merit.simulate_drawn(&uncertain, draws, seed).map_err(refused)
    }
}

/// Adds the runs of a file.
fn recorded(
    merit: &mut Merit,
    file: &Path,
    vessel: &Vessel,
    provenance: &mut Provenance,
) -> Result<(), Failure> {
    let reader = inputs::trajectories(file, "trajectories", vessel, provenance)?;
    for block in 0..reader.blocks() {
        let poses = reader.poses(block)?;
        let mut first = 0;
        for run in reader.runs(block)? {
            let rows = first..first + run.samples() + 1;
            first = rows.end;
            merit.add(&run, poses.as_ref().map(|poses| &poses[rows]));
        }
    }
    Ok(())
}
