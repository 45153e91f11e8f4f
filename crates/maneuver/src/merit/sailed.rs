use std::f64::consts::{FRAC_PI_2, PI, TAU};

use numerics::statistics::quantile;
use refusal::Invalid;

use super::figure::Hull;
use super::helm::{Held, Helm, median, radians};
use super::record::{Record, Smoother};
use crate::standard::{Sensors, Settings, Standard, Stop};

/// The length of an approach, in times in which the ship covers her length.
const APPROACH: f64 = 2.0;
/// What an order is, at least: an angle \[rad\], or a part of the dictionary's helm.
const LEAST: [f64; 2] = [0.035, 0.2];
/// What helm a log begins with at the most before its order: an angle \[rad\], or a part of the dictionary's helm.
const STRAIGHT: [f64; 2] = [0.07, 0.3];
/// How much a steady approach may turn while she covers her length \[rad\].
const STEADY_TURN: f64 = 0.035;
/// How much its speed may change, as a part of it.
const STEADY_SPEED: f64 = 0.05;
/// Standard deviation of its helm \[rad\].
const STEADY_HELM: f64 = 0.035;
/// Changes of heading at which a helm goes over in zig-zags \[°\].
const HEADINGS: [f64; 12] = [1.0, 2.0, 5.0, 7.5, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0];
/// The greatest such change \[rad\].
const MOST_HEADING: f64 = 1.05;
/// Part of the approach's speed at which a stop has ended.
const STOPPED: f64 = 0.06;

/// A kind of maneuver that is recognised in a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sort {
    ZigZag,
    Circle,
    PullOut,
    Stop { is_inertial: bool, is_full_astern: bool },
}

/// A maneuver as it was sailed.
pub(super) struct Sailed {
    pub sort: Sort,
    /// The first sample of the approach, and when the first order was given, in samples.
    pub begin: usize,
    pub order: f64,
    /// The heading before it \[rad\], and the speed.
    pub course: f64,
    pub speed_m_s: f64,
    /// The side to which she turned first: 1 starboard, −1 port.
    pub side: f64,
    /// The helm as an angle \[rad\]: by how much it was put over, and where it was.
    pub helm: Option<[f64; 2]>,
    /// Whether that is the most.
    pub is_most: bool,
    /// Change of heading at which the helm of a zig-zag goes over \[rad\].
    pub heading: f64,
    /// Whether it goes over just there, as a simulated one does.
    pub is_exact: bool,
    /// Orders to the helm.
    pub orders: Vec<Held>,
    /// The helm, where it is an angle.
    pub angle: Option<Helm>,
    pub smoother: Smoother,
    /// What is to be known of the figures.
    pub remarks: Vec<String>,
}

fn degrees(rad: f64) -> String {
    format!("{:.1}°", rad.to_degrees())
}

/// The name of a side.
pub(super) fn board(side: f64) -> &'static str {
    if side < 0.0 { "port" } else { "starboard" }
}

impl Sailed {
    /// In words: `zig-zag 10°/10°, to port first`.
    pub fn words(&self) -> String {
        let to = board(self.side);
        let helm = match self.helm {
            Some([change, _]) => format!("{:.0}°", change.to_degrees()),
            None => "the helm".to_owned(),
        };
        match self.sort {
            Sort::ZigZag => {
                let heading = (10.0 * self.heading.to_degrees()).round() / 10.0;
                format!("zig-zag {helm}/{heading}°, to {to} first")
            }
            Sort::Circle => format!("turning circle with {helm} to {to}"),
            Sort::PullOut => format!("pull-out from {helm} to {to}"),
            Sort::Stop { is_inertial: true, .. } => "inertial stop".to_owned(),
            Sort::Stop { is_full_astern: true, .. } => "stop full astern".to_owned(),
            Sort::Stop { .. } => "stop".to_owned(),
        }
    }

