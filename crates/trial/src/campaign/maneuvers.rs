use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

use maneuver::{Aim, Exceeded, Executed, Generator, Kept, Reacting, Realized, WRONG_SIGN};
use rayon::prelude::*;
use refusal::Invalid;
use ship::engine::{
    Divided, Helm, Run, Segment, check_diverged, check_runaway, simulate_command, simulate_one,
};
use ship::model::{DegreeOfFreedom, Source, Vessel};

use super::Refusal;
use super::sea::{OwnLoop, SimulatedRun};

/// Maneuvers that are judged together.
const AT_ONCE: usize = 64;

/// The maneuvers of a dictionary or of a validation, each an undisturbed run of its own.
pub struct Maneuvers<'a> {
    vessel: &'a Vessel,
    generator: &'a Generator,
    parameters: Vec<f64>,
    design: &'a str,
}

impl<'a> Maneuvers<'a> {
    /// What they react by.
    pub fn reacting(&self) -> Reacting {
        self.generator.reacting()
    }

    /// The maneuvers of `generator` as runs of `design`, simulated with the parameters of `source`.
    ///
    /// # Errors
    /// A vessel without these parameters.
    pub fn new(
        vessel: &'a Vessel,
        generator: &'a Generator,
        source: Source,
        design: &'a str,
    ) -> Result<Self, Refusal> {
        let parameters = vessel.parameters(source).map_err(Refusal::Vessel)?;
        Ok(Self { vessel, generator, parameters, design })
    }

