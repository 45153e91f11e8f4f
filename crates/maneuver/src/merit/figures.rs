use std::f64::consts::{FRAC_PI_2, PI, TAU};

use model::Vessel;
use refusal::Invalid;

use super::figure::{Figure, Hull};
use super::record::{Record, Smoother};
use super::{criteria, spirals};
use crate::standard::{Board, PullOut, Settings, Standard, Stop, TurningCircle, ZigZagTest};

/// The figures of `standard` from what a ship did, which begins with the maneuver.
///
/// # Errors
/// A record that is too coarse or too short: a heading that is not reached, a circle that does not close.
pub fn figures(standard: Standard, record: &Record, hull: &Hull) -> Result<Vec<Figure>, Invalid> {
    let smoother = Smoother::new(hull.length_m, standard.speed_m_s(), record.rate_hz)?;
    let own = Measured { record, smoother, hull };
    match standard {
        Standard::ZigZagTest(test) => own.zig_zag(test),
        Standard::TurningCircle(turn) => own.circle(turn),
        Standard::PullOut(turn) => own.pull_out(turn),
        Standard::Stop(stop) => own.stop(stop),
        Standard::SpiralTest(spiral) => spirals::direct(spiral, record, hull),
        Standard::ReverseSpiral(spiral) => spirals::reverse(spiral, record, hull),
    }
}

struct Measured<'a> {
    record: &'a Record,
    smoother: Smoother,
    hull: &'a Hull<'a>,
}

/// The refusal of a heading that is not reached by changes of heading to the side of `to`.
fn unreached(what: &str, turned: &[f64], expected: f64, to: Board) -> Invalid {
    let [found, other] = [1.0, -1.0].map(|side| turned.iter().map(|psi| side * psi).fold(0.0, f64::max));
    if let Some(wrong) = to.turned_away(found, other) {
        return wrong;
    }
    let [found, expected] = [found, expected].map(|rad| format!("{:.1}°", rad.to_degrees()));
    Invalid::new(what, format!("{found} at the most"), expected, "run it longer, or with more helm")
}

/// The helm as an angle \[rad\], where it is one input in angles.
fn angle(helm: &Settings, vessel: &Vessel) -> Option<f64> {
    let mut set = helm.iter().filter(|(_, change)| **change != 0.0);
    let (name, change) = set.next().filter(|_| helm.len() == 1)?;
    let input = vessel.model.input_variables().iter().find(|own| own.name == *name)?;
    match input.unit.as_str() {
        "rad" => Some(change.abs()),
        "deg" | "°" => Some(change.abs().to_radians()),
        _ => None,
    }
}

/// By what part of its range an input counts as at the end of it.
const NEARLY: f64 = 0.98;

/// Whether an angle is so many degrees.
fn is_degrees(angle: f64, degrees: f64) -> bool {
    (angle.to_degrees() - degrees).abs() < 0.5
}

