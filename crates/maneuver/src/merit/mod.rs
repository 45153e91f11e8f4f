//! Figures of merit of standard maneuvers, by the definitions of IMO MSC.137(76) and ITTC 7.5-04-02-01.

mod figures;
mod helm;
mod sailed;

use refusal::Invalid;
use ship::engine::track;
use ship::model::Vessel;

use crate::standard::Board;

pub use figures::{SailedFigures, figures};

/// Half the time over which a heading is smoothed, as a part of the time in which the ship covers her length.
const HALF: f64 = 0.3;

/// The longest time between samples, as a part of the same time: without noise, overshoots are then exact within 0.01°.
const LONGEST: f64 = 0.2;

/// How far before a level a ship may end an order that ends there, as a part of her last step: as the step of the sample before
/// foretells it.
const SHORT: f64 = 0.25;

/// What a ship did in a maneuver: N+1 samples, evenly spaced.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Samples per second \[Hz\].
    pub rate_hz: f64,
    /// Heading \[rad\], without jumps.
    pub heading: Vec<f64>,
    /// North and east of the midship point \[m\].
    pub place: Vec<[f64; 2]>,
    /// Surge speed \[m/s\].
    pub surge: Vec<f64>,
    /// Sway speed \[m/s\].
    pub sway: Vec<f64>,
    /// Speed \[m/s\].
    pub speed: Vec<f64>,
    /// Yaw rate \[rad/s\].
    pub yaw_rate: Vec<f64>,
    /// Inputs of the samples, N × inputs.
    pub inputs: Vec<f64>,
    /// Samples before the maneuver, where it is a segment of a longer record.
    pub lead: usize,
    /// Whether it was simulated: orders are those of the dictionary, and the inputs are held during samples.
    pub is_held: bool,
    /// Whether places were recorded, not reckoned from the speeds.
    pub is_placed: bool,
}

impl Record {
    /// By dead reckoning from states u, v, r, (N+1) × 3.
    pub fn of_states(states: &[f64], inputs: Vec<f64>, rate_hz: f64) -> Self {
        let poses = track(states, rate_hz);
        let states = states.as_chunks::<3>().0;
        Self {
            rate_hz,
            heading: poses.iter().map(|pose| pose.psi).collect(),
            place: poses.iter().map(|pose| [pose.x, pose.y]).collect(),
            surge: states.iter().map(|state| state[0]).collect(),
            sway: states.iter().map(|state| state[1]).collect(),
            speed: states.iter().map(|[u, v, _]| libm::hypot(*u, *v)).collect(),
            yaw_rate: states.iter().map(|state| state[2]).collect(),
            inputs,
            lead: 0,
            is_held: true,
            is_placed: false,
        }
    }

    /// The same as the log of a maneuver that begins after `lead` samples.
    #[must_use]
    pub fn logged(self, lead: usize) -> Self {
        Self { lead, is_held: false, ..self }
    }

    /// The same in water that moves: without a steady current \[m/s to north and east\] since sample `from`. `over_ground`: the
    /// speeds are over ground, too.
    #[must_use]
    fn without(&self, [north, east]: [f64; 2], from: f64, over_ground: bool) -> Self {
        let mut still = self.clone();
        for (k, place) in still.place.iter_mut().enumerate() {
            let seconds = (k as f64 - from) / self.rate_hz;
            *place = [place[0] - north * seconds, place[1] - east * seconds];
            if over_ground {
                let (sin, cos) = libm::sincos(self.heading[k]);
                still.surge[k] -= north * cos + east * sin;
                still.sway[k] -= east * cos - north * sin;
                still.speed[k] = libm::hypot(still.surge[k], still.sway[k]);
            }
        }
        still
    }

    /// The same with recorded north, east \[m\] and heading \[rad\] of every sample; headings may jump by whole turns.
    #[must_use]
    pub fn with_poses(self, poses: &[[f64; 3]]) -> Self {
        let mut heading = poses.first().map_or(0.0, |pose| pose[2]);
        let headings = poses.iter().map(|[_, _, psi]| {
            let turns = ((psi - heading) / std::f64::consts::TAU).round();
            heading = psi - turns * std::f64::consts::TAU;
            heading
        });
        let heading = headings.collect();
        let place = poses.iter().map(|[north, east, _]| [*north, *east]).collect();
        Self { heading, place, is_placed: true, ..self }
    }

