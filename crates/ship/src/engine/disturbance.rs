use numerics::{LANES, Lane, vectorized};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::engine::Streams;
use crate::engine::noise::{Channels, Normals};

/// A current.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Current {
    /// Still water.
    None,
    /// New independent surge and sway components at every sample, in body axes.
    White {
        /// Standard deviation of each component \[m/s\].
        #[schemars(range(min = 0.0, max = MOST_CURRENT_M_S))]
        std_m_s: f64,
    },
    /// Two components that a run keeps, drawn anew for every run.
    Constant {
        /// Standard deviation of each component \[m/s\].
        #[schemars(range(min = 0.0, max = MOST_CURRENT_M_S))]
        std_m_s: f64,
        /// Whose components they are.
        #[serde(default)]
        axes: Axes,
    },
    /// Two stationary Gauss–Markov processes, correlated as exp(−|t|/T).
    GaussMarkov {
        /// Standard deviation of each component \[m/s\].
        #[schemars(range(min = 0.0, max = MOST_CURRENT_M_S))]
        std_m_s: f64,
        /// Time constant T \[s\].
        #[schemars(range(min = 1e-6, max = 1e9))]
        time_constant_s: f64,
        /// Whose components they are.
        #[serde(default)]
        axes: Axes,
    },
}

/// Axes that a current's components belong to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Axes {
    /// The earth's: the vessel turns in the current. Every run starts at heading zero.
    #[default]
    Earth,
    /// The vessel's: the current turns with it.
    Body,
}

/// A wind-like force: what it adds to the states, in body axes and independent of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wind {
    /// Standard deviation of the surge acceleration \[m/s²\].
    #[schemars(range(min = 0.0, max = 100.0), extend("x-unit" = "m/s²"))]
    pub std_surge_m_s2: f64,
    /// Standard deviation of the sway acceleration \[m/s²\].
    #[schemars(range(min = 0.0, max = 100.0), extend("x-unit" = "m/s²"))]
    pub std_sway_m_s2: f64,
    /// Standard deviation of the yaw acceleration \[rad/s²\].
    #[schemars(range(min = 0.0, max = 100.0), extend("x-unit" = "rad/s²"))]
    pub std_yaw_rad_s2: f64,
    /// Time constant of gusts \[s\]; without it a run keeps what is drawn for it.
    #[serde(default)]
    #[schemars(range(min = 1e-6, max = 1e9))]
    pub time_constant_s: Option<f64>,
}

/// White measurement noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measurement {
    /// Standard deviation of the measured surge speed \[m/s\].
    #[schemars(range(min = 0.0, max = 100.0))]
    pub std_u_m_s: f64,
    /// Standard deviation of the measured sway speed \[m/s\].
    #[schemars(range(min = 0.0, max = 100.0))]
    pub std_v_m_s: f64,
    /// Standard deviation of the measured yaw rate \[rad/s\].
    #[schemars(range(min = 0.0, max = 100.0))]
    pub std_r_rad_s: f64,
}

/// The disturbances of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbances {
    /// Acts on the vessel through the relative velocity.
    pub current: Current,
    /// Is added to the measured states.
    pub measurement: Measurement,
}

/// Stronger currents are refused \[m/s\]: no tidal stream reaches this speed.
pub const MOST_CURRENT_M_S: f64 = 15.0;

/// Channels of the random streams: measurement noise of u, v, r, then the current's components, then the wind's.
const CURRENT_CHANNEL: u32 = 3;
const WIND_CHANNEL: u32 = 5;

impl Current {
    /// Standard deviation of each component \[m/s\].
    pub fn std_m_s(&self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::White { std_m_s } | Self::Constant { std_m_s, .. } | Self::GaussMarkov { std_m_s, .. } => {
                *std_m_s
            }
        }
    }

    /// Whether its components are the earth's.
    pub fn in_earth_axes(&self) -> bool {
        matches!(self, Self::Constant { axes: Axes::Earth, .. } | Self::GaussMarkov { axes: Axes::Earth, .. })
    }

    /// Correlation of neighbouring samples at `rate_hz`; `None` where every sample is drawn anew, and in still water.
    pub fn factor(&self, rate_hz: f64) -> Option<f64> {
        match self {
            Self::None | Self::White { .. } => None,
            Self::Constant { .. } => Some(1.0),
            Self::GaussMarkov { time_constant_s, .. } => Some(factor(*time_constant_s, rate_hz)),
        }
    }

    /// None in still water.
    fn process(&self, channels: &mut Channels, rate_hz: f64) -> Option<Process<2>> {
        let process = || Process::new(channels, [self.std_m_s(); 2], self.factor(rate_hz));
        (*self != Self::None).then(process)
    }
}

