//! The information of maneuvers about the free numbers of a ship with forces.

use std::collections::BTreeMap;

use design::Degree;
use estimation::fitting::{SimulatedRun, WhiteNoise};
use estimation::output_information;
use estimation::pooled::Covariance;
use maneuver::Generator;
use numerics::scaled_inverse;
use refusal::Invalid;
use regression::{Batch, Noise, meat, moments};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{Run, Segment};
use ship::model::{DegreeOfFreedom, ForceModel, Model, Vessel};

use super::matrices::{Unpredictable, diverges};
use super::{DegreeMoments, Expected, FreeRunModel, ManeuverMoments, Moments, OutputErrorMoments, by_name};

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
        let sums = self.simulated(initial, exogenous).information(&self.moved.forces, &self.theta, &still);
        sums.map(|sums| sums.measurement)
    }

    /// 1/σ² of every number's prior, in their order; 0 without one.
    pub fn prior_information(&self) -> Vec<f64> {
        let known = |sigma: f64| 1.0 / (sigma * sigma);
        self.moved.forces.parameters().iter().map(|parameter| parameter.prior.map_or(0.0, known)).collect()
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
        let name = run.segments.first().map_or(String::new(), |segment| segment.maneuver.clone());
        if run.design != DICTIONARY {
            let value = format!("a run of `{}`", run.design);
            let expected = "maneuvers that `simulate dictionary` simulates, of a ship with forces";
            let remedy = "simulate them, or fit the runs by `estimate --fit together`";
            return Err(Invalid::new(format!("maneuver `{name}`"), value, expected, remedy));
        }
        let output_error = self.of_experiment(run.initial, &run.exogenous);
        let output_error = output_error.ok_or_else(|| diverges(&format!("maneuver `{name}`")))?;
        let samples = run.samples() as u64;
        Ok(ManeuverMoments { name, samples, degrees: Vec::new(), output_error: Some(output_error) })
    }

    /// F and P per sample of an experiment from `initial` under `exogenous`, without priors; `None` where it diverges.
    pub(crate) fn of_experiment(&self, initial: [f64; 3], exogenous: &[f64]) -> Option<OutputErrorMoments> {
        let run = self.simulated(initial, exogenous);
        let sums = run.information(&self.moved.forces, &self.theta, &self.noise)?;
        let share = 1.0 / run.samples().max(1) as f64;
        let mean = |sum: Vec<f64>| sum.into_iter().map(|entry| share * entry).collect::<Vec<_>>();
        Some(OutputErrorMoments {
            f: mean(sums.measurement),
            e: None,
            p: (self.noise.current > 0.0).then(|| mean(sums.current)),
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
            sum.iter_mut().zip(slopes.squares(n)).for_each(|(sum, square)| *sum += square);
            total += samples as f64;
        }
        let g = (total > 0.0).then(|| sum.iter().map(|square| square / total).collect());
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
        let known = |name: &str| all.iter().find(|parameter| parameter.name == name)?.prior;
        PriorInformation::new(all.iter().map(|parameter| parameter.name.as_str()), None, known)
    }
}

impl Moments {
    /// Whether they are of a ship with forces, whose numbers have no intercepts beside them.
    pub fn is_of_forces(&self) -> bool {
        let bare = |degree: &Degree| degree.regressors.len() == degree.parameters.len();
        !self.degrees.is_empty() && self.degrees.iter().all(bare)
    }

    /// The same for a trial of `samples`, to each sample of which adds its part what is known before.
    #[must_use]
    pub fn with_prior(mut self, samples: f64) -> Self {
        let (Some(prior), Some(model)) = (&self.prior, &self.output_error) else { return self };
        for moments in self.maneuvers.iter_mut().filter_map(|maneuver| maneuver.output_error.as_mut()) {
            for matrix in [Some(&mut moments.f), moments.e.as_mut()].into_iter().flatten() {
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
        for (share, maneuver) in shares.iter().zip(&self.maneuvers) {
            let f = &maneuver.output_error.as_ref()?.f;
            sum.iter_mut().zip(f).for_each(|(sum, entry)| *sum += share * samples * entry);
        }
        let mut known = vec![0.0; n * n];
        prior.add_to(&mut known, rows, 1.0);
        let inverse = scaled_inverse(n, &sum)?;
        let share = |i: usize| (0..n).map(|j| inverse[i * n + j] * known[j * n + i]).sum::<f64>();
        let parameters = self.degrees.iter().flat_map(|degree| &degree.parameters);
        let place = |name: &String| rows.iter().position(|row| row == name);
        parameters.map(|name| Some((name.clone(), share(place(name)?).clamp(0.0, 1.0)))).collect()
    }
}

/// What is known of parameters before the trial: it counts once for the whole trial, as `F` times samples does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PriorInformation {
    /// The parameters that something is known of.
    pub parameters: Vec<String>,
    /// The inverse of their covariance, row-major: that of a fit, or 1/σ² of each by its prior, σ its standard deviation.
    pub information: Vec<f64>,
}

impl PriorInformation {
    /// The information in `covariance` about the parameters of `names` that it knows, whatever others are; what else `known` has
    /// is 1/σ². `None` where there is nothing.
    pub fn new<'n>(
        names: impl Iterator<Item = &'n str>,
        covariance: Option<&Covariance>,
        known: impl Fn(&str) -> Option<f64>,
    ) -> Option<Self> {
        let place = |name: &str| {
            let fitted = covariance?;
            let place = fitted.names.iter().position(|other| other == name)?;
            // Estimates at bounds have no variance.
            (fitted.entries[place * (fitted.names.len() + 1)] > 0.0).then_some(place)
        };
        let all: Vec<(&str, Option<usize>)> = names
            .map(|name| (name, place(name)))
            .filter(|(name, place)| place.is_some() || known(name).is_some())
            .collect();
        let n = all.len();
        let variances = |k: usize| match (all[k / n], all[k % n]) {
            ((_, Some(row)), (_, Some(column))) => {
                covariance.map_or(0.0, |matrix| matrix.entries[row * matrix.names.len() + column])
            }
            ((name, None), _) if k / n == k % n => known(name).map_or(0.0, |sigma| sigma * sigma),
            _ => 0.0,
        };
        let variances: Vec<f64> = (0..n * n).map(variances).collect();
        let information = scaled_inverse(n, &variances)?;
        let parameters = all.into_iter().map(|(name, _)| name.to_owned()).collect();
        (n > 0).then_some(Self { parameters, information })
    }

