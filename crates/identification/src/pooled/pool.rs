use vessel::{DegreeOfFreedom, Model, Vessel};

use super::{
    COLLINEAR, DegreeFit, LostInstruments, NominalModel, Options, OutputError, Part, Prior, Remade,
    deviations, fit, joined, output_error, unidentified,
};
use crate::{DegreeSums, Estimator, MeanRemoval, Sums};

/// How often refined instruments are simulated again.
const ROUNDS: usize = 3;

/// What all estimates of a study have in common.
#[derive(Clone)]
pub struct Pool<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// Its model with intercepts.
    pub model: Model,
    /// How many intercepts.
    pub removal: MeanRemoval,
    /// Strength of the prior.
    pub strength: f64,
    /// Where instruments come from.
    pub nominal: NominalModel,
    /// Most samples of a part; segments are not cut without it.
    pub part_samples: Option<usize>,
    /// Logged channels that never vary, to name where a term hardly does.
    pub constant: Vec<String>,
}

/// What errors and steps of an output-error estimate are measured by.
pub struct Scales {
    /// Standard deviations of the measured u, v, r.
    std: [f64; 3],
    /// Per parameter, intercepts among them, the change that would matter; 0 holds it.
    sizes: Vec<f64>,
}

/// An estimate of pooled parts.
pub struct Estimated {
    /// Surge, sway, yaw.
    pub degrees: [DegreeFit; 3],
    /// What each was made with.
    pub used: [Estimator; 3],
    /// Nominal parameters and intercepts, where there were any.
    pub nominal: Option<(Vec<f64>, [f64; 3])>,
    /// The output-error estimate and its scales, where it was asked for and found.
    pub output_error: Option<(OutputError, Scales)>,
    /// Why no instruments were simulated with `auto`, which then is least squares.
    pub diverged: Option<LostInstruments>,
    /// Sums of the parts with the regressors as instruments.
    ls: Vec<Sums>,
    /// Those with simulated instruments.
    iv: Option<Vec<Sums>>,
}

impl Estimated {
    /// The sums that degree of freedom `d` was estimated from, and whether its instruments were simulated.
    pub fn data(&self, d: usize) -> (&[Sums], bool) {
        match (self.used[d], &self.iv) {
            (Estimator::Iv | Estimator::RefinedIv, Some(iv)) => (iv, true),
            _ => (&self.ls, false),
        }
    }

    /// θ̂ of all degrees of freedom, and their intercepts; none unless all have one.
    pub fn theta(&self) -> Option<(Vec<f64>, [f64; 3])> {
        whole(&self.degrees)
    }

    /// The sums of every part with the regressors as instruments.
    pub fn squares(&self) -> &[Sums] {
        &self.ls
    }

    /// Whether instruments were simulated.
    pub fn instrumented(&self) -> bool {
        self.iv.is_some()
    }

    /// θ̂ and intercepts, in the order of `model`, which has them.
    pub fn parameters(&self, model: &Model) -> Option<Vec<f64>> {
        self.theta().map(|(theta, intercepts)| model.layout().woven(&theta, intercepts))
    }
}

/// θ̂ of all degrees of freedom, and their intercepts.
fn whole(degrees: &[DegreeFit; 3]) -> Option<(Vec<f64>, [f64; 3])> {
    joined(degrees.each_ref().map(|degree| degree.solution.as_ref()))
}

