//! `simulate`: trajectories from a vessel and its maneuvers.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use clap::Parser;
use files::{Provenance, Shard, Staged, Work, commit, gather, stage_set_document};
use logs::chain::{Entry, Fault, Logbook, NoLogs, force_factors};
use maneuver::Generator;
use serde_json::{Value, json};
use ship::engine::Segment;
use ship::model::{Source, Vessel};
use study::campaign_file::CampaignFile;
use study::documents::{SIMULATED_FILE, SimulatedLogsDocument};
use study::files::{generator, kept_to_data, read_any_simulated, read_campaign, read_dictionary};
use study::logs_file::LogsFile;
use study::track::read_planned;
use study::trajectories::{DataLabel, ID, VERSION};
use trial::campaign::{self, Maneuvers, Refusal, Settings};

use crate::cli::{
    Allowed, Common, Sharding, allowance, beside, budget, check_positive, folder_of, given, in_folder,
};
use crate::commands::plan::MAIN;
use crate::failure::Failure;
use crate::inputs;
use crate::simulate::{
    CampaignFlags, Files, check_campaign, check_maneuvers, note_plays, write_campaign, write_maneuvers,
};
use crate::stage::{Summary, Task};

/// Simulates a ship: single maneuvers, whole trials, plans, and what her instruments log
#[derive(Parser)]
#[command(
    name = "simulate",
    after_help = "Example:\n  simulate dictionary --vessel pipelines/paper/vessel.toml \
    --dictionary pipelines/paper/dictionary.toml --out dictionary.parquet"
)]
pub struct SimulateArguments {}

/// Simulates each maneuver of a dictionary alone, without current, wind and noise
#[derive(Parser)]
#[command(
    name = "dictionary",
    after_help = "Example:\n  simulate dictionary --vessel pipelines/paper/vessel.toml \
    --dictionary pipelines/paper/dictionary.toml --out dictionary.parquet"
)]
pub struct Dictionary {
    /// The vessel
    #[arg(long, visible_alias = "model", required_unless_present = "gather", value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
    /// The maneuvers
    #[arg(long, required_unless_present = "gather", value_name = "dictionary.toml")]
    dictionary: Option<PathBuf>,
    /// The sampling rate (default: the vessel's); terms per sample take whole multiples of theirs, or parts [Hz]
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Accepts what is refused otherwise; the outputs say so
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = allowance(&[Allowed::Mixed, Allowed::BeyondRange, Allowed::Unreached]))]
    allow: Vec<Allowed>,
    #[command(flatten)]
    sharding: Sharding,
}

/// Simulates the designed trial and random ones many times, in current, wind and noise
#[derive(Parser)]
#[command(
    name = "campaign",
    after_help = "Example:\n  simulate campaign --vessel pipelines/paper/vessel.toml \
    --dictionary pipelines/paper/dictionary.toml --campaign pipelines/paper/campaign.toml \
    --design design.json --out campaign.parquet"
)]
pub struct Campaign {
    #[command(flatten)]
    of: CampaignFlags,
    #[command(flatten)]
    sharding: Sharding,
}

/// Simulates the maneuvers that models are tested with, without current, wind and noise
#[derive(Parser)]
#[command(
    name = "validation",
    after_help = "Example:\n  simulate validation --vessel pipelines/paper/vessel.toml \
    --campaign pipelines/paper/campaign.toml --out validation.parquet"
)]
pub struct Validation {
    /// The vessel
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The validation maneuvers
    #[arg(long, value_name = "campaign.toml")]
    campaign: PathBuf,
    /// The sampling rate (default: the vessel's); terms per sample take whole multiples of theirs, or parts [Hz]
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
}

/// Simulates a planned trial many times, in current, wind and noise: the inputs of its track, without an autopilot
#[derive(Parser)]
#[command(
    name = "plan",
    after_help = "Example:\n  simulate plan --vessel pipelines/helsinki/vessel.toml \
    --campaign pipelines/helsinki/campaign.toml --plan out/helsinki/plan.json --out planned.parquet"
)]
pub struct PlanTrials {
    /// The vessel
    #[arg(long, visible_alias = "model", required_unless_present = "gather", value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
    /// Number of runs, disturbances, seed
    #[arg(long, required_unless_present = "gather", value_name = "campaign.toml")]
    campaign: Option<PathBuf>,
    /// The plan, with its track.parquet beside it
    #[arg(long, required_unless_present = "gather", value_name = "plan.json")]
    plan: Option<PathBuf>,
    #[command(flatten)]
    sharding: Sharding,
}

