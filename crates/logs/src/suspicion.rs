//! Data that can be read but may not be what they are declared to be: wrong units are refused, the rest
//! becomes counted warnings.

use std::f64::consts::TAU;

use numerics::statistics::streamed_median;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::samples::steps;
use crate::{ChannelSpec, ChannelSummary, Channels, MotionSummary, Setup, Unit};

/// Units of angles and their number per turn.
const TURNS: [(&str, f64); 2] = [("deg", 360.0), ("rad", TAU)];

/// The factor from m/s to another unit of speed.
const SPEEDS: [(&str, f64); 5] =
    [("knot", 3600.0 / 1852.0), ("km/h", 3.6), ("mm/s", 1e3), ("cm/s", 1e2), ("ft/s", 1.0 / 0.3048)];

/// The factor from rad/s to another unit of turn rate.
const RATES: [(&str, f64); 2] = [("deg/s", 360.0 / TAU), ("deg/min", 60.0 * 360.0 / TAU)];

/// Tolerance for a ratio to match that of two units.
const SAME_RATIO: f64 = 0.02;

/// Finds angles in a column that wrap at a turn of another unit than their own.
pub(crate) struct Turns<'a> {
    unit: &'a Unit,
    largest: f64,
    before: f64,
    count: usize,
    wraps: Vec<Wraps>,
    /// A time at least a second ago, and the number then.
    anchor: (f64, f64),
    fast: usize,
}

/// How a channel looked as logged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LoggedShape {
    /// Its largest modulus, in SI units.
    largest: f64,
    /// How often it moved faster than any direction of a turning ship.
    fast: usize,
}

/// No direction turns faster for a second, even on a small model \[rad/s\].
const FAST: f64 = 1.5;

/// How often it must do so: a single jump may be a fault.
const OFTEN: usize = 3;

/// Numbers that differ from the previous one by a turn of another unit.
struct Wraps {
    /// The unit, and a turn in it.
    unit: &'static str,
    turn: f64,
    /// The first such number: its index, the previous number, itself.
    first: Option<(usize, [f64; 2])>,
}

impl<'a> Turns<'a> {
    /// Before the first number of a column in `unit`.
    pub(crate) fn new(unit: &'a Unit) -> Self {
        let factor = TAU / unit.factor;
        let others =
            TURNS.into_iter().filter(|(_, turn)| unit.si == "rad" && (turn / factor - 1.0).abs() > 0.1);
        let wraps = others.map(|(unit, turn)| Wraps { unit, turn, first: None }).collect();
        let anchor = (f64::NEG_INFINITY, f64::NAN);
        Self { unit, largest: 0.0, before: f64::NAN, count: 0, wraps, anchor, fast: 0 }
    }

    /// Takes the next number, at `time` \[s\].
    pub(crate) fn see(&mut self, number: f64, time: f64) {
        for Wraps { turn, first, .. } in &mut self.wraps {
            if first.is_none() && ((number - self.before).abs() / *turn - 1.0).abs() < 0.08 {
                *first = Some((self.count, [self.before, number]));
            }
        }
        if number.is_finite() {
            self.largest = self.largest.max(number.abs());
            let (since, from) = self.anchor;
            if time - since >= 1.0 {
                let rate = (number - from).abs() * self.unit.factor / (time - since);
                self.fast += usize::from(rate > FAST);
                self.anchor = (time, number);
            }
        }
        self.before = number;
        self.count += 1;
    }

    /// Whether the numbers exceed a turn of their unit.
    pub(crate) fn go_beyond(&self) -> bool {
        self.unit.si == "rad" && self.largest * self.unit.factor > 1.02 * TAU
    }

    /// How the numbers looked.
    pub(crate) fn seen(&self) -> LoggedShape {
        LoggedShape { largest: self.unit.factor * self.largest, fast: self.fast }
    }

    /// Refuses `column`, whose number `i` stands on `line(i)`, if it wraps at another unit's turn.
    pub(crate) fn check(&self, column: &str, line: impl Fn(usize) -> String) -> Result<(), Invalid> {
        for Wraps { unit: name, turn, first } in &self.wraps {
            if let Some((i, [before, number])) = first.filter(|_| self.largest <= 1.02 * turn) {
                return Err(Invalid::new(
                    format!("line {}, column `{column}`", line(i)),
                    format!("{number} after {before}, a turn in {name}"),
                    format!("angles in {}, as its `unit` says", self.unit.name),
                    format!("it looks like {name}: set `unit = \"{name}\"`"),
                ));
            }
        }
        Ok(())
    }
}

