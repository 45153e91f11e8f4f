//! `monte-carlo`: runs that are counted as they are realized.

use std::ops::Range;

use estimation::Estimator;
use numerics::LANES;
use seatrial::{MonteCarlo, Realized, StudyError};
use study::kept::Kept;
use validation::tally::{Bounds, Tally};

use crate::failure::{Failure, Progress};
use crate::inputs::ordered;
use crate::simulate::Files;

/// Groups of runs per block of the tables.
pub const BLOCK: usize = 64;

/// Upper bound on the square root of the runs that a share needs for an interval of this half-width.
pub fn needed_for(width: f64) -> f64 {
    0.98 / width
}

/// A failure that names the file at fault.
pub fn refused(files: &Files, error: StudyError) -> Failure {
    match error {
        StudyError::Trial(refusal) => files.refused(refusal),
        StudyError::Estimate(error) => Failure::of_run(&error, files.vessel, files.campaign),
        StudyError::Invalid(invalid) => Failure::invalid(files.campaign, &invalid),
        StudyError::Design(error) => Failure::NoAnswer(error.to_string()),
    }
}

/// The work and its progress reports.
pub struct Done<'a> {
    /// The study.
    pub study: &'a MonteCarlo<'a>,
    /// Its files, for messages.
    pub files: &'a Files<'a>,
    /// Bounds of good estimates.
    pub bounds: Bounds,
    /// No progress.
    pub quiet: bool,
}

impl Done<'_> {
    fn blank(&self) -> Tally {
        Tally::new(&self.study.campaign.names(), &self.study.estimators.estimators)
    }

    /// Realizes and counts `parts`; the kept rows of each are added to `kept` in order.
    ///
    /// # Errors
    /// A simulation that diverges; output that fails.
    pub fn tallied(&self, parts: Vec<(usize, Range<usize>)>, kept: &mut Kept) -> Result<Tally, Failure> {
        let runs: usize = parts.iter().map(|(_, runs)| runs.len()).sum();
        let progress = Progress::new("runs", runs, self.quiet).foretold(self.seconds(runs));
        let mut tally = self.blank();
        self.count(parts, kept, &mut tally, &progress)?;
        Ok(tally)
    }

    fn count(
        &self,
        parts: Vec<(usize, Range<usize>)>,
        kept: &mut Kept,
        tally: &mut Tally,
        progress: &Progress,
    ) -> Result<(), Failure> {
        let (first, scores_alone) = (kept.first(), kept.of_scores_alone());
        let work = |i: usize| {
            let (design, runs) = parts[i].clone();
            let count = runs.len();
            let realized = match scores_alone {
                true => self.study.scores(design, runs).map(Realized::scored),
                false => self.study.realize(design, runs, first),
            };
            let realized = realized.map_err(|e| refused(self.files, e))?;
            let mut own = self.blank();
            own.add(&realized.scores, self.bounds);
            progress.advance(count);
            Ok::<_, Failure>((own, realized))
        };
        ordered(0..parts.len(), work, |(own, realized)| {
            tally.merge(own);
            Ok(kept.push(realized.scores, realized.estimates, &realized.runs)?)
        })
    }

    /// Continues until no share's interval is wider than twice `width`; checks at fixed numbers of runs, each a tenth
    /// larger.
    ///
    /// # Errors
    /// A simulation that diverges.
    pub fn until(&self, width: f64) -> Result<Tally, Failure> {
        let (mut tally, mut done) = (self.blank(), 0);
        let designs = self.study.campaign.designs();
        let most = needed_for(width).powi(2) * designs as f64;
        let progress = Progress::new("runs", most as usize, self.quiet).foretold(self.seconds(most as usize));
        while tally.half_width() > width && done < self.study.campaign.realizations() {
            let next = (done + (done / 10).max(LANES * BLOCK)).next_multiple_of(LANES * BLOCK);
            let next = next.min(self.study.campaign.realizations());
            let starts = || (done..next).step_by(LANES * BLOCK);
            let parts = (0..designs)
                .flat_map(|d| starts().map(move |start| (d, start..next.min(start + LANES * BLOCK))))
                .collect();
            self.count(parts, &mut Kept::default(), &mut tally, &progress)?;
            done = next;
        }
        Ok(tally)
    }

    /// Seconds of one thread for `runs` runs, order of magnitude.
    fn seconds(&self, runs: usize) -> f64 {
        let searched =
            self.study.estimators.estimators.iter().filter(|e| !matches!(e, Estimator::Ls | Estimator::Iv));
        let each = SECONDS_PER_ROW + searched.map(|e| e.seconds_per_row()).sum::<f64>();
        runs as f64 * self.study.campaign.samples() as f64 * each
    }
}

/// Seconds per row and thread for simulation, estimation by regression and scoring, order of magnitude.
const SECONDS_PER_ROW: f64 = 3e-8;
