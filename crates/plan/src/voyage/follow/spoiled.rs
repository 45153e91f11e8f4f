//! Maneuvers that were sailed along their tracks, and not as planned.

use std::collections::BTreeMap;

use numerics::statistics::sorted;

use super::along::Along;
use super::track::{ShipPosition, TrackPoint, median};

/// A time that a maneuver was broken off for, or that is left out of it \[s\]; the plan goes on by less than a part of it.
const BROKEN_S: f64 = 30.0;
const GOES_ON: f64 = 0.3;
/// Waits this near the ends are not of the maneuver \[s\].
const ENDS_S: f64 = 5.0;
/// Least part of the planned motion, or input, and greatest error of it that tells.
const LEAST: f64 = 0.5;
const TELLS: f64 = 0.15;
/// Part of the samples at which an input may differ from the planned one, by a part of its amplitude.
const FEW: f64 = 0.1;
const DIFFERS: f64 = 0.5;

/// Series over time, by name: times and values.
pub type Inputs = BTreeMap<String, Vec<[f64; 2]>>;

/// What a log says of how a maneuver was sailed.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Sailed {
    /// As planned.
    Planned,
    /// Neither: the track is straight, and no input was logged.
    Unknown,
    /// Not as planned.
    Otherwise(String),
}

/// A position in a maneuver, and the point of the plan that it belongs to.
type Fix = (ShipPosition, TrackPoint);

impl Along<'_> {
    /// How the maneuver of `step` was sailed, by motion and by the inputs that were planned and logged.
    pub(super) fn sailed(&self, step: usize, [planned, logged]: [&Inputs; 2]) -> Sailed {
        let fix = |(ship, k): (&ShipPosition, &usize)| (*ship, self.track.points[*k]);
        let informative = |(_, plan): &Fix| plan.step == step && plan.informative;
        let fixes: Vec<Fix> = self.positions.iter().zip(&self.at).map(fix).filter(informative).collect();
        if fixes.is_empty() {
            return Sailed::Planned;
        }
        let of = |(name, informative): (&String, &Vec<[f64; 2]>)| {
            input(&fixes, name, [informative, logged.get(name)?])
        };
        let inputs: Vec<Option<String>> = planned.iter().filter_map(of).collect();
        let known = !inputs.is_empty();
        match inputs.into_iter().flatten().next().or_else(|| broken_off(&fixes)) {
            Some(why) => Sailed::Otherwise(why),
            None => shape(&fixes, known),
        }
    }
}

/// Where the ship waited in a maneuver, sailed part of it again, or left part of it out.
fn broken_off(fixes: &[Fix]) -> Option<String> {
    let [begins_s, ends_s] = [fixes.first()?, fixes.last()?].map(|(_, plan)| plan.at_s);
    let usual = fixes.iter().map(|(_, plan)| plan.speed_m_s).sum::<f64>() / fixes.len() as f64;
    let is_inner = |(_, plan): &&Fix| {
        (begins_s + ENDS_S..=ends_s - ENDS_S).contains(&plan.at_s) && plan.speed_m_s >= 0.5 * usual
    };
    let inner: Vec<&Fix> = fixes.iter().filter(is_inner).collect();
    let pairs = inner.iter().enumerate().flat_map(|(k, from)| inner[k..].iter().map(move |to| (*from, *to)));
    // By how much the log, or the plan, goes on while the other hardly does.
    let times = |(from, to): &(&Fix, &Fix)| [to.0.at_s - from.0.at_s, to.1.at_s - from.1.at_s];
    let stands = |pair: &(&Fix, &Fix)| {
        let [took_s, planned_s] = times(pair);
        let [least, most] = [took_s.min(planned_s), took_s.max(planned_s)];
        (most - least >= BROKEN_S).then_some(GOES_ON * most - least)
    };
    let pair = pairs.max_by(|a, b| stands(a).unwrap_or(-1.0).total_cmp(&stands(b).unwrap_or(-1.0)))?;
    stands(&pair).filter(|by| *by >= 0.0)?;
    let ([took_s, planned_s], after_s) = (times(&pair), pair.0.1.at_s - begins_s);
    Some(match took_s > planned_s {
        true => format!("broken off {after_s:.0} s after its beginning, and resumed {took_s:.0} s later"),
        false => format!("{planned_s:.0} s of it are left out, {after_s:.0} s after its beginning"),
    })
}

