//! `validate`: how good models are.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, Parser};
use estimation::pooled::Covariance;
use estimation::{ValidationRuns, not_relative};
use files::{Provenance, TableReader, TableWriter, commit_with_document, encode_block};
use seatrial::{Merits, Unsimulated};
use serde_json::json;
use ship::model::Vessel;
use study::campaign_file::CampaignFile;
use study::documents::{ModelDocument, ValidationDocument, merit_rows};
use study::estimates;
use study::files::{read_any_simulated, read_campaign, read_dictionary, read_model};
use study::parts::MAIN;
use study::scores::{self, Row};
use study::trajectories::refuse_shard;

use super::compare::{ModelFlags, OF_PICKS, PickFlags, SCORES};
use crate::cli::{Common, Sharding, beside, given, member};
use crate::failure::{Failure, WorkProgress};
use crate::inputs::{self, Made};
use crate::pool::RunFlags;
use crate::stage::{Summary, Task};

/// Says how good models are: estimates of simulated runs against the truth, models on recordings, or models from picked parts of
/// recordings. Writes validation.json and a table
#[derive(Parser)]
#[command(
    name = "validate",
    mut_arg("trajectories", |arg| arg.required(false)),
    group(ArgGroup::new("asked").args(["campaign", "model", "design"]).required(true)),
    after_help = "Example:\n  validate --vessel pipelines/paper/vessel.toml \
    --campaign pipelines/paper/campaign.toml --estimates estimates.parquet --validation validation.parquet \
    --out scores.parquet\n  validate --model model.json --trajectories others.parquet --window-s 100 --out validation.json\n  \
    validate --vessel pipelines/esso-osaka/vessel.toml --trajectories trajectories.parquet --design design.json \
    --out scores.parquet"
)]
pub struct ValidateArguments {
    /// The vessel of estimates or picks
    #[arg(long, value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
    #[command(flatten)]
    sharding: Sharding,
    #[command(flatten, next_help_heading = "Estimates of simulated runs")]
    estimates: EstimateFlags,
    #[command(flatten, next_help_heading = "Models on recordings")]
    models: ModelFlags,
    #[command(flatten)]
    of: RunFlags,
    #[command(flatten, next_help_heading = "Picks from recordings")]
    picks: PickFlags,
}

/// Which estimates are scored, and by what.
#[derive(Args)]
struct EstimateFlags {
    /// The bounds below which an estimate counts as good
    #[arg(
        long,
        value_name = "campaign.toml",
        requires_all = ["vessel", "validation"],
        conflicts_with_all = ["trajectories", "runs", "leave_out", "window_s"],
        conflicts_with_all = OF_PICKS
    )]
    campaign: Option<PathBuf>,
    /// The estimates
    #[arg(long, value_name = "estimates.parquet")]
    estimates: Option<PathBuf>,
    /// Runs to simulate freely and compare with
    #[arg(long, value_name = "validation.parquet")]
    validation: Option<PathBuf>,
}

/// Samples of validation runs per second that a thread simulates and compares, order of magnitude: the paper's on a
/// server of 2024 (0.04 s for a thousand estimates and a thousand samples).
const SIMULATED_PER_SECOND: f64 = 2.5e7;

impl Task for ValidateArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let of = self.of.with_recordings_beside();
        if !self.models.model.is_empty() {
            return self.models.compare(&of, common);
        }
        let vessel = given(&self.vessel, "vessel")?;
        if let Some(design) = &self.picks.design {
            return self.picks.pick((vessel, design), &of, &self.sharding, common);
        }
        self.scored(vessel, common)
    }
}

impl ValidateArguments {
    /// Scores each estimate by how far its parameters and simulations are off.
    fn scored(&self, vessel_file: &Path, common: &Common) -> Result<Summary, Failure> {
        let EstimateFlags { campaign, estimates, validation } = &self.estimates;
        let mut provenance = common.provenance("validate");
        let vessel = read_any_simulated(vessel_file, &mut provenance)?;
        let config = read_campaign(given(campaign, "campaign")?, &mut provenance)?;
        let validation_file = given(validation, "validation")?;
        let runs = validation_runs(validation_file, &vessel, &mut provenance)?;
        let inputs = [&self.vessel, campaign, validation, estimates].into_iter().flatten();
        let out = common.main_output(SCORES, inputs.chain(&self.sharding.gather))?;
        let document = beside(&out, SCORES, MAIN);
        let made = match self.sharding.gathers() {
            true => {
                let shards = &self.sharding.gather;
                Made::gathered(shards, [&out, &document], &scores::columns(), provenance, scores::rows)?
            }
            false => self.computed(&vessel, &runs, provenance, [&out, &document], common.quiet)?,
        };
        Ok(publish(&config, &runs, &document, made)?.also(not_relative(&vessel)))
    }

