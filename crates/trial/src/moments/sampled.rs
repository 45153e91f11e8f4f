//! Ships with other parameters than the maneuvers were computed with: whether inputs reach their motions, and how far
//! promises may be off.

use estimation::Share;
use estimation::pooled::{Covariance, Uncertain};
use maneuver::{Tolerance, aims_of_motion};
use numerics::{LANES, Lane};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{Run, Streams, Weather, simulate};
use ship::model::Vessel;

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
                let own: Vec<f64> = states.iter().map(|state| state[ship]).collect();
                let aims = aims_of_motion(&wanted, &own, rate_hz, &Tolerance::default());
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
    parameters.iter().zip(normals).map(|(own, z)| own * libm::exp(OFF * z)).collect()
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
