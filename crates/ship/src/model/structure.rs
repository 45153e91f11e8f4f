use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use refusal::Invalid;

use super::formula::derive;
use crate::forces::{Forces, Parameter};
use crate::model::{ChannelRole, DerivedChannel, DerivedSpec, Product, Term};

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
    /// What the vessel's file says that channels are, by index among the variables.
    pub roles: BTreeMap<usize, ChannelRole>,
    /// Channels that are computed from others, each after its sources.
    pub derived: Vec<DerivedChannel>,
    /// Surge, sway, yaw.
    pub degrees: [Degree; 3],
    /// Known increments of u, v \[m/s\] and r \[rad/s\] per sample that do not depend on the vessel; not parameters.
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
        self.forces.as_ref().map_or(&[], |model| model.forces.parameters())
    }

    /// Whether increments are linear in the parameters: sums of regressors, which `ls`, `iv` and instruments are made of.
    pub fn has_regressors(&self) -> bool {
        self.forces.is_none()
    }

    /// Length of the ship \[m\], where it is known.
    pub fn length_m(&self) -> Option<f64> {
        self.forces.as_ref().map(|model| model.forces.description().ship.length_m)
    }

    /// The standard deviation of each parameter's prior; `None` without one.
    pub fn prior_deviations(&self) -> Vec<Option<f64>> {
        let of_terms = self.degrees.iter().flat_map(|degree| degree.terms.iter().map(|_| None));
        of_terms.chain(self.free().iter().map(|parameter| parameter.prior)).collect()
    }

    /// Whether input `i` drives a propeller whose thrust law holds ahead only.
    pub fn is_ahead_only(&self, i: usize) -> bool {
        self.forces.as_ref().is_some_and(|model| model.forces.is_ahead_only(i))
    }

    /// Whether an input acts late with the parameters `theta`, by a dead time.
    pub fn has_dead_time(&self, theta: &[f64]) -> bool {
        self.forces.as_ref().is_some_and(|model| model.forces.has_dead_time(theta))
    }

    /// Whether a thruster or rudder of its own describes the lag of input `i`.
    pub fn has_own_lag(&self, i: usize, theta: &[f64]) -> bool {
        let driven =
            |model: &Arc<ForceModel>| model.forces.lags(theta).iter().any(|(driven, _)| *driven == i);
        self.forces.as_ref().is_some_and(driven)
    }

    /// The measured disturbances.
    pub fn measured(&self) -> &[Variable] {
        &self.variables[3 + self.inputs..self.variables.len() - self.derived.len()]
    }

    /// The terms whose parameters are known, with their degrees of freedom.
    pub fn known(&self) -> impl Iterator<Item = (usize, &Product)> {
        self.degrees
            .iter()
            .enumerate()
            .flat_map(|(d, degree)| degree.known.iter().map(move |product| (d, product)))
    }

    /// The bounds of all parameters, infinite where there are none; `None` without any.
    pub fn bounds(&self) -> Option<Vec<[f64; 2]>> {
        if let Some(model) = &self.forces {
            let all: Vec<[f64; 2]> =
                model.forces.parameters().iter().map(|parameter| parameter.bounds).collect();
            return Some(all).filter(|all| all.iter().any(|bounds| *bounds != OPEN));
        }
        let bounded = self.degrees.iter().any(|degree| !degree.bounds.is_empty());
        bounded.then(|| {
            let bounds = |degree: &Degree, i: usize| degree.bounds.get(&i).copied().unwrap_or(OPEN);
            self.degrees
                .iter()
                .flat_map(|degree| (0..degree.terms.len()).map(move |i| bounds(degree, i)))
                .collect()
        })
    }

    /// Names of all parameters: surge, sway, yaw.
    pub fn parameter_names(&self) -> impl Iterator<Item = &str> {
        let free = self.free().iter().map(|parameter| parameter.name.as_str());
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
        let free = self.free().iter().map(|parameter| parameter.unit.clone());
        DegreeOfFreedom::ALL.into_iter().zip(&self.degrees).flat_map(of).chain(free).collect()
    }
}