    /// Scores the estimates of this shard, or all.
    fn computed(
        &self,
        vessel: &Vessel,
        validation: &ValidationRuns,
        mut provenance: Provenance,
        out: [&Path; 2],
        quiet: bool,
    ) -> Result<Made<Row>, Failure> {
        let file = given(&self.estimates.estimates, "estimates")?;
        let reader = TableReader::open(file, estimates::ID, estimates::VERSION)?;
        reader.require(&estimates::columns(vessel).schema().columns)?;
        if let Some(shard) = &reader.provenance().shard {
            return Err(refuse_shard(file, shard).into());
        }
        provenance.made("estimates", file, reader.digest(), reader.provenance())?;
        study::note_seed(reader.provenance(), &mut provenance);
        provenance.shard = self.sharding.shard;
        let truth: Option<Vec<f64>> = vessel.value.iter().copied().collect();
        let blocks = self.sharding.shard.map_or(reader.blocks(), |s| s.range(reader.blocks()).len());
        let share = blocks as f64 / reader.blocks().max(1) as f64;
        let seconds = share * reader.rows() as f64 * validation.samples() as f64 / SIMULATED_PER_SECOND;
        let progress = WorkProgress::new("blocks of estimates", blocks, quiet).foretold(seconds);
        let score = |i: usize| {
            let score = validation.score(&estimates::rows(&reader, vessel, file, i)?, truth.as_deref());
            progress.advance(1);
            Ok(score)
        };
        let made = Made::computed(out, &scores::columns(), provenance, reader.blocks(), score)?;
        match scores::doubled(&made.rows) {
            None => Ok(made),
            Some(row) => Err(Failure::refuse(
                file,
                &format!("design {}, run {}", row.design, row.run),
                &format!("its estimate by {} twice", row.estimator),
                "every estimate once",
                "estimate again",
            )),
        }
    }
}

fn validation_runs<'a>(
    file: &Path,
    vessel: &'a Vessel,
    provenance: &mut Provenance,
) -> Result<ValidationRuns<'a>, Failure> {
    let reader = inputs::trajectories(file, "validation", vessel, provenance)?;
    let runs = inputs::all(file, &reader, vessel)?;
    ValidationRuns::new(vessel, runs).ok_or_else(|| {
        Failure::refuse(file, "rows", "none", "at least one run", "simulate the validation again")
    })
}

fn publish(
    config: &CampaignFile,
    validation: &ValidationRuns,
    document: &Path,
    made: Made<Row>,
) -> Result<Summary, Failure> {
    let Made { table, provenance, rows } = made;
    let out = table.path().to_owned();
    let validated = study::validated(&rows, config.bounds(), validation.samples(), &provenance);
    let diverged: u64 = validated.designs.iter().map(|d| d.diverged).sum();
    let summary = Summary::of(
        &out,
        format!("{} runs, {diverged} diverged", rows.len()),
        json!({"runs": rows.len(), "diverged": diverged, "designs": validated.designs}),
    );
    let validated = ValidationDocument { scored: Some(validated), ..Default::default() };
    inputs::publish(table, document, &provenance, || Ok(validated))?;
    Ok(summary)
}

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
    /// Simulates the ship with so many draws of her parameters: of a model from their covariance, else from their priors, as
    /// 400 are where her true parameters are not known
    #[arg(long, value_name = "N", conflicts_with = "trajectories", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    draws: Option<u32>,
    /// Adds the derivative of every figure by every parameter of the model, for `design --criterion figures`
    #[arg(long)]
    slopes: bool,
}

/// What the document is usually called.
const MERIT: &str = "merit.json";
/// Draws of a ship whose parameters are known by their priors alone.
const DRAWS: u32 = 400;