    /// Its kind in dictionaries.
    pub fn kind(&self) -> &'static str {
        match self.sort {
            Sort::ZigZag => "zig-zag-test",
            Sort::Circle => "turning-circle",
            Sort::PullOut => "pull-out",
            Sort::Stop { .. } => "stop",
        }
    }

    /// The last sample before the helm is taken off, or of the record.
    pub fn end(&self, record: &Record) -> usize {
        match (self.sort, self.orders.first()) {
            (Sort::Circle, Some(own)) if self.orders.len() > 1 => own.to.floor() as usize,
            _ => record.last(),
        }
    }

    /// What was ordered, by a simulation of it.
    pub fn simulated(standard: Standard, record: &Record, hull: &Hull) -> Result<Self, Invalid> {
        let smoother = Smoother::new(hull.length_m, standard.speed_m_s(), record.rate_hz)?;
        let (mut hold_s, mut side, mut heading, mut is_exact) = (0.0, 1.0, 0.0, false);
        let sort = match standard {
            Standard::ZigZagTest(own) => {
                (hold_s, side, heading) = (own.hold_s, own.to.sign(), own.heading_rad);
                is_exact = own.delay_s == 0.0 && own.every_s.is_none() && own.sensors == Sensors::Own;
                Sort::ZigZag
            }
            Standard::TurningCircle(own) => {
                (hold_s, side) = (own.hold_s, own.to.sign());
                Sort::Circle
            }
            Standard::PullOut(own) => {
                (hold_s, side) = (own.hold_s, own.to.sign());
                Sort::PullOut
            }
            Standard::Stop(own) => {
                hold_s = own.hold_s;
                let is_full_astern = own.inputs.iter().any(|(name, setting)| is_astern(hull, name, *setting));
                Sort::Stop { is_inertial: own.inputs.is_empty(), is_full_astern }
            }
            Standard::SpiralTest(_) | Standard::ReverseSpiral(_) => Sort::PullOut,
        };
        let from = record.sample(hold_s);
        let settings = standard.settings().1;
        let helm = Helm::of(record, hull.vessel, settings, smoother.length());
        let mut orders = Vec::new();
        if let (Sort::ZigZag, Some(helm)) = (sort, &helm) {
            // To both sides of the approach, which a record of orders alone does not show.
            let of = &helm.smooth[from.min(helm.smooth.len() - 1)..];
            let [low, high] =
                [of.iter().copied().fold(f64::MAX, f64::min), of.iter().copied().fold(f64::MIN, f64::max)];
            orders =
                helm.orders(from, 0.5 * (low + high), side * 0.5 * (high - low).max(1e-9), smoother.length());
        }
        if let Standard::PullOut(own) = standard {
            let over = (own.hold_s + own.turn_s) * record.rate_hz;
            orders = vec![Held { side: 1, from: from as f64, to: over, level: 0.0, doubt: 0.0 }];
        }
        let angle = angle(settings, hull);
        let is_most = settings.iter().any(|(name, change)| {
            range(hull, name).is_some_and(|[low, high]| change.abs() >= NEARLY * low.abs().max(high))
        });
        Ok(Self {
            sort,
            begin: from,
            order: from as f64,
            course: record.heading[from],
            speed_m_s: standard.speed_m_s(),
            side,
            helm: angle.map(|angle| [angle; 2]),
            is_most,
            heading,
            is_exact,
            orders,
            angle: helm.filter(|helm| helm.is_angle),
            smoother,
            remarks: Vec::new(),
        })
    }

    /// What was sailed, by its log; `wanted` is what the dictionary says of it.
    ///
    /// # Errors
    /// A log of no standard maneuver, of another than is wanted, or without its beginning.
    pub fn logged(wanted: Option<Standard>, record: &Record, hull: &Hull) -> Result<Self, Invalid> {
        let mut speeds = record.speed.clone();
        speeds.sort_by(f64::total_cmp);
        let usual = quantile(&speeds, 0.75).filter(|speed| *speed > 0.0).ok_or_else(|| {
            Invalid::new("speed", "none", "a ship under way", "check the channels of her speed")
        })?;
        let rough = Smoother::new(hull.length_m, usual, record.rate_hz)?;
        let window = rough.length();
        let stopped = match wanted {
            Some(Standard::Stop(_)) | None => stop(wanted, record, hull, window),
            Some(_) => None,
        };
        let is_stop = matches!(wanted, Some(Standard::Stop(_)));
        let mut own = match stopped {
            Some((sort, order)) => {
                let approach = Approach::of(record, 0, order, window);
                let smoother = Smoother::new(hull.length_m, approach.speed_m_s, record.rate_hz)?;
                Self {
                    sort,
                    begin: 0,
                    order,
                    course: approach.course,
                    speed_m_s: approach.speed_m_s,
                    side: 1.0,
                    helm: None,
                    is_most: false,
                    heading: 0.0,
                    is_exact: false,
                    orders: Vec::new(),
                    angle: None,
                    smoother,
                    remarks: approach.remarks(record, None, window),
                }
            }
            None if is_stop => {
                let least = record.surge.iter().copied().fold(f64::INFINITY, f64::min);
                return Err(Invalid::new(
                    "speed",
                    format!("{least:.3} m/s at the least, or no order to the engine"),
                    "an engine that is stopped or goes astern, and a ship that stops",
                    "run it longer, or name the maneuver that it is",
                ));
            }
            None => Self::steered(wanted, record, hull, window)?,
        };
        own.compare(wanted)?;
        Ok(own)
    }

    /// A maneuver of the helm.
    fn steered(wanted: Option<Standard>, record: &Record, hull: &Hull, window: f64) -> Result<Self, Invalid> {
        let helm = match wanted {
            Some(standard) => Helm::of(record, hull.vessel, standard.settings().1, window),
            None => Helm::of_rudders(record, hull, window),
        };
        let helm = helm.ok_or_else(|| {
            Invalid::new(
                "helm",
                "no input in rad or deg",
                "a rudder",
                "name the inputs of the helm in a dictionary, and give it with --dictionary",
            )
        })?;
        let said = |value: f64| {
            if helm.is_angle { degrees(value) } else { format!("{value:.2} of the dictionary's") }
        };
        let of = |[angle, part]: [f64; 2]| if helm.is_angle { angle } else { part };
        // Of what came before, as much as is of one piece with the last of it.
        let at = record.lead.saturating_sub(1).min(helm.smooth.len() - 1);
        let calm = of([STEADY_HELM, LEAST[1]]).max(4.0 * helm.noise);
        let is_calm = |k: &usize| (helm.smooth[*k] - helm.smooth[at]).abs() <= calm;
        let begin = (0..=at).rev().take_while(is_calm).last().unwrap_or(at);
        let before = median(helm.smooth[begin..=at].iter().copied());
        let largest = helm.departs(0.0, begin);
        let most = helm.departs(before, at);
        let least = of(LEAST).max(6.0 * helm.noise);
        let smoother = Smoother::new(
            hull.length_m,
            Approach::of(record, begin, at as f64, window).speed_m_s.max(1e-3),
            record.rate_hz,
        )?;
        let is_over = before.abs() >= (0.5 * largest).max(of(STRAIGHT));
        if is_over {
            let turn = record.yaw_rate[begin..].iter().take(3).map(|r| r.abs()).fold(f64::INFINITY, f64::min);
            if turn * window / record.rate_hz > STEADY_TURN {
                return Err(Invalid::new(
                    "helm",
                    format!("over at {} where the log begins, and a ship that turns", said(before)),
                    "the approach, and the order after it",
                    "log from before the order on",
                ));
            }
        } else if most < least {
            return Err(Invalid::new(
                "helm",
                format!("never more than {} from {}", said(most), said(before)),
                format!("an order of a standard maneuver, at least {}", said(least)),
                "check the channel of the helm; a straight run has no figures",
            ));
        }
        let (amidships, from) = if is_over {
            (0.0, begin)
        } else {
            let over = helm.first_over(before, at).unwrap_or(at);
            let straight = |part: f64| {
                let near = part * most + 3.0 * helm.noise;
                (begin..=over).rev().find(|k| (helm.smooth[*k] - before).abs() <= near).unwrap_or(begin)
            };
            // Of a short approach no sample of the move may count.
            let straight = Some(straight(0.1))
                .filter(|k| (k - begin) as f64 > 0.5 * window)
                .unwrap_or_else(|| straight(0.02));
            let first = straight.saturating_sub((APPROACH * window) as usize).max(begin);
            (median(helm.smooth[first..=straight].iter().copied()), straight)
        };
        let off = |k: usize| helm.smooth[k] - amidships;
        let over = if is_over { begin } else { helm.first_over(amidships, from).unwrap_or(from) };
        let sign = off(over).signum();
        let mut first = 0.0_f64;
        for k in over..helm.smooth.len() {
            if sign * off(k) < 0.5 * first {
                break;
            }
            first = first.max(sign * off(k));
        }
        let orders = helm.orders(from, amidships, sign * (first - 2.0 * helm.noise).max(0.5 * first), window);
        let Some(&Held { from: order, to, .. }) = orders.first() else {
            return Err(Invalid::new(
                "helm",
                "no order",
                "one of a standard maneuver",
                "check the channel of the helm",
            ));
        };
        let order = if is_over { begin as f64 } else { order.max(begin as f64) };
        let approach = Approach::of(record, begin, order, window);
        let mut remarks = approach.remarks(record, helm.is_angle.then_some(&helm), window);
        let turned =
            |time: f64| smoother.at(time, record.heading.len(), |k| record.heading[k]) - approach.course;
        let end = turned(to.min(record.last() as f64));
        let next = orders.get(1);
        let tail = record.last() as f64 - to;
        let is_pull_out = match wanted {
            Some(Standard::PullOut(_)) => true,
            Some(_) => false,
            None => end.abs() < 2.75 * PI && tail > APPROACH * window,
        };
        // A helm that goes back in steps is a spiral's.
        let back = (over..helm.smooth.len()).find(|k| sign * off(*k) <= 0.3 * first);
        let held = &helm.smooth[over..back.unwrap_or(helm.smooth.len())];
        let near = (0.1 * (orders[0].level - amidships).abs()).max(4.0 * helm.noise);
        let is_held =
            held.iter().filter(|own| (**own - orders[0].level).abs() <= near).count() * 3 > held.len() * 2;
        let sort = match next {
            Some(next) if next.side == -1 && end.abs() <= MOST_HEADING => Sort::ZigZag,
            Some(next) if next.side == 0 && is_pull_out && is_held => Sort::PullOut,
            _ if end.abs() >= FRAC_PI_2 && is_held => Sort::Circle,
            None if matches!(wanted, Some(Standard::TurningCircle(_))) => Sort::Circle,
            _ => {
                return Err(Invalid::new(
                    "maneuver",
                    format!(
                        "{} of {} for {} of turn",
                        if is_held { "a helm" } else { "steps of helm from" },
                        said(orders[0].level),
                        degrees(end)
                    ),
                    "a zig-zag, a turning circle, a pull-out or a stop",
                    "run it longer, or name the helm and the heading in a dictionary",
                ));
            }
        };
        let reversals =
            1 + orders.windows(2).take_while(|two| two[0].side == -two[1].side && two[0].side != 0).count();
        let orders = if sort == Sort::ZigZag { orders[..reversals].to_vec() } else { orders };
        let levels: Vec<f64> =
            orders.iter().take(if sort == Sort::ZigZag { 2 } else { 1 }).map(|own| own.level).collect();
        let size = if levels.len() > 1 {
            0.5 * (levels[0] - levels[1]).abs()
        } else {
            (levels[0] - amidships).abs()
        };
        let gone: Vec<f64> = orders.iter().skip(1).map(|own| turned(own.from).abs()).collect();
        let wanted_heading = match wanted {
            Some(Standard::ZigZagTest(own)) => Some(own.heading_rad),
            _ => None,
        };
        let heading = heading(median(gone), wanted_heading);
        if sort == Sort::Circle && orders.len() > 1 && end.abs() < 3.0 * PI {
            remarks.push(format!(
                "the helm was taken off after {} of turn, what comes later is not used",
                degrees(end.abs())
            ));
        }
        let angle = helm.is_angle.then_some([size, levels[0].abs()]);
        let is_most = match (wanted, angle) {
            (_, Some(_)) => rudder_stop(hull).is_some_and(|stop| size.max(levels[0].abs()) >= NEARLY * stop),
            (Some(standard), None) => standard.settings().1.iter().any(|(name, change)| {
                range(hull, name)
                    .is_some_and(|[low, high]| (size * change).abs() >= NEARLY * low.abs().max(high))
            }),
            (None, None) => false,
        };
        let side = end.signum();
        if wanted.is_some() && sign * side < 0.0 {
            remarks.push(format!(
                "by the signs of the dictionary the helm was put to {}, and she turned to {}: the log has the other sign of the helm",
                board(sign),
                board(side)
            ));
        }
        if !helm.is_angle && (size - 1.0).abs() > 0.1 {
            remarks.push(format!("the helm was {size:.2} of that of the dictionary"));
        }
        Ok(Self {
            sort,
            begin,
            order,
            course: approach.course,
            speed_m_s: approach.speed_m_s,
            side,
            helm: angle,
            is_most,
            heading,
            is_exact: false,
            orders,
            angle: helm.is_angle.then_some(helm),
            smoother: Smoother::new(hull.length_m, approach.speed_m_s, record.rate_hz)?,
            remarks,
        })
    }

    /// Refuses another maneuver than the dictionary's, and notes what else differs from it.
    fn compare(&mut self, wanted: Option<Standard>) -> Result<(), Invalid> {
        let Some(standard) = wanted else { return Ok(()) };
        if standard.name() != self.kind() {
            return Err(Invalid::new(
                "maneuver of the log",
                format!("a {}", self.words()),
                format!("a {}, as the dictionary says", standard.name()),
                "name the maneuver that was sailed, or leave out --dictionary",
            ));
        }
        let to = match standard {
            Standard::ZigZagTest(own) => Some(own.to),
            Standard::TurningCircle(own) => Some(own.to),
            Standard::PullOut(own) => Some(own.to),
            _ => None,
        };
        if let Some(to) = to.filter(|to| to.sign() != self.side) {
            self.remarks.push(format!(
                "she turned to {} first, the dictionary says {}: the figures are those to {}",
                board(self.side),
                board(to.sign()),
                board(self.side)
            ));
        }
        let settings = standard.settings().1;
        let wanted = settings.values().map(|own| own.abs()).sum::<f64>() / settings.len().max(1) as f64;
        if let Some([change, angle]) = self.helm {
            let differs = |own: f64| (own - wanted).abs() > (0.05 * wanted).max(0.018);
            if differs(change) && differs(angle) {
                self.remarks.push(format!(
                    "the helm was {}, the dictionary says {}",
                    degrees(change),
                    degrees(wanted)
                ));
            }
        }
        if let Standard::ZigZagTest(own) = standard
            && (own.heading_rad - self.heading).abs() > 1e-6
        {
            let [found, said] = [self.heading, own.heading_rad].map(degrees);
            self.remarks.push(format!("the helm went over at {found}, the dictionary says {said}"));
        }
        let speed = standard.speed_m_s();
        if (self.speed_m_s - speed).abs() > 2.0 * STEADY_SPEED * speed {
            self.remarks.push(format!(
                "the speed of the approach was {:.2} m/s, the dictionary says {speed:.2} m/s",
                self.speed_m_s
            ));
        }
        Ok(())
    }
}

