//! `monte-carlo`: realizations that are estimated and scored in memory.

use std::ops::Range;
use std::path::{Path, PathBuf};

use artifact::{Provenance, Staged, TableWriter, Work, commit, stage_set_document};
use clap::{Parser, ValueEnum};
use identification::predictor::InitialState;
use identification::runs::RunEstimators;
use identification::{Estimator, MeanRemoval, RunEstimate, RunScore, ValidationRuns};
use in_memory::{MonteCarlo, Realized, StudyError};
use serde_json::json;
use study::campaign_file::CampaignFile;
use study::documents::{Bounds, DesignDocument, TallyDocument, ValidationDocument};
use study::files::{generator, read_campaign, read_dictionary, read_simulated};
use study::trajectories::{BlockBuilder, Layout, rows_per_block};
use study::{estimates, scores};
use trial::campaign::{Campaign, Maneuvers, Refusal, Settings};
use validation::tally::Tally;
use vessel::{LANES, Source, Vessel};

use crate::choice::choice;
use crate::cli::{Common, Sharding, beside, budget, folder_of, given};
use crate::failure::Failure;
use crate::inputs;
use crate::ordered::ordered;
use crate::progress::Progress;
use crate::simulate::Files;
use crate::stage::{Summary, Task};

/// Simulates, estimates and scores a campaign's runs in memory; writes tally.json
#[derive(Parser)]
#[command(
    name = "monte-carlo",
    after_help = "Example:\n  monte-carlo --vessel pipelines/smoke/vessel.toml \
    --dictionary pipelines/smoke/dictionary.toml --campaign pipelines/smoke/campaign.toml --design design.json \
    --realizations 1000 --out tally.json"
)]
pub struct Arguments {
    /// The vessel
    #[arg(long, visible_alias = "model", required_unless_present = "gather", value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
    /// The maneuvers
    #[arg(long, required_unless_present = "gather", value_name = "dictionary.toml")]
    dictionary: Option<PathBuf>,
    /// Runs, disturbances, validation, bounds, seed
    #[arg(long, required_unless_present = "gather", value_name = "campaign.toml")]
    campaign: Option<PathBuf>,
    /// The optimized shares
    #[arg(long, required_unless_present = "gather", value_name = "design.json")]
    design: Option<PathBuf>,
    /// The estimators, with commas between them, all on the same runs
    #[arg(long, value_delimiter = ',', value_parser = choice(&Estimator::OF_RUNS, Estimator::name, Estimator::description), default_values_t = [Estimator::Iv])]
    estimator: Vec<Estimator>,
    /// How the instruments' mean is removed
    #[arg(long, value_parser = choice(&MeanRemoval::ALL, MeanRemoval::name, MeanRemoval::description), default_value_t = MeanRemoval::Complete)]
    mean_removal: MeanRemoval,
    /// Runs per design, instead of the campaign's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_RUNS))]
    realizations: Option<u32>,
    /// Goes on until no share's 95 % interval is further from its middle than this
    #[arg(long, value_name = "SHARE", conflicts_with_all = ["realizations", "shard", "gather", "keep"])]
    until: Option<f64>,
    /// What to keep in tables beside the tally: each also what stands before it
    #[arg(long, value_enum, default_value_t = Keep::None, conflicts_with_all = ["shard", "gather"])]
    keep: Keep,
    /// Keeps the trajectories of only so many runs per design
    #[arg(long, value_name = "K")]
    keep_first: Option<u32>,
    #[command(flatten)]
    sharding: Sharding,
}

/// A run's number is a whole number of 32 bits in tables.
const MOST_RUNS: i64 = i32::MAX as i64;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
enum Keep {
    /// No table
    None,
    /// scores.parquet and validation.json
    Scores,
    /// And estimates.parquet and estimate.json
    Estimates,
    /// And campaign.parquet
    Trajectories,
}

/// What the tally is usually called.
const MAIN: &str = "tally.json";
/// Groups of runs whose tables' rows make a block.
const BLOCK: usize = 64;

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let own = [&self.vessel, &self.dictionary, &self.campaign, &self.design].into_iter().flatten();
        let out = common.main_output(MAIN, own.chain(&self.sharding.gather))?;
        if self.sharding.gathers() {
            let (provenance, merged) = study::tallies::merged(&self.sharding.gather)?;
            return published(&out, &provenance, merged, Vec::new());
        }
        self.computed(common, &out)
    }
}

