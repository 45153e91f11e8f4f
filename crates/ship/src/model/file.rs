use std::collections::BTreeMap;

use refusal::{Invalid, check_bounds, check_name, foreign};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::formula::derive;
use crate::forces::{Forces, TermSpec};
use crate::model::equation::{Equation, Parts};
use crate::model::physics::{self, CandidateTerms, Kind, VesselFile, missing, moved, preset};
use crate::model::{
    Actuator, ChannelRole, Constrained, DegreeOfFreedom, InputSpec, Model, RateChange, Term, Unusual,
    Variable, Written,
};

/// Which of the two parameter sets is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// The true values.
    #[default]
    Value,
    /// The nominal values.
    Nominal,
}

impl Source {
    /// Both of them.
    pub const ALL: [Self; 2] = [Self::Value, Self::Nominal];

    /// As in files and on the command line.
    pub fn name(self) -> &'static str {
        ["value", "nominal"][self as usize]
    }
}

/// A vessel: structure, true and nominal parameters. Valid by construction. The model's parameters are the
/// estimated ones; fixed parameters act as known terms, and tied ones are part of another parameter's term.
#[derive(Clone, Debug, PartialEq)]
pub struct Vessel {
    /// Its name.
    pub name: String,
    /// Sampling rate \[Hz\].
    pub sample_rate_hz: f64,
    /// The model structure.
    pub model: Model,
    /// True parameters, if known.
    pub value: Vec<Option<f64>>,
    /// Nominal parameters.
    pub nominal: Vec<f64>,
    /// Per input, the input that it follows and the factor.
    pub couplings: Vec<Option<(usize, f64)>>,
    /// The actuator of each input.
    pub actuators: Vec<Actuator>,
    /// Fixed and tied parameters, in the order of the file.
    pub constrained: Vec<Constrained>,
    /// Ranges of u, v \[m/s\] and r \[rad/s\] that maneuvers must keep to, from the logs that a model was
    /// fitted to; `None` where maneuvers are not limited.
    pub motion: Option<[[f64; 2]; 3]>,
    /// Whether what is unusual of ships passes.
    pub accepts_unusual: bool,
    /// What a search tries in place of its library.
    pub candidates: Option<CandidateTerms>,
}

impl VesselFile {
    /// Whether forces describe the ship, here or in her preset; not where it is refused.
    pub fn is_of_forces(&self) -> bool {
        Vessel::from_file(self.clone()).is_ok_and(|vessel| vessel.model.forces.is_some())
    }
}

impl Vessel {
    /// Checks a file's content.
    ///
    /// # Errors
    /// The first key or name that is missing, unknown or duplicate, or number that is not finite.
    pub fn from_file(file: VesselFile) -> Result<Self, Invalid> {
        let file = match file.preset {
            Some(_) => preset(file)?,
            None => file,
        };
        check_bounds(&file)?;
        let rate = file.sample_rate_hz.ok_or_else(|| missing("sample_rate_hz"))?;
        let variables = variables(&file)?;
        let couplings = couplings(&file.input)?;
        let mut actuators = file.input.iter().map(Actuator::new).collect::<Result<Vec<_>, _>>()?;
        let (forces, parts) = match file.model.unwrap_or(Kind::PerSample) {
            Kind::Forces => {
                let (moved, parts) = moved(&file, &variables, &mut actuators)?;
                (Some(moved), parts)
            }
            Kind::PerSample => (None, parts_per_sample(&file, &variables)?),
        };
        let Parts { degrees, value, nominal, constrained } = parts;
        let name = file.name.clone().ok_or_else(|| missing("name"))?;
        check_name("`name` of the vessel", &name)?;
        let names: Vec<&str> = variables.iter().map(|v| v.name.as_str()).collect();
        let derived = derive(&file.derived, &names, first_derived(&file))?;
        let (simulated, roles) = (simulated(&file), roles(&file));
        let inputs = file.input.len();
        let (constant, pace) = (file.constant, RateChange::Own);
        let model = Model { variables, inputs, simulated, roles, derived, degrees, constant, forces, pace };
        model.check_roles()?;
        let vessel = Self {
            name,
            sample_rate_hz: rate,
            model,
            value,
            nominal,
            couplings,
            actuators,
            constrained,
            motion: None,
            accepts_unusual: file.unusual.is_some() || file.fitted,
            candidates: file.candidates,
        };
        vessel.check_rudders()?;
        Ok(vessel)
    }

