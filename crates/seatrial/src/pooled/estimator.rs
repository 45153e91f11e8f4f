use identification::pooled::{
    COLLINEAR, DegreeFit, Options, OutputError, Part, PartDiverged, Prior, Regression, fit, output_error,
};
use identification::{DegreeSums, MeanRemoval, Sums};
pub use identification::{Estimator as Method, Estimator as Used};
use vessel::Model;

use super::{NominalModel, deviations};

/// How often refined instruments are simulated again.
const ROUNDS: usize = 3;

/// What all estimates of a study have in common.
#[derive(Clone, Copy)]
pub struct Pool<'a> {
    /// The model structure.
    pub model: &'a Model,
    /// The same with intercepts.
    pub lifted: &'a Model,
    /// How many intercepts.
    pub removal: MeanRemoval,
    /// Strength of the prior.
    pub strength: f64,
    /// Where instruments come from.
    pub nominal: &'a NominalModel,
    /// Logged channels that never vary, to name where a term hardly does.
    pub constant: &'a [String],
}

/// What errors and steps of an output-error estimate are measured by.
pub struct Scales {
    /// Standard deviations of the measured u, v, r.
    std: [f64; 3],
    /// Per lifted parameter the change that would matter; 0 holds it.
    sizes: Vec<f64>,
}

/// An estimate of pooled parts.
pub struct Estimated {
    /// Surge, sway, yaw.
    pub degrees: [DegreeFit; 3],
    /// What each was made with.
    pub used: [Used; 3],
    /// Nominal parameters, lifted; where there were any.
    pub nominal: Option<Vec<f64>>,
    /// The output-error estimate and its scales, where it was asked for and found.
    pub output_error: Option<(OutputError, Scales)>,
    /// Why no instruments were simulated with `auto`, which then is least squares.
    pub diverged: Option<PartDiverged>,
    /// The data with the regressors as instruments.
    ls: Vec<Regression>,
    /// The data with simulated instruments.
    iv: Option<Vec<Regression>>,
}

impl Estimated {
    /// The data that degree of freedom `d` was estimated from.
    pub fn data(&self, d: usize) -> &[Regression] {
        match (self.used[d], &self.iv) {
            (Used::Iv | Used::RefinedIv, Some(iv)) => iv,
            _ => &self.ls,
        }
    }

    /// The data with simulated instruments, where there are any.
    pub fn instrumented(&self) -> Option<&[Regression]> {
        self.iv.as_deref()
    }

    /// θ̂ of all degrees of freedom.
    pub fn theta(&self) -> Option<Vec<f64>> {
        let thetas: Option<Vec<Vec<f64>>> =
            self.degrees.iter().map(|d| d.solution.as_ref().map(|s| s.theta.clone())).collect();
        thetas.map(|t| t.concat())
    }

    /// Intercepts; 0 where there is none.
    pub fn intercepts(&self) -> [f64; 3] {
        [0, 1, 2].map(|d: usize| self.degrees[d].solution.as_ref().map_or(0.0, |s| s.intercept))
    }
}

