//! `validate compare`: a model on recordings that it was not fitted to.

use std::path::{Path, PathBuf};

use clap::Parser;
use estimation::Estimator;
use files::{Provenance, TableWriter, commit_with_document, encode_block};
use seatrial::validation::comparison::Standing;
use seatrial::{Comparison, channels_within, widest};
use serde_json::json;
use ship::model::Vessel;
use study::Tried;
use study::documents::{SelectionDocument, traces};
use study::files::{StageOfTerms, read_any_vessel_as, read_reference};
use study::selection::{Row, columns, document, rows};
use validation::selection::{PublishedLimits, Selection, SelectionOptions, Selector, available};

use crate::cli::{Common, Sharding, beside, choice, member, samples};
use crate::failure::{Failure, WorkProgress};
use crate::inputs::{self, Made, counts, joined, joined_blocks};
use crate::pool::{PoolFlags, RunFlags};
use crate::stage::{Summary, Task};

/// Tries a model on recordings, beside least squares, the mean of the data and other models; writes compare.json and
/// compare.parquet
#[derive(Parser)]
#[command(
    name = "compare",
    after_help = "Example:\n  validate compare --model model.json --trajectories others.parquet --window-s 100 \
    --out compare.json"
)]
pub struct CompareArguments {
    /// The model, or several whose trajectories are averaged, or a ship before her first fit
    #[arg(long, value_name = "model.json|vessel.toml")]
    model: PathBuf,
    #[command(flatten)]
    of: RunFlags,
    /// Averages the trajectories of these models with those of --model, say of forces with that of a search, and compares
    /// each alone, too
    #[arg(long, value_name = "model.json,…", value_delimiter = ',')]
    average: Vec<PathBuf>,
    /// Another model to compare with, of the same logs
    #[arg(long, value_name = "model.json|vessel.toml")]
    against: Option<PathBuf>,
    /// Simulates over windows of this length, side by side [s]; whole runs without it
    #[arg(long, value_name = "S")]
    window_s: Option<f64>,
}

/// The usual name of the document.
const MAIN: &str = "compare.json";

impl Task for CompareArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("validate");
        let model = Tried::read(&self.model, &mut provenance)?.at_rate_of(self.of.file());
        // The files that the model was fitted to are not inputs of the comparison, but the ship is the same.
        provenance.forget(&["dictionary", "campaign", "moments", "design", "validation", "estimates"]);
        let averaged = self.averaged(&model, &mut provenance)?;
        let read = |path: &PathBuf| read_any_vessel_as("against", path, &mut provenance);
        let other = self.against.as_ref().map(read).transpose()?;
        let comparison =
            Comparison { model: &model, averaged: &averaged, other: other.as_ref(), window: None };
        let vessel = self.widest(&comparison)?;
        let window = self.window_s.map(|s| samples("--window-s", s, vessel.sample_rate_hz)).transpose()?;
        let comparison = Comparison { window, ..comparison };
        let read =
            || [&self.model].into_iter().chain(&self.average).chain(&self.against).chain(self.of.inputs());
        let out = common.main_output(MAIN, read())?;
        let table = member(&out, MAIN, "compare.parquet", read())?;
        let runs = self.of.read_of_forces(vessel, &mut provenance)?;
        let compared = comparison.over(&runs);
        let (document, trace) = compared.map_err(|e| Failure::invalid(self.of.file(), &e.invalid()))?;
        let settings = [("window_samples", json!(window)), ("runs", json!(self.of.runs))];
        let given = settings.into_iter().chain([("leave_out", json!(self.of.leave_out))]);
        provenance.settings.extend(given.map(|(key, value)| (key.to_owned(), value)));
        let columns = traces();
        let mut writer = TableWriter::create(&table, columns.schema(), &provenance)?.with_document(&out);
        writer.push(encode_block(columns.schema(), &columns.table(&trace))?)?;
        commit_with_document(writer.finish()?, &out, &provenance, &document)?;
        let (windows, statements) = (document.windows, &document.statements);
        let details = json!({"windows": windows, "statements": statements});
        Ok(Summary::of(&out, format!("{windows} windows; {}", statements.join("; ")), details))
    }
}

impl CompareArguments {
    /// The models that are averaged with `model`, which then is a single one, too.
    fn averaged(&self, model: &Tried, provenance: &mut Provenance) -> Result<Vec<Tried>, Failure> {
        let single = |path: &Path, model: &Tried| match model.standing() {
            Standing::Average => {
                let expected = "a single model, where models are averaged";
                let remedy = "compare it alone, or name models of one structure";
                Err(Failure::refuse(path, "`data.members`", "several models", expected, remedy))
            }
            _ => Ok(()),
        };
        if !self.average.is_empty() {
            single(&self.model, model)?;
        }
        let read = |(i, path): (usize, &PathBuf)| {
            let mut of_model = Provenance { changes: provenance.changes.clone(), ..Provenance::default() };
            let tried = Tried::read(path, &mut of_model)?;
            single(path, &tried)?;
            provenance
                .inputs
                .extend(of_model.inputs.remove("model").map(|it| (format!("average:{}", i + 1), it)));
            provenance.read.extend(of_model.read);
            Ok(tried)
        };
        self.average.iter().enumerate().map(read).collect()
    }

    /// The vessel whose channels the runs are read with; all others have some of them.
    fn widest<'a>(&self, comparison: &Comparison<'a>) -> Result<&'a Vessel, Failure> {
        let vessels = comparison.vessels();
        let widest = widest(&vessels).unwrap_or(comparison.model.vessel());
        let of_model = comparison.model.vessels().iter().map(|_| &self.model);
        let files = of_model.chain(&self.average).chain(&self.against);
        for (path, vessel) in files.zip(vessels) {
            channels_within(vessel, widest).map_err(|e| Failure::invalid(path, &e))?;
        }
        Ok(widest)
    }
}

