use std::f64::consts::{FRAC_PI_2, PI, TAU};

use numerics::statistics::mean;
use refusal::Invalid;

use super::helm::{Approach, Held, degrees};
use super::sailed::{Sailed, Sort};
use super::{Figure, Hull, Record, Smoother, helm, least_squares};
use crate::standard::{Board, INERTIAL_END, Standard};

/// The figures of a maneuver, and what was sailed.
#[derive(Clone, Debug, PartialEq)]
pub struct SailedFigures {
    /// Its kind in dictionaries.
    pub kind: &'static str,
    /// What it was, in words: `zig-zag 10°/10°, to port first`.
    pub sailed: String,
    /// The figures.
    pub figures: Vec<Figure>,
    /// What is to be known of them: an approach that was not steady, a current, what differs from the dictionary.
    pub remarks: Vec<String>,
}

/// The figures of what a ship did: of `standard` as it was simulated, else of the maneuver that its log shows, which
/// `standard` names.
///
/// # Errors
/// A record that is too coarse or too short: a heading that is not reached, a circle that does not close; a log of another
/// maneuver, or of none.
pub fn figures(standard: Option<Standard>, record: &Record, hull: &Hull) -> Result<SailedFigures, Invalid> {
    let spiral = match standard {
        Some(Standard::SpiralTest(spiral)) => Some(helm::direct(spiral, record, hull)),
        Some(Standard::ReverseSpiral(spiral)) => Some(helm::reverse(spiral, record, hull)),
        _ => None,
    };
    if let Some((standard, figures)) = standard.zip(spiral) {
        Smoother::new(hull.length_m, standard.speed_m_s(), record.rate_hz)?;
        let (kind, sailed) = (standard.name(), String::new());
        return Ok(SailedFigures { kind, sailed, figures: figures?, remarks: Vec::new() });
    }
    let sailed = match standard {
        Some(standard) if record.is_held => Sailed::simulated(standard, record, hull)?,
        _ => Sailed::logged(standard, record, hull)?,
    };
    let speed_m_s = sailed.speed_m_s;
    let measured = Measured { record, hull, sailed: &sailed, speed_m_s };
    let (mut figures, mut remarks) = (measured.all()?, sailed.remarks.clone());
    if !record.is_held {
        remarks.extend(measured.unjudged(&figures));
    }
    if !record.is_held && record.is_placed && sailed.sort != Sort::PullOut {
        match sailed.without_current(record) {
            Ok(Some((remark, still))) => {
                remarks.push(remark);
                let corrected =
                    Measured { record: &still, speed_m_s: sailed.speed(&still), ..measured }.all()?;
                for figure in &mut figures {
                    let same = corrected.iter().find(|other| other.name == figure.name);
                    figure.corrected = same.map(|other| other.value);
                }
            }
            Ok(None) => {}
            Err(why) => remarks.push(why),
        }
    }
    Ok(SailedFigures { kind: sailed.kind(), sailed: sailed.words(), figures, remarks })
}

struct Measured<'a> {
    record: &'a Record,
    hull: &'a Hull<'a>,
    sailed: &'a Sailed,
    /// Speed of the approach \[m/s\].
    speed_m_s: f64,
}

/// The refusal of a heading that is not reached by changes of heading to the side of `to`.
fn unreached(what: &str, turned: &[f64], expected: f64, to: Board) -> Invalid {
    let [most, other] = [1.0, -1.0].map(|side| turned.iter().map(|psi| side * psi).fold(0.0, f64::max));
    if let Some(wrong) = to.turned_away(most, other) {
        return wrong;
    }
    let [most_degrees, expected] = [most, expected].map(degrees);
    Invalid::new(what, format!("{most_degrees} at the most"), expected, "run it longer, or with more helm")
}

/// Whether an angle is so many degrees.
fn is_degrees(angle: f64, degrees: f64) -> bool {
    (angle.to_degrees() - degrees).abs() < 1.0
}

