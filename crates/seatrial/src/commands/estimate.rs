//! `estimate`: parameters of every run.

use std::path::{Path, PathBuf};

use artifact::{
    EncodedBlock, Provenance, Staged, TableReader, TableWriter, commit, encode_block, gather, stage_document,
};
use clap::{Parser, Subcommand};
use identification::predictor::{InitialState, Levels};
use identification::runs::RunEstimators;
use identification::{EstimateStatus, Estimator, MeanRemoval};
use serde_json::json;
use study::estimates::{self, Row};
use study::files::{read_campaign, read_vessel};
use study::trajectories::{Layout, TrajectoryReader};
use vessel::Vessel;

use super::estimate_pool;
use super::unidentified::{refuse_if_all_collinear, refuse_if_none};
use crate::choice::choice;
use crate::cli::{Common, Sharding, beside, given, provenance};
use crate::failure::Failure;
use crate::ordered::{joined, joined_blocks, ordered};
use crate::progress::Progress;
use crate::stage::{Either, Summary, Task};

/// An estimate of every run, or a subcommand.
pub type Arguments = Either<Runs, Study>;

/// What `estimate` does besides single runs.
#[derive(Subcommand)]
pub enum Study {
    /// One estimate from all runs, whose segments each get instruments of their own; writes estimates.parquet, estimate.json
    /// and trust.json
    Pool(estimate_pool::Arguments),
}

/// Estimates the parameters of every run, with standard errors; writes estimates.parquet and estimate.json
#[derive(Parser)]
#[command(
    name = "estimate",
    version,
    after_help = "Example:\n  estimate --vessel pipelines/paper/vessel.toml \
    --trajectories campaign.parquet --out estimates.parquet"
)]
pub struct Runs {
    /// The vessel
    #[arg(long, value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The runs
    #[arg(long, required_unless_present = "gather", value_name = "campaign.parquet")]
    trajectories: Option<PathBuf>,
    /// The estimator
    #[arg(long, value_parser = choice(&Estimator::OF_RUNS, Estimator::name, Estimator::description), default_value_t = Estimator::Iv)]
    estimator: Estimator,
    /// Every estimator on the same runs
    #[arg(long, conflicts_with = "estimator")]
    compare: bool,
    /// What disturbs the runs: for `prediction-error` and --compare, and for standard errors of `output-error`
    #[arg(long, value_name = "campaign.toml")]
    campaign: Option<PathBuf>,
    /// How the instruments' mean is removed
    #[arg(long, value_parser = choice(&MeanRemoval::ALL, MeanRemoval::name, MeanRemoval::description), default_value_t = MeanRemoval::Complete)]
    mean_removal: MeanRemoval,
    #[command(flatten)]
    sharding: Sharding,
    #[command(flatten)]
    common: Common,
}

impl Task for Runs {
    fn common(&self) -> &Common {
        &self.common
    }

    fn run(&self) -> Result<Summary, Failure> {
        stage(self)
    }
}

impl Task for Study {
    fn common(&self) -> &Common {
        let Self::Pool(a) = self;
        a.common()
    }

    fn run(&self) -> Result<Summary, Failure> {
        let Self::Pool(a) = self;
        a.run()
    }
}

