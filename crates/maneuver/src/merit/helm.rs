use std::ops::RangeInclusive;

use numerics::statistics::{self, mean, quantile, spread};
use refusal::Invalid;
use ship::model::Vessel;

use super::{Figure, Hull, Record};
use crate::standard::{ReverseSpiral, Settings, SpiralTest, steps};

/// Half the time over which the helm is smoothed by a median, as a part of the time in which the ship covers her length.
const HALF: f64 = 0.05;
/// The most samples to either side in it: over many the beginning of a move is blurred.
const MOST_HALF: usize = 5;
/// How far a helm has moved for certain: an angle \[rad\], or a part of a move; noise may hide more.
const BEGUN: [f64; 2] = [0.0018, 0.005];
/// Part of a move at which the helm counts as over.
const OVER: f64 = 0.5;
/// How much of a move, after its beginning, a line goes through without noise: an angle \[rad\], or a part of a move; and the
/// most that it may go through.
const EARLY: [f64; 2] = [0.0175, 0.05];
const MOST: f64 = 0.4;
/// Part of a helm within which it counts as amidships again.
const AMIDSHIPS: f64 = 0.3;
/// By how many samples an order may be off what a log without noise shows.
const DOUBT: f64 = 1.25;
/// The part of a move that a step makes within a sample.
const STEP: f64 = 0.95;

/// The length of an approach, in times in which the ship covers her length.
pub(super) const APPROACH: f64 = 2.0;
/// How much a steady approach may turn while she covers her length \[rad\].
pub(super) const STEADY_TURN: f64 = 0.035;
/// How much its speed may change, as a part of it.
pub(super) const STEADY_SPEED: f64 = 0.05;
/// Standard deviation of its helm \[rad\].
pub(super) const STEADY_HELM: f64 = 0.035;

/// An angle in words.
pub(super) fn degrees(rad: f64) -> String {
    format!("{:.1}°", rad.to_degrees())
}

/// Radians in a unit of angle.
pub(super) fn radians(unit: &str) -> Option<f64> {
    match unit {
        "rad" => Some(1.0),
        "deg" | "°" => Some(1_f64.to_radians()),
        _ => None,
    }
}

/// The median of `values`; 0 of none.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    statistics::median(values.into_iter().collect()).unwrap_or(0.0)
}

/// An input or several over time: the helm, or an engine.
pub(super) struct Helm {
    /// An angle \[rad\], else a part of the dictionary's helm, or an input.
    pub smooth: Vec<f64>,
    /// Whether it is an angle.
    pub is_angle: bool,
    /// Standard deviation of the noise of `smooth`.
    pub noise: f64,
    is_held: bool,
}

/// The helm from one order to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    /// 1 where it is as in the first order, −1 to the other side, 0 amidships.
    pub side: i8,
    /// When it begins to move there, in samples.
    pub from: f64,
    /// When it begins to move away, or the end of the record, in samples.
    pub to: f64,
    /// Where it is.
    pub level: f64,
    /// By how many samples `from` may be off, for the samples and the noise of the helm.
    pub doubt: f64,
}

impl Helm {
    /// That of `settings`: changes of inputs to starboard. `window` is the number of samples in which the ship covers her length.
    pub fn of(record: &Record, vessel: &Vessel, settings: &Settings, window: f64) -> Option<Self> {
        let inputs = vessel.model.input_variables();
        let places: Vec<(usize, f64, Option<f64>)> = inputs
            .iter()
            .enumerate()
            .filter_map(|(i, input)| Some((i, *settings.get(&input.name)?, radians(&input.unit))))
            .filter(|(_, change, _)| *change != 0.0)
            .collect();
        let squares: f64 = places.iter().map(|(_, change, _)| change * change).sum();
        let angles: Option<Vec<f64>> =
            places.iter().map(|(_, h, unit)| unit.map(|unit| h.abs() * unit)).collect();
        let scale = angles.as_ref().map_or(1.0, |all| all.iter().sum::<f64>() / all.len() as f64);
        if squares == 0.0 || record.inputs.is_empty() {
            return None;
        }
        let of = |row: &[f64]| places.iter().map(|(i, h, _)| h * row[*i]).sum::<f64>() * scale / squares;
        let raw: Vec<f64> = record.inputs.chunks_exact(inputs.len()).map(of).collect();
        let half = if record.is_held { 0 } else { ((HALF * window) as usize).min(MOST_HALF) };
        let around = |k: usize| {
            let half = half.min(k).min(raw.len() - 1 - k);
            median(raw[k - half..=k + half].iter().copied())
        };
        let smooth: Vec<f64> = (0..raw.len()).map(around).collect();
        // A helm that rests or moves evenly has no second difference but that of its noise.
        let bends = raw.windows(3).map(|three| (three[0] - 2.0 * three[1] + three[2]).abs());
        let rough = 1.4826 * median(bends) / 6_f64.sqrt();
        let noise = if half == 0 { rough } else { 1.25 * rough / ((2 * half + 1) as f64).sqrt() };
        Some(Self { smooth, is_angle: angles.is_some(), noise, is_held: record.is_held })
    }

