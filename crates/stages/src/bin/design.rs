//! `design`: how long to run each maneuver.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use artifact::{commit, read_document, stage_document};
use clap::Parser;
use optimal_design::{Candidates, Design, Error, Options, Status, apportion, solve};
use serde_json::json;
use stages::cli::{Common, Summary, name_of, provenance, run};
use stages::documents::{Counts, DesignDocument, Efficiency, MomentsDocument, Start};
use stages::failure::Failure;
use stages::instruments::Removal;

/// Finds the shares of the experiment time that make the information largest (D-optimal), with a certificate
#[derive(Parser)]
#[command(
    name = "design",
    version,
    after_help = "Example:\n  design --moments moments.json --out design.json\n  \
    design --moments moments.json --segments 5 --segment-samples 200 --out design.json"
)]
struct Arguments {
    /// The maneuvers' moments
    #[arg(long, value_name = "moments.json")]
    moments: PathBuf,
    /// How the estimator will remove the instruments' mean
    #[arg(long, value_enum, default_value_t = Removal::Complete)]
    mean_removal: Removal,
    /// Random starts besides equal shares
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(0..=1000))]
    starts: u32,
    /// Stop at this Kiefer-Wolfowitz gap, relative to the dimension
    #[arg(long, value_name = "GAP", default_value_t = 1e-10)]
    tolerance: f64,
    /// Round the shares to this many whole segments
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
    if !(a.tolerance.is_finite() && a.tolerance > 0.0) {
        let message = format!("--tolerance: found {}, expected a number above 0; correct it", a.tolerance);
        return Err(Failure::Usage(message));
    }
    let loaded = read_document::<MomentsDocument>(&a.moments)?;
    let moments = loaded.data;
    let candidates = candidates(&a.moments, &moments, a.mean_removal)?;
    let options = Options {
        tolerance: a.tolerance,
        random_starts: a.starts,
        seed: a.common.seed.unwrap_or(1),
        ..Options::default()
    };
    let design = solve(&candidates, &options).map_err(|e| no_design(&a.moments, &moments, e))?;
    let document = document(a, &moments, &candidates, &design);
    let mut provenance = provenance("design");
    provenance.inputs.insert("moments".into(), loaded.digest);
    provenance.settings.insert("seed".into(), json!(options.seed));
    provenance.settings.insert("starts".into(), json!(a.starts));
    provenance.settings.insert("tolerance".into(), json!(a.tolerance));
    let out = a.common.main_output("design.json", &[&a.moments])?;
    commit(vec![stage_document(&out, &provenance, &document)?])?;
    let used = document.shares.values().filter(|w| **w > 0.0).count();
    Ok(Summary {
        line: format!(
            "{}: {} of {} maneuvers, {}, relative gap {:.1e}",
            out.display(),
            used,
            document.shares.len(),
            document.status,
            document.relative_gap
        ),
        json: json!({"out": out, "status": document.status, "relative_gap": document.relative_gap, "used": used}),
    })
}

/// One candidate per maneuver: the matrices that add up under the chosen mean removal.
fn candidates(file: &Path, moments: &MomentsDocument, removal: Removal) -> Result<Candidates, Failure> {
    check_structure(file, moments)?;
    let lifted: Vec<usize> = moments.degrees.iter().map(|d| d.regressors.len()).collect();
    let kept = lifted.iter().map(|n| if removal == Removal::Complete { *n } else { n - 1 }).collect();
    let mut candidates = Candidates::new(kept);
    for maneuver in &moments.maneuvers {
        let malformed = |what: &str| {
            Failure::refuse(
                file,
                &format!("moments of `{}`", maneuver.name),
                what,
                "a finite p̃ × p̃ matrix per degree of freedom",
                "run `moments` again",
            )
        };
        if maneuver.degrees.len() != lifted.len() {
            return Err(malformed(&format!("{} degrees of freedom", maneuver.degrees.len())));
        }
        let mut entries = Vec::with_capacity(candidates.size());
        for (degree, n) in maneuver.degrees.iter().zip(&lifted) {
            if degree.m.len() != n * n || degree.shape != [*n as u64; 2] {
                return Err(malformed(&format!("{} entries in {}", degree.m.len(), degree.name)));
            }
            entries.extend(reduced(&degree.m, *n, removal));
        }
        candidates.push(&entries).map_err(|e| malformed(&e.to_string()))?;
    }
    Ok(candidates)
}

/// Refuses degrees of freedom without one parameter per regressor, and maneuvers of the same name.
fn check_structure(file: &Path, moments: &MomentsDocument) -> Result<(), Failure> {
    let refuse = |thing: String, found: &str, expected: &str| {
        Err(Failure::refuse(file, &thing, found, expected, "run `moments` again"))
    };
    for degree in &moments.degrees {
        let (regressors, parameters) = (degree.regressors.len(), degree.parameters.len());
        if parameters == 0 || regressors != parameters + 1 {
            let found = format!("{regressors} regressors and {parameters} parameters");
            return refuse(
                format!("`data.degrees` {}", degree.name),
                &found,
                "one regressor more than parameters",
            );
        }
    }
    let mut names = BTreeSet::new();
    match moments.maneuvers.iter().find(|maneuver| !names.insert(&maneuver.name)) {
        Some(twice) => {
            refuse(format!("maneuver `{}`", twice.name), "its moments twice", "every maneuver once")
        }
        None => Ok(()),
    }
}

