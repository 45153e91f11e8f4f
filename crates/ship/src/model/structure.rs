use std::collections::BTreeMap;
use std::sync::Arc;

use crate::forces::Parameter;

use crate::model::{DerivedChannel, ForceModel, Product, RateChange, Term};

/// Surge, sway or yaw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DegreeOfFreedom {
    /// Along x, forward.
    Surge,
    /// Along y, to starboard.
    Sway,
    /// About z, bow to starboard.
    Yaw,
}

impl DegreeOfFreedom {
    /// All three, in the order of the states.
    pub const ALL: [Self; 3] = [Self::Surge, Self::Sway, Self::Yaw];

    /// `surge`, `sway` or `yaw`.
    pub fn name(self) -> &'static str {
        ["surge", "sway", "yaw"][self as usize]
    }

    /// The state's name: `u`, `v` or `r`.
    pub fn state(self) -> &'static str {
        ["u", "v", "r"][self as usize]
    }

    /// The state's unit.
    pub fn unit(self) -> &'static str {
        ["m/s", "m/s", "rad/s"][self as usize]
    }
}

/// A variable of the model: a state, an input, a measured disturbance or a derived channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    /// Name as used in terms.
    pub name: String,
    /// Its unit.
    pub unit: String,
}

/// The regressors φ_d of one degree of freedom, with the names of their parameters θ_d.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Degree {
    /// Names of the parameters.
    pub parameters: Vec<String>,
    /// One term per parameter.
    pub terms: Vec<Term>,
    /// Terms with known parameters: they act, and are not estimated.
    pub known: Vec<Product>,
    /// Bounds of estimates, by index of the parameter; infinite at an open end.
    pub bounds: BTreeMap<usize, [f64; 2]>,
    /// Whether the last term is an intercept, see [`Model::with_intercepts`].
    pub intercept: bool,
}

impl Degree {
    /// `terms` and the names of their `parameters`.
    pub fn new(parameters: Vec<String>, terms: Vec<Term>) -> Self {
        Self { parameters, terms, ..Self::default() }
    }

    /// Whether the estimate `value` of parameter `i` lies at a bound.
    pub fn at_bound(&self, i: usize, value: f64) -> bool {
        self.bounds.get(&i).is_some_and(|bounds| bounds.contains(&value))
    }

    /// The index of the term 1, whose parameter is the intercept of this degree of freedom.
    pub fn constant(&self) -> Option<usize> {
        self.terms.iter().position(Term::is_constant)
    }
}

/// The bounds of a parameter that has none.
const OPEN: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// A model structure: the regressors of the states' increments.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// `u`, `v`, `r`, then the inputs, then the measured disturbances, then the derived channels.
    pub variables: Vec<Variable>,
    /// How many of the variables are inputs.
    pub inputs: usize,
    /// Values of measured disturbances in simulated trials, by index among the variables.
    pub simulated: BTreeMap<usize, f64>,
    /// Channels that are computed from others, each after its sources.
    pub derived: Vec<DerivedChannel>,
    /// Surge, sway, yaw.
    pub degrees: [Degree; 3],
    /// Known increments of u, v \[m/s\] and r \[rad/s\] per sample that do not depend on the vessel; not
    /// parameters.
    pub constant: [f64; 3],
    /// Forces in continuous time, in place of terms and constants: then the degrees of freedom have none.
    pub forces: Option<Arc<ForceModel>>,
    /// How a sample follows from the steps that the terms hold for.
    pub pace: RateChange,
}

impl Model {
    /// The inputs, which follow the states among the variables.
    pub fn input_variables(&self) -> &[Variable] {
        &self.variables[3..3 + self.inputs]
    }

    /// The inputs' names.
    pub fn input_names(&self) -> Vec<&str> {
        self.input_variables().iter().map(|v| v.name.as_str()).collect()
    }

    /// Number of inputs, measured disturbances and derived channels.
    pub fn exogenous(&self) -> usize {
        self.variables.len() - 3
    }

    /// Number of parameters of all degrees of freedom.
    pub fn parameters(&self) -> usize {
        self.degrees.iter().map(|d| d.terms.len()).sum::<usize>() + self.free().len()
    }

    /// The free parameters of its forces; none of terms per sample.
    fn free(&self) -> &[Parameter] {
        self.forces.as_ref().map_or(&[], |own| own.forces.parameters())
    }

    /// The measured disturbances.
    pub fn measured(&self) -> &[Variable] {
        &self.variables[3 + self.inputs..self.variables.len() - self.derived.len()]
    }

    /// The terms whose parameters are known, with their degrees of freedom.
    pub fn known(&self) -> impl Iterator<Item = (usize, &Product)> {
        self.degrees.iter().enumerate().flat_map(|(d, degree)| degree.known.iter().map(move |own| (d, own)))
    }

    /// The bounds of all parameters, infinite where there are none; `None` without any.
    pub fn bounds(&self) -> Option<Vec<[f64; 2]>> {
        if let Some(own) = &self.forces {
            let all: Vec<[f64; 2]> = own.forces.parameters().iter().map(|own| own.bounds).collect();
            return Some(all).filter(|all| all.iter().any(|own| *own != OPEN));
        }
        let bounded = self.degrees.iter().any(|degree| !degree.bounds.is_empty());
        bounded.then(|| {
            let own = |degree: &Degree, i: usize| degree.bounds.get(&i).copied().unwrap_or(OPEN);
            self.degrees
                .iter()
                .flat_map(|degree| (0..degree.terms.len()).map(move |i| own(degree, i)))
                .collect()
        })
    }

    /// Names of all parameters: surge, sway, yaw.
    pub fn parameter_names(&self) -> impl Iterator<Item = &str> {
        let free = self.free().iter().map(|own| own.name.as_str());
        self.degrees.iter().flat_map(|d| d.parameters.iter().map(String::as_str)).chain(free)
    }

    /// The unit of the parameter of `term` in the equation of `degree`.
    pub fn unit(&self, degree: DegreeOfFreedom, term: &Term) -> String {
        let units: Vec<&str> =
            term.factors.iter().map(|f| self.variables[f.variable].unit.as_str()).collect();
        match units.is_empty() {
            true => degree.unit().to_owned(),
            false => format!("{} per ({})", degree.unit(), units.join(" × ")),
        }
    }

    /// Units of all parameters, such as `m/s per N`.
    pub fn parameter_units(&self) -> Vec<String> {
        let of = |(d, degree): (DegreeOfFreedom, &Degree)| {
            degree.terms.iter().map(|term| self.unit(d, term)).collect::<Vec<_>>()
        };
        let free = self.free().iter().map(|own| own.unit.clone());
        DegreeOfFreedom::ALL.into_iter().zip(&self.degrees).flat_map(of).chain(free).collect()
    }
}
