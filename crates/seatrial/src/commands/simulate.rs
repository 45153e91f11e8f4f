//! `simulate`: trajectories from a vessel and its maneuvers.

use std::path::{Path, PathBuf};

use crate::cli::{Common, Sharding, beside, given, provenance};
use crate::failure::Failure;
use crate::simulate::{Files, logs, write_campaign, write_maneuvers};
use crate::stage::{Summary, Task};
use artifact::{Provenance, Shard, commit, gather, read_document, read_toml};
use clap::{Args, Parser, Subcommand};
use serde_json::json;
use study::documents::{DesignDocument, SIMULATED_FILE, SimulatedLogsDocument};
use study::files::{generator, read_campaign, read_dictionary, read_vessel};
use study::logs_file::LogsFile;
use study::track::read_planned;
use study::trajectories::{DataLabel, ID, VERSION};
use trial::campaign::{Campaign, Maneuvers, Tally};
use vessel::{Segment, Source};

/// Simulates a vessel's trajectories
#[derive(Parser)]
#[command(
    name = "simulate",
    version,
    after_help = "Example:\n  simulate dictionary --vessel pipelines/paper/vessel.toml \
    --dictionary pipelines/paper/dictionary.toml --out dictionary.parquet"
)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Every maneuver of a dictionary on its own, undisturbed
    #[command(after_help = "Example:\n  simulate dictionary --vessel pipelines/paper/vessel.toml \
        --dictionary pipelines/paper/dictionary.toml --out dictionary.parquet")]
    Dictionary(Dictionary),
    /// Disturbed runs of the optimized and the random design
    #[command(after_help = "Example:\n  simulate campaign --vessel pipelines/paper/vessel.toml \
        --dictionary pipelines/paper/dictionary.toml --campaign pipelines/paper/campaign.toml \
        --design design.json --out campaign.parquet")]
    Campaign(CampaignArguments),
    /// The campaign's validation maneuvers, undisturbed
    #[command(after_help = "Example:\n  simulate validation --vessel pipelines/paper/vessel.toml \
        --campaign pipelines/paper/campaign.toml --out validation.parquet")]
    Validation(Validation),
    /// Disturbed runs of a planned trajectory
    #[command(after_help = "Example:\n  simulate plan --vessel pipelines/helsinki/vessel.toml \
        --campaign pipelines/helsinki/campaign.toml --plan out/helsinki/plan.json --out planned.parquet")]
    Plan(PlanArguments),
    /// What a ship's instruments would have logged in a trial: simulated logs, for `ingest`
    #[command(after_help = "Example:\n  simulate logs --vessel pipelines/model-ship/vessel.toml \
        --dictionary pipelines/model-ship/dictionary.toml --logs pipelines/model-ship/logs.toml --out logs/")]
    Logs(LogsArguments),
}

#[derive(Args)]
struct Dictionary {
    /// The vessel
    #[arg(long, value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The maneuvers
    #[arg(long, value_name = "dictionary.toml")]
    dictionary: PathBuf,
    #[command(flatten)]
    common: Common,
}

#[derive(Args)]
struct CampaignArguments {
    /// The vessel
    #[arg(long, required_unless_present = "gather", value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
    /// The maneuvers
    #[arg(long, required_unless_present = "gather", value_name = "dictionary.toml")]
    dictionary: Option<PathBuf>,
    /// Runs, disturbances, seed
    #[arg(long, required_unless_present = "gather", value_name = "campaign.toml")]
    campaign: Option<PathBuf>,
    /// The optimized shares
    #[arg(long, required_unless_present = "gather", value_name = "design.json")]
    design: Option<PathBuf>,
    #[command(flatten)]
    sharding: Sharding,
    #[command(flatten)]
    common: Common,
}

#[derive(Args)]
struct Validation {
    /// The vessel
    #[arg(long, value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The validation maneuvers
    #[arg(long, value_name = "campaign.toml")]
    campaign: PathBuf,
    #[command(flatten)]
    common: Common,
}

#[derive(Args)]
struct PlanArguments {
    /// The vessel
    #[arg(long, required_unless_present = "gather", value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
    /// Number of runs, disturbances, seed
    #[arg(long, required_unless_present = "gather", value_name = "campaign.toml")]
    campaign: Option<PathBuf>,
    /// The plan, with its track.parquet beside it
    #[arg(long, required_unless_present = "gather", value_name = "plan.json")]
    plan: Option<PathBuf>,
    #[command(flatten)]
    sharding: Sharding,
    #[command(flatten)]
    common: Common,
}

