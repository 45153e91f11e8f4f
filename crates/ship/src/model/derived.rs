//! Channels that are computed from others, sample by sample: `[[derived]]` in `vessel.toml`.

use refusal::{Invalid, foreign, nearest};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::model::Formula;

/// A channel that is computed from others.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ModelDerived")]
pub struct DerivedSpec {
    /// Name as used in terms and as a column.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub formula: String,
}

/// A derived channel with its parsed formula.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivedChannel {
    /// Its index in [`crate::model::Model::variables`].
    pub variable: usize,
    /// Its formula.
    pub formula: Formula,
    /// The formula as written.
    pub text: String,
    /// Indices of [`Formula::channels`] in [`crate::model::Model::variables`]: inputs, measured disturbances, other
    /// derived channels.
    pub sources: Vec<usize>,
}

impl DerivedChannel {
    /// Its value in a row of inputs, measured disturbances and derived channels, where the sources are set.
    pub fn value(&self, row: &[f64]) -> f64 {
        self.formula.of(|channel| row[self.sources[channel] - 3])
    }

    /// Whether `found` is `expected` up to rounding.
    pub fn agrees(found: f64, expected: f64) -> bool {
        (found - expected).abs() <= 1e-9 * (found.abs() + expected.abs())
    }
}

/// The channels of `specs`, which are the variables from `first` on with these `names`, each after its
/// sources.
pub(crate) fn derive(
    specs: &[DerivedSpec],
    names: &[&str],
    first: usize,
) -> Result<Vec<DerivedChannel>, Invalid> {
    let one = |(i, spec): (usize, &DerivedSpec)| {
        let formula = Formula::parse(&spec.formula).map_err(|malformed| {
            let found = format!("`{}` with {malformed}", foreign(&spec.formula));
            let expected = "a product such as `positive(n)`, `n |n|` or `-1 wind^2 cos(gamma)`, or a sum such as `port - starboard`";
            refused(&spec.name, &found, expected, "write the formula again")
        })?;
        let sources = formula.channels.iter().map(|name| source(&spec.name, name, names));
        let sources = sources.collect::<Result<_, _>>()?;
        let text = spec.formula.split_whitespace().collect::<Vec<_>>().join(" ");
        Ok(DerivedChannel { variable: first + i, formula, text, sources })
    };
    ordered(specs.iter().enumerate().map(one).collect::<Result<_, _>>()?, names)
}

fn source(of: &str, name: &str, names: &[&str]) -> Result<usize, Invalid> {
    let place = names.iter().position(|known| *known == name);
    if let Some(place) = place.filter(|place| *place >= 3) {
        return Ok(place);
    }
    let known = &names[3..];
    let expected = format!("one of {}", known.join(", "));
    if place.is_some() {
        let remedy = "write the state into the terms that the channel is a factor of";
        return Err(refused(of, &format!("`{name}`, a state"), &expected, remedy));
    }
    let remedy = match nearest(name, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => "declare it as [[input]], [[measured]] or [[derived]]".to_owned(),
    };
    Err(refused(of, &format!("`{name}`, which is declared nowhere"), &expected, &remedy))
}

/// Orders the channels so that each follows its sources.
fn ordered(mut left: Vec<DerivedChannel>, names: &[&str]) -> Result<Vec<DerivedChannel>, Invalid> {
    let mut ordered = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let waits = |own: &DerivedChannel| left.iter().find(|other| own.sources.contains(&other.variable));
        match left.iter().position(|own| waits(own).is_none()) {
            Some(ready) => ordered.push(left.remove(ready)),
            None => return Err(circle(&left, names)),
        }
    }
    Ok(ordered)
}

/// The refusal of channels that all wait for another one: from any of them the dependencies lead into a
/// circle.
fn circle(waiting: &[DerivedChannel], names: &[&str]) -> Invalid {
    let name = |place: &usize| names[*place];
    let mut way: Vec<usize> = Vec::new();
    let mut at = waiting.first();
    while let Some(own) = at.filter(|own| !way.contains(&own.variable)) {
        way.push(own.variable);
        at = waiting.iter().find(|other| own.sources.contains(&other.variable));
    }
    let start = at.map_or(0, |own| own.variable);
    let names: Vec<&str> =
        way.iter().skip_while(|place| **place != start).chain([&start]).map(name).collect();
    let found = format!("a circle: {}", names.join(" from "));
    refused(names[0], &found, "channels that come from inputs and measured disturbances", "break the circle")
}

fn refused(name: &str, found: &str, expected: &str, remedy: &str) -> Invalid {
    Invalid::new(format!("`formula` of derived channel `{name}`"), found, expected, remedy)
}