impl Wind {
    /// Correlation of consecutive samples at `rate_hz`; 1 where a run keeps its draw.
    pub fn factor(&self, rate_hz: f64) -> f64 {
        self.time_constant_s.map_or(1.0, |t| factor(t, rate_hz))
    }

    /// Standard deviations of the increments of u, v \[m/s\] and r \[rad/s\] per sample at `rate_hz`.
    pub fn std_per_sample(&self, rate_hz: f64) -> [f64; 3] {
        [self.std_surge_m_s2, self.std_sway_m_s2, self.std_yaw_rad_s2].map(|std| std / rate_hz)
    }

    /// The increments of the states of [`LANES`] runs after each of `samples` samples, samples × 3.
    pub fn force(&self, streams: &Streams, runs: [u32; LANES], samples: usize, rate_hz: f64) -> Vec<Lane> {
        self.process(&mut streams.lanes(runs, WIND_CHANNEL), rate_hz).all(samples)
    }

    fn process(&self, channels: &mut Channels, rate_hz: f64) -> Process<3> {
        Process::new(channels, self.std_per_sample(rate_hz), Some(self.factor(rate_hz)))
    }
}

/// Correlation of consecutive samples of a process with time constant `time_constant_s`.
pub(crate) fn factor(time_constant_s: f64, rate_hz: f64) -> f64 {
    libm::exp(-1.0 / (time_constant_s * rate_hz))
}

/// Stationary processes of [`LANES`] runs, drawn a few samples at a time: x(k+1) = factor · x(k) + white
/// noise, or white noise alone.
#[derive(Clone, Debug)]
struct Process<const WIDTH: usize> {
    noise: Noise<WIDTH>,
    /// `None` for white noise.
    factor: Option<f64>,
    last: Option<[Lane; WIDTH]>,
}

impl<const WIDTH: usize> Process<WIDTH> {
    /// Column i draws from one of the next channels, in order, and has standard deviation `std[i]`.
    fn new(channels: &mut Channels, std: [f64; WIDTH], factor: Option<f64>) -> Self {
        Self { noise: Noise::new(channels, std), factor, last: None }
    }

    /// Fills `out` with the next samples. Their number is even, except at the end.
    fn draw(&mut self, out: &mut [Lane]) {
        let Some(factor) = self.factor else { return self.noise.put(out) };
        out.fill(Lane::ZERO);
        let fresh = (1.0 - factor * factor).max(0.0).sqrt();
        let drawn = match (fresh > 0.0, self.last) {
            (true, _) => out.len(),
            (false, None) => WIDTH.min(out.len()),
            (false, Some(_)) => 0,
        };
        self.noise.add(&mut out[..drawn]);
        for row in out.as_chunks_mut::<WIDTH>().0 {
            if let Some(last) = self.last {
                for (entry, last) in row.iter_mut().zip(last) {
                    *entry = Lane::splat(factor) * last + Lane::splat(fresh) * *entry;
                }
            }
            self.last = Some(*row);
        }
    }

    fn all(mut self, samples: usize) -> Vec<Lane> {
        let mut out = vec![Lane::ZERO; WIDTH * samples];
        self.draw(&mut out);
        out
    }
}

/// The disturbances of [`numerics::LANES`] runs.
#[derive(Clone, Copy, Debug)]
pub struct Weather<'a> {
    /// Current \[m/s\], N × 2, or empty for still water.
    pub current: &'a [Lane],
    /// Sampling interval \[s\] where the current's components are in earth axes and the heading starts at
    /// zero; 0 where they are in body axes.
    pub turning: f64,
    /// Increments of the states after each sample, N × 3, or empty.
    pub force: &'a [Lane],
}

impl Weather<'_> {
    /// Still water, no force.
    pub const CALM: Self = Self { current: &[], turning: 0.0, force: &[] };

    /// The disturbances from sample `k` on.
    pub(crate) fn from(self, k: usize) -> Self {
        Self {
            current: self.current.get(2 * k..).unwrap_or(&[]),
            force: self.force.get(3 * k..).unwrap_or(&[]),
            ..self
        }
    }
}

/// The disturbances of [`LANES`] runs, drawn as needed.
#[derive(Clone, Debug)]
pub struct Disturbing {
    current: Option<Process<2>>,
    force: Option<Process<3>>,
    measurement: Noise<3>,
    turning: f64,
    /// The latest draws.
    drawn: [Vec<Lane>; 2],
}

