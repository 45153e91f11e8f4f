//! `validate`: how far the estimated models can be trusted.

use std::path::{Path, PathBuf};

use crate::choice::choice;
use crate::cli::{Common, Sharding, beside, given, provenance};
use crate::crossval;
use crate::failure::Failure;
use crate::free_runs::ValidationRuns;
use crate::ordered::ordered;
use crate::pooled::{PoolFlags, not_below, samples};
use crate::progress::Progress;
use crate::selection;
use crate::stage::{Either, Summary, Task};
use artifact::{
    EncodedBlock, Provenance, Staged, TableReader, TableWriter, commit, encode_block, gather, read_toml,
    stage_document,
};
use clap::{Args, Parser, Subcommand, ValueEnum};
use identification::{Estimator, MeanRemoval};
use serde_json::json;
use study::campaign_file::CampaignFile;
use study::documents::{Bounds, PublishedLimits, Reference, ValidationDocument};
use study::estimates;
use study::files::{read_campaign, read_vessel};
use study::scores::{self, Row};
use study::trajectories::refuse_shard;

/// The scores of estimates, or a study of its own.
pub type Arguments = Either<Scores, Study>;

/// What `validate` does besides scores.
#[derive(Subcommand)]
pub enum Study {
    /// Leaves runs or recordings out of a pooled estimate and simulates over them; writes crossval.json
    Cross(CrossArguments),
    /// Models from sub-experiments that a design picked against random picks; writes selection.parquet, selection.json
    Selection(SelectionArguments),
}

/// The command line of `validate cross`.
#[derive(Args)]
#[command(after_help = "Example:\n  validate cross --vessel pipelines/kvlcc2/vessel.toml \
    --trajectories trajectories.parquet --out crossval.json")]
pub struct CrossArguments {
    /// The vessel
    #[arg(long, value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The runs
    #[arg(long, value_name = "trajectories.parquet")]
    trajectories: PathBuf,
    /// The estimators to compare
    #[arg(long, value_parser = choice(&Estimator::POOLED, Estimator::name, Estimator::description), value_delimiter = ',', default_values_t = Estimator::POOLED)]
    estimators: Vec<Estimator>,
    /// How the instruments' mean is removed
    #[arg(long, value_parser = choice(&MeanRemoval::ALL, MeanRemoval::name, MeanRemoval::description), default_value_t = MeanRemoval::Complete)]
    mean_removal: MeanRemoval,
    /// Whether the estimated intercepts are part of the simulated models
    #[arg(long, value_enum, default_value_t = Intercepts::Keep)]
    intercepts: Intercepts,
    /// Simulates over windows of this length, side by side [s]; whole runs without it
    #[arg(long, value_name = "S")]
    window_s: Option<f64>,
    /// Deals runs or recordings in turns into N folds; without it each is left out on its own
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..))]
    folds: Option<u16>,
    #[command(flatten)]
    flags: PoolFlags,
    #[command(flatten)]
    common: Common,
}

/// The command line of `validate selection`.
#[derive(Args)]
#[command(after_help = "Example:\n  validate selection --vessel pipelines/esso-osaka/vessel.toml \
    --trajectories trajectories.parquet --design design.json --out selection.parquet")]
pub struct SelectionArguments {
    /// The vessel
    #[arg(long, value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The runs
    #[arg(long, value_name = "trajectories.parquet")]
    trajectories: PathBuf,
    /// The design whose counts, or shares of --picks, are picked
    #[arg(long, required_unless_present = "counts", conflicts_with = "counts", value_name = "design.json")]
    design: Option<PathBuf>,
    /// How many of each maneuver are picked, instead
    #[arg(long, value_name = "NAME=N,…", value_delimiter = ',')]
    counts: Vec<String>,
    /// Sub-experiments per realization, where the design has no counts
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    picks: Option<u16>,
    /// Realizations per design
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    realizations: u32,
    /// The estimator: `ls`, `iv` or `auto`
    #[arg(long, value_parser = choice(&Estimator::POOLED, Estimator::name, Estimator::description), default_value_t = Estimator::Iv)]
    estimator: Estimator,
    /// How the instruments' mean is removed
    #[arg(long, value_parser = choice(&MeanRemoval::ALL, MeanRemoval::name, MeanRemoval::description), default_value_t = MeanRemoval::Complete)]
    mean_removal: MeanRemoval,
    /// Whether the estimated intercepts are part of the simulated models
    #[arg(long, value_enum, default_value_t = Intercepts::Keep)]
    intercepts: Intercepts,
    /// Published results to compare with: counts realizations beyond the errors at which their figures end
    #[arg(long, value_name = "reference.toml")]
    reference: Option<PathBuf>,
    /// Norm of RMSE over standard deviations from which a model is degenerate (default √3: no better than the mean)
    #[arg(long, value_name = "NORM")]
    degenerate_from: Option<f64>,
    #[command(flatten)]
    flags: PoolFlags,
    #[command(flatten)]
    common: Common,
}

