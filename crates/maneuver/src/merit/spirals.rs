use refusal::Invalid;

use super::figure::{Figure, Hull};
use super::record::Record;
use crate::standard::{ReverseSpiral, Settings, SpiralTest, steps};

/// The input that the helm moves most of its range, or most: its place and unit.
fn rudder(helm: &Settings, hull: &Hull) -> (usize, String) {
    let vessel = hull.vessel;
    let inputs = vessel.model.input_variables();
    let moved = |(i, own): (usize, &ship::model::Variable)| {
        let change = helm.get(&own.name)?;
        let range = vessel.actuators[i].range.map_or(1.0, |[low, high]| high - low);
        Some((i, own.unit.clone(), change.abs() / range))
    };
    let most = inputs.iter().enumerate().filter_map(moved).max_by(|a, b| a.2.total_cmp(&b.2));
    most.map_or((0, String::new()), |(i, unit, _)| (i, unit))
}

/// Mean helm and yaw rate over the last quarter of every step.
fn settled(record: &Record, input: usize, count: usize, dwell_s: f64) -> Result<Vec<[f64; 2]>, Invalid> {
    let width = record.inputs.len() / record.last().max(1);
    let needed = count as f64 * dwell_s;
    if needed > (record.last() as f64 + 0.5) / record.rate_hz {
        let found = format!("{:.1} s", record.last() as f64 / record.rate_hz);
        return Err(Invalid::new("spiral", found, format!("{needed} s for all steps"), "run it longer"));
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
