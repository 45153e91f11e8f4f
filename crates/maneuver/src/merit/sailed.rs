use std::f64::consts::{FRAC_PI_2, PI};

use numerics::statistics::{quantile, sorted};
use refusal::Invalid;

use super::helm::{
    APPROACH, Approach, Held, Helm, STEADY_HELM, STEADY_SPEED, STEADY_TURN, degrees, median, radians,
};
use super::{Hull, Record, Smoother};
use crate::standard::{Board, Sensors, Settings, Standard};

/// What an order is, at least: an angle \[rad\], or a part of the dictionary's helm.
const LEAST: [f64; 2] = [0.035, 0.2];
/// What helm a log begins with at the most before its order: an angle \[rad\], or a part of the dictionary's helm.
const STRAIGHT: [f64; 2] = [0.07, 0.3];
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
    /// The side to which she turned first.
    pub to: Board,
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

impl Sailed {
    /// In words: `zig-zag 10°/10°, to port first`.
    pub fn words(&self) -> String {
        let to = self.to;
        let angle = self.helm.map(|[change, _]| format!("{:.0}°", change.to_degrees()));
        let helm = angle.unwrap_or_else(|| "the helm".to_owned());
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
            (Sort::Circle, Some(order)) if self.orders.len() > 1 => order.to.floor() as usize,
            _ => record.last(),
        }
    }

    /// One of which no more is known than its order and its approach: course and speed.
    fn of(sort: Sort, begin: usize, order: f64, [course, speed_m_s]: [f64; 2], smoother: Smoother) -> Self {
        Self {
            sort,
            begin,
            order,
            course,
            speed_m_s,
            to: Board::Starboard,
            helm: None,
            is_most: false,
            heading: 0.0,
            is_exact: false,
            orders: Vec::new(),
            angle: None,
            smoother,
            remarks: Vec::new(),
        }
    }

    /// What was ordered, by a simulation of it.
    pub fn simulated(standard: Standard, record: &Record, hull: &Hull) -> Result<Self, Invalid> {
        let (sort, hold_s, to) = ordered(standard, hull);
        let from = record.sample(hold_s);
        let approach = [record.heading[from], standard.speed_m_s()];
        let smoother = Smoother::new(hull.length_m, approach[1], record.rate_hz)?;
        let (settings, window) = (standard.settings().1, smoother.length);
        let mut sailed = Self::of(sort, from, from as f64, approach, smoother);
        let helm = Helm::of(record, hull.vessel, settings, window);
        sailed.to = to.unwrap_or(Board::Starboard);
        sailed.helm = angle(settings, hull).map(|angle| [angle; 2]);
        sailed.is_most = is_most(settings, 1.0, hull);
        if let Standard::ZigZagTest(test) = standard {
            sailed.heading = test.heading_rad;
            sailed.is_exact = test.delay_s == 0.0 && test.every_s.is_none() && test.sensors == Sensors::Own;
            if let Some(helm) = &helm {
                // To both sides of the approach, which a record of orders alone does not show.
                let of = &helm.smooth[from.min(helm.smooth.len() - 1)..];
                let low = of.iter().copied().fold(f64::MAX, f64::min);
                let high = of.iter().copied().fold(f64::MIN, f64::max);
                let size = 0.5 * (high - low).max(1e-9);
                sailed.orders = helm.orders(from, 0.5 * (low + high), sailed.to.sign() * size, window);
            }
        }
        if let Standard::PullOut(turn) = standard {
            let over = (turn.hold_s + turn.turn_s) * record.rate_hz;
            sailed.orders = vec![Held { side: 1, from: from as f64, to: over, level: 0.0, doubt: 0.0 }];
        }
        sailed.angle = helm.filter(|helm| helm.is_angle);
        Ok(sailed)
    }

    /// What was sailed, by its log; `wanted` is what the dictionary says of it.
    ///
    /// # Errors
    /// A log of no standard maneuver, of another than is wanted, or without its beginning.
    pub fn logged(wanted: Option<Standard>, record: &Record, hull: &Hull) -> Result<Self, Invalid> {
        let speeds = sorted(record.speed.iter().copied().map(Some));
        let usual = quantile(&speeds, 0.75).filter(|speed| *speed > 0.0).ok_or_else(|| {
            Invalid::new("speed", "none", "a ship under way", "check the channels of her speed")
        })?;
        let window = Smoother::new(hull.length_m, usual, record.rate_hz)?.length;
        let all = Settings::new();
        let engines = match wanted {
            Some(Standard::Stop(stop)) => Some(&stop.inputs),
            Some(_) => None,
            None => Some(&all),
        };
        let mut sailed = match engines.and_then(|engines| stop(engines, record, hull, window)) {
            Some((sort, order)) => {
                let approach = Approach::of(record, 0, order, window);
                let remarks = approach.remarks(record, None, window);
                let smoother = Smoother::new(hull.length_m, approach.motion[1], record.rate_hz)?;
                Self { remarks, ..Self::of(sort, 0, order, approach.motion, smoother) }
            }
            None if matches!(wanted, Some(Standard::Stop(_))) => {
                let least = record.surge.iter().copied().fold(f64::INFINITY, f64::min);
                let given = format!("{least:.3} m/s at the least, or no order to the engine");
                let expected = "an engine that is stopped or goes astern, and a ship that stops";
                let remedy = "run it longer, or name the maneuver that it is";
                return Err(Invalid::new("speed", given, expected, remedy));
            }
            None => Self::steered(wanted, record, hull, window)?,
        };
        sailed.compare(wanted, hull)?;
        Ok(sailed)
    }

    /// A maneuver of the helm.
    fn steered(wanted: Option<Standard>, record: &Record, hull: &Hull, window: f64) -> Result<Self, Invalid> {
        let helm = match wanted {
            Some(standard) => Helm::of(record, hull.vessel, standard.settings().1, window),
            None => Helm::of_rudders(record, hull, window),
        };
        let helm = helm.ok_or_else(|| {
            let remedy = "name the inputs of the helm in a dictionary, and give it with --dictionary";
            Invalid::new("helm", "no input in rad or deg", "a rudder", remedy)
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
        let [_, speed_m_s] = Approach::of(record, begin, at as f64, window).motion;
        let smoother = Smoother::new(hull.length_m, speed_m_s.max(1e-3), record.rate_hz)?;
        let is_over = before.abs() >= (0.5 * largest).max(of(STRAIGHT));
        if is_over {
            let turn = record.yaw_rate[begin..].iter().take(3).map(|r| r.abs()).fold(f64::INFINITY, f64::min);
            if turn * window / record.rate_hz > STEADY_TURN {
                let given = format!("over at {} where the log begins, and a ship that turns", said(before));
                let expected = "the approach, and the order after it";
                return Err(Invalid::new("helm", given, expected, "log from before the order on"));
            }
        } else if most < least {
            let given = format!("never more than {} from {}", said(most), said(before));
            let expected = format!("an order of a standard maneuver, at least {}", said(least));
            let remedy = "check the channel of the helm; a straight run has no figures";
            return Err(Invalid::new("helm", given, expected, remedy));
        }
        let (amidships, from) = if is_over {
            (0.0, begin)
        } else {
            let over = helm.first_over(before, at).unwrap_or(at);
            let straight = |part: f64| {
                let near = part * most + 3.0 * helm.noise;
                helm.last_near(before, near, begin..=over).unwrap_or(begin)
            };
            // Of a short approach no sample of the move may count.
            let long = Some(straight(0.1)).filter(|k| (k - begin) as f64 > 0.5 * window);
            let straight = long.unwrap_or_else(|| straight(0.02));
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
        let size = (first - 2.0 * helm.noise).max(0.5 * first);
        let mut orders = helm.orders(from, amidships, sign * size, window);
        let Some(&Held { from: order, to, level, .. }) = orders.first() else {
            let remedy = "check the channel of the helm";
            return Err(Invalid::new("helm", "no order", "one of a standard maneuver", remedy));
        };
        let order = if is_over { begin as f64 } else { order.max(begin as f64) };
        let approach = Approach::of(record, begin, order, window);
        let mut remarks = approach.remarks(record, helm.is_angle.then_some(&helm), window);
        let [course, _] = approach.motion;
        let turned = |time: f64| smoother.at(time, record.heading.len(), |k| record.heading[k]) - course;
        let end = turned(to.min(record.last() as f64));
        let is_apart = end.abs() < 2.75 * PI && record.last() as f64 - to > APPROACH * window;
        let is_pull_out = wanted.map_or(is_apart, |wanted| matches!(wanted, Standard::PullOut(_)));
        // A helm that goes back in steps is a spiral's.
        let back = (over..helm.smooth.len()).find(|k| sign * off(*k) <= 0.3 * first);
        let held = &helm.smooth[over..back.unwrap_or(helm.smooth.len())];
        let near = (0.1 * (level - amidships).abs()).max(4.0 * helm.noise);
        let is_held =
            held.iter().filter(|angle| (**angle - level).abs() <= near).count() * 3 > held.len() * 2;
        let sort = match orders.get(1) {
            Some(next) if next.side == -1 && end.abs() <= MOST_HEADING => Sort::ZigZag,
            Some(next) if next.side == 0 && is_pull_out && is_held => Sort::PullOut,
            _ if end.abs() >= FRAC_PI_2 && is_held => Sort::Circle,
            None if matches!(wanted, Some(Standard::TurningCircle(_))) => Sort::Circle,
            _ => {
                let what = if is_held { "a helm" } else { "steps of helm from" };
                let given = format!("{what} of {} for {} of turn", said(level), degrees(end));
                let expected = "a zig-zag, a turning circle, a pull-out or a stop";
                let remedy = "run it longer, or name the helm and the heading in a dictionary";
                return Err(Invalid::new("maneuver", given, expected, remedy));
            }
        };
        let mut size = (level - amidships).abs();
        if sort == Sort::ZigZag {
            let is_reversal = |two: &&[Held]| two[0].side == -two[1].side && two[0].side != 0;
            orders.truncate(1 + orders.windows(2).take_while(is_reversal).count());
            size = orders.get(1).map_or(size, |other| 0.5 * (level - other.level).abs());
        }
        let gone = orders.iter().skip(1).map(|order| turned(order.from).abs());
        let wanted_heading = match wanted {
            Some(Standard::ZigZagTest(test)) => Some(test.heading_rad),
            _ => None,
        };
        let heading = heading(median(gone), wanted_heading);
        if sort == Sort::Circle && orders.len() > 1 && end.abs() < 3.0 * PI {
            let after = degrees(end.abs());
            remarks
                .push(format!("the helm was taken off after {after} of turn, what comes later is not used"));
        }
        let angle = helm.is_angle.then_some([size, level.abs()]);
        let is_most = match wanted {
            _ if helm.is_angle => is_at_stop(size.max(level.abs()), hull),
            Some(standard) => is_most(standard.settings().1, size, hull),
            None => false,
        };
        let side = |sign: f64| if sign.is_sign_negative() { Board::Port } else { Board::Starboard };
        let [put, to] = [sign, end].map(side);
        if wanted.is_some() && put != to {
            remarks.push(format!(
                "by the signs of the dictionary the helm was put to {put}, and she turned to {to}: the log has the other sign of the helm"
            ));
        }
        if !helm.is_angle && (size - 1.0).abs() > 0.1 {
            remarks.push(format!("the helm was {size:.2} of that of the dictionary"));
        }
        let smoother = Smoother::new(hull.length_m, approach.motion[1], record.rate_hz)?;
        Ok(Self {
            to,
            helm: angle,
            is_most,
            heading,
            orders,
            angle: helm.is_angle.then_some(helm),
            remarks,
            ..Self::of(sort, begin, order, approach.motion, smoother)
        })
    }

    /// Refuses another maneuver than the dictionary's, and notes what else differs from it.
    fn compare(&mut self, wanted: Option<Standard>, hull: &Hull) -> Result<(), Invalid> {
        let Some(standard) = wanted else { return Ok(()) };
        if standard.name() != self.kind() {
            let [sailed, said] = [self.words(), standard.name().to_owned()].map(|name| format!("a {name}"));
            let remedy = "name the maneuver that was sailed, or leave out --dictionary";
            let expected = format!("{said}, as the dictionary says");
            return Err(Invalid::new("maneuver of the log", sailed, expected, remedy));
        }
        let (.., to) = ordered(standard, hull);
        if let Some(said) = to.filter(|to| *to != self.to) {
            let to = self.to;
            self.remarks.push(format!(
                "she turned to {to} first, the dictionary says {said}: the figures are those to {to}"
            ));
        }
        let settings = standard.settings().1;
        let wanted = settings.values().map(|change| change.abs()).sum::<f64>() / settings.len().max(1) as f64;
        if let Some([change, angle]) = self.helm {
            let differs = |seen: f64| (seen - wanted).abs() > (0.05 * wanted).max(0.018);
            if differs(change) && differs(angle) {
                let [sailed, said] = [change, wanted].map(degrees);
                self.remarks.push(format!("the helm was {sailed}, the dictionary says {said}"));
            }
        }
        if let Standard::ZigZagTest(test) = standard
            && (test.heading_rad - self.heading).abs() > 1e-6
        {
            let [sailed, said] = [self.heading, test.heading_rad].map(degrees);
            self.remarks.push(format!("the helm went over at {sailed}, the dictionary says {said}"));
        }
        let speed = standard.speed_m_s();
        if (self.speed_m_s - speed).abs() > 2.0 * STEADY_SPEED * speed {
            let sailed = self.speed_m_s;
            self.remarks.push(format!(
                "the speed of the approach was {sailed:.2} m/s, the dictionary says {speed:.2} m/s"
            ));
        }
        Ok(())
    }
}

/// The change of heading at which a helm went over that was seen to do so at `seen`.
fn heading(seen: f64, wanted: Option<f64>) -> f64 {
    let away = |angle: &f64| (seen - angle).abs();
    let is_near = |angle: &f64| away(angle) <= (0.1 * angle).max(1_f64.to_radians());
    let usual = HEADINGS.map(f64::to_radians).into_iter().filter(is_near);
    let nearest = usual.min_by(|a, b| away(a).total_cmp(&away(b)));
    wanted.filter(is_near).or(nearest).unwrap_or(seen)
}

/// Of what is ordered: its sort, how long the approach is held \[s\], and the side.
fn ordered(standard: Standard, hull: &Hull) -> (Sort, f64, Option<Board>) {
    match standard {
        Standard::ZigZagTest(test) => (Sort::ZigZag, test.hold_s, Some(test.to)),
        Standard::TurningCircle(turn) => (Sort::Circle, turn.hold_s, Some(turn.to)),
        Standard::PullOut(turn) => (Sort::PullOut, turn.hold_s, Some(turn.to)),
        Standard::Stop(stop) => {
            let is_full_astern = stop.inputs.iter().any(|(name, setting)| is_astern(hull, name, *setting));
            (Sort::Stop { is_inertial: stop.inputs.is_empty(), is_full_astern }, stop.hold_s, None)
        }
        Standard::SpiralTest(_) | Standard::ReverseSpiral(_) => (Sort::PullOut, 0.0, None),
    }
}

/// By what part of its range an input counts as at the end of it.
const NEARLY: f64 = 0.98;

/// The range of an input, where its vessel states one.
fn range(hull: &Hull, input: &str) -> Option<[f64; 2]> {
    let place = hull.vessel.model.input_variables().iter().position(|variable| variable.name == input)?;
    hull.vessel.actuators[place].range
}

/// Whether an angle \[rad\] is the greatest of all rudders, where their ranges are stated.
fn is_at_stop(angle: f64, hull: &Hull) -> bool {
    let inputs = hull.vessel.model.input_variables().iter();
    let stop =
        |variable: &ship::model::Variable| Some((radians(&variable.unit)?, range(hull, &variable.name)?));
    let stops = inputs.filter_map(stop).map(|(unit, [low, high])| unit * low.abs().max(high));
    stops.max_by(f64::total_cmp).is_some_and(|stop| angle >= NEARLY * stop)
}

/// Whether `part` of a dictionary's helm is the most of an input.
fn is_most(helm: &Settings, part: f64, hull: &Hull) -> bool {
    let is_end = |change: f64, [low, high]: [f64; 2]| change.abs() >= NEARLY * low.abs().max(high);
    helm.iter().any(|(name, change)| range(hull, name).is_some_and(|range| is_end(part * change, range)))
}

fn is_astern(hull: &Hull, input: &str, setting: f64) -> bool {
    range(hull, input).is_some_and(|[low, _]| low < 0.0 && setting <= NEARLY * low)
}

/// The helm as an angle \[rad\], where it is one input in angles.
fn angle(helm: &Settings, hull: &Hull) -> Option<f64> {
    let mut set = helm.iter().filter(|(_, change)| **change != 0.0);
    let (name, change) = set.next().filter(|_| helm.len() == 1)?;
    let input = hull.vessel.model.input_variables().iter().find(|variable| variable.name == *name)?;
    radians(&input.unit).map(|unit| change.abs() * unit)
}

/// What kind of stop a log is, and when the engine was ordered, in samples; `None` where she does not stop, or no engine of
/// those that are `named`, or of all, does anything before.
fn stop(named: &Settings, record: &Record, hull: &Hull, window: f64) -> Option<(Sort, f64)> {
    let engines = hull.vessel.model.input_variables().iter().zip(&hull.vessel.couplings).filter(
        |(variable, follows)| {
            let is_named = named.is_empty() || named.contains_key(&variable.name);
            follows.is_none() && radians(&variable.unit).is_none() && is_named
        },
    );
    let one = |name: &String| {
        let engine = Helm::of(record, hull.vessel, &Settings::from([(name.clone(), 1.0)]), window)?;
        let before = engine.smooth[0];
        let most = engine.departs(before, 0);
        if most < 0.5 * before.abs() || before.abs() <= 4.0 * engine.noise {
            return None;
        }
        let over = engine.first_over(before, 0)?;
        let near = 0.1 * most + 3.0 * engine.noise;
        let straight = engine.last_near(before, near, 0..=over)?;
        let first = straight.saturating_sub((APPROACH * window) as usize);
        let before = median(engine.smooth[first..=straight].iter().copied());
        let ahead = median(record.surge[first..=straight].iter().copied());
        let stopped = (straight..record.last()).find(|k| record.surge[*k] <= STOPPED * ahead)?;
        let change = (engine.smooth[over] - before).signum();
        let orders = engine.orders(straight, before, change * engine.departs(before, straight), window);
        let level = median(engine.smooth[over..stopped.max(over + 1)].iter().copied());
        let is_full_astern = is_astern(hull, name, level);
        let sort = Sort::Stop { is_inertial: level.abs() <= 0.1 * before.abs(), is_full_astern };
        Some(((sort, orders.first()?.from), most / before.abs()))
    };
    let stops = engines.filter_map(|(variable, _)| one(&variable.name));
    stops.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(stop, _)| stop)
}
