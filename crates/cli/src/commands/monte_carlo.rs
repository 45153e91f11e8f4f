//! `monte-carlo`: realizations that are estimated and scored in memory.

use std::ops::Range;
use std::path::Path;

use clap::Parser;
use estimation::predictor::InitialState;
use estimation::runs::RunEstimators;
use estimation::{Estimator, ValidationRuns, not_relative};
use files::{Provenance, Staged, Work, commit, stage_set_document};
use numerics::LANES;
use regression::MeanRemoval;
use seatrial::{MonteCarlo, undisturbed};
use serde_json::{Value, json};
use ship::model::{Source, Vessel};
use study::campaign_file::CampaignFile;
use study::documents::TallyDocument;
use study::estimates::{self, distinct};
use study::files::{generator, read_any_simulated};
use study::kept::{Keep, Kept};
use study::tallies::MAIN;
use study::trajectories::Layout;
use trial::campaign::Settings;

use crate::cli::{AdditionalFlags, Common, Sharding, budget, choice, folder_of};
use crate::failure::Failure;
use crate::monte_carlo::{BLOCK, Done, needed_for, refused};
use crate::simulate::{CampaignFlags, Files, note_plays};
use crate::stage::{Summary, Task};

/// Simulates a trial many times and counts how often its model is good; writes tally.json
#[derive(Parser)]
#[command(
    name = "monte-carlo",
    after_help = "Example:\n  monte-carlo --vessel pipelines/smoke/vessel.toml \
    --dictionary pipelines/smoke/dictionary.toml --campaign pipelines/smoke/campaign.toml --design design.json \
    --realizations 1000 --out tally.json"
)]
pub struct MonteCarloArguments {
    #[command(flatten)]
    of: CampaignFlags,
    /// The estimators, with commas between them, all on the same runs
    #[arg(long, value_delimiter = ',', value_parser = choice(&Estimator::OF_RUNS, Estimator::name, Estimator::description), default_values_t = [Estimator::Iv])]
    estimator: Vec<Estimator>,
    /// How the instruments' mean is removed
    #[arg(long, value_parser = choice(&MeanRemoval::ALL, MeanRemoval::name, MeanRemoval::description), default_value_t = MeanRemoval::Complete)]
    mean_removal: MeanRemoval,
    #[command(flatten)]
    additional: AdditionalFlags,
    /// Runs per design, instead of the campaign's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_RUNS))]
    realizations: Option<u32>,
    /// Goes on until no share's 95 % interval is further from its middle than this
    #[arg(long, value_name = "SHARE", conflicts_with_all = ["realizations", "shard", "gather", "keep"])]
    until: Option<f64>,
    /// What to keep in tables beside the tally: each also what stands before it
    #[arg(long, value_parser = choice(&Keep::ALL, Keep::name, Keep::description), default_value_t = Keep::None, conflicts_with_all = ["shard", "gather"])]
    keep: Keep,
    /// Keeps the trajectories of only so many runs per design
    #[arg(long, value_name = "K")]
    keep_first: Option<u32>,
    #[command(flatten)]
    sharding: Sharding,
}

/// A run's number is a whole number of 32 bits in tables.
const MOST_RUNS: i64 = i32::MAX as i64;

impl Task for MonteCarloArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let out = common.main_output(MAIN, self.of.paths().chain(&self.sharding.gather))?;
        if self.sharding.gathers() {
            let (provenance, merged) = study::tallies::merged(&self.sharding.gather)?;
            return published(&out, &provenance, merged, Vec::new());
        }
        self.computed(common, &out)
    }
}