impl Arguments {
    fn computed(&self, common: &Common, out: &Path) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("monte-carlo");
        let files = Files {
            vessel: given(&self.vessel, "vessel")?,
            dictionary: given(&self.dictionary, "dictionary")?,
            campaign: given(&self.campaign, "campaign")?,
            sea: given(&self.campaign, "campaign")?,
            design: given(&self.design, "design")?,
        };
        let vessel = read_simulated(files.vessel, &mut provenance)?;
        let dictionary = read_dictionary(files.dictionary, &vessel, &mut provenance)?;
        let config = read_campaign(files.campaign, &mut provenance)?;
        let design: DesignDocument = inputs::document(files.design, "design", &mut provenance)?;
        let settings = self.settings(&config, common, files.campaign)?;
        self.note(&settings, &mut provenance);
        let sea = config.sea(&vessel).map_err(|e| Failure::invalid(files.vessel, &e))?;
        let campaign = Campaign::new(sea, &dictionary, &design.designed(), &settings);
        let study = MonteCarlo {
            campaign: campaign.map_err(|e| files.refused(e))?,
            estimators: self.estimators(&vessel, &config),
            validation: validation(&vessel, &config, files.campaign)?,
            truth: vessel.value.iter().copied().collect(),
        };
        self.check_room(&study, files.campaign, out)?;
        let done = Done { study: &study, files: &files, config: &config, quiet: common.quiet };
        let mut kept = Kept::new(self, &study, out, &provenance)?;
        let tally = match self.until {
            None => done.tallied(self.mine(&study), &mut kept)?,
            Some(width) => done.until(width)?,
        };
        let runs = tally.counted.first().map_or(0, |counted| counted.runs);
        let realizations = if self.until.is_some() { runs } else { u64::from(settings.realizations) };
        let samples = [study.campaign.samples() as u64, study.validation.samples()];
        let document = TallyDocument::new(tally, bounds(&config), realizations, samples, settings.seed);
        published(out, &provenance, document, kept.finish(out, &study, &config, &provenance)?)
    }
}

impl Arguments {
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

    /// What the tally depends on besides the inputs.
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
        match self.until {
            Some(width) => noted.insert("until".into(), json!(width)),
            None => noted.insert("realizations".into(), json!(settings.realizations)),
        };
    }

    fn estimators<'a>(&self, vessel: &'a Vessel, config: &CampaignFile) -> RunEstimators<'a> {
        let mut estimators: Vec<Estimator> = Vec::new();
        for estimator in &self.estimator {
            if !estimators.contains(estimator) {
                estimators.push(*estimator);
            }
        }
        RunEstimators {
            vessel,
            estimators,
            removal: self.mean_removal,
            initial: InitialState::Known,
            levels: Some(config.levels(vessel.sample_rate_hz)),
        }
    }

    /// The runs of this shard, or all.
    fn mine(&self, study: &MonteCarlo) -> Vec<(usize, Range<usize>)> {
        let groups = study.groups();
        study.parts(self.sharding.shard.map_or(0..groups, |shard| shard.range(groups)), BLOCK)
    }

    /// Refuses what does not fit into memory or folder.
    fn check_room(&self, study: &MonteCarlo, file: &Path, out: &Path) -> Result<(), Failure> {
        let vessel = study.campaign.vessel();
        let layout = Layout::new(&vessel.model);
        let runs = if self.until.is_some() { 0.0 } else { study.campaign.runs() as f64 };
        let rows = study.campaign.samples() as f64 + 1.0;
        let each = (BLOCK * LANES) as f64;
        let at_once = 2.0 * each * rayon::current_num_threads() as f64;
        let estimators = study.estimators.estimators.len() as f64;
        let kept = if self.keep > Keep::None { 2.0 * estimates::row_bytes(vessel) * estimators } else { 0.0 };
        let trajectories = match self.keep {
            Keep::Trajectories => self.keep_first.map_or(runs, |first| f64::from(first) * 2.0).min(runs),
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

/// Refuses a half-width that no number of runs reaches, or that says nothing.
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

/// Square root of the runs that a share needs for an interval of this half-width, at most.
fn needed_for(width: f64) -> f64 {
    0.98 / width
}

fn bounds(config: &CampaignFile) -> Bounds {
    Bounds {
        parameter_error: config.validation.parameter_error_bound,
        simulation_error: config.validation.simulation_error_bound,
    }
}

/// The campaign's validation maneuvers, as `simulate validation` makes them.
fn validation<'a>(
    vessel: &'a Vessel,
    config: &CampaignFile,
    file: &Path,
) -> Result<ValidationRuns<'a>, Failure> {
    let files = Files { vessel: file, dictionary: file, campaign: file, sea: file, design: file };
    let own = generator(file, vessel, &config.validation_dictionary(), &mut Provenance::default())?;
    let maneuvers = Maneuvers::new(vessel, &own, Source::Value, "validation");
    let maneuvers = maneuvers.map_err(|e| files.refused(e))?;
    let (runs, tally) = maneuvers.simulate(0..maneuvers.count()).map_err(|e| files.refused(e))?;
    tally.check().map_err(|e| files.refused(Refusal::Campaign(e)))?;
    let runs = runs.into_iter().map(|simulated| simulated.run).collect();
    ValidationRuns::new(vessel, runs).ok_or_else(|| {
        let (expected, remedy) = ("at least one maneuver", "state what estimates are validated on");
        Failure::refuse(file, "`validation.maneuver`", "none", expected, remedy)
    })
}