/// The order of a model's parameters: those of surge, sway and yaw, each followed by that degree of freedom's
/// intercept if the model has intercepts ([`Model::with_intercepts`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterLayout {
    /// Terms of surge, sway and yaw, without intercepts.
    terms: [usize; 3],
    /// Which of them have an intercept.
    intercepts: [bool; 3],
    /// Which of them have the term 1 instead.
    constants: [bool; 3],
}

impl Model {
    /// The same model with the constant 1 as one more term of every degree of freedom that has none; its
    /// parameter is the intercept, the state's constant increment per sample beyond the known one.
    pub fn with_intercepts(&self) -> Self {
        let mut model = self.clone();
        for degree in model.degrees.iter_mut().filter(|degree| degree.constant().is_none()) {
            degree.parameters.push("intercept".to_owned());
            degree.terms.push(Term::constant());
            degree.intercept = true;
        }
        model
    }

    /// The order of its parameters.
    pub fn layout(&self) -> ParameterLayout {
        if self.forces.is_some() {
            // Parameters of forces belong to no one degree of freedom; they are in order, and no intercepts are among them.
            let terms = [self.parameters(), 0, 0];
            return ParameterLayout { terms, intercepts: [false; 3], constants: [true; 3] };
        }
        ParameterLayout {
            terms: self.degrees.each_ref().map(|degree| degree.terms.len() - usize::from(degree.intercept)),
            intercepts: self.degrees.each_ref().map(|degree| degree.intercept),
            constants: self.degrees.each_ref().map(|degree| !degree.intercept && degree.constant().is_some()),
        }
    }
}

impl ParameterLayout {
    /// The same with intercepts, where there is no term 1.
    pub fn with_intercepts(self) -> Self {
        Self { intercepts: self.constants.map(|constant| !constant), ..self }
    }

    /// Whether there are intercepts.
    pub fn has_intercepts(self) -> bool {
        self.intercepts.contains(&true)
    }

    /// Number of parameters, including intercepts.
    pub fn parameters(self) -> usize {
        self.degree(2).end
    }

    /// Indices of the parameters of degree of freedom `d` that belong to terms.
    pub fn terms(self, d: usize) -> Range<usize> {
        let before = self.intercepts[..d].iter().filter(|intercept| **intercept).count();
        let first = self.terms[..d].iter().sum::<usize>() + before;
        first..first + self.terms[d]
    }

    /// Indices of all parameters of degree of freedom `d`; its intercept is the last.
    pub fn degree(self, d: usize) -> Range<usize> {
        let terms = self.terms(d);
        terms.start..terms.end + usize::from(self.intercepts[d])
    }

    /// The degree of freedom of every parameter.
    pub fn degrees(self) -> impl Iterator<Item = usize> {
        (0..3).flat_map(move |d| self.degree(d).map(move |_| d))
    }

    /// Whether every parameter is an intercept.
    pub fn are_intercepts(self) -> impl Iterator<Item = bool> {
        (0..3).flat_map(move |d| self.degree(d).map(move |i| i == self.terms(d).end))
    }

    /// Parameters in this order from those of the terms (surge, sway, yaw) and the `intercepts`, which are
    /// ignored if there are none.
    pub fn woven(self, theta: &[f64], intercepts: [f64; 3]) -> Vec<f64> {
        let mut theta = theta.iter();
        let mut next = |(intercept, d): (bool, usize)| match intercept {
            true => Some(intercepts[d]),
            false => theta.next().copied(),
        };
        self.are_intercepts().zip(self.degrees()).map_while(&mut next).collect()
    }

    /// The terms' parameters alone: surge, sway, yaw.
    pub fn theta<T: Copy>(self, parameters: &[T]) -> Vec<T> {
        let all = parameters.iter().zip(self.are_intercepts());
        all.filter_map(|(parameter, intercept)| (!intercept).then_some(*parameter)).collect()
    }