impl MonteCarloArguments {
    fn computed(&self, common: &Common, out: &Path) -> Result<Summary, Failure> {
        self.additional.check(&self.estimator)?;
        let mut provenance = common.provenance("monte-carlo");
        let of = self.of.read(read_any_simulated, &mut provenance)?;
        let taken = self.estimator.iter().try_for_each(|own| own.check(&of.vessel));
        taken.map_err(|e| Failure::invalid(of.files.vessel, &e))?;
        let (files, config) = (of.files, &of.config);
        of.logged_helm().check(files.dictionary, &self.estimator)?;
        let settings = self.settings(config, common, files.campaign)?;
        self.note(&settings, &mut provenance);
        let study = MonteCarlo {
            campaign: of.campaign(&settings)?,
            estimators: self.estimators(&of.vessel, config),
            validation: validation(&of.vessel, config, files.campaign)?,
            truth: of.vessel.value.iter().copied().collect(),
        };
        study.estimators.check_forces().map_err(|e| Failure::invalid(files.campaign, &e))?;
        note_plays(&study.campaign, &mut provenance);
        self.check_room(&study, files.campaign, out)?;
        let done = Done { study: &study, files: &files, bounds: config.bounds(), quiet: common.quiet };
        let (campaign, keep) = (&study.campaign, (self.keep, self.keep_first));
        let mut kept = Kept::new(keep, campaign.vessel(), campaign.reacting(), out, &provenance)?;
        let tally = match self.until {
            None => done.tallied(self.mine(&study), &mut kept)?,
            Some(width) => done.until(width)?,
        };
        let runs = tally.counted.first().map_or(0, |counted| counted.runs);
        let realizations = if self.until.is_some() { runs } else { u64::from(settings.realizations) };
        let samples = [study.campaign.samples() as u64, study.validation.samples()];
        let document = TallyDocument::new(tally, config.bounds(), realizations, samples, settings.seed);
        let kept = kept.finish(out, config.bounds(), samples[1], &provenance)?;
        let summary = published(out, &provenance, document, kept)?;
        Ok(summary.also(not_relative(campaign.vessel())))
    }
}

impl MonteCarloArguments {
    /// Size and seed of the campaign.
    fn settings(&self, config: &CampaignFile, common: &Common, file: &Path) -> Result<Settings, Failure> {
        let settings = config.settings(common.seed);
        let most = MOST_RUNS as u32;
        let realizations = match self.until {
            Some(width) => reachable(width).map(|()| most)?,
            None => self.realizations.unwrap_or(settings.realizations),
        };
        if realizations > most {
            let expected = format!("at most {most}, as many as run numbers have place for");
            let remedy = "take fewer, or campaigns of other seeds";
            return Err(Failure::refuse(
                file,
                "`realizations`",
                &realizations.to_string(),
                &expected,
                remedy,
            ));
        }
        Ok(Settings { realizations, ..settings })
    }

    /// The settings that the tally depends on besides the inputs.
    fn note(&self, settings: &Settings, provenance: &mut Provenance) {
        provenance.shard = self.sharding.shard;
        let noted = &mut provenance.settings;
        noted.insert("seed".into(), json!(settings.seed));
        noted.insert("estimator".into(), json!(self.estimator[0]));
        if self.estimator.len() > 1 {
            noted.insert("compared".into(), json!(self.estimator));
        }
        if self.estimator.iter().any(|estimator| estimator.searches()) {
            noted.insert("initial_state".into(), json!(InitialState::Known.name()));
        }
        noted.insert("mean_removal".into(), json!(self.mean_removal));
        self.additional.note(noted);
        match self.until {
            Some(width) => noted.insert("until".into(), json!(width)),
            None => noted.insert("realizations".into(), json!(settings.realizations)),
        };
    }

