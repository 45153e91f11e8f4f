use std::ops::Range;

use maneuver::{Aim, Exceeded, Executed, Generator, Kept, Reacting, Realized, WRONG_SIGN};
use rayon::prelude::*;
use refusal::Invalid;
use ship::engine::{
    Divided, Helm, Run, Segment, check_diverged, check_runaway, simulate_command, simulate_one,
};
use ship::model::{DegreeOfFreedom, Source, Vessel};

use super::Refusal;
use super::own_loop::OwnLoop;
use super::sea::SimulatedRun;
use super::tally::{BEYOND_LOGS, Tally};

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

    /// Simulates maneuvers `indices`, each from its own initial state, except generated ones that exceed
    /// their limits.
    ///
    /// # Errors
    /// A maneuver of zero samples or that the model cannot hold; a simulation that diverges.
    pub fn simulate(&self, indices: Range<usize>) -> Result<(Vec<SimulatedRun>, Tally), Refusal> {
        let (mut runs, mut tally) = (Vec::with_capacity(indices.len()), Tally::default());
        for index in indices {
            if let Some(run) = self.one(index, &mut tally)? {
                tally.simulated(run.run.samples(), self.generator.limits(index).is_some());
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
            let seconds = self.generator.samples(index).map_err(Refusal::Dictionary)? as f64;
            let seconds = seconds / self.vessel.sample_rate_hz;
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
            let mut found = none.clone();
            for index in first..self.count().min(first + AT_ONCE) {
                if let Some(run) = self.one(index, &mut Tally::default())? {
                    found.add(&self.vessel.model, &self.parameters, &run.run.exogenous, &run.states);
                }
            }
            Ok(found)
        };
        let starts: Vec<usize> = (0..self.count()).step_by(AT_ONCE).collect();
        let all: Vec<_> = starts.into_par_iter().map(some).collect();
        let mut sum = none.clone();
        for found in all {
            sum.merge(&found?);
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
                        instruments =
                            own_loop.map(|own| own.instruments(model, &exogenous)).unwrap_or_default();
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
        let [found, expected] = [aim.reached, aim.wanted].map(|value| aim.value(value));
        if aim.is_turned_away() {
            let found = format!("{} to the other side in {} s", aim.value(-aim.reached), self.seconds);
            return Some(Invalid::new(thing, found, expected, WRONG_SIGN));
        }
        Some(Invalid::new(
            thing,
            format!("{found} in {} s", self.seconds),
            expected,
            "lengthen it, change what is commanded or the model that its inputs come from, hold a motion with `executed = \
             \"feedback\"`, or allow it with --allow-unreached",
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
fn left_out(vessel: &Vessel, (d, found): (usize, f64)) -> Exceeded {
    let [low, high] = vessel.motion.map_or([0.0; 2], |ranges| ranges[d]);
    let limit = format!("{} {BEYOND_LOGS}", DegreeOfFreedom::ALL[d].state());
    Exceeded { limit, allowed: 0.0, found: (low - found).max(found - high) }
}

/// The refusal of a hand-written one.
fn refused(vessel: &Vessel, name: &str, (d, found): (usize, f64)) -> Invalid {
    let [low, high] = vessel.motion.map_or([0.0; 2], |ranges| ranges[d]);
    let degree = DegreeOfFreedom::ALL[d];
    Invalid::new(
        format!("maneuver `{name}`"),
        format!("{} = {found:.4} {}", degree.state(), degree.unit()),
        format!("{low:.4} to {high:.4}, about what the logs of the model cover"),
        "request less, or allow it with --beyond-range",
    )
}
