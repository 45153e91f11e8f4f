//! Realizations of a campaign that are estimated and scored as soon as they are simulated.

use std::ops::Range;

use identification::runs::RunEstimators;
use identification::{RunEstimate, RunScore, ValidationRuns};
use rayon::prelude::*;
use trial::campaign::{Campaign, SimulatedRun};
use vessel::{LANES, Run};

use crate::StudyError;

/// Runs that are simulated, estimated and scored together.
const TOGETHER: usize = 8 * LANES;

/// A campaign, how its runs are estimated and what their models are worth.
pub struct MonteCarlo<'a> {
    /// The runs.
    pub campaign: Campaign<'a>,
    /// What is made of each.
    pub estimators: RunEstimators<'a>,
    /// What the estimated models are simulated over.
    pub validation: ValidationRuns<'a>,
    /// The true parameters, where they are known.
    pub truth: Option<Vec<f64>>,
}

/// What some runs became.
#[derive(Default)]
pub struct Realized {
    /// The runs that were to be kept.
    pub runs: Vec<SimulatedRun>,
    /// Their estimates, run by run by every estimator.
    pub estimates: Vec<RunEstimate>,
    /// The scores of these.
    pub scores: Vec<RunScore>,
}

impl MonteCarlo<'_> {
    /// Groups of runs of one design that are simulated side by side, all designs one after the other: what is shared between
    /// machines.
    pub fn groups(&self) -> usize {
        self.campaign.designs() * self.campaign.realizations().div_ceil(LANES)
    }

    /// The runs of `groups`, as ranges of at most `most` groups of one design each.
    pub fn parts(&self, groups: Range<usize>, most: usize) -> Vec<(usize, Range<usize>)> {
        let each = self.campaign.realizations().div_ceil(LANES);
        let (mut parts, mut first) = (Vec::new(), groups.start);
        while first < groups.end {
            let (design, within) = (first / each, first % each);
            let count = most.min(groups.end - first).min(each - within);
            let last = self.campaign.realizations().min((within + count) * LANES);
            parts.push((design, within * LANES..last));
            first += count;
        }
        parts
    }

    /// Simulates, estimates and scores `runs` of a design on all threads; the first `kept` runs of the design are kept.
    ///
    /// # Errors
    /// A simulation that diverges; runs that are too short.
    pub fn realize(&self, design: usize, runs: Range<usize>, kept: usize) -> Result<Realized, StudyError> {
        let starts: Vec<usize> = runs.clone().step_by(TOGETHER).collect();
        let some = |start: &usize| self.some(design, *start..runs.end.min(start + TOGETHER), kept);
        let found: Vec<Result<Realized, StudyError>> = starts.par_iter().map(some).collect();
        found.into_iter().try_fold(Realized::default(), |mut all, found| {
            let Realized { runs, estimates, scores } = found?;
            all.runs.extend(runs);
            all.estimates.extend(estimates);
            all.scores.extend(scores);
            Ok(all)
        })
    }

    fn some(&self, design: usize, runs: Range<usize>, kept: usize) -> Result<Realized, StudyError> {
        let simulated = self.campaign.simulate(design, runs)?.into_iter();
        let (own, states): (Vec<Run>, Vec<Vec<f64>>) = simulated.map(|s| (s.run, s.states)).unzip();
        let estimates = self.estimators.estimates(&own)?;
        let scores = self.validation.score(&estimates, self.truth.as_deref());
        let again = own.into_iter().zip(states).map(|(run, states)| SimulatedRun { run, states });
        let kept = again.filter(|simulated| (simulated.run.run as usize) < kept).collect();
        Ok(Realized { runs: kept, estimates, scores })
    }
}