    /// The vessel.
    pub fn vessel(&self) -> &'a Vessel {
        self.vessel
    }

    /// Number of maneuvers, including generated ones that will be left out.
    pub fn count(&self) -> usize {
        self.generator.maneuvers().len()
    }

    /// How maneuvers with tables of inputs are played, one line each.
    pub fn tables(&self) -> Vec<String> {
        self.generator.tables().values().map(ToString::to_string).collect()
    }

    /// Rows of maneuvers `indices`: of all, and of those that no limit leaves out.
    ///
    /// # Errors
    /// A maneuver of zero samples, or unbounded.
    pub fn rows(&self, indices: Range<usize>) -> Result<[usize; 2], Refusal> {
        indices.into_iter().try_fold([0, 0], |[all, written], index| {
            let rows = self.generator.samples(index).map_err(Refusal::Dictionary)? + 1;
            Ok([all + rows, written + if self.generator.limits(index).is_some() { 0 } else { rows }])
        })
    }

    /// Simulates maneuvers `indices`, each from its own initial state, except generated ones that exceed their limits.
    ///
    /// # Errors
    /// A maneuver of zero samples or that the model cannot hold; a simulation that diverges.
    pub fn simulate(&self, indices: Range<usize>) -> Result<(Vec<SimulatedRun>, Tally), Refusal> {
        let (mut runs, mut tally) = (Vec::with_capacity(indices.len()), Tally::default());
        for index in indices {
            if let Some(run) = self.one(index, &mut tally)? {
                tally.maneuvers += 1;
                tally.samples += run.run.samples();
                tally.kept += usize::from(self.generator.limits(index).is_some());
                runs.push(run);
            }
        }
        Ok((runs, tally))
    }

    /// What every maneuver that is written by hand is to reach, and what it does; none where it only plays a table.
    ///
    /// # Errors
    /// As [`Maneuvers::simulate`].
    pub fn reached(&self) -> Result<Vec<Reached>, Refusal> {
        let one = |index: usize| {
            let run = self.one(index, &mut Tally::default())?;
            let aims = run.map_or(Vec::new(), |run| self.generator.reached(index, &run.states));
            let samples = self.generator.samples(index).map_err(Refusal::Dictionary)? as f64;
            let seconds = samples / self.vessel.sample_rate_hz;
            Ok(Reached { maneuver: self.generator.maneuvers()[index].name.clone(), seconds, aims })
        };
        // All, then the first refusal in order: one that a race chose would differ from run to run.
        let all: Vec<_> = (0..self.generator.written()).into_par_iter().map(one).collect();
        all.into_iter().collect()
    }

    /// How well the samples follow the steps of the vessel's terms, which are parts of these: over all maneuvers, for the parameters
    /// that they are simulated with, and whether they go on forward in the range that the vessel is valid in. `None` where samples are
    /// no parts of steps.
    ///
    /// # Errors
    /// As [`Maneuvers::simulate`].
    pub fn divided(&self) -> Result<Option<Divided>, Refusal> {
        let Some(none) = Divided::new(&self.vessel.model) else { return Ok(None) };
        let some = |first: usize| {
            let mut of_run = none.clone();
            for index in first..self.count().min(first + AT_ONCE) {
                if let Some(run) = self.one(index, &mut Tally::default())? {
                    of_run.add(&self.vessel.model, &self.parameters, &run.run.exogenous, &run.states);
                }
            }
            Ok(of_run)
        };
        let starts: Vec<usize> = (0..self.count()).step_by(AT_ONCE).collect();
        let all: Vec<_> = starts.into_par_iter().map(some).collect();
        let mut sum = none.clone();
        for of_run in all {
            sum.merge(&of_run?);
        }
        sum.add_range(self.vessel, &self.parameters);
        Ok(Some(sum))
    }

    /// The maneuvers whose commands depend on the ship's motion: names of those that are written by hand, and from which number
    /// on all are generated ones that do.
    pub fn which_react(&self) -> (Vec<String>, Option<usize>) {
        let (all, written) = (self.generator.maneuvers(), self.generator.written());
        let names = (0..written).filter(|i| self.generator.reacts(*i)).map(|i| all[i].name.clone());
        let generated = (written < all.len() && self.generator.reacts(written)).then_some(written);
        (names.collect(), generated)
    }

    /// Simulates a maneuver, unless it is generated and exceeds its limits.
    fn one(&self, index: usize, tally: &mut Tally) -> Result<Option<SimulatedRun>, Refusal> {
        match judge(self.vessel, self.generator, index).map_err(Refusal::Dictionary)? {
            Judged::Within { initial, mut exogenous, helm } => {
                let (model, rate_hz) = (&self.vessel.model, self.vessel.sample_rate_hz);
                let (mut instruments, mut commands) = (Vec::new(), Vec::new());
                let states = match helm {
                    None => simulate_one(model, &self.parameters, initial, &exogenous),
                    Some(helm) => {
                        let samples = exogenous.len() / model.exogenous().max(1);
                        let own_loop = OwnLoop::new(self.vessel, initial, &[(helm.clone(), samples)]);
                        let ran = simulate_command(model, &self.parameters, initial, samples, rate_hz, &helm);
                        (exogenous, commands) = (ran.exogenous, ran.commands);
                        instruments = own_loop.map_or_else(Vec::new, |it| it.instruments(model, &exogenous));
                        ran.states
                    }
                };
                let maneuver = &self.generator.maneuvers()[index];
                let diverged = match maneuver.kind.standard() {
                    Some(standard) => check_runaway(&states, standard.speed_m_s()),
                    None => check_diverged(states.iter().copied()),
                };
                match diverged {
                    None => {
                        let run = self.run(index, [exogenous, instruments], &states);
                        return Ok(Some(SimulatedRun { run, states, commands }));
                    }
                    Some(_) if self.generator.limits(index).is_some() => tally.unsteady(),
                    Some(at) => {
                        let what = format!("model in maneuver `{}`", maneuver.name);
                        return Err(Refusal::Vessel(at.invalid(what, rate_hz)));
                    }
                }
            }
            Judged::Exceeds(exceeded) => tally.exceeds(&exceeded),
            Judged::Unsteady => tally.unsteady(),
        }
        Ok(None)
    }

    fn run(&self, index: usize, [exogenous, instrument_exogenous]: [Vec<f64>; 2], states: &[f64]) -> Run {
        let maneuver = self.generator.maneuvers()[index].name.clone();
        Run {
            design: self.design.to_owned(),
            run: index as i32,
            segments: vec![Segment { maneuver, start: 0 }],
            exogenous,
            instrument_exogenous,
            measured: states.to_vec(),
            initial: [states[0], states[1], states[2]],
        }
    }
}

/// What a maneuver is to reach, and what it does.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached {
    /// Its name.
    pub maneuver: String,
    /// Its duration \[s\].
    pub seconds: f64,
    /// What is wanted of it.
    pub aims: Vec<Aim>,
}

