//! `validate` on recordings: `--model` tries models that were not fitted to them, `--design` models from picked parts of them.

use std::path::{Path, PathBuf};

use clap::Args;
use estimation::Estimator;
use estimation::pooled::Pool;
use files::{Provenance, TableWriter, commit_with_document, encode_block};
use regression::MeanRemoval;
use regression::pooled::NominalModel;
use seatrial::{Comparison, channels_within, widest};
use serde_json::json;
use ship::model::Vessel;
use study::Tried;
use study::documents::{DesignDocument, Selection, ValidationDocument, traces};
use study::files::{StageOfTerms, read_any_vessel_as, read_reference};
use study::parts::MAIN;
use study::selection::{Row, columns, counts_of, rows};
use validation::selection::{PublishedLimits, SelectionOptions, Selector, available};

use crate::cli::{Common, Sharding, beside, choice, member, samples};
use crate::failure::{Failure, WorkProgress};
use crate::inputs::{self, Made, joined, joined_blocks};
use crate::pool::{RunFlags, note};
use crate::stage::Summary;

/// Which models are tried, and how.
#[derive(Args)]
pub struct ModelFlags {
    /// The model, or a ship before her first fit, beside least squares and the mean of the data; more of them are compared
    #[arg(
        long,
        value_name = "model.json|vessel.toml",
        value_delimiter = ',',
        requires = "trajectories",
        conflicts_with_all = ["vessel", "shard", "gather", "estimates", "validation"],
        conflicts_with_all = OF_PICKS
    )]
    pub model: Vec<PathBuf>,
    /// Simulates over windows of this length, side by side [s]; whole runs without it
    #[arg(long, value_name = "S")]
    window_s: Option<f64>,
}

impl ModelFlags {
    /// Tries the first of the models on the runs `of` recordings, and compares the others with it.
    pub fn compare(&self, of: &RunFlags, common: &Common) -> Result<Summary, Failure> {
        let (first, others) = (&self.model[0], &self.model[1..]);
        let mut provenance = common.provenance("validate");
        let model = Tried::read(first, &mut provenance)?.at_rate_of(of.file());
        // The files that the model was fitted to are not inputs of the comparison, but the ship is the same.
        provenance.forget(&["dictionary", "campaign", "moments", "design", "validation", "estimates"]);
        let read = |(i, path): (usize, &PathBuf)| {
            read_any_vessel_as(&format!("model:{}", i + 2), path, &mut provenance)
        };
        let others = others.iter().enumerate().map(read).collect::<Result<Vec<Vessel>, _>>()?;
        let comparison = Comparison { model: &model, others: &others, window: None };
        let vessel = self.widest(&comparison)?;
        let window = self.window_s.map(|s| samples("--window-s", s, vessel.sample_rate_hz)).transpose()?;
        let comparison = Comparison { window, ..comparison };
        let read = || self.model.iter().chain(of.inputs());
        let out = common.main_output(MAIN, read())?;
        let table = member(&out, MAIN, "compare.parquet", read())?;
        let (runs, _) = of.read(vessel, &mut provenance, inputs::runs)?;
        let compared = comparison.over(&runs);
        let (recordings, trace) = compared.map_err(|e| Failure::invalid(of.file(), &e.invalid()))?;
        let settings = [("window_samples", json!(window)), ("runs", json!(of.runs))];
        let given = settings.into_iter().chain([("leave_out", json!(of.leave_out))]);
        provenance.settings.extend(given.map(|(key, value)| (key.to_owned(), value)));
        let columns = traces();
        let mut writer = TableWriter::create(&table, columns.schema(), &provenance)?.with_document(&out);
        writer.push(encode_block(columns.schema(), &columns.table(&trace))?)?;
        let (windows, statements) = (recordings.windows, &recordings.statements);
        let details = json!({"windows": windows, "statements": statements});
        let summary = Summary::of(&out, format!("{windows} windows; {}", statements.join("; ")), details);
        let document = ValidationDocument { recordings: Some(recordings), ..Default::default() };
        commit_with_document(writer.finish()?, &out, &provenance, &document)?;
        Ok(summary)
    }

    /// The vessel whose channels the runs are read with; all others have some of them.
    fn widest<'a>(&self, comparison: &Comparison<'a>) -> Result<&'a Vessel, Failure> {
        let vessels = comparison.vessels();
        let widest = widest(&vessels).unwrap_or(comparison.model.vessel());
        let of_model = comparison.model.vessels().iter().map(|_| &self.model[0]);
        let files = of_model.chain(&self.model[1..]);
        for (path, vessel) in files.zip(vessels) {
            channels_within(vessel, widest).map_err(|e| Failure::invalid(path, &e))?;
        }
        Ok(widest)
    }
}

/// The estimators that only need sums per sub-experiment.
const ESTIMATORS: [Estimator; 3] = [Estimator::Ls, Estimator::Iv, Estimator::Auto];

