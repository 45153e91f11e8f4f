use design::{Candidates, Covariance, Norm, Options, solve_covariance_among, solve_covariance_from};
use estimation::{OutputInformation, Simulated, output_informations};
use maneuver::Generator;
use refusal::Invalid;
use regression::Noise;
use ship::model::{ParameterLayout, Vessel};

use crate::campaign::{Judged, judge};

/// Designs for output-error estimates, from a model and from the run so far.
pub struct Planner<'a> {
    vessel: &'a Vessel,
    noise: Noise,
    maneuvers: Vec<Maneuver>,
}

/// The trial before its next round.
pub struct SoFar<'a> {
    /// Number of samples so far.
    pub samples: usize,
    /// Their information, by the planning model.
    pub information: &'a OutputInformation,
    /// Shares of the previous round, which start the search for the next.
    pub shares: &'a [f64],
}

/// A maneuver at its own length.
struct Maneuver {
    /// Its index in the dictionary.
    index: usize,
    initial: [f64; 3],
    exogenous: Vec<f64>,
}

impl<'a> Planner<'a> {
    /// For the maneuvers of `generator`, except generated ones that exceed their limits.
    ///
    /// # Errors
    /// A maneuver that is too long or that the model cannot hold; limits that leave none.
    pub fn new(vessel: &'a Vessel, generator: &Generator, noise: Noise) -> Result<Self, Invalid> {
        let mut maneuvers = Vec::new();
        for index in 0..generator.maneuvers().len() {
            if let Judged::Within { initial, exogenous, .. } = judge(vessel, generator, index)? {
                maneuvers.push(Maneuver { index, initial, exogenous });
            }
        }
        if maneuvers.is_empty() {
            let (found, expected) = ("none within the limits", "at least one");
            let remedy = "see the messages of `simulate dictionary` about its limits";
            return Err(Invalid::new("maneuvers", found, expected, remedy));
        }
        Ok(Self { vessel, noise, maneuvers })
    }

    /// Indices in the dictionary of the maneuvers with shares.
    pub fn maneuvers(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.maneuvers.iter().map(|maneuver| maneuver.index)
    }

    /// Shares of the `coming` samples that minimize Σ var/size² of the parameters' estimates at their end,
    /// for the model with parameters `theta`, in addition to the information of the run so far: every
    /// candidate's matrix is that of the whole, (N_past M_past + N_coming M_q)/N. `None` where the model
    /// diverges in every maneuver or they do not excite it.
    pub fn shares(
        &self,
        theta: &[f64],
        sizes: &[f64],
        so_far: Option<SoFar>,
        coming: usize,
    ) -> Option<Vec<f64>> {
        let before = so_far.as_ref().map_or(0, |so_far| so_far.samples);
        let past = so_far.as_ref().map(|so_far| so_far.information);
        let share = coming as f64 / (before + coming) as f64;
        let each = self.maneuvers.iter();
        let each = each.map(|m| Simulated { theta, initial: m.initial, exogenous: &m.exogenous });
        let found = self.informations(&each.collect::<Vec<_>>());
        let whole = found.iter().flatten().map(|own| match past {
            None => (own.information.clone(), own.middle()),
            Some(past) => (
                mixed(&past.information, &own.information, share),
                mixed(&past.middle(), &own.middle(), share),
            ),
        });
        let criterion = self.criterion(whole, sizes)?;
        let latest = so_far.map(|so_far| {
            let kept = so_far.shares.iter().zip(&found).filter(|(_, found)| found.is_some());
            kept.map(|(share, _)| *share).collect::<Vec<f64>>()
        });
        let mut designed = self.solved(&criterion, latest)?.into_iter();
        Some(found.iter().map(|own| own.as_ref().and_then(|_| designed.next()).unwrap_or(0.0)).collect())
    }

    /// The best shares, searched from the `latest` if there are any.
    fn solved(&self, criterion: &Covariance, latest: Option<Vec<f64>>) -> Option<Vec<f64>> {
        let options = Options { random_starts: 0, tolerance: 1e-4, ..Options::default() };
        let from = latest.filter(|shares| shares.iter().any(|share| *share > 0.0));
        let designed = match from.map(|shares| solve_covariance_from(criterion, &shares, &options)) {
            Some(Ok(designed)) => designed,
            _ => solve_covariance_among(criterion, 2 * self.layout().parameters(), &options).ok()?,
        };
        Some(designed.shares)
    }

    /// Standard errors of an output-error estimate from a run of `samples` with this `information`. `None`
    /// where a direction is not excited.
    pub fn standard_errors(
        &self,
        information: &OutputInformation,
        sizes: &[f64],
        samples: usize,
    ) -> Option<Vec<f64>> {
        let own = (information.information.clone(), information.middle());
        let criterion = self.criterion(std::iter::once(own), sizes)?;
        let variances = criterion.variances(&[1.0])?;
        let kept = self.weights(sizes);
        let errors = variances.iter().zip(kept).filter(|(_, weight)| *weight > 0.0);
        Some(errors.map(|(variance, _)| (variance.max(0.0) / samples as f64).sqrt()).collect())
    }

    /// The information of runs. `None` for those that diverge.
    pub fn informations(&self, runs: &[Simulated]) -> Vec<Option<OutputInformation>> {
        output_informations(&self.vessel.model, runs, &self.noise)
    }

    /// The sum of var/size² over candidates' information and middle matrices.
    fn criterion(
        &self,
        candidates: impl Iterator<Item = (Vec<f64>, Vec<f64>)>,
        sizes: &[f64],
    ) -> Option<Covariance> {
        let dimensions = vec![self.layout().parameters()];
        let (mut information, mut middle) =
            (Candidates::new(dimensions.clone()), Candidates::new(dimensions));
        for (own, noise) in candidates {
            information.push(&own).ok()?;
            middle.push(&noise).ok()?;
        }
        Covariance::new(&information, &middle, &self.weights(sizes), Norm::Trace).ok()
    }

    /// 1/size² of the lifted parameters, zero for intercepts.
    fn weights(&self, sizes: &[f64]) -> Vec<f64> {
        let weights: Vec<f64> = sizes.iter().map(|size| size.powi(-2)).collect();
        self.layout().woven(&weights, [0.0; 3])
    }

    /// The order of information matrices' rows.
    fn layout(&self) -> ParameterLayout {
        self.vessel.model.layout().with_intercepts()
    }
}

/// (1 − share) past + share × own.
fn mixed(past: &[f64], own: &[f64], share: f64) -> Vec<f64> {
    past.iter().zip(own).map(|(past, own)| (1.0 - share) * past + share * own).collect()
}
