//! `campaign.toml`.

use estimation::predictor::{Flow, ForceNoise, NoiseModel};
use maneuver::{DictionaryFile, ManeuverSpec};
use refusal::Invalid;
use regression::{InstrumentKind, Noise};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{Axes, Current, Disturbances, Measurement, Wind};
use ship::model::{Source, Vessel};
use trial::campaign::{Sea, Settings};
use validation::tally::Bounds;

use crate::written::sequential::RoundsSpec;

/// `campaign.toml` as written.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CampaignFile {
    /// Seed of every random number of the study.
    pub seed: u64,
    /// Runs per design.
    #[schemars(range(min = 1))]
    pub realizations: u32,
    /// Duration of a run \[s\].
    #[schemars(range(min = 1e-6, max = 1e9))]
    pub duration_s: f64,
    /// The current.
    pub current: Current,
    /// The measurement noise.
    pub measurement: Measurement,
    /// A wind-like force, if any.
    pub wind: Option<Wind>,
    /// The random design, if any; with it there is one of today's practice, too.
    pub random: Option<RandomSpec>,
    /// Trials in rounds, if any.
    #[serde(skip_serializing)]
    pub rounds: Option<RoundsSpec>,
    /// The validation of estimates.
    pub validation: ValidationSpec,
}

/// Experiments of maneuvers drawn at random.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomSpec {
    /// Number of equally long segments.
    #[schemars(range(min = 1))]
    pub segments: u32,
}

/// The validation maneuvers, and the bounds of good estimates.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ValidationSpec {
    /// Bound on the parameter error.
    #[schemars(range(min = 1e-9, max = 1e9))]
    pub parameter_error_bound: f64,
    /// Bound on the simulation error.
    #[schemars(range(min = 1e-9, max = 1e9))]
    pub simulation_error_bound: f64,
    /// Which parameters turn the maneuvers into inputs.
    #[serde(default)]
    pub inputs_from: Source,
    /// The maneuvers, each a separate run.
    #[serde(skip_serializing)]
    pub maneuver: Vec<ManeuverSpec>,
}

impl CampaignFile {
    /// Current and measurement noise.
    pub fn disturbances(&self) -> Disturbances {
        Disturbances { current: self.current, measurement: self.measurement }
    }

    /// The bounds of good estimates.
    pub fn bounds(&self) -> Bounds {
        Bounds {
            parameter_error: self.validation.parameter_error_bound,
            simulation_error: self.validation.simulation_error_bound,
        }
    }

    /// Size and seed of the campaign; `seed` replaces the file's.
    pub fn settings(&self, seed: Option<u64>) -> Settings {
        Settings {
            duration_s: self.duration_s,
            realizations: self.realizations,
            random_segments: self.random.map(|random| random.segments),
            seed: seed.unwrap_or(self.seed),
        }
    }

