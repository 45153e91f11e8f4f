//! Fits of ships with forces.

use std::path::{Path, PathBuf};

use artifact::{Provenance, commit, read_document, stage_document};
use clap::Args;
use identification::Estimator;
use model::Vessel;
use seatrial::fitting::{Settings, Starts, Unfit};
use seatrial::{Physical, PhysicalError, check_captive, former};
use serde_json::json;
use study::documents::ModelDocument;
use study::files::read_reference;

use crate::cli::{Common, none_given, not_below, samples};
use crate::failure::Failure;
use crate::inputs;
use crate::pool::{Held, PoolFlags};
use crate::stage::Summary;

/// The usual name of the document.
const MAIN: &str = "model.json";
/// Weight of a former fit of the same ship or of a sister's.
const FORMER: f64 = 10.0;

/// Flags of fits of ships with forces.
#[derive(Args, Clone, Debug)]
pub struct PhysicalFlags {
    /// Of a ship with forces: the runs are simulated in windows of at most this length [s] [default: 100]
    #[arg(long, value_name = "S")]
    window_s: Option<f64>,
    /// Of a ship with forces: weight of the priors [default: 1, or 10 with --prior model.json]
    #[arg(long, value_name = "WEIGHT")]
    prior_weight: Option<f64>,
    /// Of a ship with forces: windows start at their first measured sample, not at a state that is found with the parameters.
    /// Predictions may be better, standard errors are too small
    #[arg(long)]
    measured_starts: bool,
    /// Of a ship with forces: values of captive tests under `derivatives`, to set beside the estimates
    #[arg(long, value_name = "reference.toml")]
    reference: Option<PathBuf>,
    /// Of a ship with forces: does not test what is wrong with her, which takes a few times as long as the fit
    #[arg(long)]
    no_criticism: bool,
}

impl PhysicalFlags {
    /// Refuses these flags for terms per sample.
    ///
    /// # Errors
    /// A usage error that names the first of them.
    pub fn check_absent(&self) -> Result<(), Failure> {
        let flags = [
            ("--window-s", self.window_s.is_some()),
            ("--prior-weight", self.prior_weight.is_some()),
            ("--measured-starts", self.measured_starts),
            ("--reference", self.reference.is_some()),
            ("--no-criticism", self.no_criticism),
        ];
        none_given(flags, "a vessel with terms per sample", "one with forces")
    }

    fn settings(&self, sample_s: f64, held: Option<&Held>) -> Result<Settings, Failure> {
        let usual = Settings::new(sample_s);
        let window_s = self.window_s.unwrap_or(usual.window_s);
        samples("--window-s", window_s, 1.0 / sample_s)?;
        let weight = match (self.prior_weight, held) {
            (Some(weight), Some(Held::Strength(_))) => {
                let found = format!("--prior-weight: found {weight} beside a number as --prior");
                return Err(Failure::Usage(format!("{found}, expected one of them; leave one out")));
            }
            (Some(weight), _) => not_below("--prior-weight", weight, 0.0)?,
            (None, Some(Held::Strength(weight))) => not_below("--prior", *weight, 0.0)?,
            (None, Some(Held::Former(_))) => FORMER,
            (None, None) => usual.prior_weight,
        };
        let starts = if self.measured_starts { Starts::Measured } else { Starts::Unknown };
        Ok(Settings { window_s, prior_weight: weight, starts, ..usual })
    }
}

/// Fits `vessel`, which has forces, to the runs of `flags`, and writes model.json.
///
/// # Errors
/// Flags or an estimator that need terms per sample; files that are refused; no fit.
pub fn fit(
    (flags, own): (&PoolFlags, &PhysicalFlags),
    (estimator, most_added): (Option<Estimator>, usize),
    vessel: &Vessel,
    (common, mut provenance): (&Common, Provenance),
) -> Result<Summary, Failure> {
    if let Some(other) = estimator.filter(|own| *own != Estimator::OutputError) {
        let refused = vessel.check_terms(other.name());
        refused.map_err(|e| Failure::invalid(&flags.vessel, &e))?;
    }
    flags.check_forces()?;
    let out = common.main_output(MAIN, flags.inputs().chain(&own.reference))?;
    let settings = own.settings(1.0 / vessel.sample_rate_hz, flags.prior.as_ref())?;
    let former = match &flags.prior {
        Some(Held::Former(path)) => Some(read_former(path, vessel, &mut provenance)?),
        _ => None,
    };
    let reference =
        own.reference.as_ref().map(|path| read_reference(path, "reference", &mut provenance)).transpose()?;
    if let (Some(path), Some(reference)) = (&own.reference, &reference) {
        check_captive(reference, vessel).map_err(|e| Failure::invalid(path, &e))?;
    }
    let (runs, _) = flags.of.read(vessel, &mut provenance, inputs::runs)?;
    let (former, reference) = (former.as_deref(), reference.as_ref());
    let criticise = !own.no_criticism;
    let physical = Physical { vessel, settings, former, reference, criticise, most_added };
    let model = physical.model(&runs).map_err(|e| unfit(e, &flags.vessel, flags.of.file()))?;
    let noted = [
        ("estimator", json!(Estimator::OutputError)),
        ("pool", json!(true)),
        ("runs", json!(flags.of.runs)),
        ("leave_out", json!(flags.of.leave_out)),
        ("window_s", json!(settings.window_s)),
        ("prior_weight", json!(settings.prior_weight)),
        ("measured_starts", json!(own.measured_starts)),
        ("criticised", json!(criticise)),
        ("add_terms", json!(most_added)),
    ];
    let given = noted.into_iter().filter(|(_, value)| *value != json!([]));
    provenance.settings.extend(given.map(|(key, value)| (key.to_owned(), value)));
    commit(vec![stage_document(&out, &provenance, &model)?])?;
    let (windows, free, steps) =
        model.forces.as_ref().map_or((0, 0, 0), |own| (own.windows, own.parameters.len(), own.steps));
    let statements = &model.statements;
    let said = format!("output-error from {windows} windows, {free} parameters, {steps} steps");
    let all: Vec<&str> = [said.as_str()].into_iter().chain(statements.iter().map(String::as_str)).collect();
    let details = json!({"windows": windows, "parameters": free, "steps": steps, "statements": statements});
    Ok(Summary::of(&out, all.join("; "), details))
}

/// The estimates of a former fit, in the order of the vessel's parameters.
fn read_former(path: &Path, vessel: &Vessel, provenance: &mut Provenance) -> Result<Vec<f64>, Failure> {
    let read = read_document::<ModelDocument>(path)?;
    provenance.inputs.insert("prior".to_owned(), read.digest);
    former(vessel, &read.data).map_err(|e| Failure::invalid(path, &e))
}

fn unfit(error: PhysicalError, vessel: &Path, runs: &Path) -> Failure {
    match error {
        PhysicalError::Invalid(invalid) => Failure::invalid(vessel, &invalid),
        PhysicalError::Unfit(Unfit::NoParameter) => Failure::invalid(vessel, &Unfit::NoParameter.invalid()),
        PhysicalError::Unfit(other) => Failure::NoAnswer(format!("{}: {}", runs.display(), other.invalid())),
    }
}
