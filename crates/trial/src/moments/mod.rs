//! The information of maneuvers about a model's parameters: moments of measured and simulated runs, pooled by
//! maneuver, and the dictionaries that designs choose from.

mod dictionary;
mod matrices;
mod prediction;
mod prior;

use std::collections::BTreeMap;

use design::{Degree, NoDesign};
use estimation::Share;
use estimation::pooled::{Covariance, Uncertain};
use maneuver::{Tolerance, aims_of_motion};
use numerics::{LANES, Lane};
use refusal::Invalid;
use regression::{InstrumentKind, Noise};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{Run, Streams, Weather, simulate};
use ship::model::{DegreeOfFreedom, Model, Source, Vessel};

pub use dictionary::{CriterionOf, Estimated, NoCriterion, leading, malformed};
pub use matrices::{DegreeMoments, FreeRunModel, ManeuverMoments, OutputErrorMoments, Pool, Unpredictable};
pub use prediction::Prediction;
pub use prior::PriorInformation;

/// The lifted moment matrices of every maneuver.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct Moments {
    /// Name of the vessel.
    pub vessel: String,
    /// Sampling rate \[Hz\].
    pub sample_rate_hz: f64,
    /// What the instruments are made of; a ship with forces has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instruments: Option<InstrumentKind>,
    /// What each row and column of the matrices stands for. Of a ship with forces one block of its free numbers, without
    /// intercepts.
    pub degrees: Vec<Degree>,
    /// One entry per maneuver, in the dictionary's order.
    pub maneuvers: Vec<ManeuverMoments>,
    /// Parameters that no maneuver excites apart from the others, which are held at their values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held: Vec<HeldParameter>,
    /// Where the maneuvers leave what the logs of the model cover, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beyond: Vec<String>,
    /// What the matrices `B` were computed from, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturbances: Option<Expected>,
    /// What the matrices `F` and `P` of an output-error estimate are about, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_error: Option<FreeRunModel>,
    /// What is known of the ship before the trial: by the fit of her model, or by the priors of her forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<PriorInformation>,
    /// What ships with other parameters do, where the true ones are not known and the maneuvers were simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sampled: Option<SampledShips>,
}

/// A parameter that is held at its value, since no maneuver excites it apart from the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeldParameter {
    /// Its name.
    pub parameter: String,
    /// `surge`, `sway` or `yaw`.
    pub degree: String,
    /// Its term.
    pub term: String,
}

impl HeldParameter {
    /// Those of `all`, in words.
    pub fn words(all: &[Self]) -> String {
        let one = |held: &Self| format!("`{}` (`{}` in {})", held.parameter, held.term, held.degree);
        let names = all.iter().map(one).collect::<Vec<_>>().join(", ");
        let are = if all.len() > 1 { "are" } else { "is" };
        format!(
            "no maneuver excites {names} apart from the others: {are} held at the model's values, and nothing is learnt about them"
        )
    }
}

impl Moments {
    /// A parameter that no mixture of the maneuvers excites apart from the others; `None` where all are, or where its degree
    /// of freedom has no other.
    ///
    /// # Errors
    /// As [`Moments::dictionary`].
    pub fn unexcited(&self, estimated: Estimated) -> Result<Option<HeldParameter>, Invalid> {
        let excited = self.dictionary(estimated)?.check_excited();
        let Err(NoDesign::Unexcited { degree, parameter, regressor }) = excited else { return Ok(None) };
        let is_only = self.degrees.iter().any(|degree| degree.parameters == [parameter.as_str()]);
        Ok((!is_only).then_some(HeldParameter { parameter, degree, term: regressor }))
    }
}

/// The disturbances that an estimate's covariance is predicted from, white per sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expected {
    /// Standard deviation of the measured surge speed \[m/s\].
    pub std_u_m_s: f64,
    /// Standard deviation of the measured sway speed \[m/s\].
    pub std_v_m_s: f64,
    /// Standard deviation of the measured yaw rate \[rad/s\].
    pub std_r_rad_s: f64,
    /// Standard deviation of each component of the current in body axes \[m/s\].
    pub current_std_m_s: f64,
    /// Whether the campaign has a current that lasts, whose effect is not predicted.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub lasting_current_left_out: bool,
    /// Which parameters the residual was linearised with.
    pub linearised_at: Source,
    /// These parameters, in units of the state's increment per unit of the term.
    pub parameters: BTreeMap<String, f64>,
    /// The nominal parameters, in the same units.
    pub nominal: BTreeMap<String, f64>,
    /// Duration of a trial of the campaign \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trial_s: Option<f64>,
}

impl Expected {
    /// `noise` over trials of `trial_s` seconds, and the best known parameters of `vessel`.
    ///
    /// # Errors
    /// A vessel without parameters.
    pub fn new(vessel: &Vessel, noise: Noise, trial_s: f64) -> Result<Self, Invalid> {
        let linearised_at = vessel.best_known();
        let parameters = by_name(&vessel.model, &vessel.parameters(linearised_at)?);
        let [std_u_m_s, std_v_m_s, std_r_rad_s] = noise.measurement;
        Ok(Self {
            std_u_m_s,
            std_v_m_s,
            std_r_rad_s,
            current_std_m_s: noise.current,
            lasting_current_left_out: false,
            linearised_at,
            parameters,
            nominal: by_name(&vessel.model, &vessel.nominal),
            trial_s: Some(trial_s),
        })
    }

