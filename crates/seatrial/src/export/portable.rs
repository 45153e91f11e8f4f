//! A model in a form common to all languages.

use std::collections::{BTreeMap, BTreeSet};

use ::ship::forces::{Quantity, QuantitySource};
use ::ship::model::{
    Actuator, Constraint, DegreeOfFreedom, DerivedChannel, Factor, Product, RateChange, Source, Term,
    Variable, Vessel, Written,
};
use refusal::Invalid;

use super::text::{Identifiers, file_name};
use crate::export::ship::{self, Ship};
use crate::export::text::number;

/// A model with its parameters and their properties, under names that are identifiers everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Portable {
    /// The vessel's name, as written.
    pub vessel: String,
    /// The base name of files and functions.
    pub base: String,
    /// The sampling rate that it holds for \[Hz\].
    pub rate_hz: f64,
    /// The states u, v, r, then the inputs, the measured disturbances, and derived channels, in the order of
    /// the model's variables.
    pub channels: Vec<Channel>,
    /// How channels are computed, each after its sources.
    pub derived: Vec<DerivedChannel>,
    /// The parameters with values of their own: surge, sway, yaw.
    pub parameters: Vec<Parameter>,
    /// The parameters tied to others.
    pub tied: Vec<Tied>,
    /// The increments of u, v and r in a step, summand by summand; none of a ship with forces.
    pub equations: [Vec<Summand>; 3],
    /// How a step follows from the steps that the parameters of terms hold for.
    pub pace: RateChange,
    /// Her components, for a ship with forces.
    pub ship: Option<Ship>,
    /// Ranges within which the model is known to be valid, for the channels that have one.
    pub ranges: Vec<Range>,
    /// Notes for the user.
    pub notes: Vec<String>,
    /// How well parts of the model's own step follow it, where a step is such a part.
    pub parts: Option<String>,
    /// Inputs of a ship with forces that follow commands late, in words.
    pub late: Vec<String>,
    /// Its origin.
    pub origin: Origin,
}

/// A key of a template with its value.
pub(crate) type TemplateEntry = (&'static str, String);

/// A state, an input or a measured disturbance.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// As written.
    pub name: String,
    /// In code.
    pub identifier: String,
    /// Its unit.
    pub unit: String,
    /// What it is, in words.
    pub meaning: String,
}

/// A parameter with a value of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// As written.
    pub name: String,
    /// In code.
    pub identifier: String,
    /// Its unit.
    pub unit: String,
    /// Its value.
    pub value: f64,
    /// Its standard error, where that is known.
    pub standard_error: Option<f64>,
    /// Its regressor, in words.
    pub meaning: String,
}

/// A parameter that is another one times a factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Tied {
    /// As written.
    pub name: String,
    /// The other one, as written.
    pub to: String,
    /// The factor.
    pub factor: f64,
}

/// A parameter times a sum of products; an empty sum for the parameter alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Summand {
    /// Its index among the parameters.
    pub parameter: usize,
    /// Products of channels, each with a coefficient if it has one.
    pub products: Vec<(Vec<Factor>, Option<f64>)>,
}

/// The range of a channel in the data that the model was fitted to, or what the vessel's file states for an input.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// The channel's index.
    pub channel: usize,
    /// Least value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

/// The origin of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origin {
    /// Program and version.
    pub producer: String,
    /// Name of the file.
    pub file: String,
    /// Its digest.
    pub digest: String,
    /// The kind of its values: estimates, true or nominal values.
    pub values: String,
}

/// Information about a model besides its values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Knowledge {
    /// Standard errors by parameter.
    pub standard_errors: BTreeMap<String, f64>,
    /// The data's coverage: channel, least and largest value.
    pub covered: Vec<(String, [f64; 2])>,
    /// How well parts of the model's own step follow it, where a step is such a part.
    pub parts: Option<String>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