/// The usual name of the table of scores.
pub const SCORES: &str = "scores.parquet";

/// The flags of picks alone.
pub const OF_PICKS: [&str; 4] = ["realizations", "estimator", "mean_removal", "reference"];

/// What is picked, and how the picks are estimated.
#[derive(Args)]
pub struct PickFlags {
    /// The design whose counts are picked, beside as many at random
    #[arg(
        long,
        value_name = "design.json",
        requires_all = ["vessel", "trajectories"],
        conflicts_with_all = ["estimates", "validation", "window_s"]
    )]
    pub design: Option<PathBuf>,
    /// Realizations per design
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    realizations: u32,
    /// The estimator, of sums per sub-experiment
    #[arg(long, value_parser = choice(&ESTIMATORS, Estimator::name, Estimator::description), default_value_t = Estimator::Iv)]
    estimator: Estimator,
    /// How the instruments' mean is removed
    #[arg(long, value_parser = choice(&MeanRemoval::ALL, MeanRemoval::name, MeanRemoval::description), default_value_t = MeanRemoval::Complete)]
    mean_removal: MeanRemoval,
    /// Published results: counts realizations beyond the errors at which their figures end
    #[arg(long, value_name = "reference.toml")]
    reference: Option<PathBuf>,
}

impl PickFlags {
    /// Picks of the runs `of` recordings as `design` counts them, and of as many at random. Instruments are simulated with the
    /// least-squares fit of all.
    pub fn pick(
        &self,
        (vessel_file, design): (&Path, &Path),
        of: &RunFlags,
        sharding: &Sharding,
        common: &Common,
    ) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("validate");
        let vessel = StageOfTerms::Selection.read(vessel_file, &mut provenance)?;
        let read = of.inputs().chain(&self.reference).chain(&sharding.gather).map(PathBuf::as_path);
        let out = common.main_output(SCORES, read.chain([vessel_file, design]))?;
        let (runs, constant) = of.read(&vessel, &mut provenance, inputs::runs)?;
        let pool = Pool {
            removal: self.mean_removal,
            nominal: NominalModel::Fitted,
            constant,
            ..Pool::new(&vessel)
        };
        pool.check().map_err(|e| Failure::invalid(vessel_file, &e))?;
        let bytes = pool.bytes_of_many(&runs, rayon::current_num_threads());
        inputs::fits(of.file(), &runs.amount(), bytes)?;
        let designed: DesignDocument = inputs::document(design, "design", &mut provenance)?;
        let counts = counts_of(&designed, &available(&runs.parts(None)));
        let options = SelectionOptions {
            estimator: self.estimator,
            counts: counts.map_err(|e| Failure::invalid(design, &e))?,
            realizations: self.realizations,
            seed: common.seed.unwrap_or(1),
            published_limits: self.published(&mut provenance)?,
        };
        let settings = [
            ("estimator", json!(options.estimator)),
            ("realizations", json!(options.realizations)),
            ("seed", json!(options.seed)),
            ("mean_removal", json!(self.mean_removal)),
            ("runs", json!(of.runs)),
            ("leave_out", json!(of.leave_out)),
        ];
        note(settings, &mut provenance);
        let selector = Selector::new(&pool, &runs, &options).map_err(|lost| {
            let expected = "a least-squares fit that follows the data; use --estimator ls";
            let file = of.file().display();
            Failure::NoAnswer(format!("{file}: {lost}: found no instruments, expected {expected}"))
        })?;
        let document = beside(&out, SCORES, MAIN);
        let outputs = [out.as_path(), document.as_path()];
        let made = if sharding.gathers() {
            Made::gathered(&sharding.gather, outputs, &columns(), provenance, rows)?
        } else {
            provenance.shard = sharding.shard;
            realized(&selector, outputs, provenance, common.quiet)?
        };
        publish(made, &document, |rows| selector.found(rows))
    }

    /// The limits of the figures of a published selection study.
    fn published(&self, provenance: &mut Provenance) -> Result<Option<PublishedLimits>, Failure> {
        let Some(file) = &self.reference else { return Ok(None) };
        let reference = read_reference(file, "reference", provenance)?;
        Ok(reference.selection.as_ref().map(PublishedLimits::from))
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
    picked: impl FnOnce(&[Row]) -> Selection,
) -> Result<Summary, Failure> {
    if let Some(shard) = made.provenance.shard {
        return made.publish_shard(shard, "realizations");
    }
    let Made { table, provenance, rows } = made;
    let out = table.path().to_owned();
    let picks = picked(&rows);
    let details = json!({"ratio_q90": picks.ratio_q90, "statements": picks.statements});
    let said = picks.statements.join("; ");
    let document = ValidationDocument { picks: Some(picks), ..Default::default() };
    inputs::publish(table, file, &provenance, || Ok(document))?;
    Ok(Summary::of(&out, said, details))
}
