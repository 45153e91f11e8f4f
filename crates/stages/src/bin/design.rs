//! `design`: how long to run each maneuver.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use artifact::{Provenance, commit, read_document, stage_document};
use clap::{Parser, ValueEnum};
use optimal_design::{Bounds, CountOptions, Design, Options};
use serde_json::json;
use stages::cli::{Common, Summary, given, name_of, provenance, run, run_from};
use stages::design::refine::{Refine, refine};
use stages::design::{
    Asked, Available, Criterion, CriterionName, Estimated, Experiment, Few, OverModels, Predicted, Question,
    Relative, Segments, Sequencing, Solved, Wanted, counted, document, information, no_design, restricted,
    squares, weights,
};
use stages::documents::{DesignDocument, MomentsDocument, Sequence};
use stages::failure::Failure;
use stages::instruments::Removal;
use stages::study_files::{read_dictionary, read_vessel};

/// Finds the shares of the experiment time that make the information largest (D-optimal), or a criterion of the estimate's
/// covariance smallest, with a certificate
#[derive(Parser)]
#[command(
    name = "design",
    version,
    after_help = "Example:\n  design --moments moments.json --out design.json\n  \
    design --moments moments.json --segments 5 --segment-samples 200 --out design.json\n  \
    design --moments moments.json --criterion a-relative --relative-to value --out design.json\n\n\
    The input signals themselves, from a design as a start: design refine --help"
)]
struct Arguments {
    /// The maneuvers' moments
    #[arg(long, value_name = "moments.json")]
    moments: PathBuf,
    /// How the estimator will remove the instruments' mean
    #[arg(long, value_enum, default_value_t = Removal::Complete)]
    mean_removal: Removal,
    /// What the shares are best for; all but d-hessian need moments made with --campaign (default: d-hessian; d for
    /// output-error; a-relative with --accuracy)
    #[arg(long, value_enum)]
    criterion: Option<CriterionName>,
    /// The estimator whose covariance the criterion is of; output-error needs moments made with --estimator output-error
    #[arg(long = "for", value_enum, default_value_t = Predicted::Iv)]
    estimator: Predicted,
    /// What disturbs an output-error estimate: measurement errors and the current, or measurement errors alone (then the problem
    /// is convex, and the certificate one of the global optimum)
    #[arg(long, value_enum, default_value_t = OutputNoise::All)]
    noise: OutputNoise,
    /// Moments of the same maneuvers with other models, to be robust against
    #[arg(long, value_name = "moments.json", num_args = 1..)]
    also: Vec<PathBuf>,
    /// How the criteria of several models become one
    #[arg(long, value_enum, default_value_t = OverModels::Mean)]
    over: OverModels,
    /// Use at most so many maneuvers
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(1..))]
    most_maneuvers: Option<u64>,
    /// Use a maneuver for at least so long or not at all; needs the length of the experiment [s]
    #[arg(long, value_name = "S")]
    minimal_s: Option<f64>,
    /// Find the shortest experiment of this standard error, relative to the parameters (--relative-to)
    #[arg(long, value_name = "SHARE", conflicts_with_all = ["segments", "duration_s"])]
    accuracy: Option<f64>,
    /// The accuracy is that of every parameter, not of all together (the root of the sum of squares)
    #[arg(long, requires = "accuracy")]
    per_parameter: bool,
    /// The longest experiment for --accuracy [s]
    #[arg(long, value_name = "S", default_value_t = 86_400.0)]
    longest_s: f64,
    /// Segments of the random designs that --accuracy compares with
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    random_segments: u32,
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
    /// Find order and lengths of the maneuvers with the state carried over from one to the next; needs --vessel, --dictionary
    /// and the length of the experiment
    #[arg(long, requires = "vessel", requires = "dictionary")]
    arrange: bool,
    /// The vessel, for --arrange
    #[arg(long, value_name = "vessel.toml", requires = "arrange")]
    vessel: Option<PathBuf>,
    /// The maneuvers, for --arrange
    #[arg(long, value_name = "dictionary.toml", requires = "arrange")]
    dictionary: Option<PathBuf>,
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
    // Beside the flags, which stay as they are: a program of its own.
    if std::env::args_os().nth(1).is_some_and(|word| word == "refine") {
        return run_from(std::env::args_os().skip(1), |a: &Refine| &a.common, refine);
    }
    run(|a: &Arguments| &a.common, stage)
}

fn stage(a: &Arguments) -> Result<Summary, Failure> {
    check_number("--tolerance", Some(a.tolerance))?;
    check_number("--duration-s", a.duration_s)?;
    check_number("--minimal-s", a.minimal_s)?;
    check_number("--accuracy", a.accuracy)?;
    check_number("--longest-s", Some(a.longest_s))?;
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
    let inputs: Vec<&Path> = inputs.into_iter().flatten().chain(&a.also).map(PathBuf::as_path).collect();
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

/// What disturbs an output-error estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OutputNoise {
    /// Measurement errors and the current
    All,
    /// Measurement errors alone
    Measurement,
}