    /// The last sample.
    fn last(&self) -> usize {
        self.heading.len() - 1
    }

    /// The sample at `seconds`, or the last.
    fn sample(&self, seconds: f64) -> usize {
        ((seconds * self.rate_hz).round() as usize).min(self.last())
    }

    /// Changes of heading from `course`, to a side.
    fn turned(&self, course: f64, to: Board) -> Vec<f64> {
        self.heading.iter().map(|psi| to.sign() * (psi - course)).collect()
    }
}

/// Smooths over a part of the time in which the ship covers her length.
#[derive(Clone, Copy, Debug)]
struct Smoother {
    /// Samples to either side.
    pub half: usize,
    /// In which the ship covers her length.
    pub length: f64,
}

impl Smoother {
    /// For a ship of a length at a speed \[m, m/s\].
    ///
    /// # Errors
    /// Samples that are too far apart.
    pub fn new(length_m: f64, speed_m_s: f64, rate_hz: f64) -> Result<Self, Invalid> {
        let half = ((HALF * length_m / speed_m_s * rate_hz).floor() as usize).max(1);
        let least = speed_m_s / (LONGEST * length_m);
        if rate_hz < least * (1.0 - 1e-9) {
            return Err(Invalid::new(
                "samples",
                format!("{rate_hz} Hz, {:.2} s in a ship's length", length_m / speed_m_s),
                format!("at least {least:.3} Hz for figures of merit, five samples in that time"),
                "log more often",
            ));
        }
        Ok(Self { half, length: length_m / speed_m_s * rate_hz })
    }

    /// The samples around `at`; as many at an end of the record, to one side.
    fn window(&self, at: usize, samples: usize) -> std::ops::Range<usize> {
        let whole = 2 * self.half + 1;
        let end = (at.saturating_sub(self.half) + whole).min(samples);
        end.saturating_sub(whole)..end
    }

    /// Whether there is a whole window around `at`.
    pub fn is_inside(&self, at: usize, samples: usize) -> bool {
        at >= self.half && at + self.half < samples
    }

    /// When `values` first pass `level`: by a parabola through the samples around the first that does, in samples; `None`
    /// where none does.
    pub fn crossing(&self, values: &[f64], level: f64) -> Option<f64> {
        let first = values.iter().position(|value| *value >= level)?;
        Some(self.root(self.window(first, values.len()), first, values, level))
    }

    /// The same by the samples up to the first beyond it: the helm goes over there, and what comes after follows another law.
    pub fn reached(&self, values: &[f64], level: f64) -> Option<f64> {
        let first = values.iter().position(|value| *value >= level)?;
        Some(self.root(first.saturating_sub(2 * self.half)..first + 1, first, values, level))
    }

    /// The same by the samples before the first that passes it: an order that ends there spoils that sample and what comes
    /// after. A simulated ship may end it just short of the level, by a part of her last step or of `near`.
    pub fn end(&self, values: &[f64], level: f64, near: f64) -> Option<f64> {
        let short = |k: usize| near.max(if k > 0 { SHORT * (values[k] - values[k - 1]) } else { 0.0 });
        let first = (0..values.len()).find(|k| values[*k] >= level - short(*k))?;
        let range = first.saturating_sub(2 * self.half + 1)..first.max(3).min(values.len());
        Some(self.root(range, first, values, level))
    }

    fn root(&self, range: std::ops::Range<usize>, first: usize, values: &[f64], level: f64) -> f64 {
        let [a, b, c] = parabola(range, first, |k| values[k]);
        let most = self.half as f64;
        let mut away = 0.0;
        for _ in 0..8 {
            let step = (level - (a + away * (b + away * c))) / (b + 2.0 * away * c);
            away = if step.is_finite() { (away + step).clamp(-most, most) } else { away };
        }
        (first as f64 + away).max(0.0)
    }

