use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::{self, Display};

use refusal::Invalid;

use crate::{ChannelSpec, Channels, Omission, Omissions, Reason, Series, Unit};

/// The allowed range of the numbers in a column, in its own unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Limit {
    /// Least and greatest number.
    pub(crate) numbers: [f64; 2],
    /// Where it comes from.
    pub(crate) of: LimitOf,
}

/// Where a limit comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LimitOf {
    /// `valid` in the configuration.
    Configuration,
    /// The input's `range` in the vessel file of this name, extended by half of its width on either side.
    Vessel(String),
    /// What is possible for a channel of this kind.
    Kind(&'static str),
}

impl Display for LimitOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Configuration => write!(f, "`valid` of the channel"),
            Self::Vessel(file) => write!(f, "the input's `range` in {file}, extended by half of its width"),
            Self::Kind(kind) => write!(f, "what is possible for {kind}"),
        }
    }
}

/// No quantity of a ship is larger in SI units.
const LARGEST: f64 = 1e12;

/// No direction of a ship turns faster, even of a small boat \[rad/s\].
const FASTEST_TURN: f64 = PI;

/// No shaft of a ship turns faster \[1/s\].
const FASTEST_SHAFT: f64 = 10_000.0 / 60.0;

/// No wind blows faster \[m/s\].
const FASTEST_WIND: f64 = 150.0;

impl Limit {
    /// The limit for the column of `spec`, in `unit`. `range` is that of the vessel's input, in SI units,
    /// with its file's name; `fastest` is the ship's greatest speed \[m/s\].
    pub(crate) fn new(
        spec: &ChannelSpec,
        unit: &Unit,
        range: Option<([f64; 2], &str)>,
        fastest: f64,
    ) -> Self {
        if let Some(numbers) = spec.valid {
            return Self { numbers, of: LimitOf::Configuration };
        }
        let (values, of) = match range {
            Some(([low, high], file)) => {
                let more = 0.5 * (high - low);
                ([low - more, high + more], LimitOf::Vessel(file.to_owned()))
            }
            None => {
                let (greatest, kind) = of_kind(&spec.channel, unit, fastest);
                ([-greatest, greatest], LimitOf::Kind(kind))
            }
        };
        let factor = spec.sign * spec.scale * unit.factor;
        let [a, b] = values.map(|value| (value - spec.offset) / factor);
        Self { numbers: [a.min(b), a.max(b)], of }
    }

    /// A turn in the unit of the column of `spec`, if that is an angle that may continue beyond one.
    pub(super) fn turn(&self, spec: &ChannelSpec, unit: &Unit) -> Option<f64> {
        let goes_round =
            unit.si == "rad" && !["latitude_deg", "longitude_deg"].contains(&spec.channel.as_str());
        let turn = TAU / (spec.scale * unit.factor).abs();
        (goes_round && self.of != LimitOf::Configuration).then_some(turn)
    }
}

/// The greatest modulus of a channel by its name and unit, in SI units, and the kind of channel.
fn of_kind(channel: &str, unit: &Unit, fastest: f64) -> (f64, &'static str) {
    // Allows for rounding in another unit.
    let just = 1.0 + 1e-6;
    match (channel, unit.si) {
        ("latitude_deg", _) => (just * FRAC_PI_2, "latitudes"),
        ("longitude_deg", _) => (just * TAU, "longitudes"),
        ("y_u" | "y_v" | "v_x" | "v_y", _) => (just * fastest, "a ship's speed, `max_speed_m_s`"),
        ("y_r", _) => (FASTEST_TURN, "yaw rates"),
        (name, "rad") if ["delta", "rudder"].iter().any(|kind| name.starts_with(kind)) => {
            (just * FRAC_PI_2, "rudder angles")
        }
        (_, "m/s") => (FASTEST_WIND, "speeds of wind and water"),
        (_, "1/s") if unit.name != "Hz" => (just * FASTEST_SHAFT, "shafts"),
        _ => (LARGEST, "anything on a ship"),
    }
}

/// Refuses a channel if more than the share `most` of its `values` are left out. `limit` is that of its numbers.
pub(crate) fn check_share(
    channel: &str,
    values: u64,
    omitted: &[Omission],
    most: f64,
    limit: Option<&Limit>,
) -> Result<(), Invalid> {
    let of_channel = || omitted.iter().filter(|omission| omission.channel == channel);
    let count: u64 = of_channel().map(|omission| omission.count).sum();
    if count as f64 <= most * values as f64 {
        return Ok(());
    }
    let reasons: Vec<String> = of_channel().map(|one| format!("{} {}", one.count, one.reason)).collect();
    let share = 100.0 * count as f64 / values as f64;
    let counted = format!("{count} of {values} values left out ({share:.0} %): {}", reasons.join(", "));
    let within = limit.map(|Limit { numbers: [low, high], of }| {
        format!("; the column's numbers within {} to {}, {of}", five(*low), five(*high))
    });
    Err(Invalid::new(
        format!("channel `{channel}`"),
        counted,
        format!("at most {} % left out{}", five(100.0 * most), within.unwrap_or_default()),
        "correct its `unit` or `scale`, set `valid` and `missing`, or raise its `max_omitted`",
    ))
}

/// A number with at most five digits.
fn five(number: f64) -> String {
    let digits = format!("{number:.4e}").parse::<f64>().unwrap_or(number);
    if digits.abs() < 1e7 { digits.to_string() } else { format!("{digits:e}") }
}

/// Distance that a position may always be off \[m\].
const SLACK_M: f64 = 10.0;

/// Radius of the earth \[m\].
const EARTH_M: f64 = 6_371_000.0;