    /// `vessel` among the campaign's disturbances.
    ///
    /// # Errors
    /// A vessel without true parameters.
    pub fn sea<'a>(&self, vessel: &'a Vessel) -> Result<Sea<'a>, Invalid> {
        Sea::new(vessel, self.disturbances(), self.wind)
    }

    /// The disturbances at `rate_hz`, as estimators take them.
    pub fn levels(&self, rate_hz: f64) -> NoiseModel {
        let turning = |axes: Axes| if axes == Axes::Earth { 1.0 / rate_hz } else { 0.0 };
        let current = match self.current {
            Current::None => Flow::Still,
            Current::White { std_m_s } => Flow::White { std: std_m_s },
            Current::Constant { std_m_s, axes } | Current::GaussMarkov { std_m_s, axes, .. } => {
                let factor = self.current.factor(rate_hz).unwrap_or(1.0);
                Flow::Markov { std: std_m_s, factor, turning: turning(axes) }
            }
        };
        let gusts =
            |wind: Wind| ForceNoise { std: wind.std_per_sample(rate_hz), factor: [wind.factor(rate_hz); 3] };
        NoiseModel { measurement: self.measurement.std(), current, force: self.wind.map(gusts), drift: None }
    }

    /// The noise of every sample; `None` if the current is correlated. Without the wind.
    pub fn noise(&self) -> Option<Noise> {
        let current = match self.current {
            Current::None => 0.0,
            Current::White { std_m_s } => std_m_s,
            Current::Constant { .. } | Current::GaussMarkov { .. } => return None,
        };
        Some(Noise { measurement: self.measurement.std(), current })
    }

    /// The noise of every sample, for predictions of the errors of output-error estimates.
    ///
    /// # Errors
    /// Disturbances without such predictions: wind, a correlated current, a velocity without noise.
    pub fn predictable_noise(&self) -> Result<Noise, Invalid> {
        let Some(noise) = self.noise().filter(|_| self.wind.is_none()) else {
            let expected = "no current or a white one, which errors are predicted for";
            let remedy = "take a campaign without wind and lasting currents";
            return Err(Invalid::new("disturbances", "wind or a lasting current", expected, remedy));
        };
        if noise.measurement.contains(&0.0) {
            let expected = "noise in u, v and r, which errors are predicted from";
            let remedy = "state what the sensors have";
            return Err(Invalid::new("`measurement`", "a standard deviation of 0", expected, remedy));
        }
        Ok(noise)
    }

    /// [`CampaignFile::noise`] for predictions that need white noise; `remedy` for other disturbances.
    ///
    /// # Errors
    /// A correlated current.
    pub fn white_noise(&self, remedy: &str) -> Result<Noise, Invalid> {
        let expected = "`none` or `white`, which the covariance of the estimate is predicted for";
        let lasting = || Invalid::new("`current.kind`", "a current that lasts", expected, remedy);
        self.noise().ok_or_else(lasting)
    }

    /// The noise that output-error estimates are predicted from: measurement errors alone where a current lasts.
    pub fn output_noise(&self) -> Noise {
        self.noise().unwrap_or(Noise { measurement: self.measurement.std(), current: 0.0 })
    }

    /// [`CampaignFile::white_noise`] for the covariance of estimates with these instruments. Not for the measured regressors: a
    /// covariance does not contain the bias of least squares.
    ///
    /// # Errors
    /// A correlated current; noise in the regressors that instruments are made of.
    pub fn noise_for(&self, instruments: InstrumentKind) -> Result<Noise, Invalid> {
        let noise = self.white_noise("leave out --campaign")?;
        if instruments == InstrumentKind::Regressors && noise.measurement.iter().any(|std| *std > 0.0) {
            return Err(Invalid::new(
                "`measurement`",
                "noise in the regressors, which --estimator ls makes the instruments",
                "instruments free of noise: a covariance does not tell how far least squares is off",
                "take --estimator iv, or leave out --campaign",
            ));
        }
        Ok(noise)
    }

    /// [`CampaignFile::white_noise`], of which there is some.
    ///
    /// # Errors
    /// A correlated current; no disturbance.
    pub fn some_noise(&self) -> Result<Noise, Invalid> {
        let noise = self.white_noise("name a campaign with one of these")?;
        if noise.current == 0.0 && noise.measurement == [0.0; 3] {
            let expected = "errors of measurement or a current, without which every experiment is as good";
            return Err(Invalid::new("`measurement`", "no disturbance at all", expected, "state them"));
        }
        Ok(noise)
    }

    /// The validation maneuvers as a dictionary.
    pub fn validation_dictionary(&self) -> DictionaryFile {
        DictionaryFile {
            duration_s: None,
            inputs_from: self.validation.inputs_from,
            tolerance: maneuver::Tolerance::default(),
            maneuvers: self.validation.maneuver.clone(),
            generate: None,
            limits: maneuver::StatedLimits::default(),
        }
    }
}