/// The criterion's name, the one that is asked for or the usual one.
fn criterion_name(a: &Arguments) -> Result<CriterionName, Failure> {
    let usage = |found: &str, expected: &str| {
        Err(Failure::Usage(format!("--criterion: found {found}, expected {expected}; take another")))
    };
    match (a.criterion, a.estimator) {
        (Some(CriterionName::DHessian), Predicted::OutputError) => {
            usage("d-hessian for output-error, which has no instruments", "d, a, a-relative, e or v")
        }
        (Some(CriterionName::V), Predicted::Iv) => usage("v for iv", "v with --for output-error"),
        (Some(CriterionName::DHessian), _) if !a.also.is_empty() => {
            usage("d-hessian with --also", "a criterion of the covariance")
        }
        (Some(name), _) => Ok(name),
        (None, _) if a.accuracy.is_some() => Ok(CriterionName::ARelative),
        (None, Predicted::OutputError) => Ok(CriterionName::D),
        (None, Predicted::Iv) if !a.also.is_empty() => Ok(CriterionName::D),
        (None, Predicted::Iv) => Ok(CriterionName::DHessian),
    }
}

fn estimated(a: &Arguments) -> Estimated {
    match a.estimator {
        Predicted::Iv => Estimated::Iv(a.mean_removal),
        Predicted::OutputError => Estimated::OutputError { current: a.noise == OutputNoise::All },
    }
}

/// Moments with other models.
fn also(a: &Arguments, provenance: &mut Provenance) -> Result<Vec<(PathBuf, MomentsDocument)>, Failure> {
    let mut out = Vec::new();
    for (i, path) in a.also.iter().enumerate() {
        let loaded = read_document::<MomentsDocument>(path)?;
        provenance.inputs.insert(format!("moments:{}", i + 2), loaded.digest);
        out.push((path.clone(), loaded.data));
    }
    Ok(out)
}

/// The design of `moments`: candidates, what is available, criterion, shares, counts.
fn design(
    a: &Arguments,
    moments: &MomentsDocument,
    provenance: &mut Provenance,
) -> Result<DesignDocument, Failure> {
    let (name, estimated) = (criterion_name(a)?, estimated(a));
    let refuse = |e| no_design(&a.moments, moments, estimated, e);
    let information = information(&a.moments, moments, estimated)?;
    let weights = weights(name, a.relative_to, a.weights.as_deref(), &a.moments, moments, provenance)?;
    let also = also(a, provenance)?;
    let also: Vec<(&Path, MomentsDocument)> = also.iter().map(|(p, m)| (p.as_path(), m.clone())).collect();
    let asked = Asked { name, estimated, weights, also: &also, over: a.over };
    let criterion = Criterion::new(&asked, &a.moments, moments)?;
    let options =
        Options { tolerance: a.tolerance, random_starts: a.starts, seed: seed(a), ..Options::default() };
    let timed = match a.accuracy {
        Some(accuracy) => {
            let question = Question {
                file: &a.moments,
                moments,
                criterion: &criterion,
                estimated,
                removal: a.mean_removal,
                squares: squares(a.relative_to, &a.moments, moments)?,
                wanted: wanted(a, accuracy),
                least_largest: a.per_parameter && a.criterion.is_none() && a.also.is_empty(),
                available: a.available.as_deref(),
            };
            Some(question.shortest(&options, provenance)?)
        }
        None => None,
    };
    let experiment = match &timed {
        Some(timed) => Experiment { samples: Some(timed.accuracy.samples as f64), segments: None },
        None => experiment(a, moments),
    };
    let available = match &a.available {
        Some(path) => Some(Available::read(path, moments, &experiment, provenance)?),
        None => None,
    };
    let bounds = match &available {
        Some(available) => Bounds::new(&available.shares).map_err(refuse)?,
        None => Bounds::default(),
    };
    let parameters = moments.degrees.iter().map(|d| d.parameters.len()).sum();
    let mut design = match &timed {
        Some(timed) => timed.design.clone(),
        None => criterion.solve(&bounds, &options).map_err(refuse)?,
    };
    let few = Few { most_maneuvers: a.most_maneuvers, minimal_s: a.minimal_s };
    let mut about = None;
    if few.most_maneuvers.is_some() || few.minimal_s.is_some() {
        let duration_s = few_duration(a, moments, &experiment)?;
        let found = restricted(&criterion, &design, &bounds, &few, duration_s, &options, parameters);
        let (restricted, told) = found.map_err(|e| few.refusal(&a.moments, &e))?;
        (design, about) = (restricted, Some(told));
    }
    let segments = experiment.segments.map(|(total, samples)| Segments {
        total,
        samples,
        limits: limits(available.as_ref(), about.is_some().then_some(&design), total),
    });
    let count_options = CountOptions { random_starts: a.starts, seed: seed(a), ..CountOptions::default() };
    let sequence = sequence(a, moments, &criterion, &design, experiment.samples, provenance)?;
    let count = |segments| counted(&criterion, &design, segments, &count_options, parameters);
    Ok(document(Solved {
        moments,
        information: &information,
        name,
        criterion: &criterion,
        estimated,
        removal: a.mean_removal,
        design: &design,
        available: available.as_ref(),
        counted: segments.as_ref().map(count).transpose().map_err(refuse)?,
        samples: experiment.samples,
        over: (!also.is_empty()).then_some(a.over),
        restricted: about,
        accuracy: timed.map(|timed| timed.accuracy),
        sequence,
    }))
}

