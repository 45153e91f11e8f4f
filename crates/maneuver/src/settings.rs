use refusal::Invalid;
use ship::model::Vessel;

/// Refuses inputs beyond the vessel's range, which `what` requires.
pub(super) fn check_range(vessel: &Vessel, inputs: &[f64], what: impl Fn() -> String) -> Result<(), Invalid> {
    vessel.check_helm(inputs, &what)?;
    let Some((i, [low, high])) = vessel.beyond_range(inputs) else { return Ok(()) };
    let variable = &vessel.model.input_variables()[i];
    let (from, remedy) = match vessel.motion {
        None => ("its `range` in the vessel's file", "correct the range"),
        Some(_) => ("about what the logs of the model cover", "allow more with --beyond-range"),
    };
    if inputs[i] < low && vessel.model.forces.as_ref().is_some_and(|own| own.forces.is_ahead_only(i)) {
        return Err(Invalid::new(
            what(),
            format!("{} = {} {}", variable.name, inputs[i], variable.unit),
            format!("a setting from {low} to {high}: the propeller's thrust law holds ahead only"),
            "leave it out, or give the propeller coefficients `astern`",
        ));
    }
    Err(Invalid::new(
        what(),
        format!("{} = {} {}", variable.name, inputs[i], variable.unit),
        format!("a setting from {low} to {high}, {from}"),
        format!("lower speeds and yaw rates, or {remedy}"),
    ))
}