    /// The mean of all rudders: what turns in angles, and follows no other input.
    pub fn of_rudders(record: &Record, hull: &Hull, window: f64) -> Option<Self> {
        let inputs = hull.vessel.model.input_variables().iter().zip(&hull.vessel.couplings);
        let rudders = inputs.filter(|(_, follows)| follows.is_none());
        // Equal angles of all are one of that size.
        let equal = rudders.filter_map(|(input, _)| Some((input.name.clone(), 1.0 / radians(&input.unit)?)));
        Self::of(record, hull.vessel, &equal.collect(), window)
    }

    /// How far it departs from `level` from sample `from` on, at the most.
    pub fn departs(&self, level: f64, from: usize) -> f64 {
        self.smooth[from..].iter().map(|angle| (angle - level).abs()).fold(0.0, f64::max)
    }

    /// When a move from one level to another, which is half done at sample `over`, began: where the line through its first half
    /// leaves the level. A sample whose input is held has the part of the order that falls into it.
    fn began(&self, [from, to]: [f64; 2], over: usize) -> [f64; 2] {
        let part = |k: usize| (self.smooth[k.min(self.smooth.len() - 1)] - from) / (to - from);
        let size = (to - from).abs();
        let [begun, early] =
            if self.is_angle { [BEGUN[0] / size, EARLY[0] / size] } else { [BEGUN[1], EARLY[1]] };
        let least = (4.0 * self.noise / size).max(begun).min(AMIDSHIPS);
        let first = (1..=over).rev().find(|k| part(k - 1) <= least).unwrap_or(0);
        if self.is_held && part(first + 1) >= STEP {
            return [first as f64 + (1.0 - part(first)).clamp(0.0, 1.0), DOUBT];
        }
        if part(first) >= STEP || first == 0 {
            return [first as f64, DOUBT];
        }
        let most = least + (60.0 * self.noise / size).max(early);
        let within: Vec<usize> =
            (first..=over).filter(|k| part(*k) <= MOST && (part(*k) <= most || *k < first + 3)).collect();
        let (began, slope) = if within.len() >= 3 {
            let count = within.len() as f64;
            let t = within.iter().map(|k| *k as f64).sum::<f64>() / count;
            let p = within.iter().map(|k| part(*k)).sum::<f64>() / count;
            let cross: f64 = within.iter().map(|k| (*k as f64 - t) * (part(*k) - p)).sum();
            let square: f64 = within.iter().map(|k| (*k as f64 - t).powi(2)).sum();
            (t - p * square / cross, cross / square)
        } else {
            let change = |k: &usize| part(k + 1) - part(*k);
            let steepest = (first - 1..=over).max_by(|a, b| change(a).total_cmp(&change(b))).unwrap_or(first);
            let slope = change(&steepest);
            (steepest as f64 + 0.5 - (part(steepest) + part(steepest + 1)) / 2.0 / slope, slope)
        };
        let began = began + if self.is_held { 1.0 } else { 0.0 };
        let doubt = DOUBT + 6.0 * self.noise / (slope.abs() * size);
        if began.is_finite() { [began.clamp(0.0, over as f64), doubt] } else { [first as f64, DOUBT] }
    }

    /// The first sample from `from` on at which it has gone from `level` half as far as it ever does.
    pub fn first_over(&self, level: f64, from: usize) -> Option<usize> {
        let most = self.departs(level, from);
        (from..self.smooth.len()).find(|k| (self.smooth[*k] - level).abs() >= OVER * most)
    }

    /// The last of `samples` that is within `near` of `level`.
    pub fn last_near(&self, level: f64, near: f64, samples: RangeInclusive<usize>) -> Option<usize> {
        samples.rev().find(|k| (self.smooth[*k] - level).abs() <= near)
    }

