use crate::search::made::Made;
use crate::search::roles::Roles;

/// Adds the roles of the sums and differences of pairs of thrusters: of thrusts their sum and difference; of
/// propeller speeds n the sum, and the sum and difference of n |n|, to which thrusts are proportional.
pub(crate) fn with_pairs(made: &mut Made, mut roles: Roles) -> Roles {
    for [port, starboard] in roles.pairs.clone() {
        let [p, s] = [port, starboard].map(|variable| made.model.variables[variable].name.as_str());
        let unit = made.model.variables[port].unit.as_str();
        let named = |what: &str| format!("{p}_{what}_{s}");
        let sum = made.channel(named("plus"), unit.to_owned(), format!("{p} + {s}"));
        if unit.ends_with('N') {
            let difference = made.channel(named("minus"), unit.to_owned(), format!("{p} - {s}"));
            roles.thrusts.push(sum);
            roles.differences.push(difference);
        } else {
            let square = format!("({unit})^2");
            let [together, against] = [("pushes_with", "+"), ("pushes_against", "-")].map(|(what, sign)| {
                made.channel(named(what), square.clone(), format!("{p} |{p}| {sign} {s} |{s}|"))
            });
            roles.propellers.push(sum);
            roles.even.push(together);
            roles.differences.push(against);
        }
    }
    if roles.ahead.is_empty() && roles.astern.is_empty() {
        roles.ahead.clone_from(&roles.propellers);
    }
    roles
}