/// Whether estimated intercepts are simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Intercepts {
    /// They stand for steady forces
    Keep,
    /// The model is its parameters only, as in the paper
    Drop,
}

/// Scores every estimate: parameter error and free-run simulation error; writes scores.parquet and validation.json
#[derive(Parser)]
#[command(
    name = "validate",
    version,
    after_help = "Example:\n  validate --vessel pipelines/paper/vessel.toml \
    --campaign pipelines/paper/campaign.toml --estimates estimates.parquet --validation validation.parquet \
    --out scores.parquet"
)]
pub struct Scores {
    /// The vessel
    #[arg(long, value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The bounds below which an estimate counts as good
    #[arg(long, value_name = "campaign.toml")]
    campaign: PathBuf,
    /// The estimates
    #[arg(long, required_unless_present = "gather", value_name = "estimates.parquet")]
    estimates: Option<PathBuf>,
    /// Runs to simulate freely and compare with
    #[arg(long, value_name = "validation.parquet")]
    validation: PathBuf,
    #[command(flatten)]
    sharding: Sharding,
    #[command(flatten)]
    common: Common,
}

impl Task for Scores {
    fn common(&self) -> &Common {
        &self.common
    }

    fn run(&self) -> Result<Summary, Failure> {
        stage(self)
    }
}

impl Task for Study {
    fn common(&self) -> &Common {
        match self {
            Self::Cross(a) => &a.common,
            Self::Selection(a) => &a.common,
        }
    }

    fn run(&self) -> Result<Summary, Failure> {
        match self {
            Self::Cross(a) => cross(a),
            Self::Selection(a) => select(a),
        }
    }
}

fn cross(a: &CrossArguments) -> Result<Summary, Failure> {
    let mut provenance = provenance("validate");
    let vessel = read_vessel(&a.vessel, &mut provenance)?;
    let inputs: Vec<&Path> =
        [&a.vessel, &a.trajectories].into_iter().chain(&a.flags.recordings).map(PathBuf::as_path).collect();
    let window = a.window_s.map(|s| samples("--window-s", s, vessel.sample_rate_hz)).transpose()?;
    let wanted = crossval::Wanted {
        vessel: &vessel,
        trajectories: &a.trajectories,
        flags: &a.flags,
        estimators: &a.estimators,
        removal: a.mean_removal,
        intercepts: a.intercepts == Intercepts::Keep,
        window,
        folds: a.folds.map(usize::from),
        out: a.common.main_output("crossval.json", &inputs)?,
        quiet: a.common.quiet,
    };
    crossval::cross(&wanted, provenance)
}

fn select(a: &SelectionArguments) -> Result<Summary, Failure> {
    let mut provenance = provenance("validate");
    let vessel = read_vessel(&a.vessel, &mut provenance)?;
    if matches!(a.estimator, Estimator::RefinedIv | Estimator::OutputError) {
        let found = format!("--estimator: found {}, expected ls, iv or auto", a.estimator);
        return Err(Failure::Usage(format!("{found}; a selection study adds up sums per sub-experiment")));
    }
    let files = [&a.vessel, &a.trajectories].into_iter().chain(&a.design).chain(&a.reference);
    let files = files.chain(&a.flags.recordings);
    let inputs: Vec<&Path> = files.map(PathBuf::as_path).collect();
    let wanted = selection::Wanted {
        vessel: &vessel,
        trajectories: &a.trajectories,
        flags: &a.flags,
        design: a.design.as_deref(),
        counts: &a.counts,
        picks: a.picks.map(u64::from),
        realizations: a.realizations,
        method: a.estimator,
        removal: a.mean_removal,
        intercepts: a.intercepts == Intercepts::Keep,
        degenerate_from: not_below("--degenerate-from", a.degenerate_from.unwrap_or(3f64.sqrt()), 0.0)?,
        published: published(a.reference.as_deref(), &mut provenance)?,
        seed: a.common.seed.unwrap_or(1),
        out: a.common.main_output("selection.parquet", &inputs)?,
        quiet: a.common.quiet,
    };
    selection::select(&wanted, provenance)
}

