//! The structure that a search begins with where the vessel has none for it.

use refusal::Invalid;
use ship::model::terms::listed;
use ship::model::{Degree, Model};

use crate::search::library::with_channels;
use crate::search::made::Made;
use crate::search::roles::Roles;

/// `model` with a core of terms in place of its own, or of its forces: resistance and drive in surge, `v` and `u r` in sway, `r` and
/// what steers in yaw; with the channels and roles of [`with_channels`]. Propellers of the numbers `reversing` act apart ahead and
/// astern. A model with terms whose channels do not say what steers keeps them.
///
/// # Errors
/// A channel that cannot be computed.
pub fn core(model: &Model, roles: &Roles, reversing: &[usize]) -> Result<(Model, Roles), Invalid> {
    let (model, roles) = with_astern(model, roles.clone(), reversing)?;
    let (model, roles) = with_channels(&model, &roles)?;
    let steered = [&roles.rudders[..], &roles.differences].concat();
    if model.forces.is_none() && steered.is_empty() {
        return Ok((model, roles));
    }
    let name = |variable: &usize| model.variables[*variable].name.as_str();
    let with = |first: &[&str], more: Vec<String>| {
        first.iter().map(|&own| own.to_owned()).chain(more).collect::<Vec<_>>()
    };
    let speeds = roles.propellers.iter().map(|n| format!("{0} |{0}|", name(n)));
    // Inputs of which nothing is known may drive.
    let inputs = 3..3 + model.inputs;
    let thrusts = roles.thrusts.iter().chain(roles.even.iter().filter(|own| inputs.contains(own)));
    let thrusts = thrusts.map(|own| name(own).to_owned());
    let rudders = roles.rudders.iter().map(|rudder| format!("u^2 {}", name(rudder)));
    let differences = roles.differences.iter().map(|difference| name(difference).to_owned());
    let surge = with(&["u", "u |u|"], speeds.chain(thrusts).collect());
    let (sway, yaw) = (with(&["v", "u r"], Vec::new()), with(&["r"], rudders.chain(differences).collect()));
    let degrees = [0, 1, 2].map(|_| Degree::default());
    let bare = Model { degrees, constant: [0.0; 3], forces: None, ..model.clone() };
    Ok((listed(&bare, [&surge, &sway, &yaw])?, roles))
}

/// The channels of propellers ahead and astern that are derived of those `reversing`, where none has these roles.
fn with_astern(model: &Model, mut roles: Roles, reversing: &[usize]) -> Result<(Model, Roles), Invalid> {
    let single: Vec<usize> =
        roles.propellers.iter().copied().filter(|propeller| reversing.contains(propeller)).collect();
    let apart = roles.ahead.iter().any(|own| !roles.propellers.contains(own)) || !roles.astern.is_empty();
    if single.is_empty() || apart {
        return Ok((model.clone(), roles));
    }
    let mut made = Made::new(model);
    roles.ahead.retain(|own| !single.contains(own));
    for propeller in single {
        let (name, unit) = (&model.variables[propeller].name, &model.variables[propeller].unit);
        let mut of = |what: &str, part: &str| {
            made.channel(format!("{name}_{what}"), unit.clone(), format!("{part}({name})"))
        };
        roles.ahead.push(of("ahead", "positive"));
        roles.astern.push(of("reverse", "negative"));
    }
    Ok((made.finish()?, roles))
}
