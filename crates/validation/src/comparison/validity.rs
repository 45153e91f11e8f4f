use estimation::pooled::Covered;
use regression::pooled::{PooledRuns, Recorded};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::RunView;
use ship::model::{Model, Variable};

/// Length of a stretch \[s\]: long enough that the motion passes through zero and returns.
pub const STRETCH_S: f64 = 60.0;
/// Smaller relative differences are ignored.
const NONE: f64 = 1e-9;

/// How large the channels were: the range of their root mean squares over stretches of the data, side by side in each run.
///
/// A model holds for motions as large as those that it was fitted to, and as small: a zig-zag of one degree stays inside the
/// ranges of all channels. Of n stretches that are like each other and a new one, the new one is the least or the largest
/// with probability 2/(n + 1) in each channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Magnitudes {
    /// Length of a stretch \[s\].
    pub stretch_s: f64,
    /// Their number.
    pub stretches: u64,
    /// Least and largest root mean square: states, inputs, measured disturbances in the model's order. Any of a direction.
    pub channels: Vec<Covered>,
}

/// Stretches of recordings in which the ship moves less or more than in any that the model was fitted to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Validity {
    /// Length of a stretch \[s\].
    pub stretch_s: f64,
    /// Number of stretches.
    pub stretches: u64,
    /// Those that are outside in some channel.
    pub outside: u64,
    /// The channels that are outside at all.
    pub channels: Vec<Unlike>,
}

/// A channel whose root mean square over a stretch leaves the range of those that the model was fitted to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Unlike {
    /// The channel.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Least root mean square that the model was fitted to.
    pub low: f64,
    /// Largest.
    pub high: f64,
    /// Stretches below.
    pub below: u64,
    /// Stretches above.
    pub above: u64,
}

impl Magnitudes {
    /// The magnitudes of `runs`, whose channels are the variables of `model`, at `rate_hz`; `None` if no run is as
    /// long as a stretch.
    ///
    /// # Errors
    /// Runs that cannot be read.
    pub fn of<R: Recorded>(
        model: &Model,
        runs: &PooledRuns<R>,
        rate_hz: f64,
    ) -> Result<Option<Self>, R::Error> {
        let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY]; model.variables.len()];
        let mut stretches = 0;
        runs.each_source(None, |_, parts| {
            for stretch in parts.iter().flat_map(|part| magnitudes(part.view(), rate_hz)) {
                stretches += 1;
                for ([low, high], own) in ends.iter_mut().zip(stretch) {
                    (*low, *high) = (low.min(own), high.max(own));
                }
            }
        })?;
        let channel = |(i, (variable, [low, high])): (usize, (&Variable, &[f64; 2]))| {
            // A direction of wind or water says nothing of how much the ship moves: any will do.
            let is_direction = i >= 3 + model.inputs && variable.unit == "rad";
            let [low, high] = if is_direction { [0.0, 1e12] } else { [*low, *high] };
            Covered { name: variable.name.clone(), unit: variable.unit.clone(), low, high }
        };
        let channels = model.variables.iter().zip(&ends).enumerate().map(channel).collect();
        Ok((stretches > 0).then_some(Self { stretch_s: STRETCH_S, stretches, channels }))
    }
}

/// Root mean squares of all channels over each whole stretch of `run`.
fn magnitudes(run: RunView, rate_hz: f64) -> impl Iterator<Item = Vec<f64>> {
    let length = ((STRETCH_S * rate_hz).round() as usize).max(1);
    let width = run.exogenous.len() / run.samples().max(1);
    (0..run.samples() / length).map(move |i| {
        let rows = i * length..(i + 1) * length;
        let states = run.measured[3 * rows.start..3 * rows.end].as_chunks::<3>().0;
        let inputs = run.exogenous[width * rows.start..width * rows.end].chunks_exact(width.max(1));
        let mut sums = vec![0.0; 3 + width];
        for row in states {
            row.iter().enumerate().for_each(|(d, x)| sums[d] += x * x);
        }
        for row in inputs {
            row.iter().enumerate().for_each(|(i, x)| sums[3 + i] += x * x);
        }
        sums.into_iter().map(|sum: f64| (sum / length as f64).sqrt()).collect()
    })
}

impl Validity {
    /// Compares `runs` with `known`; `None` if no run is as long as a stretch.
    pub fn of<'r>(known: &Magnitudes, runs: impl Iterator<Item = RunView<'r>>, rate_hz: f64) -> Option<Self> {
        let unlike = |c: &Covered| Unlike {
            name: c.name.clone(),
            unit: c.unit.clone(),
            low: c.low,
            high: c.high,
            below: 0,
            above: 0,
        };
        let mut channels: Vec<Unlike> = known.channels.iter().map(unlike).collect();
        let (mut stretches, mut outside) = (0, 0);
        for stretch in runs.flat_map(|run| magnitudes(run, rate_hz)) {
            stretches += 1;
            let mut left = false;
            for (channel, own) in channels.iter_mut().zip(stretch) {
                let (below, above) = (own < channel.low * (1.0 - NONE), own > channel.high * (1.0 + NONE));
                channel.below += u64::from(below);
                channel.above += u64::from(above);
                left |= below || above;
            }
            outside += u64::from(left);
        }
        channels.retain(|channel| channel.below + channel.above > 0);
        (stretches > 0).then_some(Self { stretch_s: STRETCH_S, stretches, outside, channels })
    }

    /// The validity over two sets of runs.
    pub fn together(first: Option<Self>, second: Option<Self>) -> Option<Self> {
        let (Some(mut all), Some(own)) = (first.clone(), second.clone()) else { return first.or(second) };
        all.stretches += own.stretches;
        all.outside += own.outside;
        for channel in own.channels {
            match all.channels.iter_mut().find(|known| known.name == channel.name) {
                Some(known) => {
                    known.below += channel.below;
                    known.above += channel.above;
                }
                None => all.channels.push(channel),
            }
        }
        Some(all)
    }

    /// In words; `None` if all is inside.
    pub fn statement(&self) -> Option<String> {
        let Self { stretch_s, stretches, outside, channels } = self;
        let side = |name: &str, word: &str, bound: f64, unit: &str, count: u64| {
            (count > 0).then(|| format!("{name} {word} {bound:.3e} {unit} in {count}"))
        };
        let sides = |c: &Unlike| {
            let sides = [
                side(&c.name, "below", c.low, &c.unit, c.below),
                side(&c.name, "above", c.high, &c.unit, c.above),
            ];
            sides.into_iter().flatten().collect::<Vec<_>>()
        };
        let all: Vec<String> = channels.iter().flat_map(sides).collect();
        (*outside > 0).then(|| {
            format!(
                "outside the range of validity in {outside} of {stretches} stretches of {stretch_s} s, where the ship moves \
                 less or more than in any that the model was fitted to: root mean square of {}",
                all.join(", ")
            )
        })
    }
}
