//! The information of maneuvers about the free numbers of a ship with forces.

use std::collections::BTreeMap;

use design::Degree;
use estimation::fitting::{SimulatedRun, WhiteNoise};
use maneuver::Generator;
use numerics::scaled_inverse;
use refusal::Invalid;
use regression::Noise;
use ship::engine::Run;
use ship::model::{ForceModel, Vessel};

use super::free_runs::{Unpredictable, diverges};
use super::prediction::DICTIONARY;
use super::prior::PriorInformation;
use super::{FreeRunModel, ManeuverMoments, Moments, OutputErrorMoments, by_name};

/// A ship with forces whose maneuvers are simulated, and what disturbs the measured ones.
#[derive(Clone, Debug)]
pub struct ForcesPrediction<'a> {
    vessel: &'a Vessel,
    moved: &'a ForceModel,
    theta: Vec<f64>,
    noise: WhiteNoise,
}

/// Rows and columns of the matrices of `vessel` with forces: its free numbers, which have no degree of freedom of their own.
pub fn numbers(vessel: &Vessel) -> Vec<Degree> {
    let names = || vessel.model.parameter_names().map(str::to_owned).collect();
    vec![Degree { name: FORCES.to_owned(), regressors: names(), parameters: names() }]
}

/// Name of the block of a ship's free numbers.
const FORCES: &str = "forces";

impl<'a> ForcesPrediction<'a> {
    /// `vessel` with her best known numbers, whose sensors and water have `noise`.
    ///
    /// # Errors
    /// A ship with terms per sample, or without a free number; a state without noise.
    pub fn new(vessel: &'a Vessel, noise: Noise) -> Result<Self, Invalid> {
        Self::with(vessel, vessel.parameters(vessel.best_known())?, noise)
    }

    /// `vessel` with her nominal numbers.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_nominal(vessel: &'a Vessel, noise: Noise) -> Result<Self, Invalid> {
        Self::with(vessel, vessel.nominal.clone(), noise)
    }

    /// `vessel` with the numbers `theta`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn with(vessel: &'a Vessel, theta: Vec<f64>, noise: Noise) -> Result<Self, Invalid> {
        let Some(moved) = &vessel.model.forces else {
            return Err(Invalid::new("`model`", "terms per sample", "`forces`", "predict it by its terms"));
        };
        if theta.is_empty() {
            let remedy = "write some as tables with `nominal`";
            return Err(Invalid::new("the model", "no free number", "at least one to be estimated", remedy));
        }
        if let Some(d) = noise.measurement.iter().position(|std| *std <= 0.0) {
            let thing = format!("`measurement.{}`", ["std_u_m_s", "std_v_m_s", "std_r_rad_s"][d]);
            let expected = "noise in every state, which an output-error estimate weighs errors by";
            return Err(Invalid::new(thing, "0", expected, "state what the sensor has, however little"));
        }
        let noise = WhiteNoise { measurement: noise.measurement, current: noise.current };
        Ok(Self { vessel, moved, theta, noise })
    }

    /// F of a run from `initial` under `exogenous`, summed over its samples; `None` where it diverges.
    pub fn information(&self, initial: [f64; 3], exogenous: &[f64]) -> Option<Vec<f64>> {
        let still = WhiteNoise { current: 0.0, ..self.noise };
        let found = self.simulated(initial, exogenous).information(&self.moved.forces, &self.theta, &still);
        found.map(|own| own.measurement)
    }

    /// 1/σ² of every number's prior, in their order; 0 without one.
    pub fn prior_information(&self) -> Vec<f64> {
        let known =
            |own: &ship::forces::Parameter| own.prior.map_or(0.0, |deviation| 1.0 / (deviation * deviation));
        self.moved.forces.parameters().iter().map(known).collect()
    }

    fn simulated<'r>(&self, initial: [f64; 3], inputs: &'r [f64]) -> SimulatedRun<'r> {
        let width = self.vessel.model.exogenous();
        SimulatedRun { initial, inputs, width, sample_s: self.moved.sample_s }
    }

    /// What a simulated maneuver says of the numbers, per sample.
    ///
    /// # Errors
    /// A measured run; a simulation that diverges.
    pub fn moments(&self, run: &Run) -> Result<ManeuverMoments, Invalid> {
        let name = run.segments.first().map_or(String::new(), |own| own.maneuver.clone());
        if run.design != DICTIONARY {
            let found = format!("a run of `{}`", run.design);
            let expected = "maneuvers that `simulate dictionary` simulates, of a ship with forces";
            let remedy = "simulate them, or fit the runs by `estimate pool`";
            return Err(Invalid::new(format!("maneuver `{name}`"), found, expected, remedy));
        }
        let output_error = self.of_experiment(run.initial, &run.exogenous);
        let output_error = output_error.ok_or_else(|| diverges(&format!("maneuver `{name}`")))?;
        let samples = run.samples() as u64;
        Ok(ManeuverMoments { name, samples, degrees: Vec::new(), output_error: Some(output_error) })
    }

    /// F and P per sample of an experiment from `initial` under `exogenous`, without priors; `None` where it diverges.
    pub(crate) fn of_experiment(&self, initial: [f64; 3], exogenous: &[f64]) -> Option<OutputErrorMoments> {
        let run = self.simulated(initial, exogenous);
        let found = run.information(&self.moved.forces, &self.theta, &self.noise)?;
        let share = 1.0 / run.samples().max(1) as f64;
        let mean = |sum: Vec<f64>| sum.into_iter().map(|own| share * own).collect::<Vec<_>>();
        Some(OutputErrorMoments {
            f: mean(found.measurement),
            e: None,
            p: (self.noise.current > 0.0).then(|| mean(found.current)),
        })
    }

    /// The model of free simulations, and what their errors over the maneuvers of `validation` depend on.
    ///
    /// # Errors
    /// A maneuver that the ship cannot hold, or that diverges.
    pub fn free_runs(&self, validation: &Generator) -> Result<FreeRunModel, Unpredictable> {
        let (model, n) = (&self.vessel.model, self.theta.len());
        let (mut sum, mut total) = (vec![0.0; n * n], 0.0);
        for (index, maneuver) in validation.maneuvers().iter().enumerate() {
            let samples = validation.samples(index).map_err(Unpredictable::Maneuver)?;
            let run = validation.realize(index, samples).map_err(Unpredictable::Maneuver)?;
            let inputs = model.undisturbed(&run.inputs);
            let slopes = self.simulated(run.initial, &inputs).slopes(&self.moved.forces, &self.theta);
            let slopes = slopes.ok_or_else(|| {
                Unpredictable::Vessel(diverges(&format!("validation maneuver `{}`", maneuver.name)))
            })?;
            sum.iter_mut().zip(slopes.squares(n)).for_each(|(sum, own)| *sum += own);
            total += samples as f64;
        }
        let g = (total > 0.0).then(|| sum.iter().map(|own| own / total).collect());
        Ok(FreeRunModel {
            simulated_with: self.vessel.best_known(),
            parameters: by_name(model, &self.theta),
            rows: model.parameter_names().map(str::to_owned).collect(),
            g,
        })
    }

    /// What the priors of the numbers know; `None` without any.
    pub fn prior(&self) -> Option<PriorInformation> {
        let all = self.moved.forces.parameters();
        let known = |name: &str| all.iter().find(|own| own.name == name)?.prior;
        PriorInformation::new(all.iter().map(|own| own.name.as_str()), None, known)
    }
}