    /// A quantity at a time in samples, by a parabola.
    pub fn at(&self, time: f64, samples: usize, of: impl Fn(usize) -> f64) -> f64 {
        let nearest = (time.round().max(0.0) as usize).min(samples - 1);
        let [a, b, c] = parabola(self.window(nearest, samples), nearest, of);
        let away = time - nearest as f64;
        a + away * (b + away * c)
    }

    /// When `values` are greatest within `range`, in samples, and how great: the top of a parabola around the largest sample; `None` at an end of the record.
    pub fn peak(&self, values: &[f64], range: std::ops::Range<usize>) -> Option<(f64, f64)> {
        let mut top = range.clone().max_by(|a, b| values[*a].total_cmp(&values[*b]))?;
        // With noise the largest sample may be off the top by many.
        let mut peak = (top as f64, values[top]);
        for _ in 0..4 {
            if !self.is_inside(top, values.len()) {
                return None;
            }
            let [a, b, c] = parabola(self.window(top, values.len()), top, |k| values[k]);
            let away =
                if c < 0.0 { (-0.5 * b / c).clamp(-(self.half as f64), self.half as f64) } else { 0.0 };
            peak = (top as f64 + away, a + away * (b + away * c));
            let next = (top as f64 + away.round()).max(0.0) as usize;
            if next == top {
                break;
            }
            top = next;
        }
        Some(peak)
    }

    /// A value, and its change in a sample.
    pub fn slope(&self, at: usize, values: &[f64]) -> [f64; 2] {
        let [a, b, _] = parabola(self.window(at, values.len()), at, |k| values[k]);
        [a, b]
    }
}

/// a + b t + c t² of least squares, t from `at`.
fn parabola(range: std::ops::Range<usize>, at: usize, of: impl Fn(usize) -> f64) -> [f64; 3] {
    let row = |k: usize| {
        let t = k as f64 - at as f64;
        ([1.0, t, t * t], of(k))
    };
    least_squares(range.map(row)).unwrap_or_else(|| [of(at), 0.0, 0.0])
}

/// The factors of three columns by which rows sum to values, of least squares.
fn least_squares(all: impl Iterator<Item = ([f64; 3], f64)>) -> Option<[f64; 3]> {
    let (mut sums, mut right) = ([0.0; 9], [0.0; 3]);
    for (row, value) in all {
        for i in 0..3 {
            right[i] += row[i] * value;
            (0..3).for_each(|j| sums[3 * i + j] += row[i] * row[j]);
        }
    }
    numerics::solve(3, &mut sums, &mut right).map(|()| right)
}

/// The ship that figures are measured by.
#[derive(Clone, Copy, Debug)]
pub struct Hull<'a> {
    /// The vessel, for its inputs.
    pub vessel: &'a Vessel,
    /// Length between perpendiculars \[m\].
    pub length_m: f64,
}

/// A figure of merit.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its name in files: `overshoot_1`.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Its value, as it was measured.
    pub value: f64,
    /// The same without the current that the log shows.
    pub corrected: Option<f64>,
    /// Whether it is beside those that trials are designed for.
    pub is_aside: bool,
    /// Its unit: `deg`, `deg/s`, `m`, `L` (ship lengths), `s`, or the input's.
    pub unit: String,
    /// The greatest value that IMO MSC.137(76) allows, where it has one for this test.
    pub most: Option<f64>,
}

impl Figure {
    fn new(name: &'static str, what: &'static str, value: f64, unit: &str) -> Self {
        Self { name, what, value, corrected: None, is_aside: false, unit: unit.to_owned(), most: None }
    }

    fn aside(name: &'static str, what: &'static str, value: f64, unit: &str) -> Self {
        Self { is_aside: true, ..Self::new(name, what, value, unit) }
    }

    fn at_most(self, most: Option<f64>) -> Self {
        Self { most, ..self }
    }

    /// Whether it meets its criterion; `None` without one.
    pub fn passes(&self) -> Option<bool> {
        self.most.map(|most| self.corrected.unwrap_or(self.value) <= most)
    }

    /// A figure of a spiral, in the unit of the helm's greatest input.
    fn of_helm(name: &'static str, what: &'static str, value: f64, unit: &str) -> Self {
        match unit {
            "rad" => Self::new(name, what, value.to_degrees(), "deg"),
            unit => Self::new(name, what, value, unit),
        }
    }
}