/// The change of heading at which a helm went over that was seen to do so at `seen`.
fn heading(seen: f64, wanted: Option<f64>) -> f64 {
    let is_near = |own: &f64| (seen - own).abs() <= (0.1 * own).max(1_f64.to_radians());
    let usual = || {
        HEADINGS
            .map(f64::to_radians)
            .into_iter()
            .filter(is_near)
            .min_by(|a, b| (a - seen).abs().total_cmp(&(b - seen).abs()))
    };
    wanted.filter(is_near).or_else(usual).unwrap_or(seen)
}

/// By what part of its range an input counts as at the end of it.
const NEARLY: f64 = 0.98;

/// The range of an input, where its vessel states one.
fn range(hull: &Hull, input: &str) -> Option<[f64; 2]> {
    let place = hull.vessel.model.input_variables().iter().position(|own| own.name == input)?;
    hull.vessel.actuators[place].range
}

/// The greatest angle of all rudders, where their ranges are stated \[rad\].
fn rudder_stop(hull: &Hull) -> Option<f64> {
    let inputs = hull.vessel.model.input_variables().iter();
    let stop = |own: &model::Variable| Some((radians(&own.unit)?, range(hull, &own.name)?));
    let stops = inputs.filter_map(stop).map(|(unit, [low, high])| unit * low.abs().max(high));
    stops.max_by(f64::total_cmp)
}

