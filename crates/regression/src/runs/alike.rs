//! Runs with the same inputs, whose instruments are computed once for all of them.

use numerics::{LANES, Lane};
use ship::engine::{Run, check_diverged, simulate_one};
use ship::model::Vessel;

use super::nominal_diverged::NominalDiverged;
use crate::{Batch, Excitation, Instruments, MeanRemoval, Outcome};

/// The inputs and the initial state of a run.
#[derive(Clone, Debug)]
pub struct Doing<'a> {
    /// Its design.
    pub design: &'a str,
    /// Its number.
    pub run: i32,
    /// First samples of its segments.
    pub starts: Vec<usize>,
    /// State at the start.
    pub initial: [f64; 3],
    /// N × exogenous, row-major.
    pub exogenous: &'a [f64],
}

impl<'a> Doing<'a> {
    pub(super) fn of(run: &'a Run) -> Self {
        let Run { design, initial, exogenous, .. } = run;
        Self { design, run: run.run, starts: run.starts(), initial: *initial, exogenous }
    }
}

/// The instruments of all runs with the same inputs.
pub struct SharedInputs<'a> {
    vessel: &'a Vessel,
    exogenous: &'a [f64],
    starts: Vec<usize>,
    states: Vec<f64>,
    sums: Instruments,
}

impl<'a> SharedInputs<'a> {
    /// The instruments of runs with the inputs and initial state of `one`.
    ///
    /// # Errors
    /// The nominal simulation diverges.
    pub fn new(vessel: &'a Vessel, one: &Doing<'a>, removal: MeanRemoval) -> Result<Self, NominalDiverged> {
        let Doing { design, run, starts, initial, exogenous } = one.clone();
        let states = simulate_one(&vessel.model, &vessel.nominal, initial, exogenous);
        if let Some(at) = check_diverged(states.iter().copied()) {
            return Err(NominalDiverged::over(design, run, at, vessel.sample_rate_hz));
        }
        let unmeasured = vec![Lane::ZERO; states.len()];
        let sums = Instruments::new(&batch(vessel, exogenous, &states, &starts, &unmeasured), removal);
        Ok(Self { vessel, exogenous, starts, states, sums })
    }

    /// The parameters of [`LANES`] such runs from their `measured` states, (N+1) × 3.
    pub fn parameters(&self, measured: &[Lane]) -> Vec<Outcome<Vec<f64>>> {
        self.sums.parameters(&self.batch(measured))
    }

    /// Their estimates, and the excitation of each degree of freedom.
    pub(super) fn estimates_with_excitation(&self, measured: &[Lane]) -> Vec<(Outcome, [Excitation; 3])> {
        self.sums.estimate_with_excitation(&self.batch(measured))
    }

    fn batch<'b>(&'b self, measured: &'b [Lane]) -> Batch<'b, f64> {
        batch(self.vessel, self.exogenous, &self.states, &self.starts, measured)
    }
}

fn batch<'b>(
    vessel: &'b Vessel,
    exogenous: &'b [f64],
    instrument_states: &'b [f64],
    starts: &'b [usize],
    measured: &'b [Lane],
) -> Batch<'b, f64> {
    Batch {
        model: &vessel.model,
        measured,
        instrument_states,
        exogenous,
        instrument_exogenous: exogenous,
        segments: [starts; LANES],
    }
}
