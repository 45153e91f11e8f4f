//! `design`: how long to run each maneuver.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use artifact::{Provenance, commit, read_document, stage_document};
use clap::Parser;
use optimal_design::{Bounds, CountOptions, Options};
use serde_json::json;
use stages::cli::{Common, Summary, name_of, provenance, run};
use stages::design::{
    Available, Criterion, CriterionName, Experiment, Relative, Segments, Solved, counted, document,
    information, no_design, weights,
};
use stages::documents::{DesignDocument, MomentsDocument};
use stages::failure::Failure;
use stages::instruments::Removal;

/// Finds the shares of the experiment time that make the information largest (D-optimal), or a criterion of the estimate's
/// covariance smallest, with a certificate
#[derive(Parser)]
#[command(
    name = "design",
    version,
    after_help = "Example:\n  design --moments moments.json --out design.json\n  \
    design --moments moments.json --segments 5 --segment-samples 200 --out design.json\n  \
    design --moments moments.json --criterion a-relative --relative-to value --out design.json"
)]
struct Arguments {
    /// The maneuvers' moments
    #[arg(long, value_name = "moments.json")]
    moments: PathBuf,
    /// How the estimator will remove the instruments' mean
    #[arg(long, value_enum, default_value_t = Removal::Complete)]
    mean_removal: Removal,
    /// What the shares are best for; all but d-hessian need moments made with --campaign
    #[arg(long, value_enum, default_value_t = CriterionName::DHessian)]
    criterion: CriterionName,
    /// Which parameters the errors of a-relative are relative to
    #[arg(long, value_enum, default_value_t = Relative::Nominal)]
    relative_to: Relative,
    /// Weights of the parameters' variances for a, a-relative and e: a table `[weight]`; parameters not named count nothing
    #[arg(long, value_name = "weights.toml")]
    weights: Option<PathBuf>,
    /// How much of each maneuver exists: tables `seconds` and `segments` by maneuver, or what `ingest` cut
    #[arg(long, value_name = "available.toml|ingest.json")]
    available: Option<PathBuf>,
    /// Length of the experiment, where --segments does not tell it [s]
    #[arg(long, value_name = "S", conflicts_with = "segments")]
    duration_s: Option<f64>,
    /// Random starts besides equal shares
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(0..=1000))]
    starts: u32,
    /// Stop at this gap, relative to the dimension
    #[arg(long, value_name = "GAP", default_value_t = 1e-10)]
    tolerance: f64,
    /// Find the best counts of this many whole segments
    #[arg(long, value_name = "N", requires = "segment_samples", value_parser = clap::value_parser!(u64).range(1..))]
    segments: Option<u64>,
    /// Samples per segment
    #[arg(long, value_name = "N", requires = "segments", value_parser = clap::value_parser!(u64).range(1..))]
    segment_samples: Option<u64>,
    #[command(flatten)]
    common: Common,
}

fn main() -> ExitCode {
    run(|a: &Arguments| &a.common, stage)
}

fn stage(a: &Arguments) -> Result<Summary, Failure> {
    check_number("--tolerance", Some(a.tolerance))?;
    check_number("--duration-s", a.duration_s)?;
    let loaded = read_document::<MomentsDocument>(&a.moments)?;
    let moments = loaded.data;
    let mut provenance = provenance("design");
    provenance.inputs.insert("moments".into(), loaded.digest);
    // Moments of simulated logs say so, and so does the design.
    provenance
        .settings
        .extend(loaded.provenance.settings.get_key_value("data").map(|(k, v)| (k.clone(), v.clone())));
    let document = design(a, &moments, &mut provenance)?;
    settings(a, &mut provenance);
    let inputs = [Some(&a.moments), a.weights.as_ref(), a.available.as_ref()];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
    let out = a.common.main_output("design.json", &inputs)?;
    commit(vec![stage_document(&out, &provenance, &document)?])?;
    Ok(summary(&out, &document))
}