impl Portable {
    /// `vessel` with the parameters of `source`.
    ///
    /// # Errors
    /// A parameter without a value; a dead time of a thruster.
    pub fn new(vessel: &Vessel, source: Source, known: &Knowledge, origin: Origin) -> Result<Self, Invalid> {
        let theta = vessel.parameters(source)?;
        check_dead_time(vessel, &theta)?;
        let mut names = Identifiers::reserved();
        if vessel.model.forces.is_some() {
            names.reserve(ship::RESERVED);
        }
        let channels: Vec<Channel> = channels(vessel, &mut names);
        let given = channels.len() - vessel.model.derived.len();
        // Derived channels are within their ranges if their sources are.
        let place = |name: &String| channels[..given].iter().position(|channel| channel.name == *name);
        // The range of a direction is a circle.
        let is_direction = |place: usize| place >= 3 + vessel.model.inputs && channels[place].unit == "rad";
        let covered = known.covered.iter();
        let range = |(name, [low, high]): &(String, [f64; 2])| {
            let channel = place(name).filter(|place| !is_direction(*place))?;
            Some(Range { channel, low: *low, high: *high })
        };
        let mut ranges: Vec<Range> = covered.filter_map(range).collect();
        if ranges.is_empty() {
            let limits = (3..).zip(&vessel.actuators);
            let limit = |(channel, actuator): (usize, &Actuator)| {
                actuator.range.map(|[low, high]| Range { channel, low, high })
            };
            ranges.extend(limits.filter_map(limit));
        }
        let mut making = Making { vessel, known, names, parameters: Vec::new(), tied: Vec::new() };
        let equations = match vessel.model.forces {
            Some(_) => [const { Vec::new() }; 3],
            None => DegreeOfFreedom::ALL.map(|d| making.equation(d, &theta)),
        };
        let ship = making.ship(&channels, &theta);
        let Making { parameters, tied, .. } = making;
        Ok(Self {
            vessel: vessel.name.clone(),
            base: file_name(&vessel.name),
            rate_hz: vessel.sample_rate_hz,
            ranges,
            notes: known.notes.clone(),
            parts: known.parts.clone(),
            late: late(vessel),
            derived: vessel.model.derived.clone(),
            channels,
            parameters,
            tied,
            equations,
            pace: vessel.model.pace,
            ship,
            origin,
        })
    }

    /// What its ranges are, as the end of a sentence.
    pub(crate) fn ranges_are(&self) -> &'static str {
        match self.ranges.iter().all(|range| range.channel >= 3) {
            true => "the file's `range` of each input",
            false => "what the data covered that the model was fitted to",
        }
    }

    /// The identifiers of all channels.
    pub(crate) fn identifiers(&self) -> Vec<String> {
        self.channels.iter().map(|channel| channel.identifier.clone()).collect()
    }

    /// At which rate its step holds, as a comment.
    pub(crate) fn rate_holds(&self) -> &'static str {
        match (&self.ship, self.pace) {
            (None, RateChange::Own) => "The only rate that the parameters hold for.",
            _ => "The rate of its steps; inputs are held meanwhile.",
        }
    }

    /// The rate that the parameters of terms hold for \[Hz\].
    pub(crate) fn own_rate_hz(&self) -> f64 {
        match self.pace {
            RateChange::Own => self.rate_hz,
            RateChange::Repeated(count) => self.rate_hz * f64::from(count),
            RateChange::Divided { by, .. } => self.rate_hz / f64::from(by),
        }
    }

    /// For templates: the weights of own steps where a step is not one of these; what the step of the terms is called and what it
    /// takes.
    pub(crate) fn steps(&self) -> (Option<TemplateEntry>, [TemplateEntry; 2]) {
        let weights = self.weights().map(|weights| ("weights", weights.join(", ")));
        let [step, sample] = if weights.is_some() { ["own_step", "own step"] } else { ["step", "sample"] };
        (weights, [("step", step.to_owned()), ("sample", sample.to_owned())])
    }

    /// The weights of the states after one, two, … steps of the terms, where a step is not one of these.
    pub(crate) fn weights(&self) -> Option<Vec<String>> {
        (self.pace != RateChange::Own).then(|| self.pace.weights().into_iter().map(number).collect())
    }

    /// The states.
    pub fn states(&self) -> &[Channel] {
        &self.channels[..3]
    }

    /// The inputs and measured disturbances.
    pub fn inputs(&self) -> &[Channel] {
        &self.given()[3..]
    }

    /// The channels that are not computed: states, inputs, measured disturbances.
    pub fn given(&self) -> &[Channel] {
        &self.channels[..self.channels.len() - self.derived.len()]
    }

    /// The indices of the channels that some equation uses, directly or through others.
    pub(crate) fn used(&self) -> BTreeSet<usize> {
        let products = self.equations.iter().flatten().flat_map(|summand| &summand.products);
        let factors = products.flat_map(|(factors, _)| factors).map(|factor| factor.variable);
        let mut used: BTreeSet<usize> = factors.collect();
        used.extend(self.ship.iter().flat_map(Ship::channels));
        for derived in self.derived.iter().rev() {
            if used.contains(&derived.variable) {
                used.extend(&derived.sources);
            }
        }
        used
    }

    /// The names in code that differ from the file's, with the latter.
    pub fn renamed(&self) -> BTreeMap<String, String> {
        let channels = self.channels.iter().map(|channel| (&channel.name, &channel.identifier));
        let all = channels.chain(self.parameters.iter().map(|p| (&p.name, &p.identifier)));
        let others = all.filter(|(name, identifier)| name != identifier);
        others.map(|(name, identifier)| (identifier.clone(), name.clone())).collect()
    }

    /// Those of [`Self::renamed`] that are not a component and a key, joined by `_` instead of a point.
    pub(crate) fn unlike(&self) -> BTreeMap<String, String> {
        let joined =
            |identifier: &str, name: &str| name.contains('.') && name.replace('.', "_") == identifier;
        self.renamed().into_iter().filter(|(identifier, name)| !joined(identifier, name)).collect()
    }

    /// Its size, and the renamed channels, in one line.
    pub fn summary(&self) -> String {
        let (inputs, parameters) = (self.inputs().len(), self.parameters.len());
        let renamed =
            self.unlike().into_iter().map(|(identifier, name)| format!("; {name} is called {identifier}"));
        let parts = self.parts.iter().map(|part| format!("; {part}"));
        format!(
            "{inputs} inputs, {parameters} parameters, {} Hz{}",
            self.rate_hz,
            renamed.chain(parts).collect::<String>()
        )
    }

    /// The initial value of a channel in a simulator: the one nearest to zero within its range.
    pub(crate) fn start(&self, channel: usize) -> f64 {
        let range = self.ranges.iter().find(|range| range.channel == channel);
        range.map_or(0.0, |range| 0.0_f64.max(range.low).min(range.high))
    }
}

