//! `monte-carlo`: realizations that are estimated and scored in memory, of a design or in rounds.

use std::ops::Range;
use std::path::Path;

use clap::Parser;
use estimation::predictor::InitialState;
use estimation::runs::{AdditionalUnknowns, RunEstimators};
use estimation::{Estimator, ValidationRuns, not_relative};
use files::{Provenance, Staged, Work, commit, stage_set_document};
use numerics::LANES;
use refusal::Invalid;
use regression::MeanRemoval;
use seatrial::{MonteCarlo, undisturbed};
use serde_json::{Value, json};
use ship::model::{Source, Vessel};
use study::campaign_file::CampaignFile;
use study::documents::{CountedRuns, ScoredEstimates, ValidationDocument};
use study::estimates::{self, distinct};
use study::files::{StageOfTerms, generator, read_any_simulated, read_campaign, read_dictionary};
use study::parts::{Keep, KeptTables, MAIN};
use study::sequential::{RoundsSpec, columns, document, rows};
use study::trajectories::Layout;
use trial::campaign::Settings;
use trial::rounds::{self, Arm, Row, Trial};

use super::compare::SCORES;
use crate::cli::{AdditionalFlags, Common, Sharding, beside, budget, choice, folder_of, given, none_given};
use crate::failure::{Failure, WorkProgress};
use crate::inputs::{self, Made};
use crate::simulate::{BLOCK_OF_GROUPS, CampaignFlags, Counting, Files, needed_for, note_plays, refused};
use crate::stage::{Summary, Task};

/// Simulates a trial many times and counts how often its model is good; writes validation.json. Without a design: trials that are designed
/// in rounds beside trials that are designed once, as [rounds] of campaign.toml says; writes scores.parquet and validation.json
#[derive(Parser)]
#[command(
    name = "monte-carlo",
    after_help = "Example:\n  monte-carlo --vessel pipelines/smoke/vessel.toml \
    --dictionary pipelines/smoke/dictionary.toml --campaign pipelines/smoke/campaign.toml --design design.json \
    --realizations 1000 --out validation.json\n  monte-carlo --vessel pipelines/sequential/vessel.toml \
    --dictionary pipelines/sequential/dictionary.toml --campaign pipelines/sequential/campaign.toml --out scores.parquet"
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
    /// What to keep in tables beside the counts: each also what stands before it
    #[arg(long, value_parser = choice(&Keep::ALL, Keep::name, Keep::description), default_value_t = Keep::None, conflicts_with_all = ["shard", "gather"])]
    keep: Keep,
    #[command(flatten)]
    sharding: Sharding,
}

/// A run's number is a whole number of 32 bits in tables.
const MOST_RUNS: i64 = i32::MAX as i64;

impl Task for MonteCarloArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("monte-carlo");
        if let Some(rounds) = self.rounds(&mut provenance)? {
            return self.in_rounds(rounds, common, provenance);
        }
        let out = common.main_output(MAIN, self.of.paths().chain(&self.sharding.gather))?;
        if self.sharding.gathers() {
            let (provenance, merged) = study::parts::merged(&self.sharding.gather)?;
            return published(&out, &provenance, merged, (Vec::new(), None));
        }
        self.computed(common, &out)
    }
}

