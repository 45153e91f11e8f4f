//! Data that can be read but may not be what ingest.toml says: wrong units are refused, the rest is counted and told.

use std::f64::consts::TAU;
use std::path::Path;

use logs::{Channels, Consistency, Unit};

use super::config::{ChannelSpec, IngestFile};
use crate::failure::Failure;
use study::documents::{ChannelSummary, WarningSummary};

/// Units of angles and how many of them a turn has.
const TURNS: [(&str, f64); 2] = [("deg", 360.0), ("rad", TAU)];

/// What a velocity is multiplied by where it is in this unit instead of m/s.
const SPEEDS: [(&str, f64); 5] =
    [("knot", 3600.0 / 1852.0), ("km/h", 3.6), ("mm/s", 1e3), ("cm/s", 1e2), ("ft/s", 1.0 / 0.3048)];

/// What a rate of turn is multiplied by where it is in this unit instead of rad/s.
const RATES: [(&str, f64); 2] = [("deg/s", 360.0 / TAU), ("deg/min", 60.0 * 360.0 / TAU)];

/// How far a ratio may be off that of two units.
const SAME_RATIO: f64 = 0.02;

/// Refuses an angle that wraps by a turn of another unit than its own. `numbers` as they stand in the file, each on its
/// line.
pub fn check_turns(
    path: &Path,
    spec: &ChannelSpec,
    unit: &Unit,
    numbers: &[f64],
    lines: &[usize],
) -> Result<(), Failure> {
    if unit.si != "rad" {
        return Ok(());
    }
    let own = TAU / unit.factor;
    let largest = numbers.iter().filter(|n| n.is_finite()).fold(0.0, |most: f64, n| most.max(n.abs()));
    let is_turn = |step: f64, turn: f64| (step.abs() / turn - 1.0).abs() < 0.08;
    for (name, turn) in TURNS.into_iter().filter(|(_, turn)| (turn / own - 1.0).abs() > 0.1) {
        if largest > 1.02 * turn {
            continue;
        }
        let wraps = |i: &usize| is_turn(numbers[i + 1] - numbers[*i], turn);
        if let Some(at) = (0..numbers.len().saturating_sub(1)).find(wraps) {
            return Err(Failure::refuse(
                path,
                &format!("line {}, column `{}`", lines[at + 1], spec.column),
                &format!("{} after {}, a turn in {name}", numbers[at + 1], numbers[at]),
                &format!("angles in {}, as its `unit` says", unit.name),
                &format!("it looks like {name}: set `unit = \"{name}\"`"),
            ));
        }
    }
    Ok(())
}

/// Refuses velocities that are a unit's ratio off the derivative of position or heading.
pub fn check_ratios(path: &Path, motion: &[Option<Consistency>; 3]) -> Result<(), Failure> {
    let states = [("y_u", "`x` and `y`"), ("y_v", "`x` and `y`"), ("y_r", "`psi`")];
    for ((channel, of), found) in states.into_iter().zip(motion) {
        let Some(gain) = found.and_then(|found| found.gain) else { continue };
        let units = if channel == "y_r" { &RATES[..] } else { &SPEEDS[..] };
        let same = |ratio: f64| (gain / ratio - 1.0).abs() < SAME_RATIO;
        let Some((unit, ratio)) = units.iter().find(|(_, ratio)| same(*ratio) || same(1.0 / ratio)) else {
            continue;
        };
        let remedy = match (same(*ratio), channel) {
            (true, _) => format!("`{channel}` may be in {unit}: correct its `unit`, or that of {of}"),
            (false, "y_r") => format!("{of} may be in deg: correct its `unit`, or that of `{channel}`"),
            (false, _) => format!("{of} may be in another unit: correct it, or that of `{channel}`"),
        };
        let found = format!("{gain:.4} times the derivative of {of}");
        return Err(Failure::refuse(
            path,
            &format!("unit of channel `{channel}`"),
            &found,
            "about 1 times it",
            &remedy,
        ));
    }
    Ok(())
}

/// What is odd about the channels of a recording.
pub fn warnings(
    config: &IngestFile,
    channels: &Channels,
    summaries: &[ChannelSummary],
) -> Vec<WarningSummary> {
    let mut found = Vec::new();
    for spec in config.file.iter().flat_map(|file| &file.channel) {
        let Some(summary) = summaries.iter().find(|summary| summary.name == spec.channel) else { continue };
        found.extend(constant(summary));
        found.extend(angle(spec, summary));
        found.extend(slow(config.sample_rate_hz, summary));
    }
    found.extend(jumps(channels));
    found
}

fn warning(kind: &str, channel: &str, count: u64, text: String) -> WarningSummary {
    WarningSummary { kind: kind.to_owned(), channel: channel.to_owned(), count, text }
}

fn constant(summary: &ChannelSummary) -> Option<WarningSummary> {
    let value = summary.min.filter(|min| summary.max == Some(*min))?;
    Some(warning("constant", &summary.name, 1, format!("`{}` is {value} throughout", summary.name)))
}

/// An angle beyond a turn (but for the heading, which may go round), or one in degrees that stays within a turn in radians.
fn angle(spec: &ChannelSpec, summary: &ChannelSummary) -> Option<WarningSummary> {
    let largest = summary.min?.abs().max(summary.max?.abs());
    let named = &summary.name;
    match spec.unit.as_str() {
        "rad" if largest > TAU && named != "psi" => {
            let text = format!("`{named}` reaches {largest:.1} rad, more than a turn: it may be in degrees");
            Some(warning("unit", named, 1, text))
        }
        "deg" if largest.to_degrees() <= TAU && largest > 0.0 => {
            let text =
                format!("`{named}` stays within {:.2} deg: it may be in radians", largest.to_degrees());
            Some(warning("unit", named, 1, text))
        }
        _ => None,
    }
}

/// A channel that is logged less often than the common rate.
fn slow(rate_hz: f64, summary: &ChannelSummary) -> Option<WarningSummary> {
    let own = summary.rate_hz.filter(|own| *own < 0.75 * rate_hz)?;
    let text = format!("`{}` is logged at {own:.3} Hz and interpolated to {rate_hz} Hz", summary.name);
    Some(warning("rate", &summary.name, 1, text))
}

/// Steps of the heading that no turn explains: over 0.2 rad and twelve times the median step.
fn jumps(channels: &Channels) -> Option<WarningSummary> {
    let psi = channels.get("psi")?;
    let mut steps: Vec<f64> = psi.values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let all = steps.clone();
    let middle = steps.len().checked_sub(1)? / 2;
    let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let most = (12.0 * median).max(0.2);
    let count = all.iter().filter(|step| **step > most).count() as u64;
    let text = format!("`psi` jumps by more than {:.1} deg {count} times", most.to_degrees());
    (count > 0).then(|| warning("jump", "psi", count, text))
}
