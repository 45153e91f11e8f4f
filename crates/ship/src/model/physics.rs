//! Vessels whose model is made of forces.

use std::sync::Arc;

use crate::forces::{Channel, Description, Forces};
use refusal::{Invalid, check_ranges};

use crate::model::moved::ForceModel;
use crate::model::parts::Parts;
use crate::model::written::{Kind, VesselFile, missing};
use crate::model::{Actuator, Variable};

/// Most steps of the integration in a sample.
const MOST_STEPS: f64 = 1e4;

/// Whether a file has keys of forces.
pub(crate) fn has_forces(file: &VesselFile) -> bool {
    first_key(file).is_some()
}

/// The first key of forces in a file.
fn first_key(file: &VesselFile) -> Option<&'static str> {
    let keys = [
        ("density_kg_m3", file.density_kg_m3.is_some()),
        ("step_s", file.step_s.is_some()),
        ("[ship]", file.ship.is_some()),
        ("[[propeller]]", !file.propeller.is_empty()),
        ("[[rudder]]", !file.rudder.is_empty()),
        ("[[thruster]]", !file.thruster.is_empty()),
        ("[[wind]]", !file.wind.is_empty()),
        ("[[crossflow]]", !file.crossflow.is_empty()),
    ];
    keys.into_iter().find_map(|(key, given)| given.then_some(key))
}

/// Refuses keys of forces beside terms per sample.
///
/// # Errors
/// Names the first of them.
pub(crate) fn check_absent(file: &VesselFile) -> Result<(), Invalid> {
    let remedy = "write `model = \"forces\"`, or remove it";
    let expected = "terms per sample alone, without `model = \"forces\"`";
    if let Some(key) = first_key(file) {
        return Err(Invalid::new(format!("`{key}`"), "a key of forces", expected, remedy));
    }
    let terms = [&file.surge, &file.sway, &file.yaw].into_iter().flatten();
    match terms.into_iter().find(|own| own.prime.is_some() || own.prior.is_some()) {
        Some(own) => {
            let found = if own.prime.is_some() { "`prime`" } else { "`prior`" };
            Err(Invalid::new(format!("parameter `{}`", own.parameter), found, expected, remedy))
        }
        None => Ok(()),
    }
}

/// The forces of `file`, whose thrusters may give `actuators` their lags.
///
/// # Errors
/// A key that is missing or that only terms per sample have; what [`Forces::new`] refuses; two lags of one input.
pub(crate) fn moved(
    file: &VesselFile,
    variables: &[Variable],
    actuators: &mut [Actuator],
) -> Result<(Arc<ForceModel>, Parts), Invalid> {
    if file.constant != [0.0; 3] {
        let expected = "none: increments per sample are no forces";
        return Err(Invalid::new("`constant`", "increments", expected, "remove it, or add a term `1`"));
    }
    let description = description(file)?;
    let range = |i: usize| actuators.get(i).and_then(|own| own.range);
    let channel = |(i, own): (usize, &Variable)| Channel {
        name: own.name.clone(),
        unit: own.unit.clone(),
        range: range(i),
    };
    let channels: Vec<Channel> = variables[3..].iter().enumerate().map(channel).collect();
    let forces = Forces::new(&description, &channels)?;
    let mut parts = Parts {
        nominal: forces.nominal(),
        value: forces.parameters().iter().map(|own| own.value).collect(),
        ..Parts::default()
    };
    replace(file, &forces, &mut parts)?;
    forces.check(&parts.nominal)?;
    let true_ones: Vec<f64> =
        parts.value.iter().zip(&parts.nominal).map(|(value, nominal)| value.unwrap_or(*nominal)).collect();
    forces.check(&true_ones)?;
    for theta in [&parts.nominal, &true_ones].into_iter().filter(|_| !file.fitted) {
        forces.gate(theta, file.unusual.is_some())?;
    }
    for (i, lag_s) in forces.lags(&parts.nominal) {
        let Some(actuator) = actuators.get_mut(i) else { continue };
        if actuator.lag_s > 0.0 {
            let thing = format!("`lag_s` of input `{}`", variables[3 + i].name);
            let expected = "the lag of the input, or that of its thruster";
            return Err(Invalid::new(thing, "both", expected, "remove one of them"));
        }
        actuator.lag_s = lag_s;
    }
    let sample_s = 1.0 / file.sample_rate_hz.unwrap_or(1.0);
    let steps =
        description.step_s.map(|step_s| ("step_s", sample_s / step_s, 0.0..=MOST_STEPS, "steps in a sample"));
    check_ranges(steps)?;
    Ok((Arc::new(ForceModel { forces, sample_s }), parts))
}

impl VesselFile {
    /// The keys of forces as `own` has them, and no others.
    pub fn of_forces(description: Description) -> Self {
        Self {
            model: Some(Kind::Forces),
            density_kg_m3: Some(description.density_kg_m3),
            step_s: description.step_s,
            ship: Some(description.ship),
            surge: description.surge,
            sway: description.sway,
            yaw: description.yaw,
            propeller: description.propeller,
            rudder: description.rudder,
            thruster: description.thruster,
            wind: description.wind,
            crossflow: description.crossflow,
            ..Self::default()
        }
    }
}

/// The forces that `file` describes.
///
/// # Errors
/// A file of terms per sample, or without what all forces need.
pub(crate) fn described(file: &VesselFile) -> Result<Description, Invalid> {
    if file.model != Some(Kind::Forces) {
        let expected = "`model = \"forces\"`: terms per sample hold for one ship at one rate";
        let remedy = "describe her as forces, or take a preset such as `kvlcc2-l7`";
        return Err(Invalid::new("`model`", "terms per sample", expected, remedy));
    }
    description(file)
}

fn description(file: &VesselFile) -> Result<Description, Invalid> {
    let [surge, sway, yaw] = [&file.surge, &file.sway, &file.yaw].map(Vec::clone);
    Ok(Description {
        density_kg_m3: file.density_kg_m3.ok_or_else(|| missing("density_kg_m3"))?,
        step_s: file.step_s,
        ship: file.ship.clone().ok_or_else(|| missing("ship"))?,
        surge,
        sway,
        yaw,
        propeller: file.propeller.clone(),
        rudder: file.rudder.clone(),
        thruster: file.thruster.clone(),
        wind: file.wind.clone(),
        crossflow: file.crossflow.clone(),
    })
}

/// Puts in the numbers of [value] and [nominal], in the system of each parameter.
fn replace(file: &VesselFile, forces: &Forces, parts: &mut Parts) -> Result<(), Invalid> {
    let names = || forces.parameters().iter().map(|own| own.name.as_str());
    let both = file.value.iter().map(|own| (own, true)).chain(file.nominal.iter().map(|own| (own, false)));
    for ((name, value), truth) in both {
        let Some(i) = names().position(|own| own == name) else {
            let unknown = Invalid::unknown(format!("parameter `{name}`"), name, names());
            return Err(Invalid { found: "a name that no free parameter has".to_owned(), ..unknown });
        };
        let [low, high] = forces.parameters()[i].bounds;
        if !value.is_finite() || !(low..=high).contains(value) {
            let expected = "a finite number within its bounds";
            return Err(Invalid::new(
                format!("parameter `{name}`"),
                value.to_string(),
                expected,
                "correct it",
            ));
        }
        match truth {
            true => parts.value[i] = Some(*value),
            false => parts.nominal[i] = *value,
        }
    }
    Ok(())
}
