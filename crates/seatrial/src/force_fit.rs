//! The forces of a ship, fitted to runs.

use estimation::fitting::{
    Channels, Estimates, Fit, Inputs, Prior, Problem, RecordingView, Settings, Starts, Unfit,
};
use estimation::one_step_errors;
use estimation::pooled::{Covariance, Delivered, RecordingConstant, Score, covered};
use refusal::Invalid;
use regression::pooled::{Part, PooledRuns};
use ship::engine::replay;
use ship::forces::Forces;
use ship::model::Vessel;
use study::documents::{FittedForces, FittedParameter, ModelDocument, Reference, SailedSums};
use validation::comparison::Magnitudes;
use validation::crossval::{CrossError, CrossValidation, cross_validate_forces};

use crate::criticism;
use crate::criticism::{Captive, beside, channels, criticised, interval};

/// The standard error of a parameter that grows more than this because others are unknown is none of its own.
const COLLINEAR: f64 = 10.0;

/// Recordings by name, in parts without gaps.
pub(crate) type Recorded = (String, Vec<Part>);

/// All parts of `sources`, as fits take them.
fn recordings(sources: &[Recorded]) -> Vec<RecordingView<'_>> {
    let all = sources.iter().flat_map(|(name, parts)| parts.iter().map(move |part| (name, part)));
    all.map(|(name, part)| RecordingView { name, inputs: &part.exogenous, measured: &part.measured })
        .collect()
}

/// Options of a fit of forces to runs.
pub struct ForceFit<'a> {
    /// The ship, whose model is made of forces.
    pub vessel: &'a Vessel,
    /// Windows, weights and starts.
    pub settings: Settings,
    /// What a former fit says of the parameters, in place of the ship's nominal values.
    pub former: Option<&'a [f64]>,
    /// Values of captive tests to set beside the estimates. They change none.
    pub reference: Option<&'a Reference>,
}