    /// One of the built-in vessels, by name.
    ///
    /// # Errors
    /// An unknown name.
    pub fn preset(name: &str) -> Result<Self, Invalid> {
        Self::from_file(VesselFile { preset: Some(name.to_owned()), ..VesselFile::default() })
    }

    /// Refuses a ship with forces: `what` computes with products of terms per sample. A caller that knows what takes her
    /// instead puts that into the remedy.
    ///
    /// # Errors
    /// Names `what`.
    pub fn check_terms(&self, what: &str) -> Result<(), Invalid> {
        if self.model.has_regressors() {
            return Ok(());
        }
        Err(Invalid::new(
            "`model`",
            "`forces`, which have no terms per sample",
            format!("terms per sample, with whose products `{what}` computes"),
            "give it a vessel with terms per sample",
        ))
    }

    /// Whether her parameters are known by priors alone: none has a true value.
    pub fn is_guess(&self) -> bool {
        self.model.prior_deviations().iter().any(Option::is_some) && self.value.iter().all(Option::is_none)
    }

    /// The true values where every parameter has one, else the nominal ones.
    pub fn best_known(&self) -> Source {
        if self.value.iter().all(Option::is_some) { Source::Value } else { Source::Nominal }
    }

    /// The parameters of `source`.
    ///
    /// # Errors
    /// A parameter without a true value.
    pub fn parameters(&self, source: Source) -> Result<Vec<f64>, Invalid> {
        if source == Source::Nominal {
            return Ok(self.nominal.clone());
        }
        let known = |(value, name): (&Option<f64>, &str)| {
            value.ok_or_else(|| {
                Invalid::new(
                    format!("parameter `{name}`"),
                    "no `value`",
                    "a true value, which a simulated trial follows",
                    "add `value`, or simulate the nominal model",
                )
            })
        };
        self.value.iter().zip(self.model.parameter_names()).map(known).collect()
    }

    /// The parameters of degree of freedom `d` in the order of the file.
    pub fn written(&self, d: DegreeOfFreedom) -> Vec<Written<'_>> {
        let mut all: Vec<Written> = self.model.layout().degree(d as usize).map(Written::Estimated).collect();
        for parameter in self.constrained.iter().filter(|parameter| parameter.degree == d) {
            all.insert(parameter.place, Written::Constrained(parameter));
        }
        all
    }

    /// Whether there are enough inputs to command surge, sway and yaw independently.
    pub fn commands_sway(&self) -> bool {
        self.model.inputs >= 3
    }

    /// The first of `inputs` that exceeds its range by more than rounding: its index and the range.
    pub fn beyond_range(&self, inputs: &[f64]) -> Option<(usize, [f64; 2])> {
        let beyond = |(i, (input, actuator)): (usize, (&f64, &Actuator))| {
            let [low, high] = actuator.range?;
            let rounding = 1e-9 * (high - low);
            (!(low - rounding..=high + rounding).contains(input)).then_some((i, [low, high]))
        };
        inputs.iter().zip(&self.actuators).enumerate().find_map(beyond)
    }

    /// Which of u, v, r leaves its range in `states`, rows of three, by most of its width: its index, and the extreme value.
    pub fn beyond_motion(&self, states: &[f64]) -> Option<(usize, f64)> {
        let ranges = self.motion?;
        let beyond = |(d, state): (usize, &f64)| {
            let [low, high] = ranges[d];
            let share = (low - state).max(state - high) / (high - low).max(f64::MIN_POSITIVE);
            (share > 0.0).then_some((d, *state, share))
        };
        let all =
            states.as_chunks::<3>().0.iter().flat_map(|state| state.iter().enumerate().filter_map(beyond));
        let most = all.max_by(|a, b| a.2.total_cmp(&b.2));
        most.map(|(d, state, _)| (d, state))
    }

    /// Number of samples in `duration_s`, to the nearest.
    pub fn samples(&self, duration_s: f64) -> usize {
        (duration_s * self.sample_rate_hz).round() as usize
    }
}

