//! Whether samples come about as often as requested: where they are off by far, times are in another unit.

use refusal::Invalid;

use crate::{ChannelSummary, Channels, Setup};

/// No setup resamples to a rate that is so many times higher or lower than the logged one.
const FAR: f64 = 900.0;

/// Nor so many times higher in a recording of a few seconds.
const OFTEN: f64 = 90.0;
const SHORT_S: f64 = 5.0;

/// A recording of fewer samples is a short one.
const FEW: f64 = 100.0;

/// Refuses channels whose steps are a thousandth, or thousands, of the requested step.
pub(crate) fn check_pace(
    setup: &Setup,
    channels: &Channels,
    found: &[ChannelSummary],
) -> Result<(), Invalid> {
    let common = setup.conventions.rate_hz;
    // Some channels, such as depth, may be logged very slowly.
    let all_slow = found.iter().filter_map(|channel| channel.rate_hz).all(|rate| rate / common <= 1.0 / FAR);
    for spec in setup.channels() {
        let rate =
            found.iter().find(|channel| channel.name == spec.channel).and_then(|channel| channel.rate_hz);
        let times = channels.get(&spec.channel).map(|series| &series.t);
        let (Some(rate), Some([first, last])) = (rate, times.and_then(|t| Some([t.first()?, t.last()?])))
        else {
            continue;
        };
        let (pace, duration_s) = (rate / common, last - first);
        let too_fast = pace >= FAR && duration_s * common < FEW || pace >= OFTEN && duration_s < SHORT_S;
        if !too_fast && !all_slow {
            continue;
        }
        let unit = if too_fast { "seconds, or milliseconds" } else { "milliseconds, or finer" };
        return Err(Invalid::new(
            format!("times of channel `{}`", spec.channel),
            format!("{:.3e} s from row to row, {duration_s:.3} s in all", 1.0 / rate),
            format!("about {} s, as `sample_rate_hz` says", 1.0 / common),
            format!("correct the time's `unit`: it may count {unit}; or else `sample_rate_hz`"),
        ));
    }
    Ok(())
}