/// Writes what a ship's instruments would have logged in a trial: simulated logs, for `ingest`
#[derive(Parser)]
#[command(
    name = "logs",
    after_help = "Example:\n  simulate logs --vessel pipelines/model-ship/vessel.toml \
    --dictionary pipelines/model-ship/dictionary.toml --logs pipelines/model-ship/logs.toml --out logs/"
)]
pub struct Logs {
    /// The vessel
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The maneuvers
    #[arg(long, value_name = "dictionary.toml")]
    dictionary: PathBuf,
    /// Thrusters, sensors, days at sea
    #[arg(long, value_name = "logs.toml")]
    logs: PathBuf,
}

impl Task for Dictionary {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let files = [&self.vessel, &self.dictionary].into_iter().flatten();
        let out = common.main_output("dictionary.parquet", files.chain(&self.sharding.gather))?;
        if self.sharding.gathers() {
            return gathered(&self.sharding, &out);
        }
        let mut provenance = common.provenance("simulate");
        let files = (given(&self.vessel, "vessel")?, given(&self.dictionary, "dictionary")?);
        let vessel = kept_to_data(
            files.0,
            read_any_simulated(files.0, &mut provenance)?,
            self.allow.contains(&Allowed::BeyondRange),
        )?;
        check_positive("--rate", self.rate)?;
        let vessel = study::at_rate(files.0, vessel, self.rate, &mut provenance)?;
        let generator = read_dictionary(files.1, &vessel, &mut provenance)?;
        let source = vessel.best_known();
        provenance.settings.insert("model".into(), json!(source.name()));
        provenance.shard = self.sharding.shard;
        let maneuvers = Maneuvers::new(&vessel, &generator, source, "dictionary");
        undisturbed(
            maneuvers,
            files,
            &out,
            provenance,
            Some(self.allow.contains(&Allowed::Unreached)),
            common,
        )
    }
}

impl Task for Validation {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("simulate");
        let vessel = read_any_simulated(&self.vessel, &mut provenance)?;
        check_positive("--rate", self.rate)?;
        let vessel = study::at_rate(&self.vessel, vessel, self.rate, &mut provenance)?;
        let config = read_campaign(&self.campaign, &mut provenance)?;
        let maneuvers = config.validation_dictionary();
        let generator = generator(&self.campaign, &vessel, &maneuvers, &mut provenance)?;
        let out = common.main_output("validation.parquet", [&self.vessel, &self.campaign])?;
        let maneuvers = Maneuvers::new(&vessel, &generator, Source::Value, "validation");
        undisturbed(maneuvers, (&self.vessel, &self.campaign), &out, provenance, None, common)
    }
}

/// Simulates every maneuver of `dictionary` on its own. `unreached`: whether maneuvers may miss their aims; `None`
/// skips the check.
fn undisturbed(
    maneuvers: Result<Maneuvers, Refusal>,
    (vessel, dictionary): (&Path, &Path),
    out: &Path,
    mut provenance: Provenance,
    unreached: Option<bool>,
    common: &Common,
) -> Result<Summary, Failure> {
    let files = Files { vessel, ..Files::all(dictionary) };
    let maneuvers = maneuvers.map_err(|e| files.refused(e))?;
    check_maneuvers(&maneuvers, &files, out)?;
    let divided = study::note_divided(&maneuvers, &mut provenance).map_err(|e| files.refused(e))?;
    if let Some(is_allowed) = unreached {
        let reached = maneuvers.reached().map_err(|e| files.refused(e))?;
        study::note_reached(&maneuvers, &reached, is_allowed, &mut provenance)
            .map_err(|e| Failure::NoAnswer(format!("{}: {e}", dictionary.display())))?;
    }
    let tally = write_maneuvers(&maneuvers, &files, out, &provenance, common.quiet)?;
    let mut details = json!({"maneuvers": tally.maneuvers, "samples": tally.samples});
    if tally.kept > 0 {
        let left_out = tally.left_out.iter().map(|(name, about)| (name.clone(), json!(about.count)));
        details["generated"] = json!(tally.kept);
        details["left_out"] = left_out.collect::<serde_json::Map<_, _>>().into();
    }
    let said = format!("{tally}{}", shard_of(&provenance));
    let beyond = study::beyond(vessel, out, Some(maneuvers.vessel().sample_rate_hz))?;
    let statements = [divided.into_iter().collect(), maneuvers.tables(), beyond].concat();
    Ok(with(statements, out, said, details))
}

