//! What a former fit says of a ship's numbers.

use refusal::Invalid;
use ship::forces::{Description, Forces, Parameter, TermSpec};
use ship::model::Vessel;
use study::documents::{FittedParameter, ModelDocument};

/// The estimates of a former fit of the same ship, or of a sister of another size by the prime system, for each free
/// number of `vessel`.
///
/// # Errors
/// A model without forces, another description, or a number that the prime system does not scale.
pub fn former(vessel: &Vessel, model: &ModelDocument) -> Result<Vec<f64>, Invalid> {
    let (Some(moved), Some(fitted)) = (&vessel.model.forces, &model.forces) else {
        let remedy = "name the model of a fit of forces";
        return Err(Invalid::new("`data.forces`", "terms per sample", "forces", remedy));
    };
    let forces: &Forces = &moved.forces;
    let theirs = fitted.description()?;
    check_alike(forces.description(), &theirs)?;
    let sizes = [forces.description(), &theirs].map(|own| (own.ship.length_m, own.ship.draught_m));
    let same = sizes[0] == sizes[1];
    let mean = |parameter: &Parameter| {
        let found = fitted.parameters.iter().find(|found| found.name == parameter.name).ok_or_else(|| {
            let (thing, found) = (format!("parameter `{}`", parameter.name), "a number that was known");
            Invalid::new(thing, found, "one that was estimated", "fix it in this vessel, too")
        })?;
        scaled(parameter, found, same)
    };
    forces.parameters().iter().map(mean).collect()
}

/// A former estimate in the system of `own`.
fn scaled(parameter: &Parameter, found: &FittedParameter, same: bool) -> Result<f64, Invalid> {
    match (parameter.prime, found.prime_value) {
        _ if same && parameter.unit == found.unit => Ok(found.value),
        (Some(one), Some(prime)) => Ok(prime * one / parameter.scale),
        _ if same => Ok(found.si_value / parameter.scale),
        _ => {
            let (thing, found) =
                (format!("parameter `{}`", parameter.name), format!("a number in {}", parameter.si_unit));
            let expected = "numbers of the prime system: the ships differ in size";
            Err(Invalid::new(thing, found, expected, "fix it, or take a former fit of this ship"))
        }
    }
}

/// Refuses ships with other terms or components.
fn check_alike(own: &Description, theirs: &Description) -> Result<(), Invalid> {
    let (own, theirs) = (parts(own), parts(theirs));
    let count = own.len().max(theirs.len());
    let part = |of: &[String], i: usize| of.get(i).cloned().unwrap_or_else(|| "nothing".to_owned());
    match (0..count).find(|i| own.get(*i) != theirs.get(*i)) {
        None => Ok(()),
        Some(i) => {
            let expected = format!("{}, as this vessel has", part(&own, i));
            let remedy = "take a former fit of the same terms and components";
            Err(Invalid::new("`data.forces.description`", part(&theirs, i), expected, remedy))
        }
    }
}

/// What a ship's forces consist of, without numbers.
fn parts(of: &Description) -> Vec<String> {
    let area = of.ship.area.map_or("Ld", |own| own.name());
    let coriolis = of.ship.coriolis.map_or("without-munk", |own| own.name());
    let mut all = vec![format!("area `{area}`, coriolis `{coriolis}`")];
    for (degree, terms) in [("surge", &of.surge), ("sway", &of.sway), ("yaw", &of.yaw)] {
        let part = |term_spec: &TermSpec| format!("`{}` {} in {degree}", term_spec.parameter, term_spec.term);
        all.extend(terms.iter().map(part));
    }
    all.extend(of.propeller.iter().map(|own| format!("propeller `{}` of input `{}`", own.name, own.input)));
    all.extend(of.rudder.iter().map(|own| format!("rudder `{}` of input `{}`", own.name, own.input)));
    all.extend(of.thruster.iter().map(|own| format!("thruster `{}` of input `{}`", own.name, own.input)));
    let harmonics = |wind_spec: &ship::forces::WindSpec| {
        [wind_spec.surge.len(), wind_spec.sway.len(), wind_spec.yaw.len()]
    };
    all.extend(of.wind.iter().map(|own| format!("wind `{}` of {:?} harmonics", own.name, harmonics(own))));
    all.extend(of.crossflow.iter().map(|own| format!("crossflow `{}`", own.name)));
    all
}
