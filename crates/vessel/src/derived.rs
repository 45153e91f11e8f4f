//! Channels that are computed from others, sample by sample: `[[derived]]` in `vessel.toml`.

use serde::Deserialize;

use crate::{Formula, Invalid, Model, Variable, nearest};

/// A channel as written.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DerivedSpec {
    /// Name as used in terms and as a column.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it is, by inputs, measured disturbances and other derived channels; see [`Formula`].
    pub formula: String,
}

/// A channel that is computed from others.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivedChannel {
    /// Its place among [`Model::variables`].
    pub variable: usize,
    /// What it is.
    pub formula: Formula,
    /// The same as written.
    pub text: String,
    /// Places of [`Formula::channels`] among [`Model::variables`]: inputs, measured disturbances, other derived channels.
    pub sources: Vec<usize>,
}

impl DerivedChannel {
    /// Its value in a row of inputs, measured disturbances and derived channels, of which the sources are known.
    pub fn value(&self, row: &[f64]) -> f64 {
        self.formula.of(|channel| row[self.sources[channel] - 3])
    }

    /// Whether `found` is `expected` but for rounding.
    pub fn agrees(found: f64, expected: f64) -> bool {
        (found - expected).abs() <= 1e-9 * (found.abs() + expected.abs())
    }
}

/// The channels of `specs`, which stand among `variables` from place `first` on, each after those that it is computed from.
pub(crate) fn derive(
    specs: &[DerivedSpec],
    variables: &[Variable],
    first: usize,
) -> Result<Vec<DerivedChannel>, Invalid> {
    let one = |(i, spec): (usize, &DerivedSpec)| {
        let formula = Formula::parse(&spec.formula).map_err(|malformed| {
            let found = format!("`{}` with {malformed}", spec.formula);
            let expected = "a product such as `positive(n)`, `n |n|` or `-1 wind^2 cos(gamma)`";
            refused(&spec.name, &found, expected, "write the formula again")
        })?;
        let sources = formula.channels.iter().map(|name| source(&spec.name, name, variables));
        let sources = sources.collect::<Result<_, _>>()?;
        let text = spec.formula.split_whitespace().collect::<Vec<_>>().join(" ");
        Ok(DerivedChannel { variable: first + i, formula, text, sources })
    };
    ordered(specs.iter().enumerate().map(one).collect::<Result<_, _>>()?, variables)
}

fn source(of: &str, name: &str, variables: &[Variable]) -> Result<usize, Invalid> {
    let place = variables.iter().position(|v| v.name == name);
    if let Some(place) = place.filter(|place| *place >= 3) {
        return Ok(place);
    }
    let known: Vec<&str> = variables[3..].iter().map(|v| v.name.as_str()).collect();
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

/// Each after those that it is computed from.
fn ordered(mut left: Vec<DerivedChannel>, variables: &[Variable]) -> Result<Vec<DerivedChannel>, Invalid> {
    let mut ordered = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let waits = |own: &DerivedChannel| left.iter().find(|other| own.sources.contains(&other.variable));
        match left.iter().position(|own| waits(own).is_none()) {
            Some(ready) => ordered.push(left.remove(ready)),
            None => return Err(circle(&left, variables)),
        }
    }
    Ok(ordered)
}

/// Channels of which each waits for another one: from any of them the way leads into a circle.
fn circle(waiting: &[DerivedChannel], variables: &[Variable]) -> Invalid {
    let name = |place: &usize| variables[*place].name.as_str();
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

/// Where what acts on a model comes from if not from logs: inputs from a maneuver, measured disturbances as `simulated`,
/// derived channels by their formulas. Rows hold them in this order.
impl Model {
    /// Sets what follows the inputs in a row whose inputs are set, as in simulated trials.
    pub fn complete(&self, row: &mut [f64]) {
        for (variable, value) in &self.simulated {
            row[variable - 3] = *value;
        }
        self.derive(row);
    }

    /// Sets the derived channels of a row whose others are set.
    pub fn derive(&self, row: &mut [f64]) {
        for own in &self.derived {
            row[own.variable - 3] = own.value(row);
        }
    }

    /// Adds to the slopes by inputs and measured disturbances what goes by way of derived channels, at `row`. `slopes`: a row
    /// per variable, of so many quantities.
    pub fn by_sources<const N: usize>(&self, row: &[f64], slopes: &mut [[f64; N]]) {
        for own in self.derived.iter().rev() {
            let outer = slopes[own.variable];
            for (channel, source) in own.sources.iter().enumerate() {
                let inner = own.formula.slope(channel, |channel| row[own.sources[channel] - 3]);
                slopes[*source].iter_mut().zip(outer).for_each(|(slope, outer)| *slope += inner * outer);
            }
        }
    }

    /// Inputs, N × inputs, completed by what stands beside them in simulated trials: N × exogenous, row-major.
    pub fn undisturbed(&self, inputs: &[f64]) -> Vec<f64> {
        if self.exogenous() == self.inputs {
            return inputs.to_vec();
        }
        let mut rows = vec![0.0; inputs.len() / self.inputs.max(1) * self.exogenous()];
        for (row, own) in rows.chunks_exact_mut(self.exogenous()).zip(inputs.chunks_exact(self.inputs)) {
            row[..self.inputs].copy_from_slice(own);
            self.complete(row);
        }
        rows
    }

    /// Refuses a measured disturbance that no one said what it is in a simulated trial: to take it for zero would change the
    /// motion without a word.
    ///
    /// # Errors
    /// Names the first of them.
    pub fn check_simulated(&self) -> Result<(), Invalid> {
        let known = |variable: &usize| {
            self.simulated.contains_key(variable) || self.derived.iter().any(|own| own.variable == *variable)
        };
        match (3 + self.inputs..self.variables.len()).find(|variable| !known(variable)) {
            None => Ok(()),
            Some(variable) => Err(Invalid::new(
                format!("measured disturbance `{}` of the vessel", self.variables[variable].name),
                "nothing that says what it is in a simulated trial",
                "`simulated` in its [[measured]], or a [[derived]] channel",
                "add `simulated = 0.0` where trials are to be without it, or say by [[derived]] what it comes from",
            )),
        }
    }
}