/// What is done, and how it is told.
struct Done<'a> {
    study: &'a MonteCarlo<'a>,
    files: &'a Files<'a>,
    config: &'a CampaignFile,
    quiet: bool,
}

impl Done<'_> {
    fn blank(&self) -> Tally {
        Tally::new(&self.study.campaign.names(), &self.study.estimators.estimators)
    }

    fn refused(&self, error: StudyError) -> Failure {
        match error {
            StudyError::Trial(refusal) => self.files.refused(refusal),
            StudyError::Estimate(error) => Failure::of_run(&error, self.files.vessel, self.files.campaign),
            StudyError::Invalid(invalid) => Failure::invalid(self.files.campaign, &invalid),
            StudyError::Design(error) => Failure::NoAnswer(error.to_string()),
        }
    }

    /// Realizes and counts `parts`; what is kept of each goes to `kept` in their order.
    fn tallied(&self, parts: Vec<(usize, Range<usize>)>, kept: &mut Kept) -> Result<Tally, Failure> {
        let runs: usize = parts.iter().map(|(_, runs)| runs.len()).sum();
        let progress = Progress::new("runs", runs, self.quiet).foretold(self.seconds(runs));
        let mut tally = self.blank();
        self.count(parts, kept, &mut tally, &progress)?;
        Ok(tally)
    }

    fn count(
        &self,
        parts: Vec<(usize, Range<usize>)>,
        kept: &mut Kept,
        tally: &mut Tally,
        progress: &Progress,
    ) -> Result<(), Failure> {
        let (bounds, first) = (bounds(self.config), kept.first);
        let scores_alone = kept.estimates.is_none() && kept.runs.is_none();
        let work = |i: usize| {
            let (design, runs) = parts[i].clone();
            let count = runs.len();
            let realized = match scores_alone {
                true => self.study.scores(design, runs).map(Realized::scored),
                false => self.study.realize(design, runs, first),
            };
            let realized = realized.map_err(|e| self.refused(e))?;
            let mut own = self.blank();
            own.add(&realized.scores, bounds);
            progress.advance(count);
            Ok::<_, Failure>((own, realized))
        };
        ordered(0..parts.len(), work, |(own, realized)| {
            tally.merge(own);
            kept.push(realized)
        })
    }

    /// Goes on until no share's interval is wider than twice `width`; looks at fixed numbers of runs, each a tenth further.
    fn until(&self, width: f64) -> Result<Tally, Failure> {
        let (mut tally, mut done) = (self.blank(), 0);
        let designs = self.study.campaign.designs();
        let most = needed_for(width).powi(2) * designs as f64;
        let progress = Progress::new("runs", most as usize, self.quiet).foretold(self.seconds(most as usize));
        while tally.half_width() > width && done < self.study.campaign.realizations() {
            let next = (done + (done / 10).max(LANES * BLOCK)).next_multiple_of(LANES * BLOCK);
            let next = next.min(self.study.campaign.realizations());
            let starts = || (done..next).step_by(LANES * BLOCK);
            let parts = (0..designs)
                .flat_map(|d| starts().map(move |start| (d, start..next.min(start + LANES * BLOCK))))
                .collect();
            self.count(parts, &mut Kept::default(), &mut tally, &progress)?;
            done = next;
        }
        Ok(tally)
    }

    /// How long one thread takes for so many runs, to the order.
    fn seconds(&self, runs: usize) -> f64 {
        let searched =
            self.study.estimators.estimators.iter().filter(|e| !matches!(e, Estimator::Ls | Estimator::Iv));
        let each = SECONDS_PER_ROW + searched.map(|e| e.seconds_per_row()).sum::<f64>();
        runs as f64 * self.study.campaign.samples() as f64 * each
    }
}

/// Seconds that a thread takes for a row that is simulated, estimated by regression and scored, to the order.
const SECONDS_PER_ROW: f64 = 3e-8;