    /// The standard deviations.
    pub(crate) fn noise(&self) -> Noise {
        let measurement = [self.std_u_m_s, self.std_v_m_s, self.std_r_rad_s];
        Noise { measurement, current: self.current_std_m_s }
    }
}

/// `values` of the model's parameters by name.
fn by_name(model: &Model, values: &[f64]) -> BTreeMap<String, f64> {
    model.parameter_names().map(str::to_owned).zip(values.iter().copied()).collect()
}

/// Refuses an estimated term 1: every degree of freedom of a design has an intercept already, whose error is not counted.
///
/// # Errors
/// Names the parameter.
pub fn check_constants(model: &Model) -> Result<(), Invalid> {
    let constant = |degree: &ship::model::Degree| degree.constant().map(|i| degree.parameters[i].clone());
    match model.degrees.iter().find_map(constant) {
        None => Ok(()),
        Some(name) => Err(Invalid::new(
            format!("parameter `{name}`"),
            "the term `1`, which is estimated",
            "terms that a maneuver can excite: every run has an intercept of its own, and no design makes it better known",
            "give it its value and `fixed = true`, or remove it",
        )),
    }
}

/// The rows and columns of the moments of `model`: those of each degree of freedom, or of all parameters where they multiply no
/// regressors.
pub fn structure(model: &Model) -> Vec<Degree> {
    if !model.has_regressors() {
        let names = || model.parameter_names().map(str::to_owned).collect();
        return vec![Degree { name: FORCES.to_owned(), regressors: names(), parameters: names() }];
    }
    let of = |(d, degree): (DegreeOfFreedom, &ship::model::Degree)| Degree {
        name: d.name().to_owned(),
        regressors: degree.terms.iter().map(|t| t.text.clone()).chain(["1".to_owned()]).collect(),
        parameters: degree.parameters.clone(),
    };
    DegreeOfFreedom::ALL.into_iter().zip(&model.degrees).map(of).collect()
}

/// Name of the block of all parameters.
const FORCES: &str = "forces";

/// Names of the parameters, with an intercept per degree of freedom where there are regressors, in the order of output error's
/// matrices.
pub(crate) fn rows(model: &Model) -> Vec<String> {
    if !model.has_regressors() {
        return model.parameter_names().map(str::to_owned).collect();
    }
    let of = |(d, degree): (DegreeOfFreedom, &ship::model::Degree)| {
        degree.parameters.iter().cloned().chain([format!("intercept ({})", d.name())]).collect::<Vec<_>>()
    };
    DegreeOfFreedom::ALL.into_iter().zip(&model.degrees).flat_map(of).collect()
}

/// What is known of ships with other parameters than those of the moments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SampledShips {
    /// What they are drawn from.
    pub from: SampledFrom,
    /// How many were simulated.
    pub ships: u32,
    /// The maneuvers that are executed by inputs, in order.
    pub by_inputs: Vec<PlayedMotion>,
}

/// What parameters are drawn from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SampledFrom {
    /// Nominal values without true ones, a guess: each times e^(0.4 z), z standard normal.
    Nominal,
    /// The covariance of estimated ones.
    Covariance,
}

/// A maneuver by inputs, and what other ships do with these.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlayedMotion {
    /// Its name.
    pub maneuver: String,
    /// By what is wanted of the motion, in words, how many ships miss it.
    pub missed: Vec<MissedAim>,
}

/// Something that is wanted of a motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MissedAim {
    /// What it is, in words: `change of heading`.
    pub what: String,
    /// How many ships miss it beyond a quarter.
    pub ships: u32,
}

/// A motion that many ships miss.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnreachedMotion {
    /// The maneuver.
    pub maneuver: String,
    /// What is missed, in words.
    pub what: String,
    /// Share of the sampled ships that miss it by more than a quarter.
    pub missed: Share,
}

/// The parameter error that an experiment promises.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise {
    /// Root of Σ (standard error/nominal parameter)².
    pub parameter_error: f64,
    /// The range to expect the error of a ship with other parameters in.
    pub range: [f64; 2],
}

impl Promise {
    /// What `parameter_error`, predicted with nominal parameters that are a guess, promises of an experiment whose motions are
    /// held by feedback or, `by_inputs`, follow from the nominal model's inputs.
    pub fn of_guess(parameter_error: f64, by_inputs: bool) -> Self {
        let factors = if by_inputs { BY_INPUTS } else { BY_FEEDBACK };
        Self { parameter_error, range: factors.map(|factor| factor * parameter_error) }
    }
}

/// Standard deviation of the logarithm by which a nominal parameter is off.
const OFF: f64 = 0.4;
/// Ships that are simulated.
const SHIPS: u32 = 64;
/// Their random numbers; moments depend on no other seed.
const SEED: u64 = 1;
/// The least share of ships that miss a motion for a warning.
const MANY: f64 = 0.25;

