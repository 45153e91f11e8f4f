use std::ops::Range;

use vessel::{
    Exceeded, Generator, Limits, Realized, Run, Segment, Source, Vessel, check_diverged, refuse_endless,
    simulate_one,
};

use super::Refusal;
use super::sea::SimulatedRun;
use super::tally::Tally;

/// The maneuvers of a dictionary or of a validation, each an undisturbed run of its own.
pub struct Maneuvers<'a> {
    vessel: &'a Vessel,
    generator: &'a Generator,
    parameters: Vec<f64>,
    design: &'a str,
}

impl<'a> Maneuvers<'a> {
    /// The maneuvers of `generator` as runs of `design`; the parameters of `source` move the vessel.
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

    /// Number of maneuvers, with generated ones that will be left out.
    pub fn count(&self) -> usize {
        self.generator.maneuvers().len()
    }

    /// Simulates maneuvers `indices`, each from its own initial state, but generated ones that exceed their limits.
    ///
    /// # Errors
    /// A maneuver of zero samples or that the model cannot hold; a simulation that diverges.
    pub fn simulate(&self, indices: Range<usize>) -> Result<(Vec<SimulatedRun>, Tally), Refusal> {
        let (mut runs, mut tally) = (Vec::with_capacity(indices.len()), Tally::default());
        for index in indices {
            let run = match self.generator.limits(index) {
                Some(limits) => self.within(index, limits, &mut tally)?,
                None => Some(self.written(index)?),
            };
            if let Some(run) = run {
                tally.simulated(run.run.samples(), self.generator.limits(index).is_some());
                runs.push(run);
            }
        }
        Ok((runs, tally))
    }

    /// A generated maneuver, unless it exceeds its limits.
    fn within(
        &self,
        index: usize,
        limits: &Limits,
        tally: &mut Tally,
    ) -> Result<Option<SimulatedRun>, Refusal> {
        let samples = self.generator.samples(index).map_err(Refusal::Dictionary)?;
        match judge(self.vessel, self.generator, index, limits, samples) {
            Judged::Within { initial, exogenous } => {
                let states = self.states(initial, &exogenous);
                if check_diverged(states.iter().copied()).is_none() {
                    return Ok(Some(self.run(index, exogenous, states)));
                }
                tally.unsteady();
            }
            Judged::Exceeds(exceeded) => tally.exceeds(&exceeded),
            Judged::Unsteady => tally.unsteady(),
        }
        Ok(None)
    }

    /// A maneuver written by hand, which no limits hold for.
    fn written(&self, index: usize) -> Result<SimulatedRun, Refusal> {
        let name = &self.generator.maneuvers()[index].name;
        let samples = self.generator.samples(index).map_err(Refusal::Dictionary)?;
        refuse_endless(format!("maneuver `{name}`, `duration_s`"), samples).map_err(Refusal::Dictionary)?;
        let Realized { initial, inputs } =
            self.generator.realize(index, samples).map_err(Refusal::Dictionary)?;
        let exogenous = self.vessel.model.undisturbed(&inputs);
        let states = self.states(initial, &exogenous);
        match check_diverged(states.iter().copied()) {
            None => Ok(self.run(index, exogenous, states)),
            Some(at) => Err(Refusal::Vessel(at.invalid(format!("model in maneuver `{name}`")))),
        }
    }

    fn states(&self, initial: [f64; 3], exogenous: &[f64]) -> Vec<f64> {
        simulate_one(&self.vessel.model, &self.parameters, initial, exogenous)
    }

    fn run(&self, index: usize, exogenous: Vec<f64>, states: Vec<f64>) -> SimulatedRun {
        let maneuver = self.generator.maneuvers()[index].name.clone();
        let run = Run {
            design: self.design.to_owned(),
            run: index as i32,
            segments: vec![Segment { maneuver, start: 0 }],
            exogenous,
            measured: states.clone(),
            initial: [states[0], states[1], states[2]],
        };
        SimulatedRun { run, states }
    }
}

/// A generated maneuver beside its limits.
pub enum Judged {
    /// It keeps them.
    Within {
        /// State at the start: u, v \[m/s\], r \[rad/s\].
        initial: [f64; 3],
        /// N × exogenous, row-major.
        exogenous: Vec<f64>,
    },
    /// It does not.
    Exceeds(Exceeded),
    /// No inputs hold its motion.
    Unsteady,
}

/// Judges maneuver `index` in `samples` samples by what its inputs were made with, whatever moves the vessel.
pub fn judge(
    vessel: &Vessel,
    generator: &Generator,
    index: usize,
    limits: &Limits,
    samples: usize,
) -> Judged {
    let Ok(Realized { initial, inputs }) = generator.realize(index, samples) else { return Judged::Unsteady };
    let exogenous = vessel.model.undisturbed(&inputs);
    let states = simulate_one(&vessel.model, generator.parameters(), initial, &exogenous);
    match limits.exceeded(&vessel.model, &states, &inputs) {
        Some(exceeded) => Judged::Exceeds(exceeded),
        None => Judged::Within { initial, exogenous },
    }
}
