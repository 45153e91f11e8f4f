//! Fits of a ship with a sign turned, beside the one as written.

use std::collections::BTreeSet;
use std::fmt;

use numerics::statistics::log_chi_square_tail;
use ship::forces::{Channel, Description, Forces, Number, NumberSpec};

use crate::criticism::{Absent, Suspect, sign_remedy};
use crate::fitting::{Fit, Pass, Prior, Problem, RecordingView};

const STEPS: usize = 10;
/// A sign is wrong where the cost is lower by at least this share with it turned …
const SHARE: f64 = 0.05;
/// … and chance makes any of the signs look so with less than this probability.
const LEVEL: f64 = 0.01;

impl Problem<'_> {
    pub(crate) fn sign_test(&self, fit: &Fit, alternative: &Alternative, count: usize) -> Absent {
        let as_written = Pass::new(self, fit.first).window_costs(fit);
        let none = Absent {
            kind: Suspect::Sign,
            name: alternative.turn.to_string(),
            p_value: 1.0,
            remedy: Some(alternative.turn.remedy()),
            ..Absent::default()
        };
        let Some((other, windows)) = self.fitted_as(fit, alternative) else { return none };
        let gains: Vec<f64> = as_written.iter().zip(&windows).map(|(old, new)| old - new).collect();
        let share = fit.share(fit.cost - other.cost);
        let log_p = if share > 0.0 { log_chance(&gains) } else { 0.0 };
        let p_value = (count as f64 * libm::exp(log_p)).min(1.0);
        let candidate = share >= SHARE && p_value < LEVEL;
        Absent { share: Some(share), evidence: -2.0 * log_p, p_value, candidate, ..none }
    }

    /// The fit of the ship `alternative`, from the numbers of `fit` or those before it, whichever cost less, and the costs of its windows.
    fn fitted_as(&self, fit: &Fit, alternative: &Alternative) -> Option<(Fit, Vec<f64>)> {
        let inputs = match alternative.negated {
            Some(channel) => changed(self, channel, |all| all.iter().map(|value| -value).collect()),
            None => self.recordings.iter().map(|recording| recording.inputs.to_vec()).collect(),
        };
        let problem = self.with_inputs(&alternative.forces, &inputs)?;
        let problem = problem.with_priors(self.priors_of(alternative));
        let pass = Pass::new(&problem, fit.first);
        let starts =
            [self.theta_of(alternative, &fit.theta), self.theta_of(alternative, &self.forces.nominal())];
        let costs = starts.map(|theta| (pass.cost_from(&theta), theta));
        let (_, theta) = costs.into_iter().min_by(|one, other| one.0.total_cmp(&other.0))?;
        let (best, _) = pass.search(&theta, STEPS).ok()?;
        let windows = pass.window_costs(&best);
        Some((best, windows))
    }

    fn with_inputs<'b>(&'b self, forces: &'b Forces, inputs: &'b [Vec<f64>]) -> Option<Problem<'b>> {
        let with = |(old, inputs): (&RecordingView<'b>, &'b Vec<f64>)| RecordingView { inputs, ..*old };
        let recordings = self.recordings.iter().zip(inputs).map(with).collect();
        Problem::new(forces, recordings, self.width, self.settings).ok()
    }

    /// Numbers of the ship as written for that of `alternative`; both have the same parameters.
    fn theta_of(&self, alternative: &Alternative, theta: &[f64]) -> Vec<f64> {
        let value = |parameter: &ship::forces::Parameter| {
            let at = self.forces.parameters().iter().position(|old| old.name == parameter.name);
            at.map_or(parameter.nominal, |at| alternative.value(&parameter.name, theta[at]))
        };
        alternative.forces.parameters().iter().map(value).collect()
    }

    fn priors_of(&self, alternative: &Alternative) -> Vec<Option<Prior>> {
        let prior = |parameter: &ship::forces::Parameter| {
            let at = self.forces.parameters().iter().position(|old| old.name == parameter.name)?;
            self.priors[at].map(|old| Prior { mean: alternative.value(&parameter.name, old.mean), ..old })
        };
        alternative.forces.parameters().iter().map(prior).collect()
    }
}