/// Steps in which a track is measured, in half windows of the smoother.
const PER_TRACK: f64 = 3.0;

/// Overshoots and times to check, of the first swings of a zig-zag: names, and what they are.
const SWINGS: [[(&str, &str); 2]; 2] = [
    [("overshoot_1", "first overshoot"), ("check_time_1", "time to check the first swing")],
    [("overshoot_2", "second overshoot"), ("check_time_2", "time to check the second swing")],
];
/// Headings at which its helm went over.
const EXECUTES: [(&str, &str); 2] =
    [("execute_1", "heading at the second execute"), ("execute_2", "heading at the third execute")];

impl Measured<'_> {
    fn all(&self) -> Result<Vec<Figure>, Invalid> {
        match self.sailed.sort {
            Sort::ZigZag => self.zig_zag(),
            Sort::Circle => self.circle(),
            Sort::PullOut => self.pull_out(),
            Sort::Stop { is_inertial, is_full_astern } => self.stop(is_inertial, is_full_astern),
        }
    }

    /// Why no limit of IMO stands beside the figures of a log.
    fn unjudged(&self, figures: &[Figure]) -> Option<String> {
        let expected = match self.sailed.sort {
            Sort::ZigZag => "10°/10° and 20°/20°",
            Sort::Circle => "circles with 35° or the most helm",
            Sort::Stop { .. } => "stops full astern, to the lower end of an input's `range`",
            Sort::PullOut => return None,
        };
        let is_judged = figures.iter().any(|figure| figure.most.is_some());
        (!is_judged).then(|| format!("{}: IMO has limits for {expected} only", self.sailed.words()))
    }

    /// Distance along and across the course of the approach, to the side of the turn, at a time in samples.
    fn run(&self, time: f64) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.sailed.course);
        let [to, from] = [time, self.sailed.order].map(|time| self.sailed.place(self.record, time));
        let [north, east] = [to[0] - from[0], to[1] - from[1]];
        [north * cos + east * sin, self.sailed.to.sign() * (east * cos - north * sin)]
    }

    /// Times in samples from one to another, by which a track is measured.
    fn times(&self, from: f64, to: f64) -> impl Iterator<Item = f64> {
        let count = ((to - from) / self.sailed.smoother.half as f64 * PER_TRACK).ceil().max(1.0);
        (0..=count as usize).map(move |k| from + k as f64 / count * (to - from))
    }

    /// Length of the track from the order to a time in samples, through smoothed places.
    fn track(&self, time: f64) -> f64 {
        let from = self.sailed.order;
        let places: Vec<[f64; 2]> =
            self.times(from, time).map(|time| self.sailed.place(self.record, time)).collect();
        places.windows(2).map(|two| libm::hypot(two[1][0] - two[0][0], two[1][1] - two[0][1])).sum()
    }

    /// Seconds between two times in samples.
    fn seconds(&self, from: f64, to: f64) -> f64 {
        (to - from) / self.record.rate_hz
    }

    fn is_helm(&self, degrees: f64) -> bool {
        self.sailed.helm.is_some_and(|helm| helm.iter().any(|angle| is_degrees(*angle, degrees)))
    }

    fn zig_zag(&self) -> Result<Vec<Figure>, Invalid> {
        let Sailed { to, heading, course, order, .. } = *self.sailed;
        let length = self.hull.length_m;
        let turned = self.record.turned(course, to);
        let begin = order.ceil() as usize;
        // The helm goes over at this heading, so the samples after it follow another law.
        let first = self.sailed.smoother.reached(&turned[begin..], heading);
        let first = first.ok_or_else(|| unreached("heading", &turned[begin..], heading, to))? + begin as f64;
        let seconds = length / self.speed_m_s;
        let is = |degrees: f64| is_degrees(heading, degrees) && self.is_helm(degrees);
        let initial =
            Figure::new("initial_turning", "initial turning ability", self.track(first) / length, "L");
        let mut all = vec![initial.at_most(is(10.0).then_some(INITIAL_TURNING))];
        let executes = &self.sailed.orders[1.min(self.sailed.orders.len())..];
        let values = |sign: f64| turned.iter().map(|psi| sign * psi).collect::<Vec<f64>>();
        let mut late = Vec::new();
        for (number, (execute, sign)) in executes.iter().zip([1.0, -1.0]).enumerate() {
            let values = values(sign);
            let end = (execute.to.ceil() as usize).min(values.len());
            let Some((time, peak)) = self.sailed.smoother.peak(&values, execute.from.floor() as usize..end)
            else {
                break;
            };
            let allowed = match number {
                0 if is(10.0) => Some(overshoot_10_first(seconds)),
                1 if is(10.0) => Some(overshoot_10_second(seconds)),
                0 if is(20.0) => Some(OVERSHOOT_20),
                _ => None,
            };
            let [(overshoot, what), (check_time, time_what)] = SWINGS[number];
            let from = self.executed(&values, execute);
            all.push(Figure::new(overshoot, what, (peak - from).to_degrees(), "deg").at_most(allowed));
            late.push(Figure::aside(check_time, time_what, self.seconds(execute.from, time), "s"));
        }
        if all.len() < 2 {
            return Err(Invalid::new("overshoot", "a heading that still grows", "its peak", "run it longer"));
        }
        all.extend(late);
        // A simulated helm goes over at the heading itself.
        for ((execute, sign), (name, what)) in executes.iter().zip([1.0, -1.0]).zip(EXECUTES) {
            if !self.sailed.is_exact {
                let heading = self.executed(&values(sign), execute);
                all.push(Figure::aside(name, what, heading.to_degrees(), "deg"));
            }
        }
        if let (Some(one), Some(three)) = (executes.first(), executes.get(2)) {
            all.push(Figure::aside("period", "period", self.seconds(one.from, three.from), "s"));
        }
        all.extend(self.nomoto());
        Ok(all)
    }

    /// The heading at which the helm went over: the wanted one, where she reached that within the sample.
    fn executed(&self, turned: &[f64], order: &Held) -> f64 {
        let (heading, at) = (self.sailed.heading, order.from);
        if self.sailed.is_exact {
            return heading;
        }
        // An order changes the second derivative, which the curve through both sides does not mind in its middle.
        let smoothed = self.sailed.smoother.at(at, turned.len(), |k| turned[k]);
        let [_, change] = self.sailed.smoother.slope((at.round() as usize).min(turned.len() - 1), turned);
        let within = order.doubt * change.abs();
        if (smoothed - heading).abs() <= within { heading } else { smoothed }
    }

    /// Gain and time constant of T r' + r = K (helm + constant), of least squares over its integral from the order to the end.
    fn nomoto(&self) -> Vec<Figure> {
        let Some(helm) = &self.sailed.angle else { return Vec::new() };
        let (from, last) = (self.sailed.order.ceil() as usize, self.record.last() - 1);
        let at = |k: usize| self.sailed.smoother.slope(k, &self.record.heading);
        let [start, rate] = at(from);
        let step = ((last - from) / 400).max(1);
        let mut turn = 0.0;
        let row = |k: usize| {
            let next = helm.smooth[k.min(helm.smooth.len() - 1)];
            let over =
                if self.record.is_held { helm.smooth[k - 1] } else { 0.5 * (helm.smooth[k - 1] + next) };
            turn += over / self.record.rate_hz;
            (k - from).is_multiple_of(step).then(|| {
                let [psi, r] = at(k);
                let passed_s = self.seconds(from as f64, k as f64);
                ([turn, (rate - r) * self.record.rate_hz, passed_s], psi - start)
            })
        };
        match least_squares((from + 1..=last).filter_map(row)) {
            Some(factors) if factors.iter().all(|factor| factor.is_finite()) => vec![
                Figure::aside("nomoto_gain", "Nomoto's K", factors[0].abs(), "1/s"),
                Figure::aside("nomoto_time", "Nomoto's T", factors[1], "s"),
            ],
            _ => Vec::new(),
        }
    }

    fn circle(&self) -> Result<Vec<Figure>, Invalid> {
        let Sailed { to, course, order, .. } = *self.sailed;
        let length = self.hull.length_m;
        let (begin, end) = (order.ceil() as usize, self.sailed.end(self.record));
        let turned = &self.record.turned(course, to)[begin..=end.max(begin)];
        let most = turned.iter().copied().fold(0.0, f64::max);
        let at = |angle: f64| {
            let time = self.sailed.smoother.crossing(turned, angle);
            time.map(|time| time + begin as f64).ok_or_else(|| {
                if end >= self.record.last() {
                    return unreached("change of heading", turned, angle, to);
                }
                let given = format!("taken off after {} of turn to {to}", degrees(most));
                let expected = format!("held until {:.0}°", angle.to_degrees());
                Invalid::new("helm", given, expected, "hold it longer")
            })
        };
        let [quarter, half] = [at(FRAC_PI_2)?, at(PI)?];
        let is_most = self.sailed.is_most || self.is_helm(35.0);
        let criterion = |most: f64| is_most.then_some(most);
        let [advance, transfer] = self.run(quarter);
        let [_, across] = self.run(half);
        let mut all = vec![
            Figure::new("advance", "advance", advance / length, "L").at_most(criterion(ADVANCE)),
            Figure::new("transfer", "transfer", transfer / length, "L"),
            Figure::new("tactical_diameter", "tactical diameter", across / length, "L")
                .at_most(criterion(TACTICAL_DIAMETER)),
            Figure::new("time_90", "time to 90°", self.seconds(order, quarter), "s"),
            Figure::new("time_180", "time to 180°", self.seconds(order, half), "s"),
        ];
        let greatest = |axis: usize, from: f64, to: f64| {
            let runs = self.times(from, to).map(|time| self.run(time)[axis]);
            runs.fold(f64::NEG_INFINITY, f64::max) / length
        };
        all.push(Figure::aside("greatest_advance", "greatest advance", greatest(0, order, half), "L"));
        if let Ok(three_quarters) = at(1.5 * PI) {
            let transfer = greatest(1, half, three_quarters);
            all.push(Figure::aside("greatest_transfer", "greatest transfer", transfer, "L"));
        }
        // The steady turn: from a whole turn on, at least half a turn of it.
        if let (Ok(from), true) = (at(TAU), most >= TAU + PI) {
            let range = from.ceil() as usize..end + 1;
            let mean = |of: &[f64]| mean(&of[range.clone()]).unwrap_or(f64::NAN);
            let (speed, rate) = (mean(&self.record.speed), to.sign() * mean(&self.record.yaw_rate));
            let diameter = 2.0 * speed / rate / length;
            all.push(Figure::new("steady_diameter", "steady turning diameter", diameter, "L"));
            all.push(Figure::new("steady_yaw_rate", "steady yaw rate", rate.to_degrees(), "deg/s"));
            let loss = speed / self.speed_m_s;
            all.push(Figure::new("speed_loss", "speed in the turn over that of the approach", loss, "1"));
            let drift =
                libm::atan2(-to.sign() * mean(&self.record.sway), mean(&self.record.surge)).to_degrees();
            all.push(Figure::aside("drift_angle", "drift angle in the turn", drift, "deg"));
        }
        Ok(all)
    }

    fn pull_out(&self) -> Result<Vec<Figure>, Invalid> {
        let amidships = self.sailed.orders.get(1).map_or(self.sailed.orders[0].to, |order| order.from);
        let over = amidships.round() as usize;
        if !self.sailed.smoother.is_inside(over, self.record.last()) {
            let given = format!("{:.1} s", self.record.last() as f64 / self.record.rate_hz);
            let until_s = self.seconds(0.0, amidships);
            let expected = format!("more than {until_s} s, until the helm is amidships");
            return Err(Invalid::new("pull-out", given, expected, "run it longer"));
        }
        let tail = self.record.last() - (self.record.last() - over) / 5;
        let mean = |range| mean(&self.record.yaw_rate[range]).unwrap_or(0.0).to_degrees();
        let begin = over - ((over as f64 - self.sailed.order) / 5.0).max(1.0).min(over as f64) as usize;
        let (before, after) = (mean(begin..over.max(begin + 1)), mean(tail..self.record.last() + 1));
        let turned = self.record.turned(self.sailed.course, self.sailed.to)[over];
        if let Some(wrong) = self.sailed.to.turned_away(turned.max(0.0), (-turned).max(0.0)) {
            return Err(wrong);
        }
        Ok(vec![
            Figure::new("turning_yaw_rate", "yaw rate before the helm is amidships", before, "deg/s"),
            Figure::new("residual_yaw_rate", "yaw rate that remains", after, "deg/s"),
        ])
    }

    fn stop(&self, is_inertial: bool, is_full_astern: bool) -> Result<Vec<Figure>, Invalid> {
        let (order, speed_m_s) = (self.sailed.order, self.speed_m_s);
        let (begin, length) = (order.ceil() as usize, self.hull.length_m);
        let until = if is_inertial { INERTIAL_END * speed_m_s } else { 0.0 };
        let slowed: Vec<f64> = self.record.surge[begin..].iter().map(|u| -u).collect();
        // A crash stop ends there. An inertial stop goes on, so the samples after it count, too.
        let end = match is_inertial {
            true => self.sailed.smoother.crossing(&slowed, -until),
            false => self.sailed.smoother.end(&slowed, -until, 1e-5 * speed_m_s),
        };
        let end = end.ok_or_else(|| {
            let least = self.record.surge[begin..].iter().copied().fold(f64::INFINITY, f64::min);
            let (given, expected) = (format!("{least:.3} m/s at the least"), format!("{until:.3} m/s"));
            Invalid::new("speed", given, expected, "run it longer")
        })? + begin as f64;
        let [ahead, across] = self.run(end);
        let reach = self.track(end);
        let criterion = is_full_astern.then_some(STOPPING);
        Ok(vec![
            Figure::new("track_reach", "track reach", reach / length, "L").at_most(criterion),
            Figure::new("head_reach", "head reach", ahead / length, "L"),
            Figure::new("lateral_deviation", "lateral deviation", across / length, "L"),
            Figure::new("stopping_time", "time to stop", self.seconds(order, end), "s"),
        ])
    }
}