    /// The orders from sample `from` on, by how far the helm is from `amidships` in parts of the first one's `helm`. `window` is
    /// the number of samples in which the ship covers her length.
    pub fn orders(&self, from: usize, amidships: f64, helm: f64, window: f64) -> Vec<Held> {
        let part = |k: usize| (self.smooth[k] - amidships) / helm;
        let (mut runs, mut now): (Vec<(i8, usize)>, i8) = (Vec::new(), 0);
        for k in from..self.smooth.len() {
            now = match part(k) {
                share if share >= OVER => 1,
                share if share <= -OVER => -1,
                share if share.abs() <= AMIDSHIPS => 0,
                _ => now,
            };
            if runs.last().map_or(now != 0, |(last, _)| *last != now) {
                runs.push((now, k));
            }
        }
        // On its way to the other side it passes amidships.
        let end = self.smooth.len();
        let stays = |i: &usize| {
            let until = runs.get(i + 1).map_or(end, |(_, k)| *k);
            runs[*i].0 != 0 || until == end || (until - runs[*i].1) as f64 > 1.5 * window
        };
        let mut kept: Vec<(i8, usize)> = (0..runs.len()).filter(stays).map(|i| runs[i]).collect();
        kept.dedup_by_key(|(side, _)| *side);
        let ends = |i: usize| kept.get(i + 1).map_or(end, |(_, k)| *k);
        let level = |i: usize| match kept[i].0 {
            0 => median(self.smooth[kept[i].1..ends(i)].iter().copied()),
            // Where it moves to and stays: most of the time it is there, and never much beyond.
            side => {
                let toward = f64::from(side) * helm.signum();
                let all = self.smooth[kept[i].1..ends(i)].iter().map(|angle| Some(toward * angle));
                toward * quantile(&statistics::sorted(all), 0.7).unwrap_or(0.0)
            }
        };
        let levels: Vec<f64> = (0..kept.len()).map(level).collect();
        let before = |i: usize| if i == 0 { amidships } else { levels[i - 1] };
        let began: Vec<[f64; 2]> =
            (0..kept.len()).map(|i| self.began([before(i), levels[i]], kept[i].1)).collect();
        let one = |i: usize| Held {
            side: kept[i].0,
            from: began[i][0],
            to: began.get(i + 1).map_or(end as f64, |[from, _]| *from),
            level: levels[i],
            doubt: began[i][1],
        };
        (0..kept.len()).map(one).collect()
    }
}

/// What is seen of a ship before the order.
pub(super) struct Approach {
    samples: std::ops::Range<usize>,
    /// Course \[rad\] and speed \[m/s\].
    pub motion: [f64; 2],
    /// Its length, in times in which the ship covers hers.
    length: f64,
}

impl Approach {
    /// Before `order`, from sample `begin` on at the earliest.
    pub fn of(record: &Record, begin: usize, order: f64, window: f64) -> Self {
        let end = (order.floor() as usize + 1).min(record.heading.len());
        let first = begin.min(end - 1);
        let from = |lengths: f64| ((order - lengths * window).ceil().max(0.0) as usize).clamp(first, end - 1);
        let samples = from(APPROACH)..end;
        let [course, speed_m_s] = [&record.heading[from(1.0)..end], &record.speed[samples.clone()]]
            .map(|values| mean(values).unwrap_or(0.0));
        Self { samples, motion: [course, speed_m_s], length: (order - begin as f64).max(0.0) / window }
    }

    /// Whether it was long and steady.
    pub fn remarks(&self, record: &Record, helm: Option<&Helm>, window: f64) -> Vec<String> {
        let lengths = self.length.min(APPROACH);
        if self.length < 0.5 {
            return vec![format!(
                "the approach in the log is {lengths:.1} ship lengths long, so that its steadiness is not known"
            )];
        }
        let mut unsteady = Vec::new();
        let change = |of: &[f64]| slope(of, self.samples.clone());
        let turn = change(&record.heading) * window;
        if turn.abs() > STEADY_TURN {
            unsteady.push(format!("she turned by {} while she covered her length", degrees(turn)));
        }
        let slower = change(&record.speed) * self.samples.len() as f64 / self.motion[1];
        if slower.abs() > STEADY_SPEED {
            unsteady.push(format!("her speed changed by {:.0} %", 100.0 * slower));
        }
        if let Some(helm) = helm {
            let angles = &helm.smooth[self.samples.start..self.samples.end.min(helm.smooth.len())];
            // The order itself may be in the last of them.
            let angles = &angles[..angles.len().saturating_sub(2).max(1)];
            let spread = spread(angles).unwrap_or(0.0);
            if spread > STEADY_HELM.max(3.0 * helm.noise) {
                unsteady.push(format!("the helm moved with a standard deviation of {}", degrees(spread)));
            }
        }
        if unsteady.is_empty() {
            return Vec::new();
        }
        vec![format!("the approach was not steady: in {lengths:.1} ship lengths {}", unsteady.join(", "))]
    }
}

/// The slope of values by their number, of least squares.
fn slope(values: &[f64], of: std::ops::Range<usize>) -> f64 {
    let middle = 0.5 * (of.start + of.end - 1) as f64;
    let cross: f64 = of.clone().map(|k| (k as f64 - middle) * values[k]).sum();
    let square: f64 = of.map(|k| (k as f64 - middle).powi(2)).sum();
    if square > 0.0 { cross / square } else { 0.0 }
}