/// Those of terms per sample.
fn parts_per_sample(file: &VesselFile, variables: &[Variable]) -> Result<Parts, Invalid> {
    physics::check_absent(file)?;
    let (written, terms) = (replaced(file)?, terms(file, variables)?);
    check_parameters(&written)?;
    let (all, mut terms) = (written.iter().flatten().collect::<Vec<_>>(), terms.into_iter());
    let mut parts = Parts::default();
    for d in DegreeOfFreedom::ALL {
        let specs = written[d as usize].iter().zip(terms.next().unwrap_or_default()).collect();
        Equation::new(d, specs, &all).reduce_to(&mut parts)?;
    }
    Ok(parts)
}

/// The terms of surge, sway and yaw as written, with the values of [value] and [nominal].
fn replaced(file: &VesselFile) -> Result<[Vec<TermSpec>; 3], Invalid> {
    let mut written = [&file.surge, &file.sway, &file.yaw].map(Vec::clone);
    let values = file.value.iter().map(|(name, value)| (name, *value, true));
    for (name, value, truth) in values.chain(file.nominal.iter().map(|(name, value)| (name, *value, false))) {
        match written.iter_mut().flatten().find(|spec| spec.parameter == *name) {
            Some(spec) if truth => spec.value = Some(value),
            Some(spec) => spec.nominal = Some(value),
            None => {
                let given = "a name that no term has".to_owned();
                let known = written.iter().flatten().map(|spec| spec.parameter.as_str());
                return Err(Invalid {
                    found: given,
                    ..Invalid::unknown(format!("parameter `{name}`"), name, known)
                });
            }
        }
    }
    Ok(written)
}

fn check_parameters(written: &[Vec<TermSpec>; 3]) -> Result<(), Invalid> {
    for spec in written.iter().flatten() {
        check_name("`parameter` of a term", &spec.parameter)?;
        if let Some(number) = spec.value.iter().chain(&spec.nominal).find(|number| !number.is_finite()) {
            let thing = format!("parameter `{}`", spec.parameter);
            return Err(Invalid::new(thing, number.to_string(), "a finite number", "correct it"));
        }
    }
    Ok(())
}

fn variables(file: &VesselFile) -> Result<Vec<Variable>, Invalid> {
    let variable = |name: &str, unit: &str| Variable { name: name.to_owned(), unit: unit.to_owned() };
    let states = DegreeOfFreedom::ALL.into_iter().map(|d| variable(d.state(), d.unit()));
    let inputs = file.input.iter().map(|i| variable(&i.name, &i.unit));
    let measured = file.measured.iter().map(|m| variable(&m.name, &m.unit));
    let derived = file.derived.iter().map(|d| variable(&d.name, &d.unit));
    let all: Vec<Variable> = states.chain(inputs).chain(measured).chain(derived).collect();
    for (i, v) in all.iter().enumerate() {
        check_name(format!("`name` of channel {}", i.saturating_sub(2)), &v.name)?;
        if !v.unit.is_empty() {
            check_name(format!("`unit` of channel `{}`", v.name), &v.unit)?;
        }
        let of_input = ["command_", "instrument_"].into_iter().find_map(|column| v.name.strip_prefix(column));
        let of_input = of_input.is_some_and(|name| file.input.iter().any(|input| input.name == name));
        let reserved = i >= 3 && (of_input || RESERVED.contains(&v.name.as_str()));
        let plain = v.name.chars().all(|c| c.is_alphanumeric() || c == '_') && !v.name.is_empty();
        if all[..i].iter().any(|w| w.name == v.name) || reserved || !plain {
            let what =
                if i < first_derived(file) { "input or measured disturbance" } else { "derived channel" };
            return Err(Invalid::new(
                format!("{what} `{}`", v.name),
                "a name that is taken or not a plain one",
                "letters, digits and _, each name once, no column of the trajectories",
                "rename it",
            ));
        }
    }
    Ok(all)
}

/// The index of the first derived channel among the variables.
fn first_derived(file: &VesselFile) -> usize {
    3 + file.input.len() + file.measured.len()
}