impl ForceFit<'_> {
    /// The model of `runs`.
    ///
    /// # Errors
    /// Why there is no fit, or a model without forces.
    pub fn model(&self, runs: &PooledRuns) -> Result<ModelDocument, ForceFitError> {
        self.forces()?;
        let (sources, held) = (runs.windows(None), runs.are_inputs_held());
        self.fitted_model(runs, (&sources, held))
    }

    /// The model of `runs`, whose recordings are `sources`.
    pub(crate) fn fitted_model(
        &self,
        runs: &PooledRuns,
        (sources, held): (&[Recorded], bool),
    ) -> Result<ModelDocument, ForceFitError> {
        let forces = self.forces()?;
        let problem = self.problem(forces, sources, held)?;
        let fit = self.fit(&problem)?;
        let estimates = problem.estimates(&fit)?;
        let mut fitted = self.fitted(forces, (&fit, &estimates), &problem)?;
        fitted.sailed = self.sailed(forces, (&fit, &estimates), sources);
        let also = criticism::captive_statements(fitted.sailed.as_ref(), &fitted.parameters);
        let criticism = criticised(self.vessel, &problem, &fit)?;
        let (verdict, rejected) = (criticism.statements.clone(), criticism.rejected);
        fitted.criticism = Some(criticism);
        let mut model = ModelDocument::fitted(self.vessel, &self.delivered(&fit, sources, held), fitted);
        model.rejected = Some(rejected);
        model.statements = verdict.into_iter().chain(statements(&estimates)).chain(also).collect();
        let Ok(magnitudes) = Magnitudes::of(&self.vessel.model, runs, self.vessel.sample_rate_hz);
        model.magnitudes = magnitudes;
        Ok(model)
    }

    /// The fit; where there is none, a wrong sign may say why.
    fn fit(&self, problem: &Problem) -> Result<Fit, Unfit> {
        let theta = self.former.unwrap_or(&self.vessel.nominal);
        problem.fit_from(theta).map_err(|error| {
            let channels = channels(self.vessel);
            let inputs = self.vessel.model.inputs;
            problem.explained(error, theta, Channels { all: &channels, inputs })
        })
    }

    /// The free numbers that fit `runs` best.
    ///
    /// # Errors
    /// As [`Self::model`].
    pub fn theta(&self, runs: &PooledRuns) -> Result<Vec<f64>, ForceFitError> {
        self.theta_of(&runs.windows(None), runs.are_inputs_held())
    }

    /// The same of recordings.
    pub(crate) fn theta_of(&self, sources: &[Recorded], held: bool) -> Result<Vec<f64>, ForceFitError> {
        self.theta_from(self.former.unwrap_or(&self.vessel.nominal), sources, held)
    }

    /// The same, searched for from `theta` on.
    pub(crate) fn theta_from(
        &self,
        theta: &[f64],
        sources: &[Recorded],
        held: bool,
    ) -> Result<Vec<f64>, ForceFitError> {
        let problem = self.problem(self.forces()?, sources, held)?;
        Ok(problem.fit_from(theta)?.theta)
    }

    /// Leaves runs or recordings out, fits the others, and simulates those left out over windows of so many samples, or whole,
    /// in so many folds, or each alone.
    /// `done` is called with the number of fits that are done.
    ///
    /// # Errors
    /// Nothing can be left out; no window.
    pub fn cross(
        &self,
        runs: &PooledRuns,
        scored: (Option<usize>, Option<usize>),
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<CrossValidation, CrossError> {
        let fit = |left_out: &[String]| {
            let mut others = runs.clone();
            others.select(&[], left_out).map_err(|e| e.to_string())?;
            self.theta(&others).map_err(|e| e.to_string())
        };
        cross_validate_forces(&self.vessel.model, runs, scored, &fit, done)
    }

    /// The forces of the ship.
    pub(crate) fn forces(&self) -> Result<&Forces, Invalid> {
        Ok(&self.vessel.model.forces.as_ref().ok_or_else(without_forces)?.forces)
    }

    fn problem<'p>(
        &self,
        forces: &'p Forces,
        sources: &'p [Recorded],
        are_inputs_held: bool,
    ) -> Result<Problem<'p>, Unfit> {
        let settings = self.settings_for(are_inputs_held);
        let width = self.vessel.model.exogenous();
        let problem = Problem::new(forces, recordings(sources), width, settings)?;
        Ok(problem.with_priors(self.priors(forces)))
    }

    /// The settings, where inputs do this between samples.
    fn settings_for(&self, are_inputs_held: bool) -> Settings {
        let inputs = if are_inputs_held { Inputs::Held } else { Inputs::Linear };
        Settings { inputs, ..self.settings }
    }

    /// Values of captive tests.
    fn captive(&self) -> Captive {
        self.reference.map(|reference| reference.derivatives.clone()).unwrap_or_default()
    }

    /// Sums of terms along what was sailed.
    fn sailed(
        &self,
        forces: &Forces,
        (fit, estimates): (&Fit, &Estimates),
        sources: &[Recorded],
    ) -> Option<SailedSums> {
        let states = sources.iter().flat_map(|(_, p)| p).flat_map(|part| part.measured.as_chunks::<3>().0);
        let drift = criticism::drift(states, forces.description().ship.length_m)?;
        let priors = self.priors(forces);
        criticism::sailed(forces, (&fit.theta, estimates), &priors, &self.captive(), drift)
    }

    /// Priors about the ship's nominal values, or those of a former fit.
    fn priors(&self, forces: &Forces) -> Vec<Option<Prior>> {
        let means = self.former.unwrap_or(&self.vessel.nominal);
        let prior = |(parameter, mean): (&ship::forces::Parameter, &f64)| {
            parameter.prior.map(|deviation| Prior { mean: *mean, deviation })
        };
        forces.parameters().iter().zip(means).map(prior).collect()
    }

    fn fitted(
        &self,
        forces: &Forces,
        (fit, estimates): (&Fit, &Estimates),
        problem: &Problem,
    ) -> Result<FittedForces, Invalid> {
        let priors = self.priors(forces);
        let means = self.former.unwrap_or(&self.vessel.nominal);
        let captive = self.captive();
        let parameter = |i: usize| {
            let (parameter, estimate) = (&forces.parameters()[i], &estimates.parameters[i]);
            let si_value = estimate.value * parameter.scale;
            let si_interval = estimate
                .standard_error
                .and_then(|error| interval(si_value, error * parameter.scale, estimates.pieces));
            let parameter = FittedParameter {
                name: parameter.name.clone(),
                unit: parameter.unit.clone(),
                value: estimate.value,
                standard_error: estimate.standard_error,
                prior: means[i],
                prior_deviation: priors[i].map(|prior| prior.deviation),
                prior_share: estimate.prior_share,
                inflation: estimate.inflation,
                entangled: is_collinear(estimate),
                si_value,
                si_interval,
                si_unit: parameter.si_unit.clone(),
                prime_value: parameter.prime.map(|one| si_value / one),
                prime_interval: parameter.prime.zip(si_interval).map(|(one, ends)| ends.map(|end| end / one)),
                captive: None,
                truth: self.vessel.value[i],
            };
            FittedParameter { captive: beside(&parameter, &captive), ..parameter }
        };
        let names = estimates.parameters.iter().map(|parameter| parameter.name.clone()).collect();
        Ok(FittedForces {
            description: FittedForces::text(forces.description())?,
            parameters: (0..fit.theta.len()).map(parameter).collect(),
            covariance: Covariance {
                joint: true,
                names,
                entries: estimates.covariance.clone(),
                // One piece is compared with nothing.
                parts: Some(estimates.pieces as u64).filter(|parts| *parts > 1),
            },
            condition: Some(estimates.condition).filter(|condition| condition.is_finite()),
            window_s: self.settings.window_s,
            windows: problem.windows() as u64,
            pieces: estimates.pieces as u64,
            unknown_starts: self.settings.starts == Starts::Unknown,
            held_inputs: problem.are_inputs_held(),
            prior_weight: self.settings.prior_weight,
            cost: fit.cost,
            steps: fit.steps as u64,
            sailed: None,
            criticism: None,
            captive_source: self.reference.map(|reference| reference.source.clone()),
        })
    }

    /// How the fit follows the recordings, whole and from sample to sample.
    fn delivered(&self, fit: &Fit, sources: &[Recorded], held: bool) -> Delivered {
        let model = &self.vessel.model;
        let mut score = Score::default();
        let (mut squares, mut samples, mut recordings) = ([0.0; 3], 0.0, Vec::new());
        for (source, parts) in sources {
            let (mut left, mut count) = ([0.0; 3], 0);
            for part in parts {
                let states = replay(model, &fit.theta, part.view().initial, &part.exogenous, held);
                score.add_states(&states, part.view());
                let errors = one_step_errors(model, &fit.theta, part, held);
                count += part.samples() as u64;
                for (d, error) in errors.iter().enumerate() {
                    left[d] += error.iter().sum::<f64>();
                    squares[d] += error.iter().map(|error| error * error).sum::<f64>();
                }
            }
            samples += count as f64;
            let [constant_u, constant_v, constant_r] = left.map(|sum| sum / (count as f64).max(1.0));
            let source = source.clone();
            recordings.push(RecordingConstant { source, samples: count, constant_u, constant_v, constant_r });
        }
        let parts: Vec<Part> = sources.iter().flat_map(|(_, parts)| parts.iter().cloned()).collect();
        Delivered {
            theta: fit.theta.clone(),
            constant: [0.0; 3],
            covariance: None,
            least_squares: None,
            increment_std: squares.map(|sum| (sum / f64::max(samples, 1.0)).sqrt()),
            output_rmse: score.rmse(),
            recordings,
            surroundings: Vec::new(),
            covered: covered(model, &parts),
        }
    }
}