impl Pool<'_> {
    /// Estimates from `parts`, whose instruments are left as they were used.
    ///
    /// # Errors
    /// The nominal simulation diverges.
    pub fn estimate(&self, parts: &mut [Part], method: Method) -> Result<Estimated, PartDiverged> {
        Part::regress(parts);
        let ls = self.regressions(parts);
        let sums: Vec<Sums> = ls.iter().map(Regression::sums).collect();
        let nominal = self.nominal.parameters(&sums.iter().collect::<Vec<_>>(), self.removal);
        let lifted = nominal.as_ref().map(|(theta, c)| self.lifted.layout().woven(theta, *c));
        let fitted = self.fit(&sums, nominal.as_ref().map(|(theta, _)| theta.as_slice()), Used::Ls);
        let mut found = Estimated {
            degrees: fitted,
            used: [Used::Ls; 3],
            nominal: lifted,
            output_error: None,
            diverged: None,
            ls,
            iv: None,
        };
        if method == Method::Ls {
            return Ok(found);
        }
        match (found.nominal.as_ref().map(|n| Part::instrument(parts, self.lifted, n)), method) {
            (Some(Ok(())), _) => self.instrumented(parts, nominal, method, &mut found),
            (Some(Err(diverged)), Method::Auto | Method::OutputError) => found.diverged = Some(diverged),
            (Some(Err(diverged)), _) => return Err(diverged),
            // Least squares found no model to simulate, so nothing is identified either way.
            (None, _) => {}
        }
        if method == Method::OutputError {
            self.simulated(parts, &sums, &mut found);
        }
        Ok(found)
    }

    fn instrumented(
        &self,
        parts: &mut [Part],
        nominal: Option<(Vec<f64>, [f64; 3])>,
        method: Method,
        found: &mut Estimated,
    ) {
        let theta = nominal.as_ref().map(|(theta, _)| theta.as_slice());
        let mut data = self.instrumented_regressions(parts);
        let mut degrees = self.fit_of(&data, theta, Used::Iv);
        for _ in 0..if method == Method::RefinedIv { ROUNDS } else { 0 } {
            let own: Option<Vec<Vec<f64>>> =
                degrees.iter().map(|d| d.solution.as_ref().map(|s| s.theta.clone())).collect();
            let Some(own) = own.map(|t| t.concat()) else { break };
            let intercepts =
                [0, 1, 2].map(|d: usize| degrees[d].solution.as_ref().map_or(0.0, |s| s.intercept));
            let woven = self.lifted.layout().woven(&own, intercepts);
            if Part::instrument(parts, self.lifted, &woven).is_err() {
                break;
            }
            let again = self.instrumented_regressions(parts);
            let refitted = self.fit_of(&again, theta, Used::Iv);
            if refitted.iter().any(|d| d.solution.is_none()) {
                break;
            }
            (data, degrees) = (again, refitted);
        }
        let used = if method == Method::RefinedIv { Used::RefinedIv } else { Used::Iv };
        for (d, degree) in degrees.into_iter().enumerate() {
            if degree.solution.is_some() || !matches!(method, Method::Auto | Method::OutputError) {
                (found.degrees[d], found.used[d]) = (degree, used);
            }
        }
        found.iv = Some(data);
    }

    /// Goes on from the estimate at hand to the least errors of free simulations. Where those diverge, it stays.
    fn simulated(&self, parts: &[Part], sums: &[Sums], found: &mut Estimated) {
        let Some(theta) = found.theta() else { return };
        let start = self.lifted.layout().woven(&theta, found.intercepts());
        let std = deviations(parts.iter().map(|p| p.measured.as_slice()));
        let scales = Scales { std, sizes: self.sizes(sums, std) };
        let Some(best) = self.least_errors(parts, &start, &scales) else { return };
        let degrees = self.split(&best.parameters);
        for (d, (theta, intercept)) in degrees.into_iter().enumerate() {
            if let Some(solution) = &mut found.degrees[d].solution {
                (solution.theta, solution.intercept) = (theta, intercept);
            }
            found.used[d] = Used::OutputError;
        }
        found.output_error = Some((best, scales));
    }

    fn least_errors(&self, parts: &[Part], start: &[f64], scales: &Scales) -> Option<OutputError> {
        output_error(self.lifted, parts, start, scales.std, &scales.sizes)
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

    /// θ and intercept of surge, sway and yaw from lifted parameters.
    fn split(&self, lifted: &[f64]) -> [(Vec<f64>, f64); 3] {
        let layout = self.lifted.layout();
        let intercepts = layout.intercepts(lifted);
        [0, 1, 2].map(|d| (lifted[layout.terms(d)].to_vec(), intercepts[d]))
    }

    /// Per lifted parameter the value with which its term alone would make up the state's deviation in a sample; 0 for an
    /// intercept that is not estimated and a term that is always 0.
    fn sizes(&self, sums: &[Sums], std: [f64; 3]) -> Vec<f64> {
        let mut whole = Sums::default();
        sums.iter().for_each(|s| whole.merge(s));
        let n = whole.samples.max(1) as f64;
        let size = |square: f64, std: f64| if square > 0.0 { std / (square / n).sqrt() } else { 0.0 };
        let intercept = |std: f64| if self.removal == MeanRemoval::None { 0.0 } else { std };
        let degree = |(degree, std): (&DegreeSums, f64)| -> Vec<f64> {
            let own = degree.regressor_squares.iter().map(|square| size(*square, std));
            own.chain([intercept(std)]).collect()
        };
        whole.degrees.iter().zip(std).flat_map(degree).collect()
    }

    /// Regressors, instruments and increments of every part.
    pub fn regressions(&self, parts: &[Part]) -> Vec<Regression> {
        parts.iter().map(|part| Regression::of(self.model, part)).collect()
    }

    /// Those of parts whose instruments start at the measured state.
    pub fn instrumented_regressions(&self, parts: &[Part]) -> Vec<Regression> {
        self.regressions(parts).into_iter().map(Regression::after_start).collect()
    }

    fn fit_of(&self, data: &[Regression], nominal: Option<&[f64]>, used: Used) -> [DegreeFit; 3] {
        let sums: Vec<Sums> = data.iter().map(Regression::sums).collect();
        self.fit(&sums, nominal, used)
    }

    fn fit(&self, sums: &[Sums], nominal: Option<&[f64]>, used: Used) -> [DegreeFit; 3] {
        fit(&sums.iter().collect::<Vec<_>>(), &self.options(nominal, used))
    }

    /// The options of a fit. Least squares projects whatever the columns; instruments must not be collinear.
    pub fn options<'b>(&self, nominal: Option<&'b [f64]>, used: Used) -> Options<'b> {
        let prior = nominal.filter(|_| self.strength > 0.0);
        Options {
            removal: self.removal,
            prior: prior.map(|nominal| Prior { strength: self.strength, nominal }),
            most: if used.by_instruments() { COLLINEAR } else { f64::INFINITY },
        }
    }
}