/// Refuses velocities that differ from the derivative of position or heading by the ratio of two units.
pub(crate) fn check_ratios(motion: &[Option<MotionSummary>; 3]) -> Result<(), Invalid> {
    let units = [("y_u", &SPEEDS[..]), ("y_v", &SPEEDS), ("y_r", &RATES)];
    for ((channel, units), fit) in units.into_iter().zip(motion) {
        let Some(gain) = fit.and_then(|fit| fit.gain) else { continue };
        let same = |ratio: f64| (gain / ratio - 1.0).abs() < SAME_RATIO;
        if let Some((unit, ratio)) = units.iter().find(|(_, ratio)| same(*ratio) || same(1.0 / ratio)) {
            return Err(other_unit(channel, gain, same(*ratio).then_some(*unit)));
        }
    }
    Ok(())
}

/// `channel` is `gain` times the derivative of position or heading: it may be in `unit`, or the channel it is
/// compared with in another.
fn other_unit(channel: &str, gain: f64, unit: Option<&str>) -> Invalid {
    let of = if channel == "y_r" { "`psi`" } else { "`x` and `y`" };
    let remedy = match (unit, channel) {
        (Some(unit), _) => format!("`{channel}` may be in {unit}: correct its `unit`, or that of {of}"),
        (None, "y_r") => format!("{of} may be in deg: correct its `unit`, or that of `{channel}`"),
        (None, _) => format!("{of} may be in another unit: correct it, or that of `{channel}`"),
    };
    let ratio = format!("{gain:.4} times the derivative of {of}");
    Invalid::new(format!("unit of channel `{channel}`"), ratio, "about 1 times it", remedy)
}

/// Something odd about a channel that does not hinder its use.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WarningSummary {
    /// What is odd.
    pub kind: WarningKind,
    /// The channel.
    pub channel: String,
    /// How often.
    pub count: u64,
    /// In words.
    pub text: String,
}

/// What is odd about a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum WarningKind {
    /// It has one value.
    Constant,
    /// It may be in another unit.
    Unit,
    /// It is logged less often than the common rate.
    Rate,
    /// It jumps.
    Jump,
    /// It may be from another sensor, or something else, than its name says.
    Source,
    /// Its clock was corrected.
    Clock,
    /// It comes later or earlier than what it is compared with.
    Lag,
    /// It is larger or smaller than what it is compared with.
    Gain,
    /// It is off what it is compared with by a constant.
    Bias,
}

/// An oddity of a channel: the kind, how often, in words.
pub(crate) type Oddity = (WarningKind, u64, String);

/// Oddities of the channels of a recording; `seen` is how the logged ones looked.
pub(crate) fn warnings(
    setup: &Setup,
    channels: &Channels,
    summaries: &[ChannelSummary],
    seen: &[LoggedShape],
    contradictions: &[(String, Oddity)],
) -> Vec<WarningSummary> {
    let mut odd: Vec<(&str, Oddity)> = Vec::new();
    for (spec, seen) in setup.channels().zip(seen) {
        let Some(channel) = summaries.iter().find(|channel| channel.name == spec.channel) else { continue };
        let constant = constant(channel);
        let oddities = [angle(spec, *seen, constant.is_some()), slow(setup.conventions.rate_hz, channel)];
        let oddities = [constant].into_iter().chain(oddities);
        odd.extend(oddities.flatten().map(|oddity| (channel.name.as_str(), oddity)));
    }
    odd.extend(jumps(channels).map(|oddity| ("psi", oddity)));
    odd.extend(place_jumps(channels).map(|oddity| ("x", oddity)));
    odd.extend(contradictions.iter().map(|(channel, oddity)| (channel.as_str(), oddity.clone())));
    let warning = |(channel, (kind, count, text)): (&str, Oddity)| WarningSummary {
        kind,
        channel: channel.to_owned(),
        count,
        text: format!("`{channel}` {text}"),
    };
    odd.into_iter().map(warning).collect()
}

fn constant(channel: &ChannelSummary) -> Option<Oddity> {
    let value = channel.min.filter(|min| channel.max == Some(*min))?;
    Some((WarningKind::Constant, 1, format!("is {value} throughout")))
}

/// An angle that stands still beyond a turn, or moves faster there than anything that rotates with a ship; or
/// one in degrees that stays within a turn in radians. An angle without wraps may make any number of turns.
fn angle(spec: &ChannelSpec, LoggedShape { largest, fast }: LoggedShape, still: bool) -> Option<Oddity> {
    let degrees = largest.to_degrees();
    let text = match spec.unit.as_str() {
        "rad" if largest > TAU && spec.channel != "psi" && (still || fast >= OFTEN) => {
            let how = if still { "stands still at" } else { "moves by radians in a second and reaches" };
            format!("{how} {largest:.1} rad, more than a turn: it may be in degrees")
        }
        "deg" if degrees <= TAU && largest > 0.0 => {
            format!("stays within {degrees:.2} deg: it may be in radians")
        }
        _ => return None,
    };
    Some((WarningKind::Unit, 1, text))
}