impl Pass<'_> {
    pub(crate) fn window_costs(&self, fit: &Fit) -> Vec<f64> {
        let groups = self.groups.iter().zip(&fit.starts);
        let errors = groups.flat_map(|(group, starts)| self.errors(group, &fit.theta, starts));
        errors.map(|window| self.share(&window) * window.cost(self.settings.knee)).collect()
    }
}

fn changed(problem: &Problem, channel: usize, by: impl Fn(&[f64]) -> Vec<f64>) -> Vec<Vec<f64>> {
    let width = problem.width;
    let one = |recording: &RecordingView| {
        let mut inputs = recording.inputs.to_vec();
        let column: Vec<f64> = inputs.iter().skip(channel).step_by(width).copied().collect();
        inputs.iter_mut().skip(channel).step_by(width).zip(by(&column)).for_each(|(entry, new)| *entry = new);
        inputs
    };
    problem.recordings.iter().map(one).collect()
}

/// The logarithm of the probability that chance makes the mean of `gains` so far from 0.
fn log_chance(gains: &[f64]) -> f64 {
    let count = gains.len() as f64;
    let mean = gains.iter().sum::<f64>() / count;
    let square = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>();
    if gains.len() < 2 || square <= 0.0 {
        return 0.0;
    }
    log_chi_square_tail((mean * count).powi(2) / (square * count / (count - 1.0)), 1)
}

/// Something that is turned over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// A thruster or propeller stands on the other side of the middle line.
    Side(String),
    /// A thruster pushes the other way.
    Push(String),
    /// The angle of this rudder or thruster, logged as that input, has the other sign.
    Angle(String, String),
    /// The wind that this component feels comes from the other side.
    Wind(String, String),
    /// The inputs of two thrusters or propellers on different sides are exchanged.
    Exchanged([String; 2], [String; 2]),
}

impl fmt::Display for Turn {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Side(of) => write!(f, "`{of}` is on the other side of the ship"),
            Self::Push(of) => write!(f, "`{of}` pushes the other way"),
            Self::Angle(of, input) => write!(f, "`{input}` acts with the opposite sign, the angle of `{of}`"),
            Self::Wind(of, input) => {
                write!(f, "`{input}` acts with the opposite sign, the direction of `{of}`")
            }
            Self::Exchanged([one, other], [first, second]) => {
                write!(f, "`{first}` and `{second}` are exchanged, the inputs of `{one}` and `{other}`")
            }
        }
    }
}

impl Turn {
    fn remedy(&self) -> String {
        match self {
            Self::Side(of) => format!("correct `y_m` of `{of}`"),
            Self::Push(of) => format!("correct `angle_deg` of `{of}`"),
            Self::Angle(_, input) | Self::Wind(_, input) => sign_remedy(input),
            Self::Exchanged(_, [first, second]) => {
                format!(
                    "exchange the columns of `{first}` and `{second}` in ingest.toml, or the inputs in vessel.toml"
                )
            }
        }
    }
}

pub(crate) struct Alternative {
    pub turn: Turn,
    pub forces: Forces,
    pub negated: Option<usize>,
    /// The number that changes with it, and how.
    changed: Option<(String, Change)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Negated,
    HalfTurn,
}

impl Change {
    fn of(self, value: f64) -> f64 {
        match self {
            Self::Negated => -value,
            Self::HalfTurn => value + 180.0,
        }
    }

    /// The number after the change; `None` where it is tied or 0 and stays.
    fn number(self, number: &Number) -> Option<Number> {
        match number {
            Number::Plain(value) => Some(Number::Plain(self.of(*value))),
            Number::Table(spec) if spec.tied_to.is_some() => None,
            Number::Table(spec) => {
                let ends = spec.bounds.map(|[low, high]| match self {
                    Self::Negated => [-high, -low],
                    Self::HalfTurn => [low + 180.0, high + 180.0],
                });
                let of = |number: Option<f64>| number.map(|value| self.of(value));
                let (nominal, prime, value) = (of(spec.nominal), of(spec.prime), of(spec.value));
                Some(Number::Table(NumberSpec { nominal, prime, value, bounds: ends, ..spec.clone() }))
            }
        }
    }
}