/// Refuses a thruster that follows its input after a dead time: the generated code keeps no former inputs.
fn check_dead_time(vessel: &Vessel, theta: &[f64]) -> Result<(), Invalid> {
    if vessel.model.forces.as_ref().is_some_and(|moved| moved.forces.has_dead_time(theta)) {
        let (found, expected) = ("a dead time above 0 s", "none: exported models take inputs as they act");
        let remedy = "remove it for this stage, and delay the input";
        return Err(Invalid::new("`dead_time_s`", found, expected, remedy));
    }
    Ok(())
}

/// What is not in the code of a ship with forces: how her actuators follow commands.
fn late(vessel: &Vessel) -> Vec<String> {
    let names = vessel.model.input_variables().iter();
    let late = names.zip(&vessel.actuators).filter(|_| vessel.model.forces.is_some()).filter_map(
        |(input, actuator)| {
            let lag = (actuator.lag_s > 0.0).then(|| format!("a lag of {} s", actuator.lag_s));
            let rate = actuator.rate_per_s.map(|rate| format!("a rate of {rate} {} per s", input.unit));
            let both: Vec<String> = lag.into_iter().chain(rate).collect();
            (!both.is_empty()).then(|| format!("{} follows commands with {}", input.name, both.join(" and ")))
        },
    );
    late.collect()
}

fn channels(vessel: &Vessel, names: &mut Identifiers) -> Vec<Channel> {
    let model = &vessel.model;
    let derived = |place: usize| model.derived.iter().find(|channel| channel.variable == place);
    let meaning = |place: usize| match place {
        0 => "speed along x, forward".to_owned(),
        1 => "speed along y, to starboard".to_owned(),
        2 => "yaw rate, bow to starboard".to_owned(),
        _ => match vessel.couplings.get(place - 3) {
            None => derived(place).map_or("measured disturbance".to_owned(), |d| format!("= {}", d.text)),
            Some(None) => "input".to_owned(),
            Some(Some((other, factor))) => {
                let other = &model.input_variables()[*other].name;
                format!("input; in maneuvers that leave it open, {factor} times {other}")
            }
        },
    };
    let channel = |(place, Variable { name, unit }): (usize, &Variable)| Channel {
        identifier: names.take(name),
        meaning: meaning(place),
        name: name.clone(),
        unit: unit.clone(),
    };
    model.variables.iter().enumerate().map(channel).collect()
}

