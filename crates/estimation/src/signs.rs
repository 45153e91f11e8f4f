//! Estimates whose sign is not that of the nominal value, and the channel whose sign explains them.

use refusal::listed;
use ship::model::Model;

/// Standard errors that an estimate must be away from zero for its sign to count …
const FAR: f64 = 5.0;

/// … and those that the nominal value must be away from it.
const NOMINAL: f64 = 3.0;

/// Estimates on the other side of zero than their `nominal` values, in words; `found` are those of the parameters of `model`
/// with their standard errors, where both are known.
pub fn against_nominal(model: &Model, nominal: &[f64], found: &[Option<[f64; 2]>]) -> Option<String> {
    let parameters = model.parameter_names().zip(nominal).zip(found).enumerate();
    let known = parameters.filter_map(|(i, ((name, nominal), found))| Some((i, name, *nominal, (*found)?)));
    let counted: Vec<_> = known
        .filter(|(.., nominal, [estimate, error])| {
            *error > 0.0 && estimate.abs() > FAR * error && nominal.abs() > NOMINAL * error
        })
        .collect();
    let is_turned = |(.., nominal, [estimate, _]): &(usize, &str, f64, [f64; 2])| estimate * nominal < 0.0;
    let turned = counted.iter().filter(|own| is_turned(own));
    let all: Vec<String> = turned
        .map(|(_, name, nominal, [estimate, error])| {
            format!("`{name}` {estimate:.3e} ± {error:.1e}, nominal {nominal:.3e}")
        })
        .collect();
    let terms: Vec<_> =
        (0..).zip(&model.degrees).flat_map(|(d, own)| own.terms.iter().map(move |term| (d, term))).collect();
    // Whether a turn of the sign of `variable` turns parameter `i`.
    let turns = |variable: usize, i: usize| {
        terms.get(i).is_some_and(|(d, term)| {
            let factors = term.factors.iter().filter(|own| own.variable == variable && !own.modulus).count();
            (factors + usize::from(*d == variable)) % 2 == 1
        })
    };
    let explains = |variable: &usize| {
        let own = || counted.iter().filter(|(i, ..)| turns(*variable, *i));
        own().all(is_turned) && 2 * own().count() > all.len()
    };
    let variables = (3..model.variables.len() - model.derived.len()).chain(0..3);
    let cause = variables.into_iter().find(explains).map_or(String::new(), |variable| {
        let name = &model.variables[variable].name;
        let channel = if variable < 3 { format!("y_{name}") } else { name.clone() };
        format!(
            "; all that `{name}` has a part in turned: its sensor may count to the other side; compare `{channel}` with the motion, \
             and set `sign = -1` of that channel in ingest.toml if so"
        )
    });
    let listed = listed(&all);
    (!all.is_empty()).then(|| format!("estimates with another sign than the nominal value: {listed}{cause}"))
}
