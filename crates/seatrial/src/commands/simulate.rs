//! `simulate`: trajectories from a vessel and its maneuvers.

use std::path::{Path, PathBuf};

use crate::cli::{Common, Sharding, beside, given, provenance};
use crate::failure::Failure;
use crate::simulate::campaign::{Campaign, CampaignFiles};
use crate::simulate::logs::{Files, publish, simulate};
use crate::simulate::undisturbed::{Undisturbed, Written};
use crate::stage::{Summary, Task};
use artifact::{Provenance, Shard, commit, gather, read_document, read_toml};
use clap::{Args, Parser, Subcommand, ValueEnum};
use serde_json::json;
use study::documents::{DesignDocument, SIMULATED_FILE, SimulatedLogsDocument};
use study::files::{generator, read_campaign, read_dictionary, read_vessel};
use study::logs_file::LogsFile;
use study::track::read_planned;
use study::trajectories::{DataLabel, ID, VERSION};
use vessel::{Source, Vessel};

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
    /// Which parameters move the vessel (default: the true ones where the vessel has them)
    #[arg(long, value_enum)]
    model: Option<ModelChoice>,
    #[command(flatten)]
    common: Common,
}

#[derive(Clone, Copy, ValueEnum)]
enum ModelChoice {
    /// The true parameters
    Value,
    /// The nominal parameters
    Nominal,
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
    let source = match a.model {
        Some(ModelChoice::Value) => Source::Value,
        Some(ModelChoice::Nominal) => Source::Nominal,
        None => best_known(&vessel),
    };
    provenance
        .settings
        .insert("model".into(), json!(if source == Source::Value { "value" } else { "nominal" }));
    let out = a.common.main_output("dictionary.parquet", &[&a.vessel, &a.dictionary])?;
    let work = Undisturbed {
        vessel: &vessel,
        vessel_file: &a.vessel,
        dictionary_file: &a.dictionary,
        generator: &generator,
        source,
        design: "dictionary",
    };
    let written = work.write(&out, &provenance, a.common.quiet)?;
    Ok(told(&out, &written))
}

fn told(out: &Path, written: &Written) -> Summary {
    let Written { maneuvers, samples, .. } = written;
    let mut summary = json!({"out": out, "maneuvers": maneuvers, "samples": samples});
    if written.kept > 0 {
        let left_out = written.left_out.iter().map(|(name, about)| (name.clone(), json!(about.count)));
        summary["generated"] = json!(written.kept);
        summary["left_out"] = left_out.collect::<serde_json::Map<_, _>>().into();
    }
    let line = format!("{}: {maneuvers} maneuvers, {samples} samples{}", out.display(), written.told());
    Summary { line, json: summary }
}

fn best_known(vessel: &Vessel) -> Source {
    if vessel.value.iter().all(Option::is_some) { Source::Value } else { Source::Nominal }
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
    let files = CampaignFiles {
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
    let seed = a.common.seed.unwrap_or(config.seed);
    provenance.settings.insert("seed".into(), json!(seed));
    provenance.shard.clone_from(&a.sharding.shard);
    let campaign = Campaign::new(&files, &vessel, &generator, &config, &design.data, seed)?;
    written(&campaign, &out, &provenance, &a.sharding, &a.common)
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
    let seed = a.common.seed.unwrap_or(config.seed);
    provenance.settings.insert("seed".into(), json!(seed));
    provenance.shard.clone_from(&a.sharding.shard);
    let campaign = Campaign::planned(vessel_file, &vessel, &track, &config, seed)?;
    written(&campaign, &out, &provenance, &a.sharding, &a.common)
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
    out: &Path,
    provenance: &Provenance,
    sharding: &Sharding,
    common: &Common,
) -> Result<Summary, Failure> {
    campaign.write(out, provenance, sharding.shard, common.quiet)?;
    let part = sharding.shard.map_or(String::new(), |s: Shard| format!(", shard {s}"));
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
    let files = Files { vessel: &a.vessel, dictionary: &a.dictionary, logs: &a.logs };
    let entries = simulate(&files, &vessel, &generator, &config, seed)?;
    let document = SimulatedLogsDocument::of(&vessel, &config, &entries);
    publish(&out, &entries, &document, &provenance)?;
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
    let work = Undisturbed {
        vessel: &vessel,
        vessel_file: &a.vessel,
        dictionary_file: &a.campaign,
        generator: &generator,
        source: Source::Value,
        design: "validation",
    };
    let written = work.write(&out, &provenance, a.common.quiet)?;
    Ok(told(&out, &written))
}