impl Task for MeritArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("validate");
        let read = || [&self.vessel].into_iter().chain(&self.dictionary).chain(&self.trajectories);
        let out = common.main_output(MERIT, read())?;
        let table = member(&out, MERIT, "merit.parquet", read())?;
        let vessel = read_any_simulated(&self.vessel, &mut provenance)?;
        let length_m = self.length_m.or_else(|| vessel.model.length_m());
        let Some(length_m) = length_m.filter(|length_m| *length_m > 0.0 && *length_m <= 1e3) else {
            let given = length_m.map_or("none".to_owned(), |length| length.to_string());
            let expected = "more than 0, at most 1000 m; correct it";
            return Err(Failure::Usage(format!("--length-m: found {given}, expected {expected}")));
        };
        let length = vessel.check_length(length_m, "--length-m", None);
        length.map_err(|e| Failure::invalid(&self.vessel, &e))?;
        let read = |file: &PathBuf| read_dictionary(file, &vessel, &mut provenance);
        let generator = self.dictionary.as_ref().map(read).transpose()?;
        let file = self.dictionary.as_ref().or(self.trajectories.as_ref()).unwrap_or(&self.vessel);
        let refused = |e| Failure::invalid(file, &e);
        let mut merits = Merits::new(&vessel, generator.as_ref(), length_m).map_err(refused)?;
        let model = read_model(&self.vessel)?;
        let is_guess = model.is_none() && vessel.is_guess();
        let trajectories = match &self.trajectories {
            // What a guessed ship does undisturbed says less than what ships like her do.
            Some(file) if is_guess && self.dictionary.is_some() && inputs::are_simulated(file, &vessel)? => {
                None
            }
            given => given.as_ref(),
        };
        let draws = self.draws.or((is_guess && trajectories.is_none()).then_some(DRAWS));
        let unsimulated = |e| match e {
            Unsimulated::Unheld(e) => refused(e),
            Unsimulated::Diverged(e) => Failure::invalid(&self.vessel, &e),
        };
        if self.draws.is_none() && draws.is_some() {
            // The ship as she is written is judged before others like her.
            let mut written = Merits::new(&vessel, generator.as_ref(), length_m).map_err(refused)?;
            written.simulate().map_err(unsimulated)?;
            written.found().map_err(|e| Failure::NoAnswer(format!("{}: {e}", file.display())))?;
        }
        match (trajectories, draws) {
            (Some(file), _) => {
                let reader = inputs::trajectories(file, "trajectories", &vessel, &mut provenance)?;
                let are_logged = !reader.true_states();
                if self.dictionary.is_none() && !are_logged {
                    let (expected, remedy) = ("logs, as `ingest` writes them", "give --dictionary");
                    return Err(Failure::refuse(file, "trajectories", "simulated ones", expected, remedy));
                }
                for block in 0..reader.blocks() {
                    merits.add(&reader.runs(block)?, reader.poses(block)?.as_deref(), are_logged);
                }
            }
            (None, None) => merits.simulate().map_err(unsimulated)?,
            (None, Some(draws)) => {
                let seed = common.seed.unwrap_or(1);
                merits
                    .simulate_drawn(&self.covariance(model.as_ref(), &vessel)?, draws, seed)
                    .map_err(refused)?;
            }
        }
        if self.slopes {
            merits.differentiate().map_err(|e| Failure::invalid(&self.vessel, &e))?;
        }
        let given = [("length_m", json!(length_m)), ("draws", json!(draws))];
        provenance.settings.extend(given.map(|(key, value)| (key.to_owned(), value)));
        let file = self.trajectories.as_ref().unwrap_or(file);
        let merits = merits.found().map_err(|e| Failure::NoAnswer(format!("{}: {e}", file.display())));
        let ((document, rows), columns) = (merits?, merit_rows());
        let mut writer = TableWriter::create(&table, columns.schema(), &provenance)?.with_document(&out);
        writer.push(encode_block(columns.schema(), &columns.table(&rows))?)?;
        commit_with_document(writer.finish()?, &out, &provenance, &document)?;
        let statements = &document.statements;
        let details = json!({"maneuvers": document.maneuvers.len(), "statements": statements});
        Ok(Summary::of(&out, document.in_short(), details))
    }
}

impl MeritArguments {
    /// What is known of the parameters: by the model's file, or by their priors.
    fn covariance(&self, model: Option<&ModelDocument>, vessel: &Vessel) -> Result<Covariance, Failure> {
        let of_model = model.and_then(|model| model.errors_of_parameters().cloned());
        of_model.or_else(|| Covariance::of_priors(&vessel.model)).ok_or_else(|| {
            let expected =
                "a model with one, as `estimate --fit together` writes it, or priors of a ship's parameters";
            Failure::refuse(&self.vessel, "`covariance`", "none", expected, "leave out --draws")
        })
    }
}