impl Task for Campaign {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let out = common.main_output("campaign.parquet", self.of.paths().chain(&self.sharding.gather))?;
        if self.sharding.gathers() {
            return gathered(&self.sharding, &out);
        }
        let mut provenance = common.provenance("simulate");
        let of = self.of.read(read_any_simulated, &mut provenance)?;
        let settings = settings(&of.config, &self.sharding, common, &mut provenance);
        let samples = settings.samples(&of.vessel).map_err(|e| of.files.refused(e))?;
        let runs = settings.runs() / f64::from(self.sharding.shard.map_or(1, |shard| shard.count));
        check_campaign(of.files.campaign, runs, samples, &of.vessel, &out)?;
        let campaign = of.campaign(&settings)?;
        note_plays(&campaign, &mut provenance);
        of.logged_helm().note(&mut provenance);
        disturbed(&campaign, &of.files, &out, &provenance, common)
    }
}

impl Task for PlanTrials {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let track = self.plan.as_deref().map(|plan| beside(plan, MAIN, "track.parquet"));
        let files = [&self.vessel, &self.campaign, &self.plan, &track].into_iter().flatten();
        let out = common.main_output("planned.parquet", files.chain(&self.sharding.gather))?;
        if self.sharding.gathers() {
            return gathered(&self.sharding, &out);
        }
        let mut provenance = common.provenance("simulate");
        let (vessel_file, plan) = (given(&self.vessel, "vessel")?, given(&self.plan, "plan")?);
        let vessel = read_any_simulated(vessel_file, &mut provenance)?;
        let config = read_campaign(given(&self.campaign, "campaign")?, &mut provenance)?;
        let track = read_planned(plan, &vessel, &mut provenance)?;
        let settings = settings(&config, &self.sharding, common, &mut provenance);
        let sea = config.sea(&vessel).map_err(|e| Failure::invalid(vessel_file, &e))?;
        let segment =
            |(start, maneuver): &(usize, String)| Segment { maneuver: maneuver.clone(), start: *start };
        let segments: Vec<Segment> = track.stretches.iter().map(segment).collect();
        let samples = track.inputs.len() / vessel.model.inputs;
        let runs = f64::from(settings.realizations);
        check_campaign(given(&self.campaign, "campaign")?, runs, samples, &vessel, &out)?;
        let campaign = campaign::Campaign::planned(sea, track.initial, &track.inputs, &segments, &settings);
        let sea = given(&self.campaign, "campaign")?;
        let files = Files { vessel: vessel_file, dictionary: plan, campaign: plan, sea, design: plan };
        disturbed(&campaign, &files, &out, &provenance, common)
    }
}

/// The settings of the campaign `config`; notes its seed and the shard.
fn settings(
    config: &CampaignFile,
    sharding: &Sharding,
    common: &Common,
    provenance: &mut Provenance,
) -> Settings {
    let settings = config.settings(common.seed);
    provenance.settings.insert("seed".into(), json!(settings.seed));
    provenance.shard = sharding.shard;
    settings
}

fn gathered(sharding: &Sharding, out: &Path) -> Result<Summary, Failure> {
    commit(vec![gather(&sharding.gather, out, None, ID, VERSION)?])?;
    let shards = sharding.gather.len();
    Ok(Summary::of(out, format!("gathered {shards} shards"), json!({"shards": shards})))
}

/// The summary of the output, with statements.
fn with(statements: Vec<String>, out: &Path, said: impl Display, mut details: Value) -> Summary {
    if statements.is_empty() {
        return Summary::of(out, said, details);
    }
    details["statements"] = json!(statements);
    Summary::of(out, format!("{said}; {}", statements.join("; ")), details)
}

