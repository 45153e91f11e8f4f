//! `validate compare`: a model on recordings that it was not fitted to.

use std::path::PathBuf;

use artifact::{Provenance, TableWriter, commit, encode_block, stage_set_document};
use clap::Parser;
use model::Vessel;
use seatrial::Comparison;
use serde_json::json;
use study::Tried;
use study::documents::traces;
use study::files::read_vessel;

use crate::cli::{Common, member, samples};
use crate::failure::Failure;
use crate::inputs;
use crate::pool::RunFlags;
use crate::stage::{Summary, Task};

/// Tries a model on recordings, beside least squares, the mean of the data and another model; writes compare.json and
/// compare.parquet
#[derive(Parser)]
#[command(
    name = "compare",
    after_help = "Example:\n  validate compare --model model.json --trajectories others.parquet --window-s 100 \
    --out compare.json"
)]
pub struct Arguments {
    /// The model, or several whose trajectories are averaged
    #[arg(long, value_name = "model.json|average.json")]
    model: PathBuf,
    #[command(flatten)]
    of: RunFlags,
    /// Another model to compare with, of the same channels
    #[arg(long, value_name = "model.json|vessel.toml")]
    against: Option<PathBuf>,
    /// Simulates over windows of this length, side by side [s]; whole runs without it
    #[arg(long, value_name = "S")]
    window_s: Option<f64>,
}

/// The usual name of the document.
const MAIN: &str = "compare.json";

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("validate");
        let model = Tried::read(&self.model, &mut provenance)?;
        // The files that the model was fitted to are not inputs of the comparison, but the ship is the same.
        provenance.forget(&["dictionary", "campaign", "moments", "design", "validation", "estimates"]);
        let vessel = model.vessel();
        let other = self.against(vessel, &mut provenance)?;
        let window = self.window_s.map(|s| samples("--window-s", s, vessel.sample_rate_hz)).transpose()?;
        let read = || [&self.model].into_iter().chain(&self.against).chain(self.of.inputs());
        let out = common.main_output(MAIN, read())?;
        let table = member(&out, MAIN, "compare.parquet", read())?;
        let (runs, _) = self.of.read(vessel, &mut provenance, inputs::runs)?;
        let found = Comparison { model: &model, other: other.as_ref(), window }.over(&runs);
        let (document, trace) = found.map_err(|e| Failure::invalid(self.of.file(), &e.invalid()))?;
        let settings = [("window_samples", json!(window)), ("runs", json!(self.of.runs))];
        let given = settings.into_iter().chain([("leave_out", json!(self.of.leave_out))]);
        provenance.settings.extend(given.map(|(key, value)| (key.to_owned(), value)));
        let columns = traces();
        let mut writer = TableWriter::create(&table, columns.schema(), &provenance)?.with_document(&out);
        writer.push(encode_block(columns.schema(), &columns.table(&trace))?)?;
        let members = vec![writer.finish()?];
        let main = stage_set_document(&out, &provenance, &document, &members)?;
        commit([main].into_iter().chain(members).collect())?;
        let (windows, statements) = (document.windows, &document.statements);
        let details = json!({"windows": windows, "statements": statements});
        Ok(Summary::of(&out, format!("{windows} windows; {}", statements.join("; ")), details))
    }
}

impl Arguments {
    /// The model to compare with, which must have the channels of `vessel`.
    fn against(&self, vessel: &Vessel, provenance: &mut Provenance) -> Result<Option<Vessel>, Failure> {
        let Some(path) = &self.against else { return Ok(None) };
        let mut own = Provenance { changes: provenance.changes.clone(), ..Provenance::default() };
        let other = read_vessel(path, &mut own)?;
        provenance.inputs.extend(own.inputs.into_values().map(|digest| ("against".to_owned(), digest)));
        provenance.read.extend(own.read);
        provenance.settings.extend(own.settings);
        // A search may have added channels that are computed from the same others.
        let alike = other.model.with_channels_of(&vessel.model);
        let (found, expected) = ("other channels or another rate", "those of --model");
        let remedy = "compare models of the same logs";
        match alike.filter(|_| other.sample_rate_hz == vessel.sample_rate_hz) {
            Some(model) => Ok(Some(Vessel { model, ..other })),
            None => Err(Failure::refuse(path, "model", found, expected, remedy)),
        }
    }
}