/// The input that the helm moves most of its range, or most: its place and unit.
fn rudder(helm: &Settings, hull: &Hull) -> (usize, String) {
    let vessel = hull.vessel;
    let inputs = vessel.model.input_variables();
    let moved = |(i, input): (usize, &ship::model::Variable)| {
        let change = helm.get(&input.name)?;
        let range = vessel.actuators[i].range.map_or(1.0, |[low, high]| high - low);
        Some((i, input.unit.clone(), change.abs() / range))
    };
    let most = inputs.iter().enumerate().filter_map(moved).max_by(|a, b| a.2.total_cmp(&b.2));
    most.map_or((0, String::new()), |(i, unit, _)| (i, unit))
}

/// Mean helm and yaw rate over the last quarter of every step.
fn settled(record: &Record, input: usize, count: usize, dwell_s: f64) -> Result<Vec<[f64; 2]>, Invalid> {
    let width = record.inputs.len() / record.last().max(1);
    let needed = count as f64 * dwell_s;
    if needed > (record.last() as f64 + 0.5) / record.rate_hz {
        let given = format!("{:.1} s", record.last() as f64 / record.rate_hz);
        return Err(Invalid::new("spiral", given, format!("{needed} s for all steps"), "run it longer"));
    }
    let one = |step: usize| {
        let from = record.sample((step as f64 + 0.75) * dwell_s);
        let to = record.sample((step as f64 + 1.0) * dwell_s).max(from + 1);
        let mean = |of: &dyn Fn(usize) -> f64| (from..to).map(of).sum::<f64>() / (to - from) as f64;
        [mean(&|k| record.inputs[k.min(record.last() - 1) * width + input]), mean(&|k| record.yaw_rate[k])]
    };
    Ok((0..count).map(one).collect())
}

/// Where straight lines through `points`, \[helm, yaw rate\], first pass a yaw rate of zero.
fn neutral(points: &[[f64; 2]]) -> Option<f64> {
    points.windows(2).find_map(|pair| {
        let [[helm, rate], [next, after]] = [pair[0], pair[1]];
        (rate == 0.0 || (rate > 0.0) != (after > 0.0)).then(|| helm + rate / (rate - after) * (next - helm))
    })
}

/// The loop of a direct spiral: between the helms at which the yaw rate changes sides on the way there and on the way back.
pub(super) fn direct(spiral: &SpiralTest, record: &Record, hull: &Hull) -> Result<Vec<Figure>, Invalid> {
    let (input, unit) = rudder(&spiral.helm, hull);
    let points = settled(record, input, steps(spiral.steps, true).count(), spiral.dwell_s)?;
    let there = 2 * spiral.steps as usize;
    let ends = neutral(&points[..=there]).zip(neutral(&points[there..]));
    let (one, two) = ends.ok_or_else(|| {
        let expected = "one on the way there and one on the way back";
        Invalid::new("yaw rate", "no change of sides", expected, "take more helm, or longer steps")
    })?;
    let rates = points.iter().map(|[_, rate]| rate.abs()).fold(0.0, f64::max);
    Ok(vec![
        Figure::of_helm("loop_width", "width of the loop", (one - two).abs(), &unit),
        Figure::of_helm("neutral_helm", "helm in the middle of it", 0.5 * (one + two), &unit),
        Figure::new("greatest_yaw_rate", "greatest yaw rate", rates.to_degrees(), "deg/s"),
    ])
}

/// The loop of a reverse spiral: the range of helm in which the curve of helm over yaw rate falls.
pub(super) fn reverse(spiral: &ReverseSpiral, record: &Record, hull: &Hull) -> Result<Vec<Figure>, Invalid> {
    let (input, unit) = rudder(&spiral.helm, hull);
    let points = settled(record, input, steps(spiral.steps, false).count(), spiral.dwell_s)?;
    let ends = [points[0][0], points[points.len() - 1][0]];
    let side = (ends[0] - ends[1]).signum();
    // With a helm that only ever goes one way there is no loop.
    let (mut least, mut width) = (f64::INFINITY, 0.0_f64);
    for [helm, _] in &points {
        least = least.min(side * helm);
        width = width.max(side * helm - least);
    }
    let neutral = neutral(&points).ok_or_else(|| {
        Invalid::new("yaw rate", "no change of sides", "turns to both sides", "take more helm")
    })?;
    Ok(vec![
        Figure::of_helm("loop_width", "width of the loop", width, &unit),
        Figure::of_helm("neutral_helm", "helm of no yaw rate", neutral, &unit),
    ])
}