#[derive(Args)]
struct LogsArguments {
    /// The vessel
    #[arg(long, value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The maneuvers
    #[arg(long, value_name = "dictionary.toml")]
    dictionary: PathBuf,
    /// Thrusters, sensors, days at sea
    #[arg(long, value_name = "logs.toml")]
    logs: PathBuf,
    #[command(flatten)]
    common: Common,
}

impl Task for Arguments {
    fn common(&self) -> &Common {
        match &self.what {
            What::Dictionary(a) => &a.common,
            What::Campaign(a) => &a.common,
            What::Validation(a) => &a.common,
            What::Plan(a) => &a.common,
            What::Logs(a) => &a.common,
        }
    }

    fn run(&self) -> Result<Summary, Failure> {
        match &self.what {
            What::Dictionary(a) => dictionary(a),
            What::Campaign(a) => campaign(a),
            What::Validation(a) => validation(a),
            What::Plan(a) => plan(a),
            What::Logs(a) => logs(a),
        }
    }
}

fn dictionary(a: &Dictionary) -> Result<Summary, Failure> {
    let mut provenance = provenance("simulate");
    let vessel = read_vessel(&a.vessel, &mut provenance)?;
    let generator = read_dictionary(&a.dictionary, &vessel, &mut provenance)?;
    let source = vessel.best_known();
    provenance.settings.insert("model".into(), json!(source.name()));
    let out = a.common.main_output("dictionary.parquet", &[&a.vessel, &a.dictionary])?;
    let files = undisturbed(&a.vessel, &a.dictionary);
    let maneuvers =
        Maneuvers::new(&vessel, &generator, source, "dictionary").map_err(|e| files.refused(e))?;
    let tally = write_maneuvers(&maneuvers, &files, &out, &provenance, a.common.quiet)?;
    Ok(told(&out, &tally))
}

/// The files of undisturbed maneuvers: `dictionary` alone says what is simulated.
fn undisturbed<'a>(vessel: &'a Path, dictionary: &'a Path) -> Files<'a> {
    Files { vessel, dictionary, campaign: dictionary, design: dictionary }
}

fn told(out: &Path, tally: &Tally) -> Summary {
    let mut summary = json!({"out": out, "maneuvers": tally.maneuvers, "samples": tally.samples});
    if tally.kept > 0 {
        let left_out = tally.left_out.iter().map(|(name, about)| (name.clone(), json!(about.count)));
        summary["generated"] = json!(tally.kept);
        summary["left_out"] = left_out.collect::<serde_json::Map<_, _>>().into();
    }
    Summary { line: format!("{}: {tally}", out.display()), json: summary }
}

fn campaign(a: &CampaignArguments) -> Result<Summary, Failure> {
    let own = [&a.vessel, &a.dictionary, &a.campaign, &a.design];
    let inputs: Vec<&Path> =
        own.into_iter().flatten().chain(&a.sharding.gather).map(PathBuf::as_path).collect();
    let out = a.common.main_output("campaign.parquet", &inputs)?;
    if a.sharding.gathers() {
        return gathered(&a.sharding, &out);
    }
    let mut provenance = provenance("simulate");
    let files = Files {
        vessel: given(&a.vessel, "vessel")?,
        dictionary: given(&a.dictionary, "dictionary")?,
        campaign: given(&a.campaign, "campaign")?,
        design: given(&a.design, "design")?,
    };
    let vessel = read_vessel(files.vessel, &mut provenance)?;
    let generator = read_dictionary(files.dictionary, &vessel, &mut provenance)?;
    let config = read_campaign(files.campaign, &mut provenance)?;
    let design = read_document::<DesignDocument>(files.design)?;
    provenance.inputs.insert("design".into(), design.digest);
    let settings = config.settings(a.common.seed);
    provenance.settings.insert("seed".into(), json!(settings.seed));
    provenance.shard.clone_from(&a.sharding.shard);
    let sea = config.sea(&vessel).map_err(|e| Failure::invalid(files.vessel, &e))?;
    let campaign =
        Campaign::new(sea, &generator, &design.data.designed(), &settings).map_err(|e| files.refused(e))?;
    written(&campaign, &files, &out, &provenance, &a.common)
}

