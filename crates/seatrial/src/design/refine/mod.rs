//! `design refine`: the input signals of an experiment themselves, from a design as a start.

mod limits;
mod outputs;
mod start;

use std::path::{Path, PathBuf};

use artifact::{Provenance, commit, read_document};
use clap::Args;
use identification::refine::{Effort, refine as search};
use serde_json::json;

use super::output_error::SimulateWith;
use crate::cli::{Common, beside, name_of, provenance};
use crate::failure::Failure;
use crate::stage::Summary;
use study::documents::DesignDocument;
use study::files::{read_campaign, read_dictionary, read_vessel};

/// The command line of `design refine`.
#[derive(Args)]
#[command(
    after_help = "Writes refined.json, and inputs.csv, refined-dictionary.toml and design.json for `simulate campaign`.\n\n\
    Example:\n  design refine --vessel vessel.toml --dictionary dictionary.toml --design design.json --campaign campaign.toml --out refined/"
)]
pub struct Refine {
    /// The vessel
    #[arg(long, value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The maneuvers that the design is of
    #[arg(long, value_name = "dictionary.toml")]
    dictionary: PathBuf,
    /// The design whose experiment is the start
    #[arg(long, value_name = "design.json")]
    design: PathBuf,
    /// Disturbances, and the experiment's duration
    #[arg(long, value_name = "campaign.toml")]
    campaign: PathBuf,
    /// Limits: u_m_s, v_m_s, r_rad_s, tables `inputs` and `rates` (per second) by input; default: those of [generate] in the
    /// dictionary, else what the start reaches
    #[arg(long, value_name = "limits.toml")]
    limits: Option<PathBuf>,
    /// Which parameters the experiment is simulated with (default: the true ones where the vessel has them)
    #[arg(long, value_enum)]
    simulate_with: Option<SimulateWith>,
    /// Which parameters errors are relative to (default: those that it is simulated with)
    #[arg(long, value_enum)]
    relative_to: Option<SimulateWith>,
    /// Time between the knots of what is added to the start's inputs, straight between them; below a sample every sample is
    /// corrected on its own [s]
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    knot_s: f64,
    /// Iterations at most
    #[arg(long, value_name = "N", default_value_t = 3000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    iterations: u32,
    /// Flags of every stage
    #[command(flatten)]
    pub common: Common,
}

/// Runs `design refine`.
///
/// # Errors
/// Files that are refused; limits that the start breaks; a start that excites not every parameter.
pub fn refine(a: &Refine) -> Result<Summary, Failure> {
    let mut provenance = provenance("design refine");
    let inputs =
        [Some(&a.vessel), Some(&a.dictionary), Some(&a.design), Some(&a.campaign), a.limits.as_ref()];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
    let out = a.common.main_output("refined.json", &inputs)?;
    let others = ["inputs.csv", "refined-dictionary.toml", "design.json"].map(|name| beside(&out, name));
    for path in &others {
        Common { out: path.clone(), ..a.common.clone() }.main_output("", &inputs)?;
    }
    let vessel = read_vessel(&a.vessel, &mut provenance)?;
    let generator = read_dictionary(&a.dictionary, &vessel, &mut provenance)?;
    let config = read_campaign(&a.campaign, &mut provenance)?;
    let design = read_document::<DesignDocument>(&a.design)?;
    provenance.inputs.insert("design".into(), design.digest);
    let start = start::Start::new(a, &vessel, &generator, &config, &design.data)?;
    let limits = limits::Limits::new(a, &vessel, &generator, &start, &mut provenance)?;
    let knot = knot(a, vessel.sample_rate_hz)?;
    let effort = Effort { knot, iterations: a.iterations as usize };
    let found = search(&start.criterion(&vessel), &start.inputs, &limits.signal, &effort);
    let refined = found.ok_or_else(|| start.not_identifiable(a, &vessel))?;
    settings(a, &start, knot as f64 / vessel.sample_rate_hz, &mut provenance);
    let made = outputs::Outputs { vessel: &vessel, start: &start, limits: &limits, refined: &refined, knot };
    let document = made.document();
    let staged = made.staged(&out, &others, &provenance, &document)?;
    commit(staged)?;
    let line = format!("{}: {}", out.display(), document.statement);
    let json = json!({
        "out": out, "before": document.before.value, "after": document.after.value, "worth": document.worth,
        "iterations": document.iterations, "settled": document.settled,
    });
    Ok(Summary { line, json })
}

/// Samples between knots.
fn knot(a: &Refine, rate_hz: f64) -> Result<usize, Failure> {
    match a.knot_s {
        s if s.is_finite() && s > 0.0 => Ok(((s * rate_hz).round() as usize).max(1)),
        s => Err(Failure::Usage(format!("--knot-s: found {s}, expected a number above 0; correct it"))),
    }
}

/// What the result depends on besides the inputs.
fn settings(a: &Refine, start: &start::Start, knot_s: f64, provenance: &mut Provenance) {
    let settings = &mut provenance.settings;
    settings.insert("simulate_with".into(), json!(name_of(start.with)));
    settings.insert("relative_to".into(), json!(name_of(start.relative_to)));
    settings.insert("knot_s".into(), json!(knot_s));
    settings.insert("iterations".into(), json!(a.iterations));
}