fn is_astern(hull: &Hull, input: &str, setting: f64) -> bool {
    range(hull, input).is_some_and(|[low, _]| low < 0.0 && setting <= NEARLY * low)
}

/// The helm as an angle \[rad\], where it is one input in angles.
fn angle(helm: &Settings, hull: &Hull) -> Option<f64> {
    let mut set = helm.iter().filter(|(_, change)| **change != 0.0);
    let (name, change) = set.next().filter(|_| helm.len() == 1)?;
    let input = hull.vessel.model.input_variables().iter().find(|own| own.name == *name)?;
    radians(&input.unit).map(|unit| change.abs() * unit)
}

/// What kind of stop a log is, and when the engine was ordered, in samples; `None` where she does not stop, or the engine
/// does nothing before.
fn stop(wanted: Option<Standard>, record: &Record, hull: &Hull, window: f64) -> Option<(Sort, f64)> {
    let inertial = Stop { speed_m_s: 1.0, inputs: Settings::new(), hold_s: 0.0 };
    let wanted = match wanted {
        Some(Standard::Stop(own)) => own,
        _ => &inertial,
    };
    let inputs = hull.vessel.model.input_variables();
    let engines = inputs.iter().zip(&hull.vessel.couplings).filter(|(own, follows)| {
        let is_named = wanted.inputs.is_empty() || wanted.inputs.contains_key(&own.name);
        follows.is_none() && radians(&own.unit).is_none() && is_named
    });
    let one = |name: &String| {
        let engine = Helm::of(record, hull.vessel, &Settings::from([(name.clone(), 1.0)]), window)?;
        let before = engine.smooth[0];
        let most = engine.departs(before, 0);
        if most < 0.5 * before.abs() || before.abs() <= 4.0 * engine.noise {
            return None;
        }
        let over = engine.first_over(before, 0)?;
        let near = 0.1 * most + 3.0 * engine.noise;
        let straight = (0..=over).rev().find(|k| (engine.smooth[*k] - before).abs() <= near)?;
        let first = straight.saturating_sub((APPROACH * window) as usize);
        let before = median(engine.smooth[first..=straight].iter().copied());
        let ahead = median(record.surge[first..=straight].iter().copied());
        let stopped = (straight..record.last()).find(|k| record.surge[*k] <= STOPPED * ahead)?;
        let change = (engine.smooth[over] - before).signum();
        let orders = engine.orders(straight, before, change * engine.departs(before, straight), window);
        let level = median(engine.smooth[over..stopped.max(over + 1)].iter().copied());
        let is_full_astern = is_astern(hull, name, level);
        let sort = Sort::Stop { is_inertial: level.abs() <= 0.1 * before.abs(), is_full_astern };
        Some((orders.first()?.from, sort, most / before.abs()))
    };
    let found = engines.filter_map(|(own, _)| one(&own.name));
    found.max_by(|a, b| a.2.total_cmp(&b.2)).map(|(order, sort, _)| (sort, order))
}