/// Parameters and equations under construction.
struct Making<'a> {
    vessel: &'a Vessel,
    known: &'a Knowledge,
    names: Identifiers,
    parameters: Vec<Parameter>,
    tied: Vec<Tied>,
}

impl Making<'_> {
    /// The summands of `d`, in the order of summation in a simulation: constant, estimated parameters, known
    /// ones.
    fn equation(&mut self, d: DegreeOfFreedom, theta: &[f64]) -> Vec<Summand> {
        let model = &self.vessel.model;
        let degree = &model.degrees[d as usize];
        let mut summands = Vec::new();
        let constant = model.constant[d as usize];
        if constant != 0.0 {
            let (name, meaning) =
                (format!("constant_{}", d.state()), format!("gain of {} per sample", d.state()));
            let parameter = self.parameter(&name, d.unit().to_owned(), constant, meaning);
            summands.push(Summand { parameter, products: Vec::new() });
        }
        for written in self.vessel.written(d) {
            if let Written::Estimated(place) = written {
                let i = place - model.layout().terms(d as usize).start;
                let (name, term) = (&degree.parameters[i], &degree.terms[i]);
                let parameter = self.parameter(name, model.unit(d, term), theta[place], meaning(d, term));
                summands.push(Summand { parameter, products: products(term) });
            }
        }
        for constrained in self.vessel.constrained.iter().filter(|constrained| constrained.degree == d) {
            match constrained.constraint {
                Constraint::Fixed(value) => {
                    let (unit, meaning) = (model.unit(d, &constrained.term), meaning(d, &constrained.term));
                    let parameter = self.parameter(&constrained.name, unit, value, meaning);
                    summands.push(Summand { parameter, products: products(&constrained.term) });
                }
                Constraint::Tied { to, factor } => {
                    let to = model.parameter_names().nth(to).unwrap_or_default().to_owned();
                    self.tied.push(Tied { name: constrained.name.clone(), to, factor });
                }
            }
        }
        summands
    }

    /// The ship with forces, and her numbers as parameters; those that are free have standard errors.
    fn ship(&mut self, channels: &[Channel], theta: &[f64]) -> Option<Ship> {
        let moved = self.vessel.model.forces.as_ref()?;
        let channels: Vec<String> = channels.iter().map(|channel| channel.identifier.clone()).collect();
        let quantities = moved.forces.quantities(theta);
        let ship = Ship::new(&moved.forces, moved.sample_s, &quantities, &channels, &mut self.names);
        for i in &ship.quantities {
            let Quantity { name, unit, value, source, .. } = &quantities[*i];
            let scale = match source {
                QuantitySource::Free(i) => moved.forces.parameters()[*i].scale,
                _ => 1.0,
            };
            let term = ship::term(moved.forces.description(), name);
            let known = if *source == QuantitySource::Known { ", known" } else { "" };
            let parameter = self.parameter(
                name,
                unit.clone(),
                *value,
                format!("{}{known}", term.unwrap_or_else(|| name.clone())),
            );
            let error = &mut self.parameters[parameter].standard_error;
            *error = error.map(|error| error * scale.abs());
        }
        let tied = quantities.iter().filter_map(|quantity| match &quantity.source {
            QuantitySource::Tied { to, factor } => {
                Some(Tied { name: quantity.name.clone(), to: to.clone(), factor: *factor })
            }
            _ => None,
        });
        self.tied.extend(tied);
        Some(ship)
    }

    fn parameter(&mut self, name: &str, unit: String, value: f64, meaning: String) -> usize {
        self.parameters.push(Parameter {
            identifier: self.names.take(name),
            standard_error: self.known.standard_errors.get(name).copied(),
            name: name.to_owned(),
            unit,
            value,
            meaning,
        });
        self.parameters.len() - 1
    }
}

/// The products whose sum is `term`; empty for the constant 1.
fn products(term: &Term) -> Vec<(Vec<Factor>, Option<f64>)> {
    if term.is_constant() && term.tied.is_empty() {
        return Vec::new();
    }
    let tied = |Product { coefficient, factors }: &Product| (factors.clone(), Some(*coefficient));
    [(term.factors.clone(), None)].into_iter().chain(term.tied.iter().map(tied)).collect()
}

fn meaning(d: DegreeOfFreedom, term: &Term) -> String {
    format!("{}: {}", d.name(), term.text)
}