fn stage(a: &Runs) -> Result<Summary, Failure> {
    let mut provenance = provenance("estimate");
    let vessel = read_vessel(&a.vessel, &mut provenance)?;
    let mut inputs = vec![a.vessel.as_path()];
    inputs.extend(a.trajectories.iter().chain(&a.sharding.gather).map(PathBuf::as_path));
    let out = a.common.main_output("estimates.parquet", &inputs)?;
    let levels = levels(a, &vessel, &mut provenance)?;
    let document_file = beside(&out, "estimate.json");
    if a.sharding.gathers() {
        let table = gather(&a.sharding.gather, &out, estimates::ID, estimates::VERSION)?;
        let gathered = TableReader::open(table.temporary(), estimates::ID, estimates::VERSION)?;
        gathered.require(&estimates::schema(&vessel).columns)?;
        let blocks = 0..gathered.blocks();
        let rows: Vec<Vec<Row>> =
            blocks.map(|i| estimates::rows(&gathered, &vessel, &out, i)).collect::<Result<_, _>>()?;
        return publish(a, &vessel, gathered.provenance(), table, rows.concat(), &document_file);
    }
    let file = given(&a.trajectories, "trajectories")?;
    let reader = TrajectoryReader::open(file, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
    reader.whole()?;
    provenance.inputs.insert("trajectories".into(), reader.digest());
    study::note_seed(reader.provenance(), &mut provenance);
    provenance.settings.insert("estimator".into(), json!(a.estimator));
    if a.compare {
        provenance.settings.insert("compared".into(), json!(Estimator::OF_RUNS));
    }
    let initial = if reader.true_states() { InitialState::Known } else { InitialState::Estimated };
    if a.compare || a.estimator.searches() {
        provenance.settings.insert("initial_state".into(), json!(initial.name()));
    }
    provenance.settings.insert("mean_removal".into(), json!(a.mean_removal));
    provenance.shard.clone_from(&a.sharding.shard);
    let schema = estimates::schema(&vessel);
    let mut writer = TableWriter::create(&out, &schema, &provenance)?;
    let mut rows = Vec::new();
    let mut each = |(block, own): (EncodedBlock, Vec<Row>)| {
        rows.extend(own);
        Ok(writer.push(block)?)
    };
    let estimators = RunEstimators {
        vessel: &vessel,
        estimators: if a.compare { Estimator::OF_RUNS.to_vec() } else { vec![a.estimator] },
        removal: a.mean_removal,
        initial,
        levels,
    };
    estimate_blocks(a, &estimators, file, &reader, &schema, &mut each)?;
    if a.sharding.shard.is_none() {
        refuse_if_all_collinear(&estimators, file, &reader, &rows)?;
        refuse_if_none(file, &vessel, &rows)?;
    }
    publish(a, &vessel, &provenance, writer.finish()?, rows, &document_file)
}

/// What disturbs the runs, where that is stated.
fn levels(a: &Runs, vessel: &Vessel, provenance: &mut Provenance) -> Result<Option<Levels>, Failure> {
    let Some(file) = a.campaign.as_deref() else {
        let needed =
            [(a.compare, "--compare"), (a.estimator == Estimator::PredictionError, "prediction-error")];
        return match needed.into_iter().find(|(needed, _)| *needed && !a.sharding.gathers()) {
            None => Ok(None),
            Some((_, what)) => Err(Failure::Usage(format!(
                "--campaign: found none, expected the campaign.toml whose disturbances {what} needs; name it"
            ))),
        };
    };
    let levels = read_campaign(file, provenance)?.levels(vessel.sample_rate_hz);
    let silent = levels.measurement.iter().position(|std| *std == 0.0);
    match silent.filter(|_| a.compare || a.estimator == Estimator::PredictionError) {
        None => Ok(Some(levels)),
        Some(d) => Err(Failure::refuse(
            file,
            &format!("`measurement.{}`", ["std_u_m_s", "std_v_m_s", "std_r_rad_s"][d]),
            "0",
            "measurement noise in every state, which the filter of `prediction-error` weighs predictions with",
            "state what the sensor has, however little",
        )),
    }
}

fn estimate_blocks(
    a: &Runs,
    estimators: &RunEstimators,
    file: &Path,
    reader: &TrajectoryReader,
    schema: &artifact::TableSchema,
    each: &mut dyn FnMut((EncodedBlock, Vec<Row>)) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let outputs = joined_blocks(reader.blocks());
    let mine = a.sharding.shard.map_or(0..outputs, |s| s.range(outputs));
    let progress = Progress::new("blocks of runs", reader.blocks(), a.common.quiet);
    let block = |i: usize| {
        let rows = estimators.estimates(&reader.runs(i)?);
        progress.advance(1);
        rows.map_err(|e| Failure::of_run(&e, &a.vessel, file))
    };
    let work = |i: usize| {
        let rows = joined(i, reader.blocks(), block)?;
        Ok((encode_block(schema, &estimates::table(estimators.vessel, &rows))?, rows))
    };
    ordered(mine, work, each)
}

fn publish(
    a: &Runs,
    vessel: &Vessel,
    provenance: &Provenance,
    table: Staged,
    rows: Vec<Row>,
    document_file: &Path,
) -> Result<Summary, Failure> {
    let out = table.path().to_owned();
    let (runs, identified) = (rows.len(), rows.iter().filter(|r| r.estimate.is_some()).count());
    let count = |status: EstimateStatus| rows.iter().filter(|r| r.status == status).count();
    let (unexcited, unconverged, kept) = (
        count(EstimateStatus::NotIdentifiable),
        count(EstimateStatus::NotConverged),
        count(EstimateStatus::Kept),
    );
    let also = |count: usize, what: &str| if count > 0 { format!(", {count} {what}") } else { String::new() };
    let searched = also(unconverged, EstimateStatus::NotConverged.name()) + &also(kept, "kept unrefined");
    let mut staged = vec![table];
    if provenance.shard.is_none() {
        let document = estimates::summarize(&out, provenance, vessel, &rows)?;
        staged.push(stage_document(document_file, provenance, &document)?);
    }
    commit(staged)?;
    let single = estimates::estimators(&rows).len() < 2;
    let simple = single && unconverged + kept == 0;
    let things = if single { "runs" } else { "estimates" };
    let part = a.sharding.shard.map_or(String::new(), |s| format!(", shard {s}"));
    Ok(Summary {
        line: format!("{}: {runs} {things}, {unexcited} not identifiable{searched}{part}", out.display()),
        json: if simple {
            json!({"out": out, "runs": runs, "identified": identified})
        } else {
            json!({"out": out, "estimates": runs, "identified": identified, "not_identifiable": unexcited,
                "not_converged": unconverged, "kept": kept})
        },
    })
}