/// Channels of a geographic position.
const GEOGRAPHIC: [&str; 2] = ["latitude_deg", "longitude_deg"];

/// Tracks that are followed in parallel.
const MOST_TRACKS: usize = 16;

/// Positions each of which a ship can reach from the previous one.
struct Track {
    time: f64,
    place: [f64; 2],
    count: u64,
    /// Whether all of them are 0 N 0 E.
    null: bool,
}

/// Consecutive positions of one track.
struct Stay {
    times: [f64; 2],
    track: usize,
    /// Whether all of them are 0 N 0 E.
    null: bool,
}

/// The positions of a recording, track by track.
struct Tracks {
    geographic: bool,
    metres: Metres,
    fastest: f64,
    tracks: Vec<Track>,
    stays: Vec<Stay>,
}

/// The distance between two positions \[m\].
type Metres = fn([f64; 2], [f64; 2]) -> f64;

/// The channels of the position, if there are any, and their distance function.
pub(super) fn pair(channels: &Channels) -> Option<([&'static str; 2], Metres)> {
    let pairs: [(_, Metres); 2] = [(GEOGRAPHIC, on_earth), (["x", "y"], on_plane)];
    pairs.into_iter().find(|(names, _)| names.iter().all(|name| channels.contains_key(*name)))
}

fn on_plane(from: [f64; 2], to: [f64; 2]) -> f64 {
    let [a, b] = [to[0] - from[0], to[1] - from[1]];
    (a * a + b * b).sqrt()
}

fn on_earth(from: [f64; 2], to: [f64; 2]) -> f64 {
    let [north, turned] = [to[0] - from[0], to[1] - from[1]];
    let east = (turned - TAU * (turned / TAU).round()) * libm::cos(0.5 * (from[0] + to[0]));
    EARTH_M * (north * north + east * east).sqrt()
}

/// Leaves out of `channels` the positions that a ship of at most `fastest` \[m/s\] cannot reach, and counts them.
pub(crate) fn keep_possible(channels: &mut Channels, fastest: f64, omitted: &mut Omissions) {
    let Some((names, metres)) = pair(channels) else { return };
    let [Some(first), Some(second)] = names.map(|name| channels.get(name)) else { return };
    let mut tracks =
        Tracks { geographic: names == GEOGRAPHIC, metres, fastest, tracks: Vec::new(), stays: Vec::new() };
    for ((time, a), b) in first.t.iter().zip(first.values.iter()).zip(second.at(first.t.iter())) {
        if b.is_finite() {
            tracks.add(time, [a, b]);
        }
    }
    let wrong = tracks.wrong();
    for name in names.iter().filter(|_| !wrong.is_empty()) {
        let Some(series) = channels.get_mut(*name) else { continue };
        // Those that are not 0 N 0 E, and those that are.
        let mut counts = [0; 2];
        *series = without(
            series,
            &wrong,
            |stay| stay.times[1],
            |stay, time| {
                let is_wrong = stay.times[0] <= time;
                counts[usize::from(stay.null)] += u64::from(is_wrong);
                is_wrong
            },
        );
        omitted.add(name, Reason::Motion, counts[0]);
        omitted.add(name, Reason::NullIsland, counts[1]);
    }
}

impl Tracks {
    fn add(&mut self, time: f64, place: [f64; 2]) {
        let null = self.geographic && place == [0.0; 2];
        let near = |(i, track): (usize, &Track)| {
            let off = (self.metres)(track.place, place);
            (off <= self.fastest * (time - track.time) + SLACK_M).then_some((i, off))
        };
        let near = self.tracks.iter().enumerate().filter_map(near).min_by(|a, b| a.1.total_cmp(&b.1));
        let index = match near {
            Some((i, _)) => i,
            None if self.tracks.len() < MOST_TRACKS => {
                self.tracks.push(Track { time, place, count: 0, null: true });
                self.tracks.len() - 1
            }
            // One of many that continue no track: the shortest track begins anew.
            None => (0..MOST_TRACKS).min_by_key(|i| self.tracks[*i].count).unwrap_or(0),
        };
        let track = &mut self.tracks[index];
        (track.time, track.place, track.count, track.null) =
            (time, place, track.count + 1, track.null && null);
        match self.stays.last_mut().filter(|stay| stay.track == index && stay.null == null) {
            Some(stay) => stay.times[1] = time,
            None => self.stays.push(Stay { times: [time; 2], track: index, null }),
        }
    }

    /// The stays that are not on the longest track, in order; all that are 0 N 0 E where the longest track is.
    fn wrong(self) -> Vec<Stay> {
        let longest = (0..self.tracks.len()).max_by_key(|i| (self.tracks[*i].count, std::cmp::Reverse(*i)));
        let Some(longest) = longest else { return Vec::new() };
        let null = self.tracks[longest].null;
        self.stays.into_iter().filter(|stay| stay.track != longest || null && stay.null).collect()
    }
}

/// `series` without the values at which the first of `spans` that has not ended `is_out`; `end` is the end of a span \[s\].
pub(super) fn without<T>(
    series: &Series,
    spans: &[T],
    end: impl Fn(&T) -> f64,
    mut is_out: impl FnMut(&T, f64) -> bool,
) -> Series {
    let mut next = 0;
    series.with(series.values.made(series.t.iter().zip(series.values.iter()).map(|(time, value)| {
        while spans.get(next).is_some_and(|span| end(span) < time) {
            next += 1;
        }
        if spans.get(next).is_some_and(|span| is_out(span, time)) { f64::NAN } else { value }
    })))
}
