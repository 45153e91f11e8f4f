//! Vessels at another sampling rate than their own.

use std::path::Path;

use artifact::{Error, Provenance};
use engine::{Divided, check_diverged, simulate_one};
use model::{Actuator, Vessel};
use refusal::Invalid;
use serde_json::json;
use trial::campaign::{Maneuvers, Refusal};

/// The vessel at `path` at the rate that was requested \[Hz\], if one was; notes both.
///
/// # Errors
/// A rate that its terms per sample cannot have.
pub fn at_rate(
    path: &Path,
    vessel: Vessel,
    rate_hz: Option<f64>,
    provenance: &mut Provenance,
) -> Result<Vessel, Error> {
    let Some(rate_hz) = rate_hz else { return Ok(vessel) };
    let own = vessel.sample_rate_hz;
    let vessel = vessel.at_rate(rate_hz).map_err(|e| crate::invalid(path, &e))?;
    provenance.settings.insert("rate_hz".into(), json!(rate_hz));
    provenance.settings.insert("vessel_rate_hz".into(), json!(own));
    Ok(vessel)
}

/// Notes how well samples that are parts of the vessel's steps follow these, and says it; nothing for other samples.
///
/// # Errors
/// Samples that are off by more than 0.2 % of a standard deviation; maneuvers that cannot be simulated.
pub fn note_divided(maneuvers: &Maneuvers, provenance: &mut Provenance) -> Result<Option<String>, Refusal> {
    let Some(divided) = maneuvers.divided()? else { return Ok(None) };
    let statement = divided.statement().map_err(Refusal::Vessel)?;
    provenance.settings.insert("divided".into(), json!(statement));
    Ok(Some(statement))
}

/// Samples of the run that a model is tried with, and how many have the same inputs.
const SAMPLES: usize = 5_000;
const HELD: usize = 100;

/// How well the parts of the steps of `vessel` follow these in a run from the middle of her known range of motion, or from rest,
/// whose inputs go to other settings within their ranges every hundred samples; `None` where samples are no parts of steps.
///
/// # Errors
/// An input without a range; a run that diverges; as [`Divided::found`].
pub(crate) fn tried(vessel: &Vessel, parameters: &[f64]) -> Result<Option<String>, Invalid> {
    let Some(mut divided) = Divided::new(&vessel.model) else { return Ok(None) };
    let inputs = vessel.model.inputs;
    let range = |(i, own): (usize, &Actuator)| {
        own.range.ok_or_else(|| {
            let thing = format!("input `{}`", vessel.model.input_variables()[i].name);
            let expected = "a `range`, within which a faster step is tried";
            Invalid::new(thing, "no `range`", expected, "state it, or export at the vessel's own rate")
        })
    };
    let ranges = vessel.actuators.iter().enumerate().map(range).collect::<Result<Vec<_>, _>>()?;
    let row = |k: usize| {
        let mut row = vec![0.0; inputs];
        for (i, (to, [low, high])) in row.iter_mut().zip(&ranges).enumerate() {
            // Multiples of square roots, which no setting repeats.
            let share = ((k / HELD + 1) as f64 * (2.0 + 3.0 * i as f64).sqrt()).fract();
            *to = low + (high - low) * share;
        }
        row
    };
    let settings: Vec<f64> = (0..SAMPLES).flat_map(row).collect();
    let exogenous = vessel.model.undisturbed(&settings);
    let initial = vessel.motion.map_or([0.0; 3], |ranges| ranges.map(|[low, high]| 0.5 * (low + high)));
    let states = simulate_one(&vessel.model, parameters, initial, &exogenous);
    if let Some(at) = check_diverged(states.iter().copied()) {
        return Err(at.invalid("model in the run that a faster step is tried in", vessel.sample_rate_hz));
    }
    divided.add(&vessel.model, parameters, &exogenous, &states);
    divided.add_range(vessel, parameters);
    divided.statement().map(Some)
}