impl MonteCarloArguments {
    fn computed(&self, common: &Common, out: &Path) -> Result<Summary, Failure> {
        self.additional.check(&self.estimator)?;
        let mut provenance = common.provenance("monte-carlo");
        let of = self.of.read(read_any_simulated, &mut provenance)?;
        let taken = self.estimator.iter().try_for_each(|estimator| estimator.check(&of.vessel));
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
        study.estimators.check().map_err(|e| Failure::invalid(files.campaign, &e.into()))?;
        note_plays(&study.campaign, &mut provenance);
        self.check_room(&study, files.campaign, out)?;
        let done = Counting { study: &study, files: &files, bounds: config.bounds(), quiet: common.quiet };
        let campaign = &study.campaign;
        let mut kept = KeptTables::new(self.keep, campaign.vessel(), campaign.reacting(), out, &provenance)?;
        let tally = match self.until {
            None => done.tallied(self.mine(&study), &mut kept)?,
            Some(width) => done.until(width)?,
        };
        let runs = tally.counted.first().map_or(0, |counted| counted.runs);
        let realizations = if self.until.is_some() { runs } else { u64::from(settings.realizations) };
        let samples = [study.campaign.samples() as u64, study.validation.samples()];
        let counted = CountedRuns::new(tally, config.bounds(), realizations, samples, settings.seed);
        let kept = kept.finish(out, config.bounds(), samples[1], &provenance)?;
        let summary = published(out, &provenance, counted, kept)?;
        Ok(summary.also(not_relative(campaign.vessel())))
    }

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
            let (given, remedy) = (realizations.to_string(), "take fewer, or campaigns of other seeds");
            return Err(Failure::refuse(file, "`realizations`", &given, &expected, remedy));
        }
        Ok(Settings { realizations, ..settings })
    }

    /// The settings that the counts depend on besides the inputs.
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
        study.parts(self.sharding.shard.map_or(0..groups, |shard| shard.range(groups)), BLOCK_OF_GROUPS)
    }

    /// Refuses work that does not fit into memory or on disk.
    fn check_room(&self, study: &MonteCarlo, file: &Path, out: &Path) -> Result<(), Failure> {
        let vessel = study.campaign.vessel();
        let layout = Layout::new(&vessel.model);
        let runs = if self.until.is_some() { 0.0 } else { study.campaign.runs() as f64 };
        let rows = study.campaign.samples() as f64 + 1.0;
        let each = (BLOCK_OF_GROUPS * LANES) as f64;
        let at_once = 2.0 * each * rayon::current_num_threads() as f64;
        let estimators = study.estimators.estimators.len() as f64;
        let kept =
            if self.keep.keeps(Keep::Scores) { 2.0 * estimates::row_bytes(vessel) * estimators } else { 0.0 };
        let trajectories = if self.keep.keeps(Keep::Trajectories) { runs } else { 0.0 };
        let size = format!("{runs} runs of {} samples", study.campaign.samples());
        let remedy = "keep less, or take fewer `realizations`";
        let work = Work { file, thing: "`realizations`", found: &size, remedy };
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
    let maneuvers = generator(file, vessel, &config.validation_dictionary(), &mut Provenance::default())?;
    let runs = undisturbed(vessel, &maneuvers, Source::Value, "validation");
    let runs = runs.map_err(|e| refused(&Files::all(file), e))?;
    ValidationRuns::new(vessel, runs).ok_or_else(|| {
        let (expected, remedy) = ("at least one maneuver", "state what estimates are validated on");
        Failure::refuse(file, "`validation.maneuver`", "none", expected, remedy)
    })
}

/// Publishes the counts with the kept tables and their scores, and summarises them.
fn published(
    out: &Path,
    provenance: &Provenance,
    counted: CountedRuns,
    (mut files, scored): (Vec<Staged>, Option<ScoredEstimates>),
) -> Result<Summary, Failure> {
    let document = ValidationDocument { scored, counted: Some(counted.clone()), ..Default::default() };
    files.push(stage_set_document(out, provenance, &document, &files)?);
    commit(files)?;
    let part = provenance.shard.map_or(String::new(), |shard| format!(", shard {shard}"));
    let first = counted.tally.counted.first().map(|counted| counted.estimator);
    let of_first = counted.tally.counted.iter().filter(|counted| Some(counted.estimator) == first);
    let plays = provenance.settings.get("plays").and_then(Value::as_array).into_iter().flatten();
    let statements = plays.filter_map(Value::as_str).chain(counted.statements.iter().map(String::as_str));
    let said: Vec<String> = statements.map(|said| format!("; {}", said.trim_end_matches('.'))).collect();
    let runs: u64 = of_first.map(|counted| counted.runs).sum();
    Ok(Summary::of(
        out,
        format!("{runs} runs{part}{}", said.concat()),
        json!({"runs": runs, "scores": counted.scores, "paired": counted.paired}),
    ))
}