fn is_collinear(parameter: &estimation::fitting::Parameter) -> bool {
    parameter.standard_error.is_some() && parameter.inflation.is_none_or(|inflation| inflation > COLLINEAR)
}

/// What to know before using the fit.
fn statements(estimates: &Estimates) -> Vec<String> {
    let named = |of: &dyn Fn(&estimation::fitting::Parameter) -> bool| -> Vec<String> {
        let names = estimates.parameters.iter().filter(|parameter| of(parameter));
        names.map(|parameter| format!("`{}`", parameter.name)).collect()
    };
    let mut all = Vec::new();
    let collinear = named(&is_collinear);
    if !collinear.is_empty() {
        let index = match estimates.condition {
            index if index.is_finite() => format!("condition index {index:.0}"),
            _ => "the runs leave a direction open".to_owned(),
        };
        all.push(format!("{index}: the runs know sums of terms, not {} alone", collinear.join(", ")));
    }
    let prior = named(&|parameter| parameter.prior_share > 0.5);
    let at_bound = named(&|parameter| parameter.standard_error.is_none());
    for (what, names) in [("more than half the prior's", prior), ("at a bound", at_bound)] {
        if !names.is_empty() {
            all.push(format!("{what}: {}", names.join(", ")));
        }
    }
    all
}

fn without_forces() -> Invalid {
    let remedy = "write `model = \"forces\"`, or take another estimator";
    Invalid::new("`model`", "terms per sample", "forces", remedy)
}

/// Why forces were not fitted.
#[derive(Debug, thiserror::Error)]
pub enum ForceFitError {
    /// There is no fit.
    #[error("{0}")]
    Unfit(#[from] Unfit),
    /// What is asked for is invalid.
    #[error("{0}")]
    Invalid(#[from] Invalid),
}