impl Pool<'_> {
    /// Estimates from `parts`, whose instruments are left as they were used.
    ///
    /// # Errors
    /// The nominal simulation diverges.
    pub fn estimate(&self, parts: &mut [Part], estimator: Estimator) -> Result<Estimated, LostInstruments> {
        Part::regress(parts);
        let ls = self.regressions(parts, false).sums();
        let nominal = self.nominal.parameters(&ls.iter().collect::<Vec<_>>(), self.removal);
        let fitted = self.fit(&ls, nominal.as_ref().map(|(theta, _)| theta.as_slice()), Estimator::Ls);
        let mut found = Estimated {
            degrees: fitted,
            used: [Estimator::Ls; 3],
            nominal,
            output_error: None,
            diverged: None,
            ls,
            iv: None,
        };
        if estimator == Estimator::Ls {
            return Ok(found);
        }
        let simulated = found.nominal.as_ref().map(|(theta, c)| self.instrument(parts, theta, *c));
        match (simulated, estimator) {
            (Some(Ok(())), _) => self.instrumented(parts, estimator, &mut found),
            (Some(Err(diverged)), Estimator::Auto | Estimator::OutputError) => {
                found.diverged = Some(diverged)
            }
            (Some(Err(diverged)), _) => return Err(diverged),
            // Least squares found no model to simulate, so nothing is identified either way.
            (None, _) => {}
        }
        if estimator == Estimator::OutputError {
            self.simulated(parts, &mut found);
        }
        Ok(found)
    }

    /// The least-squares estimate of the data of `found`, and its intercepts.
    pub fn least_squares(&self, found: &Estimated) -> Option<(Vec<f64>, [f64; 3])> {
        let nominal = found.nominal.as_ref().map(|(theta, _)| theta.as_slice());
        whole(&self.fit(&found.ls, nominal, Estimator::Ls))
    }

    /// Simulates the model of `theta` and `intercepts` over `parts` as their instruments.
    ///
    /// # Errors
    /// It diverges.
    pub fn instrument(
        &self,
        parts: &mut [Part],
        theta: &[f64],
        intercepts: [f64; 3],
    ) -> Result<(), LostInstruments> {
        Part::instrument(parts, &self.model, &self.model.layout().woven(theta, intercepts))
    }

    fn instrumented(&self, parts: &mut [Part], estimator: Estimator, found: &mut Estimated) {
        let nominal = found.nominal.as_ref().map(|(theta, _)| theta.as_slice());
        let mut data = self.regressions(parts, true).sums();
        let mut degrees = self.fit(&data, nominal, Estimator::Iv);
        let mut model = found.nominal.clone();
        for _ in 0..if estimator == Estimator::RefinedIv { ROUNDS } else { 0 } {
            let Some((own, intercepts)) = whole(&degrees) else { break };
            if self.instrument(parts, &own, intercepts).is_err() {
                break;
            }
            let again = self.regressions(parts, true).sums();
            let refitted = self.fit(&again, nominal, Estimator::Iv);
            if refitted.iter().any(|d| d.solution.is_none()) {
                // Back to the instruments that the estimate is made with; they could be simulated before.
                let _ = model.as_ref().map(|(theta, c)| self.instrument(parts, theta, *c));
                break;
            }
            (data, degrees, model) = (again, refitted, Some((own, intercepts)));
        }
        let used = if estimator == Estimator::RefinedIv { Estimator::RefinedIv } else { Estimator::Iv };
        for (d, degree) in degrees.into_iter().enumerate() {
            if degree.solution.is_some() || !matches!(estimator, Estimator::Auto | Estimator::OutputError) {
                (found.degrees[d], found.used[d]) = (degree, used);
            }
        }
        found.iv = Some(data);
    }

    /// Goes on from the estimate at hand to the least errors of free simulations. Where those diverge, it stays.
    fn simulated(&self, parts: &[Part], found: &mut Estimated) {
        let Some(start) = found.parameters(&self.model) else { return };
        let std = deviations(parts.iter().map(|p| p.measured.as_slice()));
        let scales = Scales { std, sizes: self.sizes(&found.ls, std) };
        let Some(best) = self.least_errors(parts, &start, &scales) else { return };
        let degrees = self.split(&best.parameters);
        for (d, (theta, intercept)) in degrees.into_iter().enumerate() {
            if let Some(solution) = &mut found.degrees[d].solution {
                (solution.theta, solution.intercept) = (theta, intercept);
            }
            found.used[d] = Estimator::OutputError;
        }
        found.output_error = Some((best, scales));
    }

    fn least_errors(&self, parts: &[Part], start: &[f64], scales: &Scales) -> Option<OutputError> {
        output_error(&self.model, parts, start, scales.std, &scales.sizes)
    }

    /// The output-error estimate of the parts at `drawn`, started at that of all: θ̂ of surge, sway and yaw.
    pub fn simulated_again(
        &self,
        parts: &[Part],
        drawn: &[usize],
        found: &Estimated,
    ) -> Option<[Vec<f64>; 3]> {
        let (all, scales) = found.output_error.as_ref()?;
        let own: Vec<Part> = drawn.iter().map(|i| parts[*i].clone()).collect();
        let best = self.least_errors(&own, &all.parameters, scales)?;
        Some(self.split(&best.parameters).map(|(theta, _)| theta))
    }

    /// θ and intercept of surge, sway and yaw from parameters of the model with intercepts.
    fn split(&self, parameters: &[f64]) -> [(Vec<f64>, f64); 3] {
        let layout = self.model.layout();
        let intercepts = layout.intercepts(parameters);
        [0, 1, 2].map(|d| (parameters[layout.terms(d)].to_vec(), intercepts[d]))
    }

    /// Per parameter, intercepts among them, the value with which its term alone would make up the state's deviation in a sample; 0 for an
    /// intercept that is not estimated and a term that is always 0.
    fn sizes(&self, sums: &[Sums], std: [f64; 3]) -> Vec<f64> {
        let whole = Sums::total(sums);
        let n = whole.samples.max(1) as f64;
        let size = |square: f64, std: f64| if square > 0.0 { std / (square / n).sqrt() } else { 0.0 };
        let intercept = |std: f64| if self.removal == MeanRemoval::None { 0.0 } else { std };
        let degree = |(degree, std): (&DegreeSums, f64)| -> Vec<f64> {
            let own = degree.regressor_squares.iter().map(|square| size(*square, std));
            own.chain([intercept(std)]).collect()
        };
        whole.degrees.iter().zip(std).flat_map(degree).collect()
    }

    /// Why degrees of freedom have no estimate, in words.
    pub fn unidentified(&self, degrees: &[DegreeFit; 3]) -> Vec<String> {
        let why = |d: DegreeOfFreedom| {
            let (degree, fit) = (&self.vessel.model.degrees[d as usize], &degrees[d as usize]);
            unidentified(d, degree, &fit.status, &self.constant)
        };
        DegreeOfFreedom::ALL.into_iter().filter_map(why).collect()
    }

    /// Regressors, instruments and increments of every part: with their own instruments if those were `simulated`, from the
    /// measured state on; else with their regressors for instruments.
    pub fn regressions<'b>(&'b self, parts: &'b [Part], simulated: bool) -> Remade<'b> {
        Remade { model: &self.vessel.model, parts, simulated }
    }

    fn fit(&self, sums: &[Sums], nominal: Option<&[f64]>, used: Estimator) -> [DegreeFit; 3] {
        fit(&sums.iter().collect::<Vec<_>>(), &self.options(nominal, used))
    }

    /// The options of a fit. Least squares projects whatever the columns; instruments must not be collinear.
    pub fn options<'b>(&self, nominal: Option<&'b [f64]>, used: Estimator) -> Options<'b> {
        let prior = nominal.filter(|_| self.strength > 0.0);
        Options {
            removal: self.removal,
            prior: prior.map(|nominal| Prior { strength: self.strength, nominal }),
            most: if used.by_instruments() { COLLINEAR } else { f64::INFINITY },
        }
    }
}