fn disturbed(
    campaign: &campaign::Campaign,
    files: &Files,
    out: &Path,
    provenance: &Provenance,
    common: &Common,
) -> Result<Summary, Failure> {
    let runs = write_campaign(campaign, files, out, provenance, common.quiet)?;
    let samples = campaign.samples();
    let details = json!({"runs": runs, "samples": samples});
    let said = format!("{runs} runs of {samples} samples{}", shard_of(provenance));
    let statements = [campaign.statements().to_vec(), study::beyond(files.vessel, out, None)?].concat();
    Ok(with(statements, out, said, details))
}

/// The shard, for the summary.
fn shard_of(provenance: &Provenance) -> String {
    provenance.shard.map_or(String::new(), |shard: Shard| format!(", shard {shard}"))
}

impl Task for Logs {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("simulate");
        let vessel = read_any_simulated(&self.vessel, &mut provenance)?;
        let generator = read_dictionary(&self.dictionary, &vessel, &mut provenance)?;
        let config: LogsFile = inputs::toml(&self.logs, "logs", &mut provenance)?;
        let seed = common.seed.unwrap_or(config.seed);
        provenance.settings.insert("seed".into(), json!(seed));
        DataLabel::SimulatedLogs.label(&mut provenance);
        let out =
            common.output_in_any_folder(SIMULATED_FILE, [&self.vessel, &self.dictionary, &self.logs])?;
        let entries = simulate(self, &vessel, &generator, &config, seed)?;
        let document = SimulatedLogsDocument::of(&vessel, &config, &entries);
        publish(&out, &entries, &document, &provenance)?;
        let (recordings, samples) = (entries.len(), config.samples);
        let maneuvers = recordings / config.repeats as usize;
        let said: String = document.statements.iter().map(|statement| format!("; {statement}")).collect();
        Ok(Summary::of(
            &out,
            format!("{recordings} simulated logs of {maneuvers} maneuvers, {samples} samples each{said}"),
            json!({"recordings": recordings, "maneuvers": maneuvers, "samples": samples,
                "statements": document.statements}),
        ))
    }
}

/// Simulates the logs of `config`, which is one of `files`.
fn simulate(
    files: &Logs,
    vessel: &Vessel,
    generator: &Generator,
    config: &LogsFile,
    seed: u64,
) -> Result<Vec<Entry>, Failure> {
    let names: Vec<&str> = generator.maneuvers().iter().map(|m| m.name.as_str()).collect();
    config.check(&names, vessel.sample_rate_hz).map_err(|e| Failure::invalid(&files.logs, &e))?;
    check_room(&files.logs, config, &names, vessel.sample_rate_hz)?;
    let parameters = vessel.parameters(Source::Value).map_err(|e| Failure::invalid(&files.vessel, &e))?;
    let entries = || {
        let chain = config.chain(vessel, &parameters, force_factors(vessel)?);
        Logbook::new(chain, generator, config.schedule(), seed)?.entries()
    };
    entries().map_err(|NoLogs { fault, what }| {
        let file = match fault {
            Fault::Vessel => &files.vessel,
            Fault::Maneuvers => &files.dictionary,
            Fault::Thrusters => &files.logs,
        };
        Failure::invalid(file, &what)
    })
}

/// Refuses logs that do not fit into memory, where all are held until they are written.
fn check_room(file: &Path, config: &LogsFile, maneuvers: &[&str], rate_hz: f64) -> Result<(), Failure> {
    /// Characters of a cell with its separator.
    const CELL: f64 = 14.0;
    let rows = config.rows(maneuvers, rate_hz);
    let cells = rows * (4 + 2 * config.thruster.len()) as f64;
    let (size, remedy) = (format!("logs of {rows} rows"), "take fewer `repeats` or `samples`");
    Ok(budget().memory(Work { file, thing: "`repeats`", found: &size, remedy }, CELL * cells)?)
}

/// Writes the logs and `out` next to them: all or nothing.
fn publish(
    out: &Path,
    entries: &[Entry],
    document: &SimulatedLogsDocument,
    provenance: &Provenance,
) -> Result<(), Failure> {
    in_folder(folder_of(out), || {
        let mut files = Vec::with_capacity(entries.len() + 1);
        for (entry, recording) in entries.iter().zip(&document.recordings) {
            files.push(Staged::bytes(folder_of(out).join(&recording.file), entry.text.as_bytes())?);
        }
        files.push(stage_set_document(out, provenance, document, &files)?);
        Ok(commit(files)?)
    })
}