impl Alternative {
    /// All of `forces`, whose rows of inputs have these `channels`.
    pub fn all(forces: &Forces, channels: &[Channel]) -> Vec<Self> {
        let turns = Turns { forces, channels };
        let pairs = turns.exchanged();
        turns.sides().chain(turns.pushes()).chain(turns.angles()).chain(turns.winds()).chain(pairs).collect()
    }

    /// A value of the parameter `name` of the ship as written, for this one.
    pub fn value(&self, name: &str, value: f64) -> f64 {
        match &self.changed {
            Some((changed, how)) if changed == name => how.of(value),
            _ => value,
        }
    }
}

struct Turns<'a> {
    forces: &'a Forces,
    channels: &'a [Channel],
}

impl Turns<'_> {
    fn written(&self) -> &Description {
        self.forces.description()
    }

    /// The ship of `description`; `None` where she is none, so that nothing can be said of her.
    fn with(&self, turn: Turn, description: &Description, changed: (String, Change)) -> Option<Alternative> {
        let forces = Forces::new(description, self.channels).ok()?;
        Some(Alternative { turn, forces, negated: None, changed: Some(changed) })
    }

    fn negated(&self, turn: Turn, channel: usize) -> Alternative {
        Alternative { turn, forces: self.forces.clone(), negated: Some(channel), changed: None }
    }

    fn on_other_side(&self, all: &Description, name: &str) -> Option<Alternative> {
        self.with(Turn::Side(name.to_owned()), all, (format!("{name}.y_m"), Change::Negated))
    }

    fn sides(&self) -> impl Iterator<Item = Alternative> {
        let written = self.written();
        let thrusters = (0..written.thruster.len()).filter_map(move |i| {
            let mut all = written.clone();
            let y = &mut all.thruster[i].y_m;
            *y = Some(other_side(y.as_ref())?);
            self.on_other_side(&all, &written.thruster[i].name)
        });
        let propellers = (0..written.propeller.len()).filter_map(move |i| {
            let mut all = written.clone();
            let y = &mut all.propeller[i].y_m;
            *y = Some(other_side(y.as_ref())?);
            self.on_other_side(&all, &written.propeller[i].name)
        });
        thrusters.chain(propellers)
    }

    fn pushes(&self) -> impl Iterator<Item = Alternative> {
        let written = self.written();
        let fixed = (0..written.thruster.len()).filter(|i| written.thruster[*i].angle.is_none());
        fixed.filter_map(move |i| {
            let mut all = written.clone();
            let thruster = &mut all.thruster[i];
            let name = thruster.name.clone();
            let angle = thruster.angle_deg.clone().unwrap_or(Number::Plain(0.0));
            thruster.angle_deg = Some(Change::HalfTurn.number(&angle)?);
            self.with(Turn::Push(name.clone()), &all, (format!("{name}.angle_deg"), Change::HalfTurn))
        })
    }

    /// Rudders and azimuth thrusters; several that follow one input are turned together.
    fn angles(&self) -> impl Iterator<Item = Alternative> {
        let written = self.written();
        let rudders = written.rudder.iter().enumerate();
        let rudders = rudders.map(|(i, it)| (&it.name, self.forces.rudder_input(i).0.channel));
        let azimuths = written.thruster.iter().enumerate();
        let azimuths =
            azimuths.filter_map(|(i, it)| Some((&it.name, self.forces.thruster_inputs(i).1?.channel)));
        let mut turned = BTreeSet::new();
        rudders.chain(azimuths).filter(move |(_, channel)| turned.insert(*channel)).map(|(name, channel)| {
            let input = self.channels[channel].name.clone();
            self.negated(Turn::Angle(name.clone(), input), channel)
        })
    }

    fn winds(&self) -> impl Iterator<Item = Alternative> {
        self.written().wind.iter().enumerate().map(|(i, wind)| {
            let [_, direction] = self.forces.wind_inputs(i);
            let turn = Turn::Wind(wind.name.clone(), self.channels[direction.channel].name.clone());
            self.negated(turn, direction.channel)
        })
    }

    fn exchanged(&self) -> Vec<Alternative> {
        let written = self.written();
        let thrusters = written.thruster.iter().map(|it| (&it.name, &it.input, it.y_m.as_ref()));
        let propellers = written.propeller.iter().map(|it| (&it.name, &it.input, it.y_m.as_ref()));
        let (thrusters, propellers): (Vec<Placed>, Vec<Placed>) = (thrusters.collect(), propellers.collect());
        let of_thrusters = opposite(&thrusters).into_iter().map(|(i, j)| {
            let mut all = written.clone();
            let (before, after) = all.thruster.split_at_mut(j);
            std::mem::swap(&mut before[i].input, &mut after[0].input);
            (all, [thrusters[i], thrusters[j]])
        });
        let of_propellers = opposite(&propellers).into_iter().map(|(i, j)| {
            let mut all = written.clone();
            let (before, after) = all.propeller.split_at_mut(j);
            std::mem::swap(&mut before[i].input, &mut after[0].input);
            (all, [propellers[i], propellers[j]])
        });
        let alternative = |(all, pair): (Description, [Placed; 2])| {
            let turn = Turn::Exchanged(pair.map(|it| it.0.clone()), pair.map(|it| it.1.clone()));
            let forces = Forces::new(&all, self.channels).ok()?;
            Some(Alternative { turn, forces, negated: None, changed: None })
        };
        of_thrusters.chain(of_propellers).filter_map(alternative).collect()
    }
}

