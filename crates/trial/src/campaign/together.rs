use std::sync::Arc;

use numerics::lanes::{interleave, lane, lane_of, recycle};
use numerics::{LANES, Lane};
use ship::engine::{Helm, Run, Segment, SideBySide};
use ship::model::Model;

use super::own_loop::OwnLoop;
use super::sea::{SimulatedRun, States};

/// The planned content of a run, without disturbances.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Its segments, in order.
    pub segments: Vec<Segment>,
    /// State at the start: u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// Inputs, and measured disturbances of zero: N × exogenous, row-major.
    pub exogenous: Vec<f64>,
    /// Its commands, if they depend on the ship's motion. Then the above are those of an undisturbed ship.
    pub helm: Option<Helm>,
    /// The instruments of motions that it tracks.
    pub own_loop: Option<OwnLoop>,
}

/// Up to [`LANES`] simulated runs of one design, in lanes.
pub struct Together<'a> {
    pub(super) model: &'a Model,
    pub(super) design: &'static str,
    /// Number of the first.
    pub(super) first: u32,
    /// The experiment of each; a single one, if all have the same.
    pub(super) experiments: Vec<Arc<Experiment>>,
    pub(super) states: States,
}

impl Together<'_> {
    /// How many runs there are.
    pub fn runs(&self) -> usize {
        self.experiments.len()
    }

    /// Number of a run.
    fn number(&self, lane: usize) -> i32 {
        self.first as i32 + lane as i32
    }

    /// Measured states, (N+1) × 3.
    pub fn measured(&self) -> &[Lane] {
        &self.states.measured
    }

    /// First samples of the segments of each.
    pub fn starts(&self) -> Vec<Vec<usize>> {
        let own =
            |experiment: &Arc<Experiment>| experiment.segments.iter().map(|segment| segment.start).collect();
        self.experiments.iter().map(own).collect()
    }

    /// The runs in the form that estimators take.
    pub fn side_by_side(self) -> SideBySide {
        let rows = || self.experiments.iter().map(|own| own.exogenous.as_slice()).collect::<Vec<_>>();
        let instrument_exogenous = self.instrument_exogenous();
        let known = self.states.exogenous;
        SideBySide {
            runs: self.experiments.len(),
            instrument_exogenous,
            exogenous: if known.is_empty() { interleave(&rows()) } else { known },
            initial: [0, 1, 2]
                .map(|d: usize| lane(self.experiments.len(), |run| self.experiments[run].initial[d])),
            samples: [self.states.measured.len() / 3 - 1; LANES],
            measured: self.states.measured,
        }
    }

    /// What instruments are simulated with, N × exogenous; empty where that are the recorded inputs of all runs.
    fn instrument_exogenous(&self) -> Vec<Lane> {
        if self.experiments.iter().all(|own| own.own_loop.is_none()) {
            return Vec::new();
        }
        let rows = |(lane, own): (usize, &Arc<Experiment>)| {
            let recorded = lane_of(&self.states.exogenous, lane);
            match &own.own_loop {
                Some(own) => own.instruments(self.model, &recorded),
                None => recorded,
            }
        };
        let rows: Vec<Vec<f64>> = self.experiments.iter().enumerate().map(rows).collect();
        interleave(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }

    /// Recycles the buffer of the states.
    pub fn recycle(self) {
        recycle([self.states.measured]);
    }

    /// A run by itself.
    pub fn run(&self, lane: usize) -> SimulatedRun {
        let [states, measured] = self.states.of(lane);
        let Experiment { segments, initial, exogenous, helm, own_loop } = &*self.experiments[lane];
        let exogenous = match helm {
            None => exogenous.clone(),
            Some(_) => lane_of(&self.states.exogenous, lane),
        };
        let instruments =
            own_loop.as_ref().map(|own| own.instruments(self.model, &exogenous)).unwrap_or_default();
        let run = Run {
            design: self.design.to_owned(),
            run: self.number(lane),
            segments: segments.clone(),
            exogenous,
            instrument_exogenous: instruments,
            measured,
            initial: *initial,
        };
        SimulatedRun { run, states, commands: lane_of(&self.states.commands, lane) }
    }
}