fn plan(a: &PlanArguments) -> Result<Summary, Failure> {
    let track = a.plan.as_deref().map(|plan| beside(plan, "track.parquet"));
    let own = [&a.vessel, &a.campaign, &a.plan, &track];
    let inputs: Vec<&Path> =
        own.into_iter().flatten().chain(&a.sharding.gather).map(PathBuf::as_path).collect();
    let out = a.common.main_output("planned.parquet", &inputs)?;
    if a.sharding.gathers() {
        return gathered(&a.sharding, &out);
    }
    let mut provenance = provenance("simulate");
    let (vessel_file, plan) = (given(&a.vessel, "vessel")?, given(&a.plan, "plan")?);
    let vessel = read_vessel(vessel_file, &mut provenance)?;
    let config = read_campaign(given(&a.campaign, "campaign")?, &mut provenance)?;
    let track = read_planned(plan, &vessel, &mut provenance)?;
    let settings = config.settings(a.common.seed);
    provenance.settings.insert("seed".into(), json!(settings.seed));
    provenance.shard.clone_from(&a.sharding.shard);
    let sea = config.sea(&vessel).map_err(|e| Failure::invalid(vessel_file, &e))?;
    let segment = |(start, maneuver): &(usize, String)| Segment { maneuver: maneuver.clone(), start: *start };
    let segments: Vec<Segment> = track.stretches.iter().map(segment).collect();
    let campaign = Campaign::planned(sea, track.initial, &track.inputs, &segments, &settings);
    let files = Files { vessel: vessel_file, dictionary: plan, campaign: plan, design: plan };
    written(&campaign, &files, &out, &provenance, &a.common)
}

fn gathered(sharding: &Sharding, out: &Path) -> Result<Summary, Failure> {
    commit(vec![gather(&sharding.gather, out, ID, VERSION)?])?;
    let shards = sharding.gather.len();
    Ok(Summary {
        line: format!("{}: gathered {shards} shards", out.display()),
        json: json!({"out": out, "shards": shards}),
    })
}

fn written(
    campaign: &Campaign,
    files: &Files,
    out: &Path,
    provenance: &Provenance,
    common: &Common,
) -> Result<Summary, Failure> {
    write_campaign(campaign, files, out, provenance, common.quiet)?;
    let part = provenance.shard.map_or(String::new(), |s: Shard| format!(", shard {s}"));
    Ok(Summary {
        line: format!("{}: {} runs of {} samples{part}", out.display(), campaign.runs(), campaign.samples()),
        json: json!({"out": out, "runs": campaign.runs(), "samples": campaign.samples()}),
    })
}

fn logs(a: &LogsArguments) -> Result<Summary, Failure> {
    let mut provenance = provenance("simulate");
    let vessel = read_vessel(&a.vessel, &mut provenance)?;
    let generator = read_dictionary(&a.dictionary, &vessel, &mut provenance)?;
    let (config, digest) = read_toml::<LogsFile>(&a.logs)?;
    provenance.inputs.insert("logs".into(), digest);
    let seed = a.common.seed.unwrap_or(config.seed);
    provenance.settings.insert("seed".into(), json!(seed));
    DataLabel::SimulatedLogs.label(&mut provenance);
    let out = a.common.main_output(SIMULATED_FILE, &[&a.vessel, &a.dictionary, &a.logs])?;
    let files = logs::Files { vessel: &a.vessel, dictionary: &a.dictionary, logs: &a.logs };
    let entries = logs::simulate(&files, &vessel, &generator, &config, seed)?;
    let document = SimulatedLogsDocument::of(&vessel, &config, &entries);
    logs::publish(&out, &entries, &document, &provenance)?;
    let recordings = entries.len();
    let maneuvers = recordings / config.repeats as usize;
    let told: String = document.statements.iter().map(|statement| format!("; {statement}")).collect();
    Ok(Summary {
        line: format!(
            "{}: {recordings} simulated logs of {maneuvers} maneuvers, {} samples each{told}",
            out.display(),
            config.samples
        ),
        json: json!({
            "out": out, "recordings": recordings, "maneuvers": maneuvers, "samples": config.samples,
            "statements": document.statements,
        }),
    })
}

fn validation(a: &Validation) -> Result<Summary, Failure> {
    let mut provenance = provenance("simulate");
    let vessel = read_vessel(&a.vessel, &mut provenance)?;
    let config = read_campaign(&a.campaign, &mut provenance)?;
    let generator = generator(&a.campaign, &vessel, &config.validation_dictionary(), &mut provenance)?;
    let out = a.common.main_output("validation.parquet", &[&a.vessel, &a.campaign])?;
    let files = undisturbed(&a.vessel, &a.campaign);
    let maneuvers =
        Maneuvers::new(&vessel, &generator, Source::Value, "validation").map_err(|e| files.refused(e))?;
    let tally = write_maneuvers(&maneuvers, &files, &out, &provenance, a.common.quiet)?;
    Ok(told(&out, &tally))
}
