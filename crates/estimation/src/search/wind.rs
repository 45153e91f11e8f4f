use crate::search::made::Made;
use crate::search::roles::Roles;

/// Channels that the library derives from the relative wind's speed W and the angle γ that it comes from: name, the
/// powers of cos γ and sin γ that multiply the square of W, and whether a reflection between port and starboard
/// leaves it unchanged. They span all harmonics of γ up to the third: cos 2γ is 2 cos² γ − 1, and so on.
const PRODUCTS: [(&str, i32, i32, bool); 7] = [
    ("square", 0, 0, true),
    ("cos", 1, 0, true),
    ("sin", 0, 1, false),
    ("cos_2", 2, 0, true),
    ("cos_sin", 1, 1, false),
    ("cos_3", 3, 0, true),
    ("sin_3", 0, 3, false),
];

/// Adds the roles of the channels derived from the wind, if there is one. A channel that the model has already, up to
/// a factor, is not derived again.
pub(crate) fn with_wind(made: &mut Made, mut roles: Roles) -> Roles {
    let (Some(wind), Some(from)) = (roles.wind, roles.wind_from) else { return roles };
    let [wind, from] = [wind, from].map(|variable| &made.model.variables[variable]);
    for (called, cosines, sines, even) in PRODUCTS {
        let factor = |function: &str, power: i32| match power {
            0 => String::new(),
            1 => format!(" {function}({})", from.name),
            _ => format!(" {function}({})^{power}", from.name),
        };
        let formula = format!("{}^2{}{}", wind.name, factor("cos", cosines), factor("sin", sines));
        if made.computes(&formula) {
            continue;
        }
        let (name, unit) = (format!("{}_{called}", wind.name), format!("({})^2", wind.unit));
        let side = if even { &mut roles.even } else { &mut roles.odd };
        side.push(made.channel(name, unit, formula));
    }
    roles
}
