//! `validate`: how far the estimated models can be trusted.

use std::path::{Path, PathBuf};

use artifact::{
    EncodedBlock, Provenance, Staged, TableReader, TableWriter, commit, encode_block, gather, stage_document,
};
use clap::{Parser, Subcommand};
use identification::ValidationRuns;
use serde_json::json;
use study::campaign_file::CampaignFile;
use study::documents::{Bounds, ValidationDocument};
use study::estimates;
use study::files::{read_campaign, read_vessel};
use study::scores::{self, Row};
use study::trajectories::refuse_shard;
use vessel::Vessel;

use super::{cross, selection};
use crate::cli::{Common, Sharding, beside, given, provenance};
use crate::failure::Failure;
use crate::ordered::ordered;
use crate::pool::all_runs;
use crate::progress::Progress;
use crate::stage::{Either, Summary, Task};

/// The scores of estimates, or a study of its own.
pub type Arguments = Either<Scores, Study>;

/// What `validate` does besides scores.
#[derive(Subcommand)]
pub enum Study {
    /// Leaves runs or recordings out of a pooled estimate and simulates over them; writes crossval.json
    Cross(cross::Arguments),
    /// Models from sub-experiments that a design picked against random picks; writes selection.parquet, selection.json
    Selection(selection::Arguments),
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
            Self::Cross(a) => a.common(),
            Self::Selection(a) => a.common(),
        }
    }

    fn run(&self) -> Result<Summary, Failure> {
        match self {
            Self::Cross(a) => a.run(),
            Self::Selection(a) => a.run(),
        }
    }
}

fn stage(a: &Scores) -> Result<Summary, Failure> {
    let mut provenance = provenance("validate");
    let vessel = read_vessel(&a.vessel, &mut provenance)?;
    let config = read_campaign(&a.campaign, &mut provenance)?;
    let validation = validation_runs(&a.validation, &vessel, &mut provenance)?;
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

fn validation_runs<'a>(
    file: &Path,
    vessel: &'a Vessel,
    provenance: &mut Provenance,
) -> Result<ValidationRuns<'a>, Failure> {
    let runs = all_runs(file, "validation", vessel, provenance)?;
    ValidationRuns::new(vessel, runs).ok_or_else(|| {
        Failure::refuse(file, "rows", "none", "at least one run", "simulate the validation again")
    })
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