/// Tables that are kept, and their rows.
#[derive(Default)]
struct Kept {
    scores: Option<(TableWriter, Vec<RunScore>)>,
    estimates: Option<(TableWriter, Vec<RunEstimate>)>,
    runs: Option<(TableWriter, Layout)>,
    vessel: Option<Vessel>,
    first: usize,
}

impl Kept {
    fn new(
        asked: &Arguments,
        study: &MonteCarlo,
        out: &Path,
        provenance: &Provenance,
    ) -> Result<Self, Failure> {
        let vessel = study.campaign.vessel();
        let layout = Layout::new(&vessel.model);
        let table = |least: Keep, name: &str, schema: &artifact::TableSchema, document: Option<&str>| {
            if asked.keep < least {
                return Ok::<_, Failure>(None);
            }
            let writer = TableWriter::create(beside(out, MAIN, name), schema, provenance)?;
            Ok(Some(match document {
                Some(document) => writer.with_document(&beside(out, MAIN, document)),
                None => writer,
            }))
        };
        let columns = estimates::columns(vessel);
        let scored =
            table(Keep::Scores, "scores.parquet", scores::columns().schema(), Some("validation.json"))?;
        let estimated = table(Keep::Estimates, "estimates.parquet", columns.schema(), Some("estimate.json"))?;
        let runs = table(Keep::Trajectories, "campaign.parquet", &layout.schema(), None)?;
        let all = asked.keep_first.map_or(usize::MAX, |first| first as usize);
        Ok(Self {
            scores: scored.map(|writer| (writer, Vec::new())),
            estimates: estimated.map(|writer| (writer, Vec::new())),
            first: if runs.is_some() { all } else { 0 },
            runs: runs.map(|writer| (writer, layout)),
            vessel: Some(vessel.clone()),
        })
    }

    fn push(&mut self, realized: Realized) -> Result<(), Failure> {
        let Some(vessel) = &self.vessel else { return Ok(()) };
        if let Some((writer, rows)) = &mut self.scores {
            writer.push(scores::columns().encode(&realized.scores)?)?;
            rows.extend(realized.scores);
        }
        if let Some((writer, rows)) = &mut self.estimates {
            writer.push(estimates::columns(vessel).encode(&realized.estimates)?)?;
            rows.extend(realized.estimates);
        }
        let (Some((writer, layout)), Some(first)) = (&mut self.runs, realized.runs.first()) else {
            return Ok(());
        };
        for runs in realized.runs.chunks(rows_per_block(first.run.samples())) {
            let mut builder = BlockBuilder::new(layout, vessel.sample_rate_hz);
            runs.iter().for_each(|run| builder.push(run));
            writer.push(artifact::encode_block(&layout.schema(), &builder.table())?)?;
        }
        Ok(())
    }

    /// The files beside the tally.
    fn finish(
        self,
        out: &Path,
        study: &MonteCarlo,
        config: &CampaignFile,
        provenance: &Provenance,
    ) -> Result<Vec<Staged>, Failure> {
        let mut files = Vec::new();
        if let Some((writer, rows)) = self.estimates {
            let table = writer.finish()?;
            let document = estimates::summarize(table.path(), provenance, study.campaign.vessel(), &rows)?;
            let path = beside(out, MAIN, "estimate.json");
            files.push(stage_set_document(path, provenance, &document, std::slice::from_ref(&table))?);
            files.push(table);
        }
        if let Some((writer, rows)) = self.scores {
            let table = writer.finish()?;
            let bounds = bounds(config);
            let document = ValidationDocument {
                bounds,
                samples: study.validation.samples(),
                seed: study::seed(provenance),
                designs: scores::summarize(&rows, bounds),
                recommendations: study::recommendations(&rows),
                compared: scores::compare(&rows, bounds),
            };
            let path = beside(out, MAIN, "validation.json");
            files.push(stage_set_document(path, provenance, &document, std::slice::from_ref(&table))?);
            files.push(table);
        }
        if let Some((writer, _)) = self.runs {
            files.push(writer.finish()?);
        }
        Ok(files)
    }
}

/// Gives the tally and what is kept their names, and says what it says.
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
    let said: Vec<String> = document
        .statements
        .iter()
        .map(|statement| format!("; {}", statement.trim_end_matches('.')))
        .collect();
    let runs: u64 = own.map(runs).sum();
    Ok(Summary::of(
        out,
        format!("{runs} runs{part}{}", said.concat()),
        json!({"runs": runs, "scores": document.scores, "paired": document.paired}),
    ))
}