impl Measured<'_> {
    /// Distance along and across a course, to `side`, from sample `from`, at a time in samples.
    fn run(&self, from: usize, side: f64, time: f64) -> [f64; 2] {
        let Record { place, heading, .. } = self.record;
        let (sin, cos) = libm::sincos(heading[from]);
        let [north, east] =
            [0, 1].map(|axis| self.smoother.at(time, place.len(), |k| place[k][axis]) - place[from][axis]);
        [north * cos + east * sin, side * (east * cos - north * sin)]
    }

    /// Length of the track from `from` to a time in samples.
    fn track(&self, from: usize, time: f64) -> f64 {
        let place = &self.record.place;
        let whole = (time.floor() as usize).clamp(from, place.len() - 1);
        let step = |k: usize| libm::hypot(place[k + 1][0] - place[k][0], place[k + 1][1] - place[k][1]);
        let rest = if whole + 1 < place.len() { (time - whole as f64) * step(whole) } else { 0.0 };
        (from..whole).map(step).sum::<f64>() + rest
    }

    fn zig_zag(&self, test: &ZigZagTest) -> Result<Vec<Figure>, Invalid> {
        let (from, length) = (self.record.sample(test.hold_s), self.hull.length_m);
        let turned = self.record.turned(from, test.to.sign());
        // The helm goes over at this heading, so the samples after it follow another law.
        let first = self.smoother.reached(&turned[from..], test.heading_rad);
        let first =
            first.ok_or_else(|| unreached("heading", &turned, test.heading_rad, test.to))? + from as f64;
        let seconds = length / test.speed_m_s;
        let helm = angle(&test.helm, self.hull.vessel);
        let is = |degrees: f64| {
            is_degrees(test.heading_rad, degrees) && helm.is_some_and(|helm| is_degrees(helm, degrees))
        };
        let run = self.track(from, first) / length;
        let initial = Figure::new("initial_turning", "initial turning ability", run, "L");
        let mut all = vec![initial.at_most(is(10.0).then_some(criteria::INITIAL_TURNING))];
        for (number, peak) in self.peaks(&turned, from, test.heading_rad).into_iter().take(2).enumerate() {
            let (name, what) =
                [("overshoot_1", "first overshoot"), ("overshoot_2", "second overshoot")][number];
            let allowed = match number {
                0 if is(10.0) => Some(criteria::overshoot_10_first(seconds)),
                1 if is(10.0) => Some(criteria::overshoot_10_second(seconds)),
                0 if is(20.0) => Some(criteria::OVERSHOOT_20),
                _ => None,
            };
            let over = (peak - test.heading_rad).to_degrees();
            all.push(Figure::new(name, what, over, "deg").at_most(allowed));
        }
        if all.len() < 2 {
            return Err(Invalid::new("overshoot", "a heading that still grows", "its peak", "run it longer"));
        }
        Ok(all)
    }

    /// The greatest changes of heading of the swings, by turns to either side.
    fn peaks(&self, turned: &[f64], from: usize, heading: f64) -> Vec<f64> {
        let (mut peaks, mut start, mut side) = (Vec::new(), from, 1.0);
        loop {
            let values: Vec<f64> = turned.iter().map(|psi| side * psi).collect();
            let reached = (start..values.len()).find(|k| values[*k] >= heading);
            let Some(reached) = reached else { return peaks };
            let end = (reached..values.len()).find(|k| values[*k] <= -heading).unwrap_or(values.len());
            let Some(peak) = self.smoother.peak(&values, reached..end) else { return peaks };
            peaks.push(peak);
            (start, side) = (end, -side);
        }
    }

    fn circle(&self, turn: &TurningCircle) -> Result<Vec<Figure>, Invalid> {
        let (from, length, side) = (self.record.sample(turn.hold_s), self.hull.length_m, turn.to.sign());
        let turned = &self.record.turned(from, side)[from..];
        let at = |angle: f64| {
            let time = self.smoother.crossing(turned, angle);
            let why = || unreached("change of heading", turned, angle, turn.to);
            time.map(|time| time + from as f64).ok_or_else(why)
        };
        let [quarter, half] = [at(FRAC_PI_2)?, at(PI)?];
        let helm = angle(&turn.helm, self.hull.vessel);
        let is_most = helm.is_some_and(|helm| is_degrees(helm, 35.0)) || self.is_most(&turn.helm);
        let criterion = |most: f64| is_most.then_some(most);
        let [advance, transfer] = self.run(from, side, quarter);
        let [_, across] = self.run(from, side, half);
        let mut all = vec![
            Figure::new("advance", "advance", advance / length, "L").at_most(criterion(criteria::ADVANCE)),
            Figure::new("transfer", "transfer", transfer / length, "L"),
            Figure::new("tactical_diameter", "tactical diameter", across / length, "L")
                .at_most(criterion(criteria::TACTICAL_DIAMETER)),
            Figure::new("time_90", "time to 90°", self.smoother.seconds(quarter - from as f64), "s"),
            Figure::new("time_180", "time to 180°", self.smoother.seconds(half - from as f64), "s"),
        ];
        // The steady turn: from a whole turn on, at least half a turn of it.
        if let (Ok(begin), true) = (at(TAU), turned.iter().any(|psi| *psi >= TAU + PI)) {
            let range = (begin.ceil() as usize)..self.record.heading.len();
            let mean = |of: &[f64]| range.clone().map(|k| of[k]).sum::<f64>() / range.len() as f64;
            let (speed, rate) = (mean(&self.record.speed), side * mean(&self.record.yaw_rate));
            all.push(Figure::new(
                "steady_diameter",
                "steady turning diameter",
                2.0 * speed / rate / length,
                "L",
            ));
            all.push(Figure::new("steady_yaw_rate", "steady yaw rate", rate.to_degrees(), "deg/s"));
            all.push(Figure::new(
                "speed_loss",
                "speed in the turn over that of the approach",
                speed / turn.speed_m_s,
                "1",
            ));
        }
        Ok(all)
    }

    /// Whether the helm takes an input to the end of its range.
    fn is_most(&self, helm: &Settings) -> bool {
        helm.iter().any(|(name, change)| {
            self.range(name).is_some_and(|[low, high]| change.abs() >= NEARLY * low.abs().max(high))
        })
    }

    /// Whether a setting is astern, at the end of its input's range.
    fn is_full_astern(&self, settings: &Settings) -> bool {
        settings.iter().any(|(name, setting)| {
            self.range(name).is_some_and(|[low, _]| low < 0.0 && *setting <= NEARLY * low)
        })
    }

    /// The range of an input, where its vessel states one.
    fn range(&self, input: &str) -> Option<[f64; 2]> {
        let vessel = self.hull.vessel;
        let place = vessel.model.input_variables().iter().position(|own| own.name == input)?;
        vessel.actuators[place].range
    }

    fn pull_out(&self, turn: &PullOut) -> Result<Vec<Figure>, Invalid> {
        let needed = turn.hold_s + turn.turn_s;
        let over = self.record.sample(needed);
        if !self.smoother.is_inside(over, self.record.last()) {
            let found = format!("{:.1} s", self.record.last() as f64 / self.record.rate_hz);
            let expected = format!("more than {needed} s, until the helm is amidships");
            return Err(Invalid::new("pull-out", found, expected, "run it longer"));
        }
        let tail = self.record.last() - (self.record.last() - over) / 5;
        let mean = |range: std::ops::Range<usize>| {
            range.clone().map(|k| self.record.yaw_rate[k]).sum::<f64>() / range.len().max(1) as f64
        };
        let begin = over.saturating_sub((over / 5).max(1));
        let (before, after) = (mean(begin..over.max(begin + 1)), mean(tail..self.record.last() + 1));
        let turned = self.record.turned(self.record.sample(turn.hold_s), turn.to.sign())[over];
        if let Some(wrong) = turn.to.turned_away(turned.max(0.0), (-turned).max(0.0)) {
            return Err(wrong);
        }
        Ok(vec![
            Figure::new(
                "turning_yaw_rate",
                "yaw rate before the helm is amidships",
                before.to_degrees(),
                "deg/s",
            ),
            Figure::new("residual_yaw_rate", "yaw rate that remains", after.to_degrees(), "deg/s"),
        ])
    }

    fn stop(&self, stop: &Stop) -> Result<Vec<Figure>, Invalid> {
        let (from, length) = (self.record.sample(stop.hold_s), self.hull.length_m);
        let slowed: Vec<f64> = self.record.surge[from..].iter().map(|u| -u).collect();
        // A crash stop ends there. An inertial stop goes on, so the samples after it count, too.
        let end = match stop.inputs.is_empty() {
            true => self.smoother.crossing(&slowed, -stop.end_m_s()),
            false => self.smoother.end(&slowed, -stop.end_m_s(), 1e-5 * stop.speed_m_s),
        };
        let end = end.ok_or_else(|| {
            let least = self.record.surge[from..].iter().copied().fold(f64::INFINITY, f64::min);
            let (found, expected) =
                (format!("{least:.3} m/s at the least"), format!("{:.3} m/s", stop.end_m_s()));
            Invalid::new("speed", found, expected, "run it longer")
        })? + from as f64;
        let [ahead, across] = self.run(from, 1.0, end);
        let reach = self.track(from, end);
        let criterion = self.is_full_astern(&stop.inputs).then_some(criteria::STOPPING);
        Ok(vec![
            Figure::new("track_reach", "track reach", reach / length, "L").at_most(criterion),
            Figure::new("head_reach", "head reach", ahead / length, "L"),
            Figure::new("lateral_deviation", "lateral deviation", across / length, "L"),
            Figure::new("stopping_time", "time to stop", self.smoother.seconds(end - from as f64), "s"),
        ])
    }
}