fn check_number(flag: &str, value: Option<f64>) -> Result<(), Failure> {
    match value.filter(|value| !(value.is_finite() && *value > 0.0)) {
        Some(value) => {
            Err(Failure::Usage(format!("{flag}: found {value}, expected a number above 0; correct it")))
        }
        None => Ok(()),
    }
}

/// The design of `moments`: candidates, what is available, criterion, shares, counts.
fn design(
    a: &Arguments,
    moments: &MomentsDocument,
    provenance: &mut Provenance,
) -> Result<DesignDocument, Failure> {
    let refuse = |e| no_design(&a.moments, moments, e);
    let information = information(&a.moments, moments, a.mean_removal)?;
    let experiment = experiment(a, moments);
    let available = match &a.available {
        Some(path) => Some(Available::read(path, moments, &experiment, provenance)?),
        None => None,
    };
    let weights = weights(a.criterion, a.relative_to, a.weights.as_deref(), &a.moments, moments, provenance)?;
    let criterion =
        Criterion::new(a.criterion, &a.moments, moments, information.clone(), a.mean_removal, weights)?;
    let bounds = match &available {
        Some(available) => Bounds::new(&available.shares).map_err(refuse)?,
        None => Bounds::default(),
    };
    let options =
        Options { tolerance: a.tolerance, random_starts: a.starts, seed: seed(a), ..Options::default() };
    let design = criterion.solve(&bounds, &options).map_err(refuse)?;
    let segments = experiment.segments.map(|(total, samples)| Segments {
        total,
        samples,
        limits: available.as_ref().and_then(|available| available.counts.clone()),
    });
    let parameters = moments.degrees.iter().map(|d| d.parameters.len()).sum();
    let count_options = CountOptions { random_starts: a.starts, seed: seed(a), ..CountOptions::default() };
    let count = |segments| counted(&criterion, &design, segments, &count_options, parameters);
    Ok(document(Solved {
        moments,
        information: &information,
        name: a.criterion,
        criterion: &criterion,
        removal: a.mean_removal,
        design: &design,
        available: available.as_ref(),
        counted: segments.as_ref().map(count).transpose().map_err(refuse)?,
        samples: experiment.samples,
    }))
}

fn experiment(a: &Arguments, moments: &MomentsDocument) -> Experiment {
    let segments = a.segments.zip(a.segment_samples);
    let counted = segments.map(|(n, samples)| n as f64 * samples as f64);
    Experiment { samples: a.duration_s.map(|s| s * moments.sample_rate_hz).or(counted), segments }
}

fn seed(a: &Arguments) -> u64 {
    a.common.seed.unwrap_or(1)
}

/// What the result depends on besides the inputs; a criterion only where it is not the default.
fn settings(a: &Arguments, provenance: &mut Provenance) {
    let settings = &mut provenance.settings;
    settings.insert("seed".into(), json!(seed(a)));
    settings.insert("starts".into(), json!(a.starts));
    settings.insert("tolerance".into(), json!(a.tolerance));
    if a.criterion != CriterionName::DHessian {
        settings.insert("criterion".into(), json!(name_of(a.criterion)));
    }
    if a.criterion == CriterionName::ARelative && a.weights.is_none() {
        settings.insert("relative_to".into(), json!(name_of(a.relative_to)));
    }
    if let Some(duration) = a.duration_s {
        settings.insert("duration_s".into(), json!(duration));
    }
}

fn summary(out: &Path, document: &DesignDocument) -> Summary {
    let used = document.shares.values().filter(|w| **w > 0.0).count();
    Summary {
        line: format!(
            "{}: {} of {} maneuvers, {}, relative gap {:.1e}",
            out.display(),
            used,
            document.shares.len(),
            document.status,
            document.relative_gap
        ),
        json: json!({"out": out, "status": document.status, "relative_gap": document.relative_gap, "used": used}),
    }
}