/// Error found over error promised of 90 % of trials in a prototype, where the nominal model is off by e^(0.4 z) and motions are held by
/// feedback (docs/design.md).
const BY_FEEDBACK: [f64; 2] = [1.0 / 1.7, 1.7];
/// The same where the nominal model's inputs are played.
const BY_INPUTS: [f64; 2] = [1.0 / 5.4, 1.0 / 0.26];

/// Ships with drawn parameters, to be simulated.
pub struct ShipSampler<'a> {
    vessel: &'a Vessel,
    from: SampledFrom,
    /// By eight ships, a lane per parameter.
    parameters: Vec<Vec<Lane>>,
}

impl<'a> ShipSampler<'a> {
    /// Ships like `vessel`, whose nominal parameters are a guess, or have a `covariance`; `None` where that is none.
    pub fn new(vessel: &'a Vessel, covariance: Option<&Covariance>) -> Option<Self> {
        let streams = Streams::new(SEED, "sampled ships");
        let (from, all): (_, Vec<Vec<f64>>) = match covariance {
            None => {
                (SampledFrom::Nominal, (0..SHIPS).map(|ship| off(&vessel.nominal, &streams, ship)).collect())
            }
            Some(covariance) => {
                let uncertain = Uncertain::new(vessel, vessel.nominal.clone(), covariance)?;
                (SampledFrom::Covariance, (0..SHIPS).map(|ship| uncertain.drawn(&streams, ship)).collect())
            }
        };
        let lanes = |ships: &[Vec<f64>]| {
            let lane = |i: usize| {
                let mut lane = Lane::ZERO;
                ships.iter().enumerate().for_each(|(place, ship)| lane[place] = ship[i]);
                lane
            };
            (0..vessel.nominal.len()).map(lane).collect()
        };
        Some(Self { vessel, from, parameters: all.chunks(LANES).map(lanes).collect() })
    }

    /// How many ships miss the motion of `run`, the undisturbed ship with the nominal parameters, by its inputs.
    pub fn play(&self, run: &Run) -> PlayedMotion {
        let (model, rate_hz) = (&self.vessel.model, self.vessel.sample_rate_hz);
        let rows = &run.measured.as_chunks::<3>().0[..run.samples()];
        let wanted: Vec<[f64; 2]> = rows.iter().map(|[u, _, r]| [*u, *r]).collect();
        let mut missed: Vec<MissedAim> = Vec::new();
        for parameters in &self.parameters {
            let mut states = vec![Lane::ZERO; run.measured.len()];
            let initial = run.initial.map(Lane::splat);
            simulate(model, parameters, initial, &run.exogenous, &Weather::CALM, &mut states);
            for ship in 0..LANES {
                let speeds: Vec<f64> = states.iter().map(|state| state[ship]).collect();
                let aims = aims_of_motion(&wanted, &speeds, rate_hz, &Tolerance::default());
                missed.resize_with(aims.len(), || MissedAim { what: String::new(), ships: 0 });
                for (known, aim) in missed.iter_mut().zip(aims) {
                    known.what = aim.what;
                    known.ships += u32::from(!aim.is_met);
                }
            }
        }
        let maneuver = run.segments.first().map_or(String::new(), |segment| segment.maneuver.clone());
        PlayedMotion { maneuver, missed }
    }

    /// What is known of the ships, with what they do `by_inputs`.
    pub fn found(&self, by_inputs: Vec<PlayedMotion>) -> SampledShips {
        SampledShips { from: self.from, ships: SHIPS, by_inputs }
    }
}

/// `parameters`, each times e^(0.4 z).
fn off(parameters: &[f64], streams: &Streams, ship: u32) -> Vec<f64> {
    let mut normals = vec![0.0; parameters.len()];
    streams.normals(ship, 0, &mut normals);
    parameters.iter().zip(normals).map(|(value, z)| value * libm::exp(OFF * z)).collect()
}

impl SampledShips {
    /// The motions of maneuvers in use that a quarter of the ships or more miss, by what most of them miss.
    pub fn unreached(&self, is_used: impl Fn(&str) -> bool) -> Vec<UnreachedMotion> {
        let one = |motion: &PlayedMotion| {
            let most = motion.missed.iter().max_by_key(|aim| aim.ships)?;
            let missed = Share::of(most.ships as usize, self.ships as usize);
            let (maneuver, what) = (motion.maneuver.clone(), most.what.clone());
            (missed.share >= MANY).then_some(UnreachedMotion { maneuver, what, missed })
        };
        self.by_inputs.iter().filter(|motion| is_used(&motion.maneuver)).filter_map(one).collect()
    }

    /// What `parameter_error` is as a promise, if the parameters that it is predicted with are a guess.
    pub fn promise(&self, parameter_error: f64, is_used: impl Fn(&str) -> bool) -> Option<Promise> {
        let by_inputs = self.by_inputs.iter().any(|motion| is_used(&motion.maneuver));
        (self.from == SampledFrom::Nominal).then(|| Promise::of_guess(parameter_error, by_inputs))
    }
}