impl Disturbing {
    /// The disturbances of the next samples. Their number is even, except at the end.
    pub(crate) fn next(&mut self, samples: usize) -> Weather<'_> {
        let Self { current, force, drawn: [currents, forces], .. } = self;
        if let Some(current) = current {
            currents.resize(2 * samples, Lane::ZERO);
            current.draw(currents);
        }
        if let Some(force) = force {
            forces.resize(3 * samples, Lane::ZERO);
            force.draw(forces);
        }
        Weather { current: currents, turning: self.turning, force: forces }
    }

    /// The noise that [`Self::measure`] will add to the next samples, up to rounding, samples × 3.
    pub(crate) fn noise(&self, out: &mut [Lane]) {
        self.measurement.clone().put(out);
    }

    /// Adds measurement noise to the states of the next samples, samples × 3. Their number is even, except at the end.
    pub(crate) fn measure(&mut self, states: &mut [Lane]) {
        self.measurement.add(states);
    }
}

impl Disturbances {
    /// The current of [`LANES`] runs over `samples` samples at `rate_hz`, samples × 2, in its own axes; empty in still water.
    pub fn current(&self, streams: &Streams, runs: [u32; LANES], samples: usize, rate_hz: f64) -> Vec<Lane> {
        let process = self.current.process(&mut streams.lanes(runs, CURRENT_CHANNEL), rate_hz);
        process.map_or_else(Vec::new, |process| process.all(samples))
    }

    /// Adds measurement noise to the states of [`LANES`] runs, rows × 3.
    pub fn measure(&self, streams: &Streams, runs: [u32; LANES], states: &mut [Lane]) {
        self.measurement.noise(&mut streams.lanes(runs, 0)).add(states);
    }

    /// The disturbances of [`LANES`] runs, with a wind, at `rate_hz`.
    pub fn of_runs(
        &self,
        wind: Option<&Wind>,
        streams: &Streams,
        runs: [u32; LANES],
        rate_hz: f64,
    ) -> Disturbing {
        // The current's channels follow those of the measurement.
        let mut channels = streams.lanes(runs, 0);
        Disturbing {
            measurement: self.measurement.noise(&mut channels),
            current: self.current.process(&mut channels, rate_hz),
            force: wind.map(|wind| wind.process(&mut streams.lanes(runs, WIND_CHANNEL), rate_hz)),
            turning: if self.current.in_earth_axes() { 1.0 / rate_hz } else { 0.0 },
            drawn: [Vec::new(), Vec::new()],
        }
    }
}

impl Measurement {
    /// The standard deviations of u, v \[m/s\] and r \[rad/s\].
    pub fn std(&self) -> [f64; 3] {
        [self.std_u_m_s, self.std_v_m_s, self.std_r_rad_s]
    }

    fn noise(&self, channels: &mut Channels) -> Noise<3> {
        Noise::new(channels, self.std())
    }
}

/// White noise in several columns, each with a channel of its own, of [`LANES`] runs.
#[derive(Clone, Debug)]
struct Noise<const WIDTH: usize> {
    normals: [Normals; WIDTH],
    std: [Lane; WIDTH],
}

impl<const WIDTH: usize> Noise<WIDTH> {
    fn new(channels: &mut Channels, std: [f64; WIDTH]) -> Self {
        Self { normals: channels.next(), std: std.map(Lane::splat) }
    }

    /// Adds the next numbers to the rows of `out`. Each draw fills two rows; for an odd number of rows the
    /// last one takes the first half.
    fn add(&mut self, out: &mut [Lane]) {
        vectorized!(self.change(
            out,
            #[inline(always)]
            |value, noise, std| std.fused(noise, value)
        ));
    }

    /// Writes the next numbers instead, so that `out` need not be initialized.
    fn put(&mut self, out: &mut [Lane]) {
        vectorized!(self.change(
            out,
            #[inline(always)]
            |_, noise, std| std.fused(noise, Lane::ZERO)
        ));
    }

    /// Applies `f` to every entry, its random number and its standard deviation.
    #[inline(always)]
    fn change(&mut self, out: &mut [Lane], f: impl Fn(Lane, Lane, Lane) -> Lane) {
        let Self { normals, std } = self;
        let mut pairs = out.chunks_exact_mut(2 * WIDTH);
        for rows in &mut pairs {
            for (column, normals) in normals.iter_mut().enumerate() {
                let [one, two] = normals.pair();
                rows[column] = f(rows[column], one, std[column]);
                rows[WIDTH + column] = f(rows[WIDTH + column], two, std[column]);
            }
        }
        let last = pairs.into_remainder().iter_mut();
        for ((entry, normals), std) in last.zip(normals).zip(std) {
            *entry = f(*entry, normals.pair()[0], *std);
        }
    }
}
