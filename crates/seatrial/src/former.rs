//! A former fit of the same ship, or of a sister of another size.

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
    let sizes = [forces.description(), &theirs].map(|d| (d.ship.length_m, d.ship.draught_m));
    let same = sizes[0] == sizes[1];
    let mean = |parameter: &Parameter| {
        let estimate = fitted.parameters.iter().find(|e| e.name == parameter.name).ok_or_else(|| {
            let (thing, found) = (format!("parameter `{}`", parameter.name), "a number that was known");
            Invalid::new(thing, found, "one that was estimated", "fix it in this vessel, too")
        })?;
        scaled(parameter, estimate, same)
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
fn check_alike(ours: &Description, theirs: &Description) -> Result<(), Invalid> {
    let (ours, theirs) = (parts(ours), parts(theirs));
    let count = ours.len().max(theirs.len());
    let part = |of: &[String], i: usize| of.get(i).cloned().unwrap_or_else(|| "nothing".to_owned());
    match (0..count).find(|i| ours.get(*i) != theirs.get(*i)) {
        None => Ok(()),
        Some(i) => {
            let expected = format!("{}, as this vessel has", part(&ours, i));
            let remedy = "take a former fit of the same terms and components";
            Err(Invalid::new("`data.forces.description`", part(&theirs, i), expected, remedy))
        }
    }
}

/// What a ship's forces consist of, without numbers.
fn parts(of: &Description) -> Vec<String> {
    let area = of.ship.area.map_or("Ld", |area| area.name());
    let coriolis = of.ship.coriolis.map_or("without-munk", |coriolis| coriolis.name());
    let mut all = vec![format!("area `{area}`, coriolis `{coriolis}`")];
    for (degree, terms) in [("surge", &of.surge), ("sway", &of.sway), ("yaw", &of.yaw)] {
        let part = |term: &TermSpec| format!("`{}` {} in {degree}", term.parameter, term.term);
        all.extend(terms.iter().map(part));
    }
    all.extend(of.propeller.iter().map(|p| format!("propeller `{}` of input `{}`", p.name, p.input)));
    all.extend(of.rudder.iter().map(|r| format!("rudder `{}` of input `{}`", r.name, r.input)));
    all.extend(of.thruster.iter().map(|t| format!("thruster `{}` of input `{}`", t.name, t.input)));
    let harmonics = |wind: &ship::forces::WindSpec| [wind.surge.len(), wind.sway.len(), wind.yaw.len()];
    all.extend(of.wind.iter().map(|wind| format!("wind `{}` of {:?} harmonics", wind.name, harmonics(wind))));
    all.extend(of.crossflow.iter().map(|crossflow| format!("crossflow `{}`", crossflow.name)));
    all
}
