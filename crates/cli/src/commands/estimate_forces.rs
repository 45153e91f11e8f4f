//! Fits of ships with forces.

use std::path::{Path, PathBuf};

use estimation::Estimator;
use files::{Provenance, commit_with_document, read_document, stage_document};
use seatrial::estimation::fitting::{Settings, Unfit};
use seatrial::validation::crossval::dealt;
use seatrial::{ForceFit, ForceFitError, check_captive, former};
use serde_json::json;
use ship::model::Vessel;
use study::documents::{ChosenStructure, EstimateDocument, LeftOutScores, ModelDocument};
use study::files::read_reference;

use crate::cli::{Common, none_given, not_below, samples};
use crate::failure::{Failure, WorkProgress};
use crate::inputs;
use crate::pool::{EstimateArguments, Folds, Held, PoolFlags, SetPaths, besides, note};
use crate::stage::Summary;

/// Weight of a former fit of the same ship or of a sister's.
const FORMER: f64 = 10.0;

/// Refuses these flags for terms per sample.
pub(super) fn absent<const N: usize>(flags: [(&str, bool); N]) -> Result<(), Failure> {
    none_given(flags, "a vessel with terms per sample", "one with forces")
}

/// The settings with windows of the length `window_s`, by its flag, and what holds back.
pub(super) fn settings(
    sample_s: f64,
    (flag, window_s): (&'static str, Option<f64>),
    held: Option<&Held>,
) -> Result<Settings, Failure> {
    let usual = Settings::new(sample_s);
    let window_s = window_s.unwrap_or(usual.window_s);
    samples(flag, window_s, 1.0 / sample_s)?;
    let prior_weight = match held {
        Some(Held::Strength(weight)) => not_below("--prior", *weight, 0.0)?,
        Some(Held::Former(_)) => FORMER,
        None => usual.prior_weight,
    };
    Ok(Settings { window_s, prior_weight, ..usual })
}

/// Fits `vessel`, which has forces, to windows of the runs, sets what is published beside, and writes estimate.json and model.json.
pub(super) fn fit(
    asked: &EstimateArguments,
    structure: ChosenStructure,
    vessel: &Vessel,
    (common, mut provenance): (&Common, Provenance),
) -> Result<Summary, Failure> {
    let flags = &asked.flags;
    check(flags, &asked.estimator, vessel)?;
    let written = SetPaths::of(common, asked, false)?;
    let rate_hz = vessel.sample_rate_hz;
    let settings =
        settings(1.0 / rate_hz, ("--fitted-window-s", asked.fitted_window_s), flags.prior.as_ref())?;
    let window = asked.scored(vessel)?;
    let former = read_former(flags, vessel, &mut provenance)?;
    let read = |path: &PathBuf| {
        let reference = read_reference(path, "reference", &mut provenance)?;
        check_captive(&reference, vessel).map_err(|e| Failure::invalid(path, &e))?;
        Ok::<_, Failure>(reference)
    };
    let reference = asked.reference.as_ref().map(read).transpose()?;
    let promised = asked.promised(common)?;
    let (runs, _) = flags.of.read(vessel, &mut provenance, inputs::runs)?;
    let (former, reference) = (former.as_deref(), reference.as_ref());
    let fit = ForceFit { vessel, settings, former, reference };
    let mut model = fit.model(&runs).map_err(|e| unfit(e, &flags.vessel, flags.of.file()))?;
    model.statements.extend(study::noted_contradicting(&provenance));
    let noted = [
        ("estimator", json!(Estimator::OutputError)),
        ("pool", json!(true)),
        ("runs", json!(flags.of.runs)),
        ("leave_out", json!(flags.of.leave_out)),
        ("window_s", json!(settings.window_s)),
        ("prior_weight", json!(settings.prior_weight)),
    ];
    note(noted, &mut provenance);
    let left_out = match asked.folds {
        None => None,
        Some(Folds(folds)) => {
            let folds = folds.map(usize::from);
            let progress = WorkProgress::new("folds", dealt(runs.sources(), folds).len(), common.quiet);
            let fit = ForceFit { reference: None, ..fit };
            let scores = fit.cross(&runs, (window, folds), &|count| progress.advance(count));
            let scores = scores.map_err(|e| Failure::invalid(flags.of.file(), &e.invalid()))?;
            note([("window_samples", json!(window)), ("folds", json!(folds))], &mut provenance);
            let window_s = window.map(|samples| samples as f64 / rate_hz);
            Some(LeftOutScores::of_forces(settings.prior_weight, window_s, &scores))
        }
    };
    let promise = asked.promise(promised, Some(&model), &mut provenance)?;
    let besides = besides(left_out.as_ref(), promise.as_ref());
    let document = EstimateDocument {
        structure: Some(structure),
        left_out,
        promise,
        ..EstimateDocument::new(model.estimator, model.mean_removal)
    };
    let member = stage_document(&written.model, &provenance, &model)?;
    commit_with_document(member, &written.document, &provenance, &document)?;
    let (windows, free, steps) =
        model.forces.as_ref().map_or((0, 0, 0), |fit| (fit.windows, fit.parameters.len(), fit.steps));
    let statements = &model.statements;
    let said = format!("output-error from {windows} windows, {free} parameters, {steps} steps");
    let all: Vec<&str> = [said.as_str()].into_iter().chain(statements.iter().map(String::as_str)).collect();
    let details = json!({"windows": windows, "parameters": free, "steps": steps, "statements": statements});
    Ok(Summary::of(&written.document, all.join("; "), details).also(besides))
}

/// Refuses flags and estimators that need terms per sample.
fn check(flags: &PoolFlags, estimators: &[Estimator], vessel: &Vessel) -> Result<(), Failure> {
    let refused = |e| Failure::invalid(&flags.vessel, &e);
    estimators.iter().try_for_each(|estimator| estimator.check(vessel)).map_err(refused)?;
    flags.check_forces()
}

/// The estimates of a former fit, in the order of the vessel's parameters, if one is named.
fn read_former(
    flags: &PoolFlags,
    vessel: &Vessel,
    provenance: &mut Provenance,
) -> Result<Option<Vec<f64>>, Failure> {
    let Some(Held::Former(path)) = &flags.prior else { return Ok(None) };
    let read = read_document::<ModelDocument>(path)?;
    provenance.inputs.insert("prior".to_owned(), read.digest);
    former(vessel, &read.data).map(Some).map_err(|e| Failure::invalid(path, &e))
}

/// Why there is no fit of the ship of `vessel` to `runs`.
fn unfit(error: ForceFitError, vessel: &Path, runs: &Path) -> Failure {
    match error {
        ForceFitError::Invalid(invalid) => Failure::invalid(vessel, &invalid),
        ForceFitError::Unfit(Unfit::NoParameter) => Failure::invalid(vessel, &Unfit::NoParameter.invalid()),
        ForceFitError::Unfit(other) => Failure::NoAnswer(format!("{}: {}", runs.display(), other.invalid())),
    }
}