/// Part of the speed from which on a drift counts as a current.
const DRIFTS: f64 = 0.02;
/// Headings of which places a turn apart are compared.
const PAIRS: usize = 9;

impl Sailed {
    /// The record without the current that the log shows, and what is said of it: by MSC/Circ.1053 from places a whole turn
    /// apart, else from speeds through the water against the track; or why it shows none.
    pub fn without_current(&self, record: &Record) -> Result<Option<(String, Record)>, String> {
        let end = self.end(record);
        let [first, half] = [self.order.ceil() as usize, (0.5 * (self.order + end as f64)) as usize];
        let size = |vector: [f64; 2]| libm::hypot(vector[0], vector[1]);
        // Between track and speeds.
        let off = |from: usize, to: usize| {
            let mut sum = [0.0; 2];
            for k in from..to {
                let (sin, cos) = libm::sincos(0.5 * (record.heading[k] + record.heading[k + 1]));
                let [u, v] =
                    [&record.surge, &record.sway].map(|of| 0.5 * (of[k] + of[k + 1]) / record.rate_hz);
                sum = [sum[0] + u * cos - v * sin, sum[1] + u * sin + v * cos];
            }
            let [start, end] = [from, to].map(|k| self.place(record, k as f64));
            [0, 1].map(|axis| (end[axis] - start[axis] - sum[axis]) / ((to - from) as f64 / record.rate_hz))
        };
        let corrected = |to: [f64; 2], by: &str, over_ground: bool| {
            let (speed, course) = (size(to), libm::atan2(to[1], to[0]).to_degrees().rem_euclid(360.0));
            let words = format!(
                "the track drifts at {speed:.2} m/s to {course:03.0}°, {by}: figures are corrected for it as for a steady \
                 current (MSC/Circ.1053)"
            );
            Some((words, record.without(to, self.order, over_ground)))
        };
        let least = DRIFTS * self.speed_m_s;
        let all = if end > first + 2 { off(first, end) } else { [0.0; 2] };
        let turned = record.turned(self.course, self.to);
        let whole = turned[..=end].iter().copied().fold(0.0, f64::max);
        if self.sort == Sort::Circle && whole >= 2.97 * PI {
            let from = (whole - TAU - PI).clamp(PI, TAU).min(whole - TAU);
            let at = |psi: f64| self.smoother.crossing(&turned, psi);
            let (mut seconds, mut moved) = (0.0, [0.0; 2]);
            for pair in 0..PAIRS {
                let psi = from + pair as f64 / (PAIRS - 1) as f64 * (whole - TAU - from);
                let Some((one, other)) = at(psi).zip(at(psi + TAU)) else { continue };
                let [one_place, other_place] = [one, other].map(|time| self.place(record, time));
                seconds += (other - one) / record.rate_hz;
                moved = [0, 1].map(|axis| moved[axis] + other_place[axis] - one_place[axis]);
            }
            let to = moved.map(|metres| metres / seconds);
            if size(to) < least || size(to).is_nan() {
                return Ok(None);
            }
            return Ok(corrected(to, "from places a whole turn apart", size(all) < 0.5 * size(to)));
        }
        let [one, other] = if half > first + 2 { [off(first, half), off(half, end)] } else { [[0.0; 2]; 2] };
        let is_steady = size([one[0] - other[0], one[1] - other[1]]) < 0.5 * size(all);
        if size(all) >= least && is_steady {
            let by = "from the speeds of the log, which are through the water, against the track";
            return Ok(corrected(all, by, false));
        }
        let turns = (record.heading[end] - self.course).abs() / TAU;
        Err(format!(
            "not corrected for a current: {turns:.1} turns do not show one, 1.5 are needed, or speeds through the water"
        ))
    }