/// A channel that is logged less often than the common rate.
fn slow(common_hz: f64, channel: &ChannelSummary) -> Option<Oddity> {
    let own_hz = channel.rate_hz.filter(|rate_hz| *rate_hz < 0.75 * common_hz)?;
    Some((WarningKind::Rate, 1, format!("is logged at {own_hz:.3} Hz and interpolated to {common_hz} Hz")))
}

/// Steps of the heading over 0.2 rad and twelve times the median step, which no turn explains.
fn jumps(channels: &Channels) -> Option<Oddity> {
    let psi = &channels.get("psi")?.values;
    let turned = || steps(psi.iter()).map(f64::abs);
    let above = (12.0 * streamed_median(turned)?).max(0.2);
    let count = turned().filter(|step| *step > above).count();
    let text = format!("jumps by more than {:.1} deg {count} times", above.to_degrees());
    (count > 0).then_some((WarningKind::Jump, count as u64, text))
}

/// Changes of the speed between positions above 1 m/s and twelve times the median change, which no ship
/// makes. Repeated positions, as between fixes, count once.
fn place_jumps(channels: &Channels) -> Option<Oddity> {
    let (x, y) = (channels.get("x")?, channels.get("y")?);
    let changes = || {
        let places = x.t.iter().zip(x.values.iter()).zip(y.at(x.t.iter()));
        let (mut before, mut speed) = ([f64::NAN; 3], [f64::NAN; 2]);
        places.filter_map(move |((t, x), y)| {
            let [t0, x0, y0] = before;
            if (x, y) == (x0, y0) {
                return None;
            }
            let now = [x - x0, y - y0].map(|way| way / (t - t0));
            let change = ((now[0] - speed[0]).powi(2) + (now[1] - speed[1]).powi(2)).sqrt();
            (before, speed) = ([t, x, y], now);
            change.is_finite().then_some(change)
        })
    };
    let above = (12.0 * streamed_median(changes)?).max(1.0);
    let count = changes().filter(|change| *change > above).count();
    let text = format!("and `y` jump, by their speed, by more than {above:.1} m/s {count} times");
    (count > 0).then_some((WarningKind::Jump, count as u64, text))
}

refusal::choices! {
    /// Why values of a channel were left out.
    pub enum Reason {
        /// Numbers that stand for no value.
        Missing = "missing",
        /// Beyond `valid`, or beyond what is possible where that is not said.
        Range = "range",
        /// Of a place that no ship gets to from the one before.
        Motion = "motion",
        /// The same value again and again while the ship moves.
        Frozen = "frozen",
        /// 0 N 0 E, where there is no fix.
        NullIsland = "0 N 0 E",
        /// Of a fix that is none, or of a quality that nobody asked for.
        Quality = "quality",
        /// Of a sentence that lacks what its value is made of, such as a heading without variation.
        Incomplete = "incomplete",
        /// Of a time that is not the clock's, or under a clock that was not set yet.
        Time = "time",
    }
}

/// Values of a channel that were left out for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Omission {
    /// The channel, or the column where no channel was made of it.
    pub channel: String,
    /// Why.
    pub reason: Reason,
    /// How many.
    pub count: u64,
}

/// What was left out, each channel and reason once, in order of first appearance.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Omissions(Vec<Omission>);

impl Omissions {
    /// Counts `count` more values of `channel`.
    pub fn add(&mut self, channel: &str, reason: Reason, count: u64) {
        if count == 0 {
            return;
        }
        match self.0.iter_mut().find(|known| known.channel == channel && known.reason == reason) {
            Some(known) => known.count += count,
            None => self.0.push(Omission { channel: channel.to_owned(), reason, count }),
        }
    }

    /// Adds the counts of `others`, whose columns belong to the channels that `named` returns.
    pub fn append<'a>(&mut self, others: &'a Self, named: impl Fn(&'a str) -> &'a str) {
        others.0.iter().for_each(|other| self.add(named(&other.channel), other.reason, other.count));
    }

    /// `14 values left out: 12 of psi (missing), 2 of y_u (range)`, naming only a few; `None` where there are none.
    pub fn in_words(&self) -> Option<String> {
        const NAMED: usize = 6;
        let all: u64 = self.0.iter().map(|one| one.count).sum();
        let one = |one: &Omission| format!("{} of `{}` ({})", one.count, one.channel, one.reason);
        let named: Vec<String> = self.0.iter().take(NAMED).map(one).collect();
        let more = self.0.len().saturating_sub(NAMED);
        let more = if more > 0 {
            format!(" and more of {more} other kinds, see ingest.json")
        } else {
            String::new()
        };
        (all > 0).then(|| format!("{all} values left out: {}{more}", named.join(", ")))
    }

    /// All of them.
    pub fn as_slice(&self) -> &[Omission] {
        &self.0
    }

    /// All of them.
    pub fn into_vec(self) -> Vec<Omission> {
        self.0
    }
}
