//! The shortest experiment of a wanted accuracy.

use std::path::Path;

use artifact::Provenance;
use design::{Bounds, Design, Error, Options};

use super::accuracy::{self, Errors, Wanted};
use super::available::{Available, Experiment};
use super::criterion::Criterion;
use super::matrices::Estimated;
use super::refusal::no_design;
use crate::failure::Failure;
use crate::instruments::Removal;
use study::documents::{Accuracy, MomentsDocument};

/// How long has an experiment to be?
pub struct Question<'a> {
    /// The file of the moments, for messages.
    pub file: &'a Path,
    /// The moments.
    pub moments: &'a MomentsDocument,
    /// The criterion.
    pub criterion: &'a Criterion,
    /// The estimate that it is about.
    pub estimated: Estimated,
    /// Mean removal of the paper's criterion, to compare with.
    pub removal: Removal,
    /// Squares that variances are relative to.
    pub squares: Vec<f64>,
    /// The accuracy.
    pub wanted: Wanted,
    /// Whether the largest relative error is made small instead of the criterion.
    pub least_largest: bool,
    /// How much of every maneuver exists.
    pub available: Option<&'a Path>,
}

/// A design of the shortest duration for an accuracy.
pub struct Timed {
    /// The design.
    pub design: Design,
    /// How long it takes, in time.
    pub accuracy: Accuracy,
}

impl Question<'_> {
    /// The answer.
    ///
    /// # Errors
    /// A criterion without standard errors; an accuracy out of reach, telling the best; as the solvers.
    pub fn shortest(&self, options: &Options, provenance: &mut Provenance) -> Result<Timed, Failure> {
        let own = accuracy::needs_covariance(self.criterion)?;
        let errors = Errors::new(own, self.moments, self.estimated, &self.squares, self.wanted.per_parameter);
        let rate = self.moments.sample_rate_hz;
        let (design, bound, samples) = if self.available.is_some() {
            self.within_what_is_available(&errors, options, provenance)?
        } else {
            let (design, bound) = self.solve(&errors, &Bounds::default(), options)?;
            let samples = accuracy::reachable(self.file, &errors, &design.shares, &self.wanted, rate)?;
            (design, bound, samples)
        };
        let paper = accuracy::papers_shares(self.file, self.moments, self.removal, &Bounds::default());
        let (wanted, moments, paper) = (&self.wanted, self.moments, paper.as_deref());
        let accuracy = accuracy::document(&errors, &design.shares, wanted, moments, samples, bound, paper);
        Ok(Timed { design, accuracy })
    }

    fn refuse(&self, error: Error) -> Failure {
        no_design(self.file, self.moments, self.estimated, error)
    }

    /// The best shares within bounds, and a bound on the least largest error where that is asked for.
    fn solve(
        &self,
        errors: &Errors,
        bounds: &Bounds,
        options: &Options,
    ) -> Result<(Design, Option<f64>), Failure> {
        let refuse = |e| self.refuse(e);
        let mut design = self.criterion.solve(bounds, options).map_err(refuse)?;
        if !self.least_largest {
            return Ok((design, None));
        }
        let make = |weights: &[f64]| accuracy::reweighted(self.file, self.moments, self.estimated, weights);
        let (shares, bound) = accuracy::least_largest(errors, bounds, options, make, refuse)?;
        design.log_det = self.criterion.value(&shares).unwrap_or(f64::MIN);
        design.sensitivities = self.criterion.sensitivities(&shares).unwrap_or(design.sensitivities);
        design.gap = design.sensitivities.iter().copied().fold(f64::MIN, f64::max) - self.criterion.degree();
        design.shares = shares;
        Ok((design, Some(bound)))
    }

    /// What limits the shares of an experiment of so many samples; `None` where not so much is available.
    fn bounds(&self, samples: f64, provenance: &mut Provenance) -> Result<Option<Bounds>, Failure> {
        let Some(path) = self.available else { return Ok(Some(Bounds::default())) };
        let experiment = Experiment { samples: Some(samples), segments: None };
        match Available::read(path, self.moments, &experiment, provenance) {
            Ok(available) => Bounds::new(&available.shares).map(Some).map_err(|e| self.refuse(e)),
            Err(Failure::NoAnswer(_)) => Ok(None),
            Err(other) => Err(other),
        }
    }

    /// By halving: the longest experiment that is available, then the shortest that is accurate enough.
    fn within_what_is_available(
        &self,
        errors: &Errors,
        options: &Options,
        provenance: &mut Provenance,
    ) -> Result<(Design, Option<f64>, f64), Failure> {
        let rate = self.moments.sample_rate_hz;
        let (mut longest, mut beyond) = (1.0, (self.wanted.longest_s * rate).floor() + 1.0);
        while beyond - longest > 1.0 {
            let middle = (0.5 * (longest + beyond)).floor();
            match self.bounds(middle, provenance)? {
                Some(_) => longest = middle,
                None => beyond = middle,
            }
        }
        let Some(bounds) = self.bounds(longest, provenance)? else {
            return Err(self.refuse(Error::Infeasible { total: 0.0 }));
        };
        let (mut design, mut bound) = self.solve(errors, &bounds, options)?;
        let at_most = Wanted { longest_s: longest / rate, ..self.wanted };
        accuracy::reachable(self.file, errors, &design.shares, &at_most, rate)?;
        let (mut low, mut high) = (0.0, longest);
        while high - low > 1.0 {
            let middle = (0.5 * (low + high)).floor();
            let found = match self.bounds(middle, provenance)? {
                Some(bounds) => Some(self.solve(errors, &bounds, options)?),
                None => None,
            };
            match found.filter(|(d, _)| accuracy::samples(errors, &d.shares, &self.wanted) <= middle) {
                Some(found) => ((design, bound), high) = (found, middle),
                None => low = middle,
            }
        }
        Ok((design, bound, high))
    }
}