impl Reached {
    /// In words: `heading to starboard 23.1° (wanted 20.0°), …`; `None` where nothing is wanted.
    pub fn words(&self) -> Option<String> {
        let words: Vec<String> = self.aims.iter().map(ToString::to_string).collect();
        (!words.is_empty()).then(|| words.join(", "))
    }

    /// The first aim that is missed, as a refusal of the maneuver.
    pub fn missed(&self) -> Option<Invalid> {
        let aim = self.aims.iter().find(|aim| !aim.is_met)?;
        let thing = format!("maneuver `{}`, {}", self.maneuver, aim.what);
        let [reached, expected] = [aim.reached, aim.wanted].map(|value| aim.value(value));
        if aim.is_turned_away() {
            let value = format!("{} to the other side in {} s", aim.value(-aim.reached), self.seconds);
            return Some(Invalid::new(thing, value, expected, WRONG_SIGN));
        }
        Some(Invalid::new(
            thing,
            format!("{reached} in {} s", self.seconds),
            expected,
            "lengthen it, change what is commanded or the model that its inputs come from, hold a motion with `executed = \
             \"feedback\"`, or allow it with --allow=unreached",
        ))
    }
}

/// A maneuver judged by its limits.
pub enum Judged {
    /// It keeps them, or has none because it was written by hand.
    Within {
        /// State at the start: u, v \[m/s\], r \[rad/s\].
        initial: [f64; 3],
        /// N × exogenous, row-major.
        exogenous: Vec<f64>,
        /// Its commands, if they depend on the ship's motion.
        helm: Option<Helm>,
    },
    /// It exceeds a limit.
    Exceeds(Exceeded),
    /// No inputs hold its motion.
    Unsteady,
}

/// Judges maneuver `index` with the parameters of its inputs, regardless of the simulated ones.
///
/// # Errors
/// A hand-written maneuver that is too long, that the model cannot hold, or whose motion leaves its `keeps`
/// or [`Vessel::motion`].
pub fn judge(vessel: &Vessel, generator: &Generator, index: usize) -> Result<Judged, Invalid> {
    let samples = generator.samples(index)?;
    let limits = generator.limits(index);
    let Realized { initial, inputs, helm } = match generator.realize(index, samples) {
        Err(_) if limits.is_some() => return Ok(Judged::Unsteady),
        realized => realized?,
    };
    let exogenous = vessel.model.undisturbed(&inputs);
    let maneuver = &generator.maneuvers()[index];
    let is_kept = maneuver.keeps != Kept::default();
    if limits.is_none() && vessel.motion.is_none() && !is_kept {
        return Ok(Judged::Within { initial, exogenous, helm });
    }
    let states = simulate_one(&vessel.model, generator.parameters(), initial, &exogenous);
    maneuver.keeps.check_states(&maneuver.name, &states)?;
    let judged: &[f64] = if maneuver.executed == Executed::Feedback { &[] } else { &inputs };
    let exceeded =
        limits.and_then(|limits| limits.exceeded(&vessel.model, &states, judged, vessel.sample_rate_hz));
    if let Some(exceeded) = exceeded {
        return Ok(Judged::Exceeds(exceeded));
    }
    match vessel.beyond_motion(&states) {
        None => Ok(Judged::Within { initial, exogenous, helm }),
        Some(beyond) if limits.is_some() => Ok(Judged::Exceeds(left_out(vessel, beyond))),
        Some(beyond) => Err(refused(vessel, &maneuver.name, beyond)),
    }
}

/// A generated maneuver that leaves the known range of motion of the model.
fn left_out(vessel: &Vessel, (d, reached): (usize, f64)) -> Exceeded {
    let [low, high] = vessel.motion.map_or([0.0; 2], |ranges| ranges[d]);
    let limit = format!("{} {BEYOND_LOGS}", DegreeOfFreedom::ALL[d].state());
    Exceeded { limit, allowed: 0.0, found: (low - reached).max(reached - high) }
}

/// The refusal of a hand-written one.
fn refused(vessel: &Vessel, name: &str, (d, reached): (usize, f64)) -> Invalid {
    let [low, high] = vessel.motion.map_or([0.0; 2], |ranges| ranges[d]);
    let degree = DegreeOfFreedom::ALL[d];
    Invalid::new(
        format!("maneuver `{name}`"),
        format!("{} = {reached:.4} {}", degree.state(), degree.unit()),
        format!("{low:.4} to {high:.4}, about what the logs of the model cover"),
        "request less, or allow it with --allow=beyond-range",
    )
}