/// What trials in rounds are made of.
type InRounds<'a> = (Files<'a>, CampaignFile, RoundsSpec);

impl MonteCarloArguments {
    /// The files of trials in rounds, and what `campaign.toml` says; `None` where a design is given, or shards of counts.
    fn rounds(&self, provenance: &mut Provenance) -> Result<Option<InRounds<'_>>, Failure> {
        let (None, Some(campaign)) = (&self.of.design, &self.of.campaign) else { return Ok(None) };
        let config = read_campaign(campaign, provenance)?;
        let Some(rounds) = config.rounds.clone() else {
            let expected = "a design.json, or [rounds] in campaign.toml for trials in rounds";
            return Err(Failure::Usage(format!(
                "--design: found none, expected {expected}; name or write it"
            )));
        };
        let realizations = self.realizations.unwrap_or(rounds.realizations);
        let (vessel, dictionary) =
            (given(&self.of.vessel, "vessel")?, given(&self.of.dictionary, "dictionary")?);
        let files = Files { vessel, dictionary, campaign, sea: campaign, design: campaign };
        Ok(Some((files, config, RoundsSpec { realizations, ..rounds })))
    }

    /// Simulates trials that are designed in rounds, from a crude model, beside trials that are designed once.
    fn in_rounds(
        &self,
        (files, campaign, config): InRounds,
        common: &Common,
        mut provenance: Provenance,
    ) -> Result<Summary, Failure> {
        let flags = [
            ("--estimator", self.estimator != [Estimator::Iv]),
            ("--mean-removal", self.mean_removal != MeanRemoval::Complete),
            ("--until", self.until.is_some()),
            ("--keep", self.keep != Keep::None),
        ];
        none_given(flags, "trials in rounds, which are estimated by `output-error`", "a --design")?;
        let out = common.main_output(SCORES, self.of.paths().chain(&self.sharding.gather))?;
        let vessel = StageOfTerms::Sequential.read_simulated(files.vessel, &mut provenance)?;
        let generator = read_dictionary(files.dictionary, &vessel, &mut provenance)?;
        let seed = common.seed.unwrap_or(campaign.seed);
        provenance.settings.insert("seed".into(), json!(seed));
        let of = |file: &'_ Path| {
            let file = file.to_owned();
            move |e: Invalid| Failure::invalid(&file, &e)
        };
        rounds::truth(&vessel).map_err(of(files.vessel))?;
        let knowledge = config.knowledge(&vessel, seed).map_err(of(files.campaign))?;
        let ends = rounds::ends(&vessel, config.duration_s, config.rounds as usize);
        let ends = ends.map_err(|e| Invalid { thing: e.thing.replacen('`', "`rounds.", 1), ..e });
        let ends = ends.map_err(of(files.campaign))?;
        self.check_rows(&config, files.campaign)?;
        let noise = campaign.predictable_noise().map_err(of(files.campaign))?;
        let sea = campaign.sea(&vessel).map_err(of(files.vessel))?;
        let estimators = RunEstimators {
            vessel: &vessel,
            estimators: vec![Estimator::OutputError],
            removal: MeanRemoval::Complete,
            initial: InitialState::Known,
            additional: AdditionalUnknowns::default(),
            levels: Some(campaign.levels(vessel.sample_rate_hz)),
        };
        let segments = campaign.random.map_or(5, |random| random.segments as usize);
        let trial = Trial::new(sea, &generator, noise, estimators, knowledge, ends, segments)
            .map_err(|e| files.refused(e))?;
        let (document, rate_hz) = (beside(&out, SCORES, MAIN), vessel.sample_rate_hz);
        let outputs = [out.as_path(), document.as_path()];
        let made = if self.sharding.gathers() {
            let shards = &self.sharding.gather;
            Made::gathered(shards, outputs, &columns(rate_hz), provenance, |reader| rows(reader, rate_hz))?
        } else {
            provenance.shard = self.sharding.shard;
            realized(&trial, &files, (config.realizations, rate_hz), outputs, (provenance, common.quiet))?
        };
        publish(files.campaign, &document, made, &trial, (&config, rate_hz))
    }

    /// Refuses more realizations than fit into memory: their rows are kept for the summary while they are converted
    /// to columns.
    fn check_rows(&self, config: &RoundsSpec, file: &Path) -> Result<(), Failure> {
        let (realizations, rounds) = (config.realizations, config.rounds);
        let rows = f64::from(realizations) * Arm::ALL.len() as f64 * f64::from(rounds);
        let size = format!("{realizations} realizations of {rounds} rounds");
        let remedy = "take fewer `realizations`, or --shard";
        let work = Work { file, thing: "`rounds.realizations`", found: &size, remedy };
        let part = f64::from(self.sharding.shard.map_or(1, |shard| shard.count));
        Ok(budget().memory(work, 2.0 * rows / part * size_of::<Row>() as f64)?)
    }
}