    /// Adds its part in each of `samples` to `matrix`, whose rows and columns are `rows`.
    pub(crate) fn add_to(&self, matrix: &mut [f64], rows: &[String], samples: f64) {
        let place = |name: &String| rows.iter().position(|row| row == name);
        let (n, places) = (rows.len(), self.parameters.iter().map(place).collect::<Vec<_>>());
        let of = |k: usize| Some((places[k / places.len()]?, places[k % places.len()]?));
        for (k, known) in self.information.iter().enumerate() {
            if let Some((row, column)) = of(k) {
                matrix[row * n + column] += known / samples;
            }
        }
    }
}

/// Name of the design of a dictionary's runs.
const DICTIONARY: &str = "dictionary";

/// The predictions about estimates, besides the moments themselves.
#[derive(Clone, Debug)]
pub struct Prediction<'a> {
    model: &'a Model,
    /// The expected disturbances and the parameters that the residual is linearised with: for the matrices B.
    noise: Option<(Noise, Vec<f64>)>,
    /// The parameters of free simulations: for output error, with the same disturbances.
    free_runs: Option<Vec<f64>>,
}

/// A measured run as one run per segment, each from its first measured state; a run of a dictionary unchanged.
fn segments(run: &Run) -> Vec<Run> {
    if run.design == DICTIONARY || run.segments.len() < 2 {
        return vec![run.clone()];
    }
    let ends = run.segments.iter().skip(1).map(|s| s.start).chain([run.samples()]);
    let part = |(segment, end): (&Segment, usize)| {
        let part = run.view().part(segment.start..end);
        Run {
            design: run.design.clone(),
            run: run.run,
            segments: vec![Segment { maneuver: segment.maneuver.clone(), start: 0 }],
            exogenous: part.exogenous.to_vec(),
            instrument_exogenous: part.own_instrument_inputs(),
            measured: part.measured.to_vec(),
            initial: if segment.start == 0 { run.initial } else { part.initial },
        }
    };
    run.segments.iter().zip(ends).map(part).collect()
}

impl<'a> Prediction<'a> {
    /// With the matrices B if disturbances are `expected`, and output error's information if there is a model for it.
    pub fn new(model: &'a Model, expected: Option<&Expected>, output_error: Option<&FreeRunModel>) -> Self {
        let theta = |by_name: &BTreeMap<String, f64>| -> Vec<f64> {
            model.parameter_names().map(|name| by_name[name]).collect()
        };
        let noise = expected.map(|e| (e.noise(), theta(&e.parameters)));
        Self { model, noise, free_runs: output_error.map(|o| theta(&o.parameters)) }
    }

    /// The runs whose moments are computed: the segments of measured ones, each with instruments of its own.
    pub fn runs(&self, recorded: &[Run]) -> Vec<Run> {
        recorded.iter().flat_map(segments).collect()
    }

    /// The moments of every run of a batch, each one maneuver, and whether they may be pooled with others of
    /// the same name: those of measured runs may, but not those of a dictionary, where each name has one run.
    ///
    /// # Errors
    /// A free simulation that diverges.
    pub fn moments(&self, batch: &Batch, runs: &[Run]) -> Result<Vec<(bool, ManeuverMoments)>, Invalid> {
        let mut middles = self.noise.as_ref().map(|(noise, theta)| meat(batch, theta, noise).into_iter());
        let of = |(run, sums): (&Run, regression::ManeuverMoments)| {
            let mut middle = middles.as_mut().and_then(Iterator::next).into_iter().flatten();
            let degree = |((d, m), nonstationarity): ((DegreeOfFreedom, Vec<f64>), f64)| DegreeMoments {
                name: d.name().to_owned(),
                shape: [m.len().isqrt() as u64; 2],
                m,
                nonstationarity,
                b: middle.next(),
            };
            let matrices = DegreeOfFreedom::ALL.into_iter().zip(sums.matrices);
            let maneuver = ManeuverMoments {
                name: run.segments[0].maneuver.clone(),
                samples: sums.samples,
                degrees: matrices.zip(sums.nonstationarity).map(degree).collect(),
                output_error: self.output_error(run)?,
            };
            Ok((run.design != DICTIONARY, maneuver))
        };
        runs.iter().zip(moments(batch)).map(of).collect()
    }

    fn output_error(&self, run: &Run) -> Result<Option<OutputErrorMoments>, Invalid> {
        let Some(((noise, _), theta)) = self.noise.as_ref().zip(self.free_runs.as_ref()) else {
            return Ok(None);
        };
        let information = output_information(self.model, theta, run.initial, &run.exogenous, noise)
            .ok_or_else(|| diverges(&format!("maneuver `{}`", run.segments[0].maneuver)))?;
        let weighted = noise.measurement.iter().all(|std| *std > 0.0);
        Ok(Some(OutputErrorMoments {
            f: information.information,
            e: (!weighted).then_some(information.measurement),
            p: (noise.current > 0.0).then_some(information.process),
        }))
    }
}
