use refusal::{Invalid, check_ranges};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::engine::disturbance::{MOST_CURRENT_M_S, factor};
use crate::engine::{NormalRows, Streams, Wind};

/// How water and air change while one ship sails, about a constant current: stationary Gauss–Markov processes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Changes {
    /// Of the current.
    pub current: Option<ChangingCurrent>,
    /// Gusts.
    pub wind: Option<Wind>,
}

/// Changes of a current, north and east, correlated as exp(−|t|/T).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChangingCurrent {
    /// Standard deviation of each component \[m/s\].
    pub std_m_s: f64,
    /// Time constant T \[s\].
    pub time_constant_s: f64,
}

impl Changes {
    /// Whether nothing changes.
    pub fn are_none(&self) -> bool {
        *self == Self::default()
    }

    /// Those of run `run` of `streams`; `None` where nothing changes.
    pub fn of_run(&self, streams: Streams, run: u32, rate_hz: f64) -> Option<Changing> {
        let [u, v, r] = self.wind.map_or([0.0; 3], |wind| wind.std_per_sample(rate_hz));
        let gust = self.wind.map_or(0.0, |wind| wind.factor(rate_hz));
        let (water, flow) = self
            .current
            .map_or((0.0, 0.0), |current| (current.std_m_s, factor(current.time_constant_s, rate_hz)));
        let (stds, factors) = ([water, water, u, v, r], [flow, flow, gust, gust, gust]);
        let noise = NormalRows::new(streams, run);
        (!self.are_none()).then_some(Changing { stds, factors, noise, at: None })
    }

    /// Refuses numbers without meaning.
    ///
    /// # Errors
    /// Names the key and its value.
    pub fn check(&self) -> Result<(), Invalid> {
        self.wind.map_or(Ok(()), |wind| wind.check())?;
        let Some(ChangingCurrent { std_m_s, time_constant_s }) = self.current else { return Ok(()) };
        check_ranges([
            ("changing_current.std_m_s", std_m_s, 0.0..=MOST_CURRENT_M_S, "m/s"),
            ("changing_current.time_constant_s", time_constant_s, 1e-6..=1e9, "s"),
        ])
    }
}

/// North and east of the current, and what the wind adds to u, v and r.
const VALUES: usize = 5;

/// The changes of one run, drawn sample by sample: x(k+1) = factor · x(k) + white noise.
#[derive(Clone, Debug)]
pub struct Changing {
    stds: [f64; VALUES],
    factors: [f64; VALUES],
    noise: NormalRows<VALUES>,
    /// The last sample.
    at: Option<[f64; VALUES]>,
}

impl Iterator for Changing {
    /// Of the current, north and east \[m/s\], and of the states after the next sample \[m/s, m/s, rad/s\].
    type Item = ([f64; 2], [f64; 3]);

    fn next(&mut self) -> Option<Self::Item> {
        let noise = self.noise.next()?;
        let next = |i: usize| match self.at {
            None => self.stds[i] * noise[i],
            Some(at) => {
                let factor = self.factors[i];
                factor * at[i] + (1.0 - factor * factor).sqrt() * self.stds[i] * noise[i]
            }
        };
        let [north, east, u, v, r] = *self.at.insert(std::array::from_fn(next));
        Some(([north, east], [u, v, r]))
    }
}