/// From M = \[\[X̄, Ȳ\], \[Z̄ᵀ, 1\]\]: M itself, X̄ − Ȳ Z̄ᵀ or X̄.
fn reduced(m: &[f64], lifted: usize, removal: Removal) -> Vec<f64> {
    let p = lifted - 1;
    let entry = |i: usize, j: usize| m[i * lifted + j];
    match removal {
        Removal::Complete => m.to_vec(),
        Removal::Batch => {
            (0..p * p).map(|k| entry(k / p, k % p) - entry(k / p, p) * entry(p, k % p)).collect()
        }
        Removal::None => (0..p * p).map(|k| entry(k / p, k % p)).collect(),
    }
}

fn no_design(file: &Path, moments: &MomentsDocument, error: Error) -> Failure {
    match error {
        Error::Unexcited { block, direction } => {
            let degree = &moments.degrees[block];
            let weight = |i: &usize| direction[*i].abs();
            let parameter =
                (0..degree.parameters.len()).max_by(|a, b| weight(a).total_cmp(&weight(b))).unwrap_or(0);
            Failure::NoAnswer(format!(
                "{}: parameter `{}` ({}): found a direction that no maneuver excites, expected every parameter to be \
                 excited by some maneuver; add a maneuver in which `{}` varies independently of the other terms of {}",
                file.display(),
                degree.parameters[parameter],
                degree.name,
                degree.regressors[parameter],
                degree.name
            ))
        }
        Error::Empty => {
            Failure::refuse(file, "`data.maneuvers`", "none", "at least one maneuver", "run `moments` again")
        }
        other => Failure::NoAnswer(format!(
            "{}: design: found {other}, expected a convergent search; raise --starts or --tolerance",
            file.display()
        )),
    }
}

fn document(
    a: &Arguments,
    moments: &MomentsDocument,
    candidates: &Candidates,
    design: &Design,
) -> DesignDocument {
    let names: Vec<String> = moments.maneuvers.iter().map(|m| m.name.clone()).collect();
    let named =
        |values: &[f64]| names.iter().cloned().zip(values.iter().copied()).collect::<BTreeMap<_, _>>();
    let parameters = moments.degrees.iter().map(|d| d.parameters.len()).sum();
    let count = candidates.len();
    let p = candidates.dimension() as f64;
    let starts = starts(design);
    let counted = a.segments.zip(a.segment_samples).map(|(segments, segment_samples)| {
        let counts = apportion(&design.shares, segments);
        let shares: Vec<f64> = counts.iter().map(|n| *n as f64 / segments as f64).collect();
        let efficiency = design.efficiency(candidates, &shares, parameters);
        (counts, Counts { segments, segment_samples, efficiency })
    });
    DesignDocument {
        criterion: "D".into(),
        mean_removal: name_of(a.mean_removal),
        status: match design.status {
            Status::Optimal => "optimal",
            Status::Stationary => "stationary",
            Status::Stalled => "stalled",
        }
        .into(),
        statement: statement(design, &starts, p),
        shares: named(&design.shares),
        sensitivities: named(&design.sensitivities),
        dimension: candidates.dimension() as u64,
        gap: design.gap,
        relative_gap: design.gap / p,
        log_det: design.log_det,
        proved_global: design.status == Status::Optimal,
        starts,
        efficiency: Efficiency {
            equal_shares: design.efficiency(candidates, &vec![1.0 / count as f64; count], parameters),
            single: named(&design.single_efficiencies(candidates, parameters)),
        },
        counts: counted
            .as_ref()
            .map(|(counts, _)| names.iter().cloned().zip(counts.iter().copied()).collect()),
        counted: counted.map(|(_, about)| about),
        order: names,
    }
}

fn starts(design: &Design) -> Vec<Start> {
    let agrees = |log_det: f64| (design.log_det - log_det).abs() <= 1e-8 * design.log_det.abs().max(1.0);
    let start = |(i, s): (usize, &optimal_design::Start)| Start {
        name: if i == 0 { "equal".into() } else { format!("random {i}") },
        log_det: s.log_det,
        relative_gap: s.relative_gap,
        iterations: s.iterations,
        agrees: agrees(s.log_det),
    };
    design.starts.iter().enumerate().map(start).collect()
}

fn statement(design: &Design, starts: &[Start], p: f64) -> String {
    let agreeing = starts.iter().filter(|s| s.agrees).count();
    let starts = format!("{agreeing} of {} starts reached this value", starts.len());
    let gap = design.gap / p;
    match design.status {
        Status::Optimal => format!(
            "Globally optimal: the problem is concave, and no shares have a criterion more than {:.1e} higher; {starts}.",
            design.gap.max(0.0)
        ),
        Status::Stationary => format!(
            "Stationary to a relative gap of {gap:.1e}, not proved global (the problem is not concave); {starts}."
        ),
        Status::Stalled => {
            format!("The search stalled at a relative gap of {gap:.1e}: not optimal; {starts}.")
        }
    }
}