/// Where the figures of a published selection study end.
fn published(file: Option<&Path>, provenance: &mut Provenance) -> Result<Option<PublishedLimits>, Failure> {
    let Some(file) = file else { return Ok(None) };
    let (reference, digest) = read_toml::<Reference>(file)?;
    provenance.inputs.insert("reference".into(), digest);
    Ok(reference.selection.as_ref().map(PublishedLimits::from))
}

fn stage(a: &Scores) -> Result<Summary, Failure> {
    let mut provenance = provenance("validate");
    let vessel = read_vessel(&a.vessel, &mut provenance)?;
    let config = read_campaign(&a.campaign, &mut provenance)?;
    let validation = ValidationRuns::read(&a.validation, &vessel, &mut provenance)?;
    let mut inputs = vec![a.vessel.as_path(), &a.campaign, &a.validation];
    inputs.extend(a.estimates.iter().chain(&a.sharding.gather).map(PathBuf::as_path));
    let out = a.common.main_output("scores.parquet", &inputs)?;
    if a.sharding.gathers() {
        let table = gather(&a.sharding.gather, &out, scores::ID, scores::VERSION)?;
        let gathered = TableReader::open(table.temporary(), scores::ID, scores::VERSION)?;
        let rows = scores::rows(&gathered)?;
        return publish(&config, &validation, gathered.provenance(), table, &rows);
    }
    let file = given(&a.estimates, "estimates")?;
    let reader = TableReader::open(file, estimates::ID, estimates::VERSION)?;
    reader.require(&estimates::schema(&vessel).columns)?;
    if let Some(shard) = &reader.provenance().shard {
        return Err(refuse_shard(file, shard).into());
    }
    provenance.inputs.insert("estimates".into(), reader.digest());
    study::note_seed(reader.provenance(), &mut provenance);
    provenance.shard.clone_from(&a.sharding.shard);
    let truth: Option<Vec<f64>> = vessel.value.iter().copied().collect();
    let mut writer = TableWriter::create(&out, &scores::schema(), &provenance)?;
    let blocks = a.sharding.shard.map_or(0..reader.blocks(), |s| s.range(reader.blocks()));
    let progress = Progress::new("blocks of estimates", blocks.len(), a.common.quiet);
    let mut rows = Vec::new();
    let work = |i: usize| {
        let own = validation.score(&estimates::rows(&reader, &vessel, file, i)?, truth.as_deref());
        progress.advance(1);
        Ok::<_, Failure>((encode_block(&scores::schema(), &scores::table(&own))?, own))
    };
    ordered(blocks, work, |(block, own): (EncodedBlock, Vec<Row>)| {
        rows.extend(own);
        Ok(writer.push(block)?)
    })?;
    publish(&config, &validation, &provenance, writer.finish()?, &rows)
}

fn publish(
    config: &CampaignFile,
    validation: &ValidationRuns,
    provenance: &Provenance,
    table: Staged,
    rows: &[Row],
) -> Result<Summary, Failure> {
    let out = table.path().to_owned();
    let bounds = Bounds {
        parameter_error: config.validation.parameter_error_bound,
        simulation_error: config.validation.simulation_error_bound,
    };
    let designs = scores::summarize(rows, bounds);
    let diverged: u64 = designs.iter().map(|d| d.diverged).sum();
    let json = json!({"out": out, "runs": rows.len(), "diverged": diverged, "designs": designs});
    let mut staged = vec![table];
    if provenance.shard.is_none() {
        let document = ValidationDocument {
            bounds,
            samples: validation.samples(),
            seed: study::seed(provenance),
            designs,
            recommendations: study::recommendations(rows),
            compared: scores::compare(rows, bounds),
        };
        staged.push(stage_document(beside(&out, "validation.json"), provenance, &document)?);
    }
    commit(staged)?;
    Ok(Summary { line: format!("{}: {} runs, {diverged} diverged", out.display(), rows.len()), json })
}