    /// The intercepts alone; zero where there are none.
    pub fn intercepts(self, parameters: &[f64]) -> [f64; 3] {
        [0, 1, 2].map(|d: usize| if self.intercepts[d] { parameters[self.terms(d).end] } else { 0.0 })
    }
}

/// The exogenous inputs of a model where there are no logs: inputs from a maneuver, measured disturbances as
/// `simulated`, derived channels by their formulas. Rows hold them in this order.
impl Model {
    /// Sets the disturbances and derived channels of a row whose inputs are set, as in simulated trials.
    pub fn complete(&self, row: &mut [f64]) {
        for (variable, value) in &self.simulated {
            row[variable - 3] = *value;
        }
        self.derive(row);
    }

    /// Sets the derived channels of a row whose other channels are set.
    pub fn derive(&self, row: &mut [f64]) {
        for channel in &self.derived {
            row[channel.variable - 3] = channel.value(row);
        }
    }

    /// Adds to the derivatives by inputs and measured disturbances the part by way of derived channels, at
    /// `row`. `slopes`: a row per variable, of `N` quantities.
    pub fn by_sources<const N: usize>(&self, row: &[f64], slopes: &mut [[f64; N]]) {
        for derived in self.derived.iter().rev() {
            let outer = slopes[derived.variable];
            for (channel, source) in derived.sources.iter().enumerate() {
                let inner = derived.formula.slope(channel, |channel| row[derived.sources[channel] - 3]);
                slopes[*source].iter_mut().zip(outer).for_each(|(slope, outer)| *slope += inner * outer);
            }
        }
    }

    /// Inputs, N × inputs, completed by the other channels of simulated trials: N × exogenous, row-major.
    pub fn undisturbed(&self, inputs: &[f64]) -> Vec<f64> {
        if self.exogenous() == self.inputs {
            return inputs.to_vec();
        }
        let mut rows = vec![0.0; inputs.len() / self.inputs.max(1) * self.exogenous()];
        for (row, settings) in rows.chunks_exact_mut(self.exogenous()).zip(inputs.chunks_exact(self.inputs)) {
            row[..self.inputs].copy_from_slice(settings);
            self.complete(row);
        }
        rows
    }

    /// The inputs of N × exogenous rows, row-major: N × inputs.
    pub fn inputs_of(&self, rows: &[f64]) -> Vec<f64> {
        let rows = rows.chunks_exact(self.exogenous().max(1));
        rows.flat_map(|row| row[..self.inputs].iter().copied()).collect()
    }

    /// Refuses a measured disturbance without a value for simulated trials: taking it as zero would silently change the motion.
    ///
    /// # Errors
    /// Names the first of them.
    pub fn check_simulated(&self) -> Result<(), Invalid> {
        let known = |variable: &usize| {
            self.simulated.contains_key(variable)
                || self.derived.iter().any(|channel| channel.variable == *variable)
        };
        match (3 + self.inputs..self.variables.len()).find(|variable| !known(variable)) {
            None => Ok(()),
            Some(variable) => Err(Invalid::new(
                format!("measured disturbance `{}` of the vessel", self.variables[variable].name),
                "no value for simulated trials",
                "`simulated` in its [[measured]], or a [[derived]] channel",
                "add `simulated = 0.0` if simulated trials have none of it, or compute it by [[derived]]",
            )),
        }
    }

    /// The refusal of the role of `variable`.
    pub fn refused_role(&self, variable: usize, found: String, expected: &str, remedy: &str) -> Invalid {
        let table = match variable.checked_sub(3 + self.inputs) {
            None => "input",
            Some(i) if i < self.measured().len() => "measured",
            Some(_) => "derived",
        };
        Invalid::new(format!("{table} `{}`, `role`", self.variables[variable].name), found, expected, remedy)
    }

