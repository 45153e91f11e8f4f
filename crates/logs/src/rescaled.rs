//! Channels whose unit changes within a recording: their size changes by the ratio of two units at a moment, and the motion
//! does not.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::quality::{Derivatives, correlations};
use crate::suspicion::{Oddity, WarningKind};
use crate::{ChannelSpec, Channels, Samples, unit};

/// Ratios of units by what is measured, with their names, the larger number first.
const RATIOS: [(&str, f64, &str); 7] = [
    ("rad", 360.0 / TAU, "deg and rad"),
    ("rad/s", 360.0 / TAU, "deg/s and rad/s"),
    ("rad/s", 60.0, "deg/min and deg/s"),
    ("1/s", 60.0, "rpm and rps"),
    ("1/s", TAU, "rad/s and rps"),
    ("m/s", 3600.0 / 1852.0, "kn and m/s"),
    ("m/s", 3.6, "km/h and m/s"),
];

/// Values that are compared at most, and the fewest on either side.
const MOST: usize = 2000;
const FEWEST: usize = 8;

/// Correlation from which an angle and the turning belong together.
const CORRELATED: f64 = 0.5;

/// The oddity of the channel of `spec`, if its unit changes.
pub(crate) fn rescaled(
    spec: &ChannelSpec,
    channels: &Channels,
    derivatives: Option<&Derivatives>,
) -> Option<Oddity> {
    let (series, si) = (channels.get(&spec.channel)?, unit(&spec.unit)?.si);
    let turning = || derivatives.map(|own| &own.r);
    let motion = match (si, spec.channel.as_str()) {
        ("rad", "psi" | "roll" | "pitch" | "wind_from" | "latitude_deg" | "longitude_deg") => return None,
        ("rad", _) => Some(channels.get("y_r").or_else(turning)?),
        ("rad/s", "y_r") => Some(turning()?),
        ("1/s", _) => Some(channels.get("y_u")?),
        ("m/s", "y_u") => None,
        _ => return None,
    };
    let every = series.t.len().div_ceil(MOST).max(1);
    let (times, values): (Vec<f64>, Vec<f64>) =
        series.t.iter().zip(series.values.iter()).step_by(every).unzip();
    let known = |value: f64| if value.is_finite() { value } else { 0.0 };
    let motion: Option<Vec<f64>> = motion.map(|own| own.at(times.iter().copied()).map(known).collect());
    let (k, size) = split(&values)?;
    let is_near = |found: f64, ratio: f64, most: f64| libm::log(found / ratio).abs() < libm::log(most);
    let fits = |(of, ratio, _): &&(&str, f64, &str)| {
        let ratio = if size > 1.0 { *ratio } else { 1.0 / ratio };
        let value = |i: usize| if i < k { values[i] } else { ratio * values[i] };
        let mut steps: Vec<f64> = (1..values.len()).map(|i| (value(i) - value(i - 1)).abs()).collect();
        let step = steps[k - 1];
        steps.sort_by(f64::total_cmp);
        let usual = steps[steps.len() * 9 / 10];
        let goes_on = step <= 4.0 * usual + 0.02 * values[k - 1].abs();
        let belongs = |motion: &[f64], part: Range<usize>| {
            let [own, other] =
                [values.as_slice(), motion].map(|all| Samples::from(all[part.clone()].to_vec()));
            si == "1/s"
                || correlations(&own, &other, part.len() / 4).iter().any(|own| own.abs() >= CORRELATED)
        };
        let stays = |motion: &Vec<f64>| {
            let [before, after] = [&motion[..k], &motion[k..]].map(mean_square);
            let is_same = is_near((before / after).sqrt(), 1.0, 2.0);
            is_same && belongs(motion, 0..k) && belongs(motion, k..values.len())
        };
        *of == si
            && goes_on
            && is_near(size, ratio, 2.0)
            && motion.as_ref().map_or_else(
                // A ship cannot lose half of her speed from one value to the next.
                || is_near(size, ratio, 1.3) && (values[k] - values[k - 1]).abs() > 8.0 * usual,
                stays,
            )
    };
    let (_, ratio, units) = RATIOS.iter().find(fits)?;
    let how = if size > 1.0 { "smaller" } else { "larger" };
    let text = format!(
        "is {ratio:.3} times {how} from {:.1} s of the recording on, and the motion goes on as before: its unit may change there \
         ({units}); cut the log there, and ingest each part with its own `unit`",
        times[k]
    );
    Some((WarningKind::Unit, 1, text))
}

fn mean_square(of: &[f64]) -> f64 {
    of.iter().map(|value| value * value).sum::<f64>() / of.len() as f64
}

/// The index from which on `values` have another size, and the ratio of the sizes before and after: by the likelihood of
/// normal values.
fn split(values: &[f64]) -> Option<(usize, f64)> {
    let cost = |k: &usize| {
        let [before, after] = [&values[..*k], &values[*k..]].map(mean_square);
        *k as f64 * libm::log(before) + (values.len() - k) as f64 * libm::log(after)
    };
    let inner = FEWEST..values.len().saturating_sub(FEWEST);
    let all = inner.map(|k| (cost(&k), k)).filter(|(cost, _)| cost.is_finite());
    let (_, k) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((k, (mean_square(&values[..k]) / mean_square(&values[k..])).sqrt()))
}