/// How much of the planned motion aside of a straight line there is, over the maneuver and each third of it.
fn shape(fixes: &[Fix], known: bool) -> Sailed {
    let third = fixes.len() / 3;
    let parts = [0..fixes.len(), 0..third, third..2 * third, 2 * third..fixes.len()];
    let gains: Vec<[f64; 2]> = parts.into_iter().filter_map(|part| gain(&fixes[part])).collect();
    let tells = || gains.iter().filter(|[_, error]| *error <= TELLS);
    match tells().find(|[own, error]| own + 2.0 * error < LEAST) {
        Some([own, _]) if *own < -LEAST => Sailed::Otherwise("to the other side".to_owned()),
        Some([own, _]) => {
            let percent = 100.0 * own.max(0.0);
            let words = format!("its motion has {percent:.0} % of the planned one, or a part of it has");
            Sailed::Otherwise(words)
        }
        None if known || tells().next().is_some() => Sailed::Planned,
        None => Sailed::Unknown,
    }
}

/// The part of the planned way aside of a straight line that was sailed, and its standard error.
fn gain(fixes: &[Fix]) -> Option<[f64; 2]> {
    let mean = |of: &dyn Fn(&Fix) -> f64| fixes.iter().map(of).sum::<f64>() / fixes.len() as f64;
    let at_s = mean(&|(_, plan)| plan.at_s);
    let later_s = |(_, plan): &Fix| plan.at_s - at_s;
    let squares = mean(&|own| later_s(own) * later_s(own));
    let aside = |place: fn(&Fix) -> [f64; 2]| -> Vec<[f64; 2]> {
        let line = [0, 1].map(|c: usize| {
            [mean(&|own| place(own)[c]), mean(&|own| later_s(own) * place(own)[c]) / squares]
        });
        let off = |own: &Fix| [0, 1].map(|c: usize| place(own)[c] - line[c][0] - line[c][1] * later_s(own));
        fixes.iter().map(off).collect()
    };
    let (planned, sailed) = (aside(|(_, plan)| plan.place), aside(|(ship, _)| ship.place));
    let dot =
        |a: &[[f64; 2]], b: &[[f64; 2]]| a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum::<f64>();
    let squares = dot(&planned, &planned);
    let gain = dot(&planned, &sailed) / squares;
    let misses = dot(&sailed, &sailed) - gain * gain * squares;
    let error = (misses.max(0.0) / (2.0 * fixes.len() as f64) / squares).sqrt();
    (gain.is_finite() && error.is_finite()).then_some([gain, error])
}

/// Whether a logged input is the planned one; `None` where it was not logged, or is constant in the plan.
fn input(fixes: &[Fix], name: &str, series: [&[[f64; 2]]; 2]) -> Option<Option<String>> {
    let value = |series: &[[f64; 2]], at_s: f64| {
        let next = series.partition_point(|own| own[0] <= at_s + 1e-6);
        series.get(next.checked_sub(1)?).filter(|own| at_s - own[0] <= BROKEN_S).map(|own| own[1])
    };
    let pair = |(ship, plan): &Fix| Some([value(series[0], plan.at_s)?, value(series[1], ship.at_s)?]);
    let pairs: Vec<[f64; 2]> = fixes.iter().filter_map(pair).collect();
    let middle = median(pairs.iter().map(|own| own[0]));
    let amplitudes = sorted(pairs.iter().map(|pair| Some((pair[0] - middle).abs())));
    let amplitude = amplitudes
        .get(amplitudes.len() * 9 / 10)
        .copied()
        .filter(|amplitude| *amplitude > 1e-6 * middle.abs())?;
    let sum = |of: fn(&[f64; 2]) -> f64| pairs.iter().map(of).sum::<f64>();
    let gain = (sum(|own| own[0] * own[1]) / sum(|own| own[0] * own[0])).clamp(LEAST, 1.0 / LEAST);
    let differs = pairs.iter().filter(|pair| (pair[1] / gain - pair[0]).abs() > DIFFERS * amplitude).count();
    let part = differs as f64 / pairs.len() as f64;
    let words = || format!("`{name}` differs from the planned one for {:.0} % of it", 100.0 * part);
    Some((part > FEW).then(words))
}