/// What is seen of a ship before the order.
struct Approach {
    samples: std::ops::Range<usize>,
    course: f64,
    speed_m_s: f64,
    /// Its length, in times in which the ship covers hers.
    length: f64,
}

impl Approach {
    /// Before `order`, from sample `begin` on at the earliest.
    fn of(record: &Record, begin: usize, order: f64, window: f64) -> Self {
        let end = (order.floor() as usize + 1).min(record.heading.len());
        let from = |lengths: f64| {
            ((order - lengths * window).ceil().max(0.0) as usize).clamp(begin.min(end - 1), end - 1)
        };
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        let samples = from(APPROACH)..end;
        Self {
            course: mean(&record.heading[from(1.0)..end]),
            speed_m_s: mean(&record.speed[samples.clone()]),
            length: (order - begin as f64).max(0.0) / window,
            samples,
        }
    }

    /// Whether it was long and steady.
    fn remarks(&self, record: &Record, helm: Option<&Helm>, window: f64) -> Vec<String> {
        let lengths = self.length.min(APPROACH);
        if self.length < 0.5 {
            let words = format!(
                "the approach in the log is {lengths:.1} ship lengths long, so that its steadiness is not known"
            );
            return vec![words];
        }
        let mut unsteady = Vec::new();
        let change = |of: &[f64]| slope(of, self.samples.clone());
        let turn = change(&record.heading) * window;
        if turn.abs() > STEADY_TURN {
            unsteady.push(format!("she turned by {} while she covered her length", degrees(turn)));
        }
        let slower = change(&record.speed) * self.samples.len() as f64 / self.speed_m_s;
        if slower.abs() > STEADY_SPEED {
            unsteady.push(format!("her speed changed by {:.0} %", 100.0 * slower));
        }
        if let Some(helm) = helm {
            let own = &helm.smooth[self.samples.start..self.samples.end.min(helm.smooth.len())];
            // The order itself may be in the last of them.
            let own = &own[..own.len().saturating_sub(2).max(1)];
            let spread = numerics::statistics::spread(own).unwrap_or(0.0);
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

/// A steady current \[m/s to north and east\].
pub(super) struct Current {
    pub to: [f64; 2],
    /// How it shows.
    pub by: &'static str,
    /// Whether the log's speeds are over ground.
    pub over_ground: bool,
}

/// Part of the speed from which on a drift counts as a current.
const DRIFTS: f64 = 0.02;
/// Headings of which places a turn apart are compared.
const PAIRS: usize = 9;

impl Sailed {
    /// The current that the log shows, by MSC/Circ.1053 from places a whole turn apart, else from speeds through the water
    /// against the track; or why it does not.
    pub fn current(&self, record: &Record) -> Result<Option<Current>, String> {
        let end = self.end(record);
        let [first, half] = [self.order.ceil() as usize, (0.5 * (self.order + end as f64)) as usize];
        // Between track and speeds.
        let off = |from: usize, to: usize| {
            let seconds = (to - from) as f64 / record.rate_hz;
            let mut sum = [0.0; 2];
            for k in from..to {
                let (sin, cos) = libm::sincos(0.5 * (record.heading[k] + record.heading[k + 1]));
                let [u, v] =
                    [&record.surge, &record.sway].map(|of| 0.5 * (of[k] + of[k + 1]) / record.rate_hz);
                sum = [sum[0] + u * cos - v * sin, sum[1] + u * sin + v * cos];
            }
            let place = |k: usize| self.place(record, k as f64);
            [0, 1].map(|axis| (place(to)[axis] - place(from)[axis] - sum[axis]) / seconds)
        };
        let size = |own: [f64; 2]| libm::hypot(own[0], own[1]);
        let least = DRIFTS * self.speed_m_s;
        let all = if end > first + 2 { off(first, end) } else { [0.0; 2] };
        let turned = record.turned(self.course, self.side);
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
            let to = moved.map(|own| own / seconds);
            let is_one = size(to) >= least;
            let current =
                Current { to, by: "from places a whole turn apart", over_ground: size(all) < 0.5 * size(to) };
            return Ok(is_one.then_some(current));
        }
        let [one, other] = if half > first + 2 { [off(first, half), off(half, end)] } else { [[0.0; 2]; 2] };
        let is_steady = size([one[0] - other[0], one[1] - other[1]]) < 0.5 * size(all);
        if size(all) >= least && is_steady {
            let by = "from the speeds of the log, which are through the water, against the track";
            return Ok(Some(Current { to: all, by, over_ground: false }));
        }
        let turns = (record.heading[end] - self.course).abs() / TAU;
        Err(format!(
            "not corrected for a current: {turns:.1} turns do not show one, 1.5 are needed, or speeds through the water"
        ))
    }

    /// The speed of the approach in another record of it \[m/s\].
    pub fn speed(&self, record: &Record) -> f64 {
        Approach::of(record, self.begin, self.order, self.smoother.length()).speed_m_s
    }

    /// North and east at a time in samples \[m\], smoothed.
    pub fn place(&self, record: &Record, time: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.smoother.at(time, record.place.len(), |k| record.place[k][axis]))
    }
}