/// Name of the one reason for leaving out a maneuver that is not a limit.
const UNSTEADY: &str = "no steady inputs";
/// Suffix of the reason that a maneuver leaves the motion in the logs of its model, after `u`, `v` or `r`.
const BEYOND_LOGS: &str = "beyond the model's logs";

/// How many maneuvers were simulated, and how many were left out for which reason.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Number of maneuvers.
    pub maneuvers: usize,
    /// Their samples.
    pub samples: usize,
    /// How many of them are generated.
    pub kept: usize,
    /// Generated maneuvers that were left out, by the limit that they exceed most.
    pub left_out: BTreeMap<String, LeftOut>,
}

/// Maneuvers left out for one reason.
#[derive(Clone, Copy, Debug, Default)]
pub struct LeftOut {
    /// Their number.
    pub count: usize,
    /// The limit.
    pub allowed: f64,
    /// The smallest of their values.
    pub nearest: f64,
}

impl Tally {
    fn exceeds(&mut self, Exceeded { limit, allowed, found }: &Exceeded) {
        self.leave_out(limit, LeftOut { count: 1, allowed: *allowed, nearest: *found });
    }

    fn unsteady(&mut self) {
        self.leave_out(UNSTEADY, LeftOut { count: 1, ..LeftOut::default() });
    }

    fn leave_out(&mut self, name: &str, about: LeftOut) {
        let known = self.left_out.entry(name.to_owned()).or_insert(LeftOut { count: 0, ..about });
        known.count += about.count;
        known.nearest = known.nearest.min(about.nearest);
    }

    /// Adds the counts for other maneuvers.
    pub fn merge(&mut self, other: &Self) {
        self.maneuvers += other.maneuvers;
        self.samples += other.samples;
        self.kept += other.kept;
        other.left_out.iter().for_each(|(name, about)| self.leave_out(name, *about));
    }

    /// Refuses limits that no generated maneuver keeps: names the one that most exceed, and the least excess.
    ///
    /// # Errors
    /// Generated maneuvers that are all left out.
    pub fn check(&self) -> Result<(), Invalid> {
        if self.kept > 0 || self.left_out.is_empty() {
            return Ok(());
        }
        let all = self.all_left_out();
        let tightest = self.left_out.iter().max_by(|a, b| a.1.count.cmp(&b.1.count).then(b.0.cmp(a.0)));
        let (name, left) = tightest.map_or(("", LeftOut::default()), |(name, about)| (name.as_str(), *about));
        if name == UNSTEADY {
            return Err(Invalid::new(
                "`generate`",
                format!("no candidate of {all} that inputs hold steady"),
                "at least one",
                "give `speed_m_s` and limits that the vessel can reach, or other `kinds`",
            ));
        }
        if name.ends_with(BEYOND_LOGS) {
            return Err(Invalid::new(
                "`generate`",
                format!(
                    "{} of {all} candidates with {name} most, the nearest by {:.4}",
                    left.count, left.nearest
                ),
                "at least one within the motion in the logs of the model",
                "request speeds and yaw rates as in the logs, or allow more with --allow=beyond-range",
            ));
        }
        Err(Invalid::new(
            format!("`generate.limits.{name}`"),
            format!(
                "{}, which is the tightest: {} of {all} candidates exceed it most, the nearest reaches {:.4}, and none \
                 keeps all limits",
                left.allowed, left.count, left.nearest
            ),
            "limits that at least one candidate keeps",
            format!("raise `{name}`, or draw more `candidates`"),
        ))
    }

    fn all_left_out(&self) -> usize {
        self.left_out.values().map(|left_out| left_out.count).sum()
    }
}

impl fmt::Display for Tally {
    /// `12 maneuvers, 960 samples; 8 of 20 generated left out: 5 by u_m_s, …`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} maneuvers, {} samples", self.maneuvers, self.samples)?;
        let out = self.all_left_out();
        if out == 0 {
            return Ok(());
        }
        let reasons: Vec<String> =
            self.left_out.iter().map(|(name, l)| format!("{} by {name}", l.count)).collect();
        write!(f, "; {out} of {} generated left out: {}", out + self.kept, reasons.join(", "))
    }
}