fn publish(
    campaign: &Path,
    file: &Path,
    made: Made<Row>,
    trial: &Trial,
    (config, rate_hz): (&RoundsSpec, f64),
) -> Result<Summary, Failure> {
    if let Some(shard) = made.provenance.shard {
        return made.publish_shard(shard, "rows");
    }
    let Made { table, provenance, rows } = made;
    let (out, count) = (table.path().to_owned(), config.realizations);
    if rows.iter().all(|row| row.parameter_error.is_none()) {
        return Err(Failure::NoAnswer(format!(
            "{}: rounds: found no estimate in any of {count} realizations, expected some that converge; lengthen `rounds.duration_s`, \
             or give the vessel a nominal model nearer to it",
            campaign.display(),
        )));
    }
    let summary = rounds::Summary::new(&rows, trial.ends(), config.accuracy, rate_hz);
    let rounds = document(config, summary, trial.maneuvers());
    let said: Vec<String> = trial.statement().into_iter().chain(rounds.statements.iter().cloned()).collect();
    let said = said.join("; ");
    let details = json!({"realizations": count, "statements": rounds.statements});
    let document = ValidationDocument { rounds: Some(rounds), ..Default::default() };
    inputs::publish(table, file, &provenance, || Ok(document))?;
    Ok(Summary::of(&out, format!("{count} realizations; {said}"), details))
}

/// The rows of this shard, or all.
fn realized(
    trial: &Trial,
    files: &Files,
    (count, rate_hz): (u32, f64),
    out: [&Path; 2],
    (provenance, quiet): (Provenance, bool),
) -> Result<Made<Row>, Failure> {
    let together = together(count);
    let groups = (count as usize).div_ceil(together);
    let mine = provenance.shard.map_or(groups, |shard| shard.range(groups).len());
    // Every round of every arm is simulated and estimated from the beginning.
    let each = Arm::ALL.len() as f64 * trial.ends().iter().sum::<usize>() as f64;
    let seconds = (mine * together) as f64 * each * Estimator::OutputError.seconds_per_row();
    let progress = WorkProgress::new("realizations", mine * together, quiet).foretold(seconds);
    Made::computed(out, &columns(rate_hz), provenance, groups, |group| {
        let first = (group * together) as u32;
        let numbers = first..count.min(first + together as u32);
        let advance = numbers.len();
        let rows = trial.realizations(numbers).map_err(|e| files.refused(e));
        progress.advance(advance);
        rows
    })
}

/// Realizations that are computed together. With more of them, fewer lanes are idle while some searches continue;
/// with few realizations only one group of lanes, so that all shards and threads have work.
fn together(count: u32) -> usize {
    (count as usize / (8 * LANES)).clamp(1, 4) * LANES
}