/// The estimators that only need sums per sub-experiment.
const ESTIMATORS: [Estimator; 3] = [Estimator::Ls, Estimator::Iv, Estimator::Auto];

/// Compares models from sub-experiments that a design picks with random picks; writes selection.parquet, selection.json
#[derive(Parser)]
#[command(
    name = "selection",
    after_help = "Example:\n  validate selection --vessel pipelines/esso-osaka/vessel.toml \
    --trajectories trajectories.parquet --design design.json --out selection.parquet"
)]
pub struct SelectionArguments {
    #[command(flatten)]
    flags: PoolFlags,
    /// The design whose counts are picked
    #[arg(long, required_unless_present = "counts", conflicts_with = "counts", value_name = "design.json")]
    design: Option<PathBuf>,
    /// How many of each maneuver are picked, instead
    #[arg(long, value_name = "NAME=N,…")]
    counts: Vec<String>,
    /// Realizations per design
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    realizations: u32,
    /// The estimator: `ls`, `iv` or `auto`
    #[arg(long, value_parser = choice(&Estimator::POOLED, Estimator::name, Estimator::description), default_value_t = Estimator::Iv)]
    estimator: Estimator,
    /// Published results to compare with: counts realizations beyond the errors at which their figures end
    #[arg(long, value_name = "reference.toml")]
    reference: Option<PathBuf>,
    #[command(flatten)]
    sharding: Sharding,
}

/// The usual name of the table.
const SELECTION: &str = "selection.parquet";

impl Task for SelectionArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("validate");
        let vessel = StageOfTerms::Selection.read(&self.flags.vessel, &mut provenance)?;
        if !ESTIMATORS.contains(&self.estimator) {
            return Err(Failure::Usage(format!(
                "--estimator: found {}, expected ls, iv or auto; a selection study adds up sums per sub-experiment",
                self.estimator
            )));
        }
        let inputs = self.flags.inputs().chain(&self.design).chain(&self.reference);
        let out = common.main_output(SELECTION, inputs.chain(&self.sharding.gather))?;
        let (runs, pool) = self.flags.read(&vessel, &mut provenance, inputs::runs)?;
        let bytes = pool.bytes_of_many(&runs, rayon::current_num_threads());
        inputs::fits(self.flags.of.file(), &runs.amount(), bytes)?;
        let there = available(&runs.parts(None));
        let options = SelectionOptions {
            estimator: self.estimator,
            counts: counts(self.design.as_deref(), &self.counts, &there, &mut provenance)?,
            realizations: self.realizations,
            seed: common.seed.unwrap_or(1),
            published_limits: self.published(&mut provenance)?,
        };
        self.note(&options, &mut provenance);
        let selector = Selector::new(&pool, &runs, &options);
        let selector = selector.map_err(|e| Failure::lost(self.flags.of.file(), &e))?;
        let document_file = beside(&out, SELECTION, "selection.json");
        let outputs = [out.as_path(), document_file.as_path()];
        let made = if self.sharding.gathers() {
            Made::gathered(&self.sharding.gather, outputs, &columns(), provenance, rows)?
        } else {
            provenance.shard = self.sharding.shard;
            realized(&selector, outputs, provenance, common.quiet)?
        };
        let of = |found: &Selection| document(&pool, self.flags.nominal().source(), &options, found);
        publish(made, &document_file, |rows| of(&selector.found(rows)))
    }
}

impl SelectionArguments {
    /// The limits of the figures of a published selection study.
    fn published(&self, provenance: &mut Provenance) -> Result<Option<PublishedLimits>, Failure> {
        let Some(file) = &self.reference else { return Ok(None) };
        let reference = read_reference(file, "reference", provenance)?;
        Ok(reference.selection.as_ref().map(PublishedLimits::from))
    }

    fn note(&self, options: &SelectionOptions, provenance: &mut Provenance) {
        let settings = [
            ("estimator", json!(options.estimator)),
            ("intercepts", json!(true)),
            ("realizations", json!(options.realizations)),
            ("seed", json!(options.seed)),
        ];
        self.flags.note(settings, provenance);
    }
}

/// The rows of this shard, or all.
fn realized(
    selector: &Selector,
    out: [&Path; 2],
    provenance: Provenance,
    quiet: bool,
) -> Result<Made<Row>, Failure> {
    let (groups, blocks) = (selector.groups(), joined_blocks(selector.groups()));
    let share = provenance.shard.map_or(1.0, |shard| shard.range(blocks).len() as f64 / blocks as f64);
    let all = (0..groups).map(|i| selector.realizations_of(i)).sum::<usize>();
    let progress = WorkProgress::new("realizations", (share * all as f64) as usize, quiet);
    let group = |i: usize| {
        progress.advance(selector.realizations_of(i));
        Ok(selector.group(i))
    };
    Made::computed(out, &columns(), provenance, blocks, |i| joined(i, groups, group))
}

fn publish(
    made: Made<Row>,
    file: &Path,
    document: impl FnOnce(&[Row]) -> SelectionDocument,
) -> Result<Summary, Failure> {
    if let Some(shard) = made.provenance.shard {
        return made.publish_shard(shard, "realizations");
    }
    let Made { table, provenance, rows } = made;
    let out = table.path().to_owned();
    let document = document(&rows);
    let details = json!({"ratio_q90": document.ratio_q90, "statements": document.statements});
    let said = document.statements.join("; ");
    inputs::publish(table, file, &provenance, || Ok(document))?;
    Ok(Summary::of(&out, said, details))
}
