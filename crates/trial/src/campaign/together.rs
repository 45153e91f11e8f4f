use std::sync::Arc;

use engine::{Helm, Run, Segment, SideBySide};
use numerics::lanes::{interleave, lane, lane_of, recycle};
use numerics::{LANES, Lane};

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
}

/// Up to [`LANES`] simulated runs of one design, in lanes.
pub struct Together {
    pub(super) design: &'static str,
    /// Number of the first.
    pub(super) first: u32,
    /// The experiment of each; a single one, if all have the same.
    pub(super) experiments: Vec<Arc<Experiment>>,
    pub(super) states: States,
}

impl Together {
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
        let known = self.states.exogenous;
        SideBySide {
            runs: self.experiments.len(),
            exogenous: if known.is_empty() { interleave(&rows()) } else { known },
            initial: [0, 1, 2]
                .map(|d: usize| lane(self.experiments.len(), |run| self.experiments[run].initial[d])),
            samples: [self.states.measured.len() / 3 - 1; LANES],
            measured: self.states.measured,
        }
    }

    /// Recycles the buffer of the states.
    pub fn recycle(self) {
        recycle([self.states.measured]);
    }

    /// A run by itself.
    pub fn run(&self, lane: usize) -> SimulatedRun {
        let [states, measured] = self.states.of(lane);
        let Experiment { segments, initial, exogenous, helm } = &*self.experiments[lane];
        let run = Run {
            design: self.design.to_owned(),
            run: self.number(lane),
            segments: segments.clone(),
            exogenous: helm
                .as_ref()
                .map_or_else(|| exogenous.clone(), |_| lane_of(&self.states.exogenous, lane)),
            measured,
            initial: *initial,
        };
        SimulatedRun { run, states }
    }
}