/// Order and lengths of the maneuvers of `design`, where they are asked for.
fn sequence(
    a: &Arguments,
    moments: &MomentsDocument,
    criterion: &Criterion,
    design: &Design,
    samples: Option<f64>,
    provenance: &mut Provenance,
) -> Result<Option<Sequence>, Failure> {
    if !a.arrange {
        return Ok(None);
    }
    let usage = |found: &str, expected: &str| {
        Err(Failure::Usage(format!("--arrange: found {found}, expected {expected}")))
    };
    let Some(samples) = samples else {
        return usage(
            "no length of the experiment",
            "one to fill; add --duration-s, --accuracy, or --segments and --segment-samples",
        );
    };
    if a.available.is_some()
        || a.most_maneuvers.is_some()
        || a.minimal_s.is_some()
        || a.mean_removal == Removal::Batch
    {
        return usage(
            "--available, --most-maneuvers, --minimal-s or --mean-removal batch, which the search does not keep",
            "none of them; leave them out",
        );
    }
    let (vessel_file, dictionary_file) = (given(&a.vessel, "vessel")?, given(&a.dictionary, "dictionary")?);
    let vessel = read_vessel(vessel_file, provenance)?;
    let generator = read_dictionary(dictionary_file, &vessel, provenance)?;
    let sequencing = Sequencing {
        vessel: &vessel,
        generator: &generator,
        dictionary_file,
        moments,
        name: criterion_name(a)?,
        criterion,
        estimated: estimated(a),
        seed: seed(a),
    };
    sequencing.search(&design.shares, &design.sensitivities, samples.round() as usize).map(Some)
}

/// Most segments of every maneuver: none of those that a restricted design does not use.
fn limits(available: Option<&Available>, restricted: Option<&Design>, total: u64) -> Option<Vec<u64>> {
    let limits = available.and_then(|available| available.counts.clone());
    let Some(design) = restricted else { return limits };
    let limits = limits.unwrap_or_else(|| vec![total; design.shares.len()]);
    Some(limits.iter().zip(&design.shares).map(|(limit, w)| if *w > 0.0 { *limit } else { 0 }).collect())
}

/// The experiment's duration, which --minimal-s needs.
fn few_duration(
    a: &Arguments,
    moments: &MomentsDocument,
    experiment: &Experiment,
) -> Result<Option<f64>, Failure> {
    let duration = experiment.samples.map(|samples| samples / moments.sample_rate_hz);
    match (a.minimal_s, duration) {
        (Some(_), None) => Err(Failure::Usage(
            "--minimal-s: found no length of the experiment, expected one to relate it to; add --duration-s, or --segments and \
             --segment-samples"
                .into(),
        )),
        (Some(minimal), Some(duration)) if minimal > duration => Err(Failure::Usage(format!(
            "--minimal-s: found {minimal}, expected no more than the experiment's {duration} s; lower it"
        ))),
        _ => Ok(duration),
    }
}

fn wanted(a: &Arguments, accuracy: f64) -> Wanted {
    Wanted {
        accuracy,
        per_parameter: a.per_parameter,
        longest_s: a.longest_s,
        random_segments: a.random_segments,
        seed: seed(a),
    }
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
    let name = criterion_name(a).unwrap_or(CriterionName::DHessian);
    if name != CriterionName::DHessian {
        settings.insert("criterion".into(), json!(name_of(name)));
    }
    if (name == CriterionName::ARelative && a.weights.is_none()) || a.accuracy.is_some() {
        settings.insert("relative_to".into(), json!(name_of(a.relative_to)));
    }
    if a.estimator == Predicted::OutputError {
        settings.insert("estimator".into(), json!("output-error"));
        settings.insert("noise".into(), json!(name_of(a.noise)));
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