    fn estimators<'a>(&self, vessel: &'a Vessel, config: &CampaignFile) -> RunEstimators<'a> {
        RunEstimators {
            vessel,
            estimators: distinct(self.estimator.iter().copied()),
            removal: self.mean_removal,
            initial: InitialState::Known,
            additional: self.additional.unknown(),
            levels: Some(config.levels(vessel.sample_rate_hz)),
        }
    }

    /// The runs of this shard, or all.
    fn mine(&self, study: &MonteCarlo) -> Vec<(usize, Range<usize>)> {
        let groups = study.groups();
        study.parts(self.sharding.shard.map_or(0..groups, |shard| shard.range(groups)), BLOCK)
    }

    /// Refuses work that does not fit into memory or on disk.
    fn check_room(&self, study: &MonteCarlo, file: &Path, out: &Path) -> Result<(), Failure> {
        let vessel = study.campaign.vessel();
        let layout = Layout::new(&vessel.model);
        let runs = if self.until.is_some() { 0.0 } else { study.campaign.runs() as f64 };
        let rows = study.campaign.samples() as f64 + 1.0;
        let designs = study.campaign.designs() as f64;
        let each = (BLOCK * LANES) as f64;
        let at_once = 2.0 * each * rayon::current_num_threads() as f64;
        let estimators = study.estimators.estimators.len() as f64;
        let kept =
            if self.keep.keeps(Keep::Scores) { 2.0 * estimates::row_bytes(vessel) * estimators } else { 0.0 };
        let trajectories = match self.keep {
            Keep::Trajectories => self.keep_first.map_or(runs, |first| f64::from(first) * designs).min(runs),
            _ => 0.0,
        };
        let found = format!("{runs} runs of {} samples", study.campaign.samples());
        let remedy = "keep less, or take fewer `realizations`";
        let work = Work { file, thing: "`realizations`", found: &found, remedy };
        let simulated = at_once.min(runs.max(each)) * rows * layout.run_bytes();
        let encoded = trajectories.min(at_once) * rows * layout.working_bytes();
        budget().memory(work, simulated + encoded + runs * kept)?;
        let rows = trajectories * rows;
        Ok(budget().disk(work, folder_of(out), rows * study::trajectories::LEAST_ROW_BYTES)?)
    }
}

/// Refuses a half-width that no number of runs reaches, or that is trivial.
fn reachable(width: f64) -> Result<(), Failure> {
    let least = needed_for(1.0) / (MOST_RUNS as f64).sqrt();
    if width >= least && width < 0.5 {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "--until: found {width:?}, expected a half-width of a share from {least:.1e}, which {MOST_RUNS} runs reach, to below \
         0.5; correct it"
    )))
}

/// The campaign's validation maneuvers, as `simulate validation` simulates them.
fn validation<'a>(
    vessel: &'a Vessel,
    config: &CampaignFile,
    file: &Path,
) -> Result<ValidationRuns<'a>, Failure> {
    let own = generator(file, vessel, &config.validation_dictionary(), &mut Provenance::default())?;
    let runs = undisturbed(vessel, &own, Source::Value, "validation");
    let runs = runs.map_err(|e| refused(&Files::all(file), e))?;
    ValidationRuns::new(vessel, runs).ok_or_else(|| {
        let (expected, remedy) = ("at least one maneuver", "state what estimates are validated on");
        Failure::refuse(file, "`validation.maneuver`", "none", expected, remedy)
    })
}

/// Publishes the tally and the kept tables, and summarises it.
fn published(
    out: &Path,
    provenance: &Provenance,
    document: TallyDocument,
    kept: Vec<Staged>,
) -> Result<Summary, Failure> {
    let mut files = vec![stage_set_document(out, provenance, &document, &kept)?];
    files.extend(kept);
    commit(files)?;
    let part = provenance.shard.map_or(String::new(), |shard| format!(", shard {shard}"));
    let runs = |c: &validation::tally::Counted| c.runs;
    let first = document.tally.counted.first().map(|counted| counted.estimator);
    let own = document.tally.counted.iter().filter(|counted| Some(counted.estimator) == first);
    let plays = provenance.settings.get("plays").and_then(Value::as_array).into_iter().flatten();
    let statements = plays.filter_map(Value::as_str).chain(document.statements.iter().map(String::as_str));
    let said: Vec<String> = statements.map(|said| format!("; {}", said.trim_end_matches('.'))).collect();
    let runs: u64 = own.map(runs).sum();
    Ok(Summary::of(
        out,
        format!("{runs} runs{part}{}", said.concat()),
        json!({"runs": runs, "scores": document.scores, "paired": document.paired}),
    ))
}