impl Moments {
    /// Whether they are of a ship with forces, whose numbers have no intercepts beside them.
    pub fn is_of_forces(&self) -> bool {
        let bare = |own: &Degree| own.regressors.len() == own.parameters.len();
        !self.degrees.is_empty() && self.degrees.iter().all(bare)
    }

    /// The same for a trial of `samples`, to each sample of which adds its part what is known before.
    #[must_use]
    pub fn with_prior(mut self, samples: f64) -> Self {
        let (Some(prior), Some(model)) = (&self.prior, &self.output_error) else { return self };
        for own in self.maneuvers.iter_mut().filter_map(|own| own.output_error.as_mut()) {
            for matrix in [Some(&mut own.f), own.e.as_mut()].into_iter().flatten() {
                if matrix.len() == model.rows.len() * model.rows.len() {
                    prior.add_to(matrix, &model.rows, samples);
                }
            }
        }
        self
    }

    /// How much of each estimate is known before, from 0 to 1, after `samples` of these `shares` of the maneuvers, of moments
    /// with that; `None` where nothing is, or the information is singular.
    pub fn prior_shares(&self, shares: &[f64], samples: f64) -> Option<BTreeMap<String, f64>> {
        let (prior, rows) = (self.prior.as_ref()?, &self.output_error.as_ref()?.rows);
        let n = rows.len();
        let mut sum = vec![0.0; n * n];
        for (share, own) in shares.iter().zip(&self.maneuvers) {
            let f = &own.output_error.as_ref()?.f;
            sum.iter_mut().zip(f).for_each(|(sum, own)| *sum += share * samples * own);
        }
        let mut known = vec![0.0; n * n];
        prior.add_to(&mut known, rows, 1.0);
        let inverse = scaled_inverse(n, &sum)?;
        let share = |i: usize| (0..n).map(|j| inverse[i * n + j] * known[j * n + i]).sum::<f64>();
        let parameters = self.degrees.iter().flat_map(|degree| &degree.parameters);
        let place = |name: &String| rows.iter().position(|own| own == name);
        parameters.map(|name| Some((name.clone(), share(place(name)?).clamp(0.0, 1.0)))).collect()
    }
}