/// Values of measured disturbances in simulated trials, by index among the variables.
fn simulated(file: &VesselFile) -> BTreeMap<usize, f64> {
    let places = (3 + file.input.len()..).zip(&file.measured);
    places.filter_map(|(place, measured)| Some((place, measured.simulated?))).collect()
}

/// What channels are said to be, by index among the variables.
fn roles(file: &VesselFile) -> BTreeMap<usize, ChannelRole> {
    let inputs = file.input.iter().map(|input| input.role);
    let measured = file.measured.iter().map(|channel| channel.role);
    let written = inputs.chain(measured).chain(file.derived.iter().map(|channel| channel.role));
    (3..).zip(written).filter_map(|(place, role)| Some((place, role?))).collect()
}

/// The trajectories' own columns.
const RESERVED: [&str; 12] =
    ["design", "run", "segment", "maneuver", "sample", "t", "y_u", "y_v", "y_r", "x", "y", "psi"];

/// The terms of surge, sway and yaw, each with a parameter of its own.
fn terms(file: &VesselFile, variables: &[Variable]) -> Result<[Vec<Term>; 3], Invalid> {
    let names: Vec<&str> = variables.iter().map(|v| v.name.as_str()).collect();
    let mut taken: Vec<&str> = Vec::new();
    let degree = |d: DegreeOfFreedom, specs: &[TermSpec]| -> Result<Vec<Term>, Invalid> {
        if specs.is_empty() {
            return Err(Invalid::new(
                format!("[[{}]]", d.name()),
                "no term",
                "at least one term per degree of freedom",
                "add one",
            ));
        }
        specs.iter().map(|s| Term::parse(&s.term, &names)).collect()
    };
    let all = [
        degree(DegreeOfFreedom::Surge, &file.surge)?,
        degree(DegreeOfFreedom::Sway, &file.sway)?,
        degree(DegreeOfFreedom::Yaw, &file.yaw)?,
    ];
    for name in [&file.surge, &file.sway, &file.yaw].into_iter().flatten().map(|t| t.parameter.as_str()) {
        if taken.contains(&name) || name.is_empty() {
            return Err(Invalid::new(
                format!("parameter `{name}`"),
                "twice or empty",
                "a name of its own",
                "rename it",
            ));
        }
        taken.push(name);
    }
    Ok(all)
}

fn couplings(inputs: &[InputSpec]) -> Result<Vec<Option<(usize, f64)>>, Invalid> {
    let coupling = |input: &InputSpec| match (&input.follows, input.factor) {
        (None, None) => Ok(None),
        (Some(name), Some(factor)) if factor.is_finite() => {
            match inputs.iter().position(|i| i.name == *name && i.name != input.name) {
                Some(index) => Ok(Some((index, factor))),
                None => Err(bad_coupling(input, &format!("`follows = \"{name}\"`"))),
            }
        }
        _ => Err(bad_coupling(input, "only one of `follows` and `factor`, or no finite factor")),
    };
    inputs.iter().map(coupling).collect()
}

fn bad_coupling(input: &InputSpec, found: &str) -> Invalid {
    Invalid::new(
        format!("input `{}`", input.name),
        found,
        "`follows` naming another input and a finite `factor`, or neither",
        "correct it",
    )
}

/// The greatest angle of a rudder \[°\].
const HARD_OVER_DEG: f64 = 90.0;
/// Names of rudders among inputs, where nothing else says what they are.
const RUDDERS: [&str; 4] = ["rudder", "helm", "delta", "δ"];
/// By how much of it a stated length may differ from the ship's.
const ROUNDING: f64 = 0.01;

impl VesselFile {
    /// The same file, which accepts what is unusual of ships if that is all that it is refused for; and what that is.
    ///
    /// # Errors
    /// What [`Vessel::from_file`] refuses besides.
    pub fn accepting_unusual(self) -> Result<(Self, Option<Invalid>), Invalid> {
        let Err(unusual) = Vessel::from_file(self.clone()) else { return Ok((self, None)) };
        let accepting = Self { unusual: Some(Unusual::Accepted), ..self };
        Vessel::from_file(accepting.clone())?;
        Ok((accepting, Some(unusual)))
    }
}