    /// The speed of the approach in another record of it \[m/s\].
    pub fn speed(&self, record: &Record) -> f64 {
        Approach::of(record, self.begin, self.order, self.smoother.length).motion[1]
    }

    /// North and east at a time in samples \[m\], smoothed.
    pub fn place(&self, record: &Record, time: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.smoother.at(time, record.place.len(), |k| record.place[k][axis]))
    }
}

// The criteria of IMO MSC.137(76).

/// The greatest first overshoot in a 10°/10° zig-zag \[°\], for a ship that covers her length in `seconds`.
fn overshoot_10_first(seconds: f64) -> f64 {
    match seconds {
        _ if seconds < 10.0 => 10.0,
        _ if seconds >= 30.0 => 20.0,
        _ => 5.0 + 0.5 * seconds,
    }
}

/// The greatest second one \[°\].
fn overshoot_10_second(seconds: f64) -> f64 {
    match seconds {
        _ if seconds < 10.0 => 25.0,
        _ if seconds >= 30.0 => 40.0,
        _ => 17.5 + 0.75 * seconds,
    }
}

/// The greatest first overshoot in a 20°/20° zig-zag \[°\].
const OVERSHOOT_20: f64 = 25.0;
/// Of a turning circle \[ship lengths\].
const ADVANCE: f64 = 4.5;
/// Of a turning circle \[ship lengths\].
const TACTICAL_DIAMETER: f64 = 5.0;
/// Track run with 10° of helm until the heading has changed by 10° \[ship lengths\].
const INITIAL_TURNING: f64 = 2.5;
/// Track reach of a full astern stop \[ship lengths\]; it says nothing of stops with less, nor of inertial ones.
const STOPPING: f64 = 15.0;