/// Name, input and place to starboard of a thruster or propeller.
type Placed<'a> = (&'a String, &'a String, Option<&'a Number>);

fn opposite(all: &[Placed]) -> Vec<(usize, usize)> {
    let side = |i: usize| all[i].2.and_then(value).filter(|side| *side != 0.0).map(|side| side > 0.0);
    let apart = |(i, j): &(usize, usize)| {
        side(*i).zip(side(*j)).is_some_and(|(one, other)| one != other) && all[*i].1 != all[*j].1
    };
    (0..all.len()).flat_map(|i| (i + 1..all.len()).map(move |j| (i, j))).filter(apart).collect()
}

fn value(number: &Number) -> Option<f64> {
    match number {
        Number::Plain(number) => Some(*number),
        Number::Table(number) => number.nominal.or(number.prime),
    }
}

/// The place on the other side; `None` for one on the middle line.
fn other_side(place: Option<&Number>) -> Option<Number> {
    let place = place.filter(|number| value(number).is_some_and(|side| side != 0.0))?;
    Change::Negated.number(place)
}

const DELAY_STEPS: usize = 6;
/// Times that are tried, in those of the score.
const TIMES: [f64; 4] = [0.5, 1.0, 1.5, 2.0];

/// How an input acts late.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lateness {
    /// After a dead time.
    DeadTime,
    /// With a lag of first order.
    Lag,
}

impl fmt::Display for Lateness {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(if *self == Self::Lag { "lag" } else { "dead time" })
    }
}

impl Lateness {
    /// The column `all`, linear between samples `sample_s` apart, as it acts.
    fn of(self, all: &[f64], seconds: f64, sample_s: f64) -> Vec<f64> {
        match self {
            Self::DeadTime => ship::forces::late(all, seconds, 0.0, sample_s),
            Self::Lag => ship::forces::late(all, 0.0, seconds, sample_s),
        }
    }
}

impl Problem<'_> {
    /// The best time \[s\] of this kind for an input, about `late`, and by which share of the cost it falls then.
    pub(super) fn delay_test(
        &self,
        fit: &Fit,
        input: usize,
        kind: Lateness,
        late: f64,
    ) -> Option<(f64, f64)> {
        let tried = TIMES.iter().filter_map(|times| {
            let seconds = times * late;
            let cost = self.late_cost(fit, input, |all| kind.of(all, seconds, self.settings.sample_s))?;
            Some((seconds, fit.share(fit.cost - cost)))
        });
        tried.max_by(|one, other| one.1.total_cmp(&other.1))
    }

    fn late_cost(&self, fit: &Fit, channel: usize, acts: impl Fn(&[f64]) -> Vec<f64>) -> Option<f64> {
        let inputs = changed(self, channel, acts);
        let problem = self.with_inputs(self.forces, &inputs)?.with_priors(self.priors.clone());
        Pass::new(&problem, fit.first).search(&fit.theta, DELAY_STEPS).ok().map(|(fit, _)| fit.cost)
    }
}
