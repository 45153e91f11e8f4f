use design::{Bounds, Candidates, Covariance, Norm, Options, solve_covariance};
use identification::{Noise, OutputInformation, output_information, output_informations};
use vessel::{Generator, Invalid, ParameterLayout, Vessel};

use super::growing_run::GrowingRun;
use crate::campaign::{Judged, judge};

/// Designs for output-error estimates, from a model and from the run so far.
pub struct Planner<'a> {
    vessel: &'a Vessel,
    noise: Noise,
    maneuvers: Vec<Maneuver>,
}

/// A maneuver at its own length.
struct Maneuver {
    /// Its place in the dictionary.
    index: usize,
    initial: [f64; 3],
    exogenous: Vec<f64>,
}

impl<'a> Planner<'a> {
    /// Over the maneuvers of `generator`, but generated ones that exceed their limits.
    ///
    /// # Errors
    /// A maneuver that is too long or that the model cannot hold; limits that leave none.
    pub fn new(vessel: &'a Vessel, generator: &Generator, noise: Noise) -> Result<Self, Invalid> {
        let mut maneuvers = Vec::new();
        for index in 0..generator.maneuvers().len() {
            if let Judged::Within { initial, exogenous } = judge(vessel, generator, index)? {
                maneuvers.push(Maneuver { index, initial, exogenous });
            }
        }
        if maneuvers.is_empty() {
            let (found, expected) = ("none within the limits", "at least one");
            let remedy = "see what `simulate dictionary` says of its limits";
            return Err(Invalid::new("maneuvers", found, expected, remedy));
        }
        Ok(Self { vessel, noise, maneuvers })
    }

    /// Places in the dictionary of the maneuvers that shares are for.
    pub fn maneuvers(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.maneuvers.iter().map(|maneuver| maneuver.index)
    }

    /// Shares of the `coming` samples that make Σ var/size² of the parameters' estimates smallest at their end, for the model
    /// with parameters `theta`, beside what the run so far tells: every candidate's matrix is that of the whole,
    /// (N_past M_past + N_coming M_q)/N. `None` where the model diverges in every maneuver or they do not excite it.
    pub fn shares(
        &self,
        theta: &[f64],
        sizes: &[f64],
        so_far: &GrowingRun,
        coming: usize,
    ) -> Option<Vec<f64>> {
        let before = so_far.samples(self.vessel);
        let past = match before {
            0 => None,
            _ => Some(self.information(theta, so_far.initial, &so_far.exogenous)?),
        };
        let share = coming as f64 / (before + coming) as f64;
        let runs: Vec<([f64; 3], &[f64])> =
            self.maneuvers.iter().map(|m| (m.initial, m.exogenous.as_slice())).collect();
        let found = output_informations(&self.vessel.model, theta, &runs, &self.noise);
        let whole = found.iter().flatten().map(|own| match &past {
            None => (own.information.clone(), own.middle()),
            Some(past) => (
                mixed(&past.information, &own.information, share),
                mixed(&past.middle(), &own.middle(), share),
            ),
        });
        let criterion = self.criterion(whole, sizes)?;
        let options = Options { random_starts: 0, tolerance: 1e-4, ..Options::default() };
        let mut designed =
            solve_covariance(&criterion, &Bounds::default(), &options).ok()?.shares.into_iter();
        Some(found.iter().map(|own| own.as_ref().and_then(|_| designed.next()).unwrap_or(0.0)).collect())
    }

    /// Standard errors of the parameters that an output-error estimate from `run` has if the parameters are `theta`.
    /// `None` where the model diverges or a direction is not excited.
    pub fn standard_errors(&self, theta: &[f64], sizes: &[f64], run: &GrowingRun) -> Option<Vec<f64>> {
        let own = self.information(theta, run.initial, &run.exogenous)?;
        let samples = run.samples(self.vessel) as f64;
        let criterion = self.criterion([(own.information.clone(), own.middle())].into_iter(), sizes)?;
        let variances = criterion.variances(&[1.0])?;
        let kept = self.weights(sizes);
        let errors = variances.iter().zip(kept).filter(|(_, weight)| *weight > 0.0);
        Some(errors.map(|(variance, _)| (variance.max(0.0) / samples).sqrt()).collect())
    }

    fn information(&self, theta: &[f64], initial: [f64; 3], exogenous: &[f64]) -> Option<OutputInformation> {
        output_information(&self.vessel.model, theta, initial, exogenous, &self.noise)
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

    /// 1/size² of the lifted parameters, none for intercepts.
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

#[cfg(test)]
mod tests {
    use super::*;
    use design::apportion;
    use vessel::{DictionaryFile, Source};

    use crate::campaign::{Parts, Plan};

    const NOISE: Noise = Noise { measurement: [0.1, 0.1, 0.1], current: 0.1 };

    #[test]
    fn law_a_design_beats_equal_shares_and_makes_good_what_was_missed() {
        let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
        let dictionary: DictionaryFile =
            toml::from_str(include_str!("../../../../pipelines/paper/dictionary.toml")).unwrap();
        let generator = Generator::without_tables(&vessel, &dictionary).unwrap();
        let planner = Planner::new(&vessel, &generator, NOISE).unwrap();
        let theta = vessel.parameters(Source::Value).unwrap();
        let sizes: Vec<f64> = theta.iter().map(|t| t.abs()).collect();
        let go_on = |run: &GrowingRun, shares: &[f64]| {
            let counts = apportion(shares, 500).into_iter().enumerate().filter(|(_, n)| *n > 0);
            let mut longer = run.clone();
            let plan: Plan = counts.map(|(q, n)| (q, n as usize)).collect();
            longer.go_on(&vessel, &generator, &mut Parts::default(), &plan).unwrap();
            longer
        };
        let error = |run: &GrowingRun| {
            let errors = planner.standard_errors(&theta, &sizes, run).unwrap();
            errors.iter().zip(&sizes).map(|(e, s)| (e / s).powi(2)).sum::<f64>().sqrt()
        };
        let new = GrowingRun::default();
        let once = planner.shares(&theta, &sizes, &new, 500).unwrap();
        let equal = vec![1.0 / 11.0; 11];
        assert!(error(&go_on(&new, &once)) < error(&go_on(&new, &equal)));
        // The same maneuver for a while: the best rest is another one than the best whole.
        let lopsided = go_on(&new, &[1.0].iter().chain(&[0.0; 10]).copied().collect::<Vec<_>>());
        let rest = planner.shares(&theta, &sizes, &lopsided, 500).unwrap();
        assert!(rest[0] < once[0], "{rest:?} {once:?}");
        assert!(error(&go_on(&lopsided, &rest)) < error(&go_on(&lopsided, &equal)));
    }
}