    /// Refuses roles that their channels cannot have.
    pub(crate) fn check_roles(&self) -> Result<(), Invalid> {
        let of = |role: ChannelRole| {
            let stated = self.roles.iter().filter(move |(_, stated)| **stated == role);
            stated.map(|(i, _)| (*i, &self.variables[*i])).collect::<Vec<_>>()
        };
        let from = of(ChannelRole::WindFrom);
        for several in [&of(ChannelRole::Wind), &from] {
            if let [(_, first), (i, _), ..] = several[..] {
                let twice = format!("`{}`, which `{}` is too", self.roles[&i], first.name);
                return Err(self.refused_role(i, twice, "one channel of it", "remove one of them"));
            }
        }
        if let Some((i, angle)) = from.iter().find(|(_, angle)| angle.unit != "rad") {
            let given = format!("`wind-from` in `{}`", angle.unit);
            return Err(self.refused_role(*i, given, "an angle in `rad`", "log it in radians"));
        }
        let (port, starboard) = (of(ChannelRole::Port), of(ChannelRole::Starboard));
        let paired = port.len().min(starboard.len());
        if let Some((i, _)) = port.get(paired).or(starboard.get(paired)) {
            let alone = format!("`{}` without a thruster on the other side", self.roles[i]);
            let expected = "as many `port` as `starboard`, in the same order";
            return Err(self.refused_role(*i, alone, expected, "state the other side, too"));
        }
        let differ = port.iter().zip(&starboard).find(|((_, one), (_, other))| one.unit != other.unit);
        differ.map_or(Ok(()), |((_, one), (i, other))| {
            let units =
                format!("`starboard` in `{}`, and its pair `{}` in `{}`", other.unit, one.name, one.unit);
            Err(self.refused_role(*i, units, "one unit", "state both in the same unit"))
        })
    }

    /// The model with the channels of `specs` after its own.
    ///
    /// # Errors
    /// A formula that cannot be parsed, or of channels that the model does not have.
    pub fn with_derived(&self, specs: &[DerivedSpec]) -> Result<Self, Invalid> {
        let mut model = self.clone();
        let variable = |spec: &DerivedSpec| Variable { name: spec.name.clone(), unit: spec.unit.clone() };
        model.variables.extend(specs.iter().map(variable));
        let names: Vec<&str> = model.variables.iter().map(|variable| variable.name.as_str()).collect();
        model.derived.extend(derive(specs, &names, self.variables.len())?);
        Ok(model)
    }
}

/// Forces that move a ship from sample to sample.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceModel {
    /// The forces.
    pub forces: Forces,
    /// From one sample to the next \[s\].
    pub sample_s: f64,
}

/// How a sample follows from the steps that the terms hold for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RateChange {
    /// It is one.
    #[default]
    Own,
    /// It is as many, one after the other.
    Repeated(u32),
    /// It is a part of one, by Newton's forward formula.
    Divided {
        /// How many samples make a step.
        by: u32,
        /// Order of the formula: how many steps ahead it looks.
        order: u32,
    },
}

/// The order of Newton's forward formula.
pub const ORDER: u32 = 4;

impl RateChange {
    /// The weights of the states after one, two, … steps; what they lack in 1 is that of the state before the first. Sums of
    /// differences Δᵏ of the states times s (s − 1) … (s − k + 1) / k!, where s is a part of a step.
    pub fn weights(self) -> Vec<f64> {
        match self {
            Self::Own => vec![1.0],
            Self::Repeated(count) => (1..=count).map(|step| f64::from(u8::from(step == count))).collect(),
            Self::Divided { by, order } => {
                let mut weights = vec![0.0; order as usize + 1];
                let part = 1.0 / f64::from(by);
                let mut factor = 1.0;
                for k in 0..=order {
                    // Δᵏ is the sum of (−1)^(k − j) (k over j) times state j.
                    let mut share = factor * if k % 2 == 0 { 1.0 } else { -1.0 };
                    for j in 0..=k {
                        weights[j as usize] += share;
                        share *= -f64::from(k - j) / f64::from(j + 1);
                    }
                    factor *= (part - f64::from(k)) / f64::from(k + 1);
                }
                weights.split_off(1)
            }
        }
    }
}