impl Vessel {
    /// The greatest angle of input `i` in its unit, if it is a rudder.
    fn hard_over(&self, i: usize) -> Option<f64> {
        let input = &self.model.input_variables()[i];
        let most = match input.unit.as_str() {
            "rad" => HARD_OVER_DEG.to_radians(),
            "deg" | "°" => HARD_OVER_DEG,
            _ => return None,
        };
        let forces = self.model.forces.as_ref().map(|model| &model.forces);
        let drives =
            |ship: &Forces| (0..ship.description().rudder.len()).any(|k| ship.rudder_input(k).0.channel == i);
        let turns = |ship: &Forces| {
            let mut thrusters = 0..ship.description().thruster.len();
            thrusters.any(|k| ship.thruster_inputs(k).1.is_some_and(|angle| angle.channel == i))
        };
        let name = input.name.to_lowercase();
        let is_called = !self.accepts_unusual && RUDDERS.iter().any(|rudder| name.starts_with(rudder));
        let is_one = forces.is_some_and(|ship| drives(ship) || (is_called && !turns(ship)));
        (is_one || (forces.is_none() && is_called)).then_some(most * (1.0 + 1e-9))
    }

    /// Refuses a setting in `what` with which a rudder is beyond 90°: it is in degrees, most likely.
    ///
    /// # Errors
    /// Names the input.
    pub fn check_helm(&self, inputs: &[f64], what: impl Fn() -> String) -> Result<(), Invalid> {
        let over = |(i, setting): (usize, &f64)| {
            self.hard_over(i).filter(|most| setting.abs() > *most).map(|most| (i, *setting, most))
        };
        let Some((i, setting, most)) = inputs.iter().enumerate().find_map(over) else { return Ok(()) };
        let input = &self.model.input_variables()[i];
        let (name, unit) = (foreign(&input.name), foreign(&input.unit));
        let given = format!("{name} = {setting} {unit}");
        let expected = format!("a rudder angle of at most {most:.4} {unit}, {HARD_OVER_DEG}°");
        Err(Invalid::new(what(), given, expected, "give it in the unit of the input: 35° are 0.6109 rad"))
    }

    /// Refuses ranges of rudders beyond 90°.
    fn check_rudders(&self) -> Result<(), Invalid> {
        let ends = [0, 1].map(|end| {
            self.actuators.iter().map(move |actuator| actuator.range.map_or(0.0, |range| range[end]))
        });
        ends.into_iter().try_for_each(|ends| {
            self.check_helm(&ends.collect::<Vec<_>>(), || "`range` of an input".to_owned())
        })
    }

    /// Refuses a speed in `what` that is unusual of such a ship, unless her file accepts that.
    ///
    /// # Errors
    /// Names the speed.
    pub fn check_speed(&self, speed_m_s: f64, what: impl Fn() -> String) -> Result<(), Invalid> {
        let Some(model) = self.model.forces.as_ref().filter(|_| !self.accepts_unusual) else { return Ok(()) };
        let (froude, most) = model.forces.usual_speed();
        if speed_m_s.abs() <= most {
            return Ok(());
        }
        let expected =
            format!("at most {most:.4} m/s, a Froude number of {froude:.2} for a hull as full as this");
        let remedy = "give m/s at this ship's length: 1 kn is 0.514 m/s; or write `unusual = \"accepted\"` in the vessel's file";
        Err(Invalid::new(what(), format!("{speed_m_s} m/s"), expected, remedy))
    }

    /// Refuses a length in `what` that is not that of the ship's file, where that has one.
    ///
    /// # Errors
    /// Names both.
    pub fn check_length(&self, length_m: f64, what: &str, most: Option<f64>) -> Result<(), Invalid> {
        let Some(length) = self.model.forces.as_ref().map(|model| model.forces.description().ship.length_m)
        else {
            return Ok(());
        };
        if (length_m / length - 1.0).abs() <= most.unwrap_or(ROUNDING) {
            return Ok(());
        }
        let expected = format!("{length} m, as `length_m` of [ship] in the vessel's file");
        Err(Invalid::new(
            what,
            format!("{length_m} m"),
            expected,
            "give the length of this ship, or correct her file",
        ))
    }
}
