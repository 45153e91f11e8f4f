use std::sync::Arc;

use ship::engine::{Command, Program, Progress, Seen, Spoken};
use ship::model::Vessel;

use super::{Sensors, Settings, Standard, steps};
use crate::feedback::{Gains, Loop};

/// What is done until a condition is met, then what is next.
#[derive(Clone, Debug)]
struct Order {
    act: Act,
    until: Until,
}

#[derive(Clone, Debug)]
enum Act {
    /// These inputs.
    Set(Vec<f64>),
    /// So much of the greatest helm as holds this yaw rate \[rad/s\].
    Turn(f64),
}

#[derive(Clone, Copy, Debug)]
enum Until {
    /// So long after its beginning \[s\].
    Seconds(f64),
    /// The course has changed by so much, to starboard where positive \[rad\].
    Heading(f64),
    /// The speed is no greater \[m/s\].
    Speed(f64),
    /// The end of the maneuver.
    End,
}

impl Until {
    /// What is waited for, in words.
    fn what(self) -> &'static str {
        match self {
            Self::Seconds(_) | Self::End => "end of its orders",
            Self::Heading(_) => "change of heading",
            Self::Speed(_) => "speed",
        }
    }
}

/// When orders have been carried out.
#[derive(Clone, Copy, Debug)]
enum Ending {
    /// They go on, but each has been given.
    Open,
    /// The condition of the last one is met.
    Last,
    /// The course has changed by so much to either side under the last one \[rad\].
    Turned(f64),
}

/// Orders in their sequence.
#[derive(Clone, Debug)]
pub(crate) struct Orders(Arc<Sequence>);

#[derive(Debug)]
struct Sequence {
    orders: Vec<Order>,
    /// The order that follows the last one.
    again: Option<usize>,
    ending: Ending,
    /// The order at whose beginning the course is taken.
    course_at: usize,
    /// Helm for yaw rates.
    turning: Option<Turning>,
    delay_s: f64,
    every_s: Option<f64>,
    sensors: Sensors,
    rate_hz: f64,
    spoken: Spoken,
}

/// The helm that holds yaw rates.
#[derive(Clone, Debug)]
struct Turning {
    amidships: Vec<f64>,
    helm: Vec<f64>,
    gains: Gains,
    /// Increment of r in a sample by the greatest helm \[rad/s\].
    authority: f64,
}

impl Orders {
    /// The orders of `standard` from its approach, which the inputs `held` hold. `slopes`: of the increments of u, v, r in a sample by
    /// these inputs; `decay`: how fast u, v and r decay there \[1/sample\].
    pub fn new(
        standard: Standard,
        vessel: &Vessel,
        held: &[f64],
        slopes: &[[f64; 3]],
        decay: [f64; 3],
    ) -> Self {
        let helm = changes(standard.settings().1, vessel);
        let stopped =
            |i: usize, input: f64| vessel.actuators[i].range.map_or(input, |range| at_stop(range, input));
        let helm_of = |part: f64| {
            let inputs = held.iter().zip(&helm).enumerate();
            Act::Set(inputs.map(|(i, (u, h))| stopped(i, u + part * h)).collect())
        };
        let mut sequence = Sequence {
            orders: Vec::new(),
            again: None,
            ending: Ending::Open,
            course_at: 0,
            turning: None,
            delay_s: 0.0,
            every_s: None,
            sensors: Sensors::Own,
            rate_hz: vessel.sample_rate_hz,
            spoken: spoken(standard, vessel),
        };
        match standard {
            Standard::ZigZagTest(test) => {
                sequence.hold(held, test.hold_s);
                sequence.again = Some(sequence.course_at);
                (sequence.delay_s, sequence.every_s, sequence.sensors) =
                    (test.delay_s, test.every_s, test.sensors);
                for side in [test.to.sign(), -test.to.sign()] {
                    sequence.order(helm_of(side), Until::Heading(side * test.heading_rad));
                }
            }
            Standard::TurningCircle(turn) => {
                sequence.hold(held, turn.hold_s);
                sequence.ending = Ending::Turned(turn.turn_rad);
                sequence.order(helm_of(turn.to.sign()), Until::End);
            }
            Standard::PullOut(turn) => {
                sequence.hold(held, turn.hold_s);
                sequence.order(helm_of(turn.to.sign()), Until::Seconds(turn.turn_s));
                sequence.order(helm_of(0.0), Until::End);
            }
            Standard::SpiralTest(spiral) => {
                sequence.ending = Ending::Last;
                for part in steps(spiral.steps, true) {
                    sequence.order(helm_of(spiral.to.sign() * part), Until::Seconds(spiral.dwell_s));
                }
            }
            Standard::ReverseSpiral(spiral) => {
                (sequence.sensors, sequence.ending) = (spiral.sensors, Ending::Last);
                for part in steps(spiral.steps, false) {
                    let rate = spiral.to.sign() * part * spiral.yaw_rate_rad_s;
                    sequence.order(Act::Turn(rate), Until::Seconds(spiral.dwell_s));
                }
                let authority = helm.iter().zip(slopes).map(|(h, slope)| h * slope[2]).sum();
                let (amidships, gains) = (held.to_vec(), Gains::of(decay));
                sequence.turning = Some(Turning { amidships, helm, gains, authority });
            }
            Standard::Stop(stop) => {
                sequence.hold(held, stop.hold_s);
                sequence.ending = Ending::Last;
                sequence.order(Act::Set(helm), Until::Speed(stop.end_m_s()));
                sequence.order(Act::Set(vec![0.0; held.len()]), Until::End);
            }
        }
        Self(Arc::new(sequence))
    }

    /// All settings of inputs that are ordered at some time, and the greatest helm to either side.
    pub fn extremes(&self) -> impl Iterator<Item = Vec<f64>> {
        let set = self.0.orders.iter().filter_map(|order| match &order.act {
            Act::Set(inputs) => Some(inputs.clone()),
            Act::Turn(_) => None,
        });
        let turning = self.0.turning.iter().flat_map(|turning| [1.0, -1.0].map(|part| turning.inputs(part)));
        set.chain(turning)
    }
}

impl Sequence {
    fn order(&mut self, act: Act, until: Until) {
        self.orders.push(Order { act, until });
    }

    fn hold(&mut self, inputs: &[f64], seconds: f64) {
        if seconds > 0.0 {
            self.order(Act::Set(inputs.to_vec()), Until::Seconds(seconds));
            self.course_at = 1;
        }
    }
}

impl Turning {
    fn inputs(&self, part: f64) -> Vec<f64> {
        self.amidships.iter().zip(&self.helm).map(|(u, h)| u + part * h).collect()
    }
}

/// By what part of its range the most helm may be beyond the stop, since the helm of the approach is not quite amidships.
const BEYOND_STOP: f64 = 0.05;

/// An input that is a little beyond the end of its range, at that end; others are as they are.
fn at_stop([low, high]: [f64; 2], input: f64) -> f64 {
    let stop = input.clamp(low, high);
    if (input - stop).abs() <= BEYOND_STOP * (high - low) { stop } else { input }
}

/// `settings` as a row of inputs; inputs that follow others do so here, too.
pub(crate) fn changes(settings: &Settings, vessel: &Vessel) -> Vec<f64> {
    let inputs = vessel.model.input_variables();
    let mut row: Vec<f64> =
        inputs.iter().map(|input| settings.get(&input.name).copied().unwrap_or(0.0)).collect();
    for (i, coupling) in vessel.couplings.iter().enumerate() {
        if let Some((leader, factor)) = coupling {
            row[i] = factor * row[*leader];
        }
    }
    row
}

/// A standard maneuver as a bridge orders it: angles in degrees, other inputs in their units.
fn spoken(standard: Standard, vessel: &Vessel) -> Spoken {
    // To a tenth.
    let degrees = |rad: f64| format!("{}", (10.0 * rad.to_degrees()).round() / 10.0);
    let (settings, inputs) = (standard.settings().1, vessel.model.input_variables());
    let of = |(name, value): (&String, &f64)| match inputs.iter().find(|input| input.name == *name) {
        Some(input) if input.unit == "rad" => format!("{}°", degrees(*value)),
        Some(input) => format!("{value} {}", input.unit),
        None => value.to_string(),
    };
    let all: Vec<String> = match settings.len() {
        1 => settings.iter().map(of).collect(),
        _ => settings.iter().map(|one| format!("{} {}", one.0, of(one))).collect(),
    };
    let helm = all.join(", ");
    let (what, has_side, how) = match standard {
        Standard::ZigZagTest(test) => {
            let heading = degrees(test.heading_rad);
            let first = helm.strip_suffix('°').map_or_else(String::new, |helm| format!("{helm}/"));
            let how = format!("order {helm}, reverse at {heading}° off");
            (format!("zig-zag {first}{heading}"), true, how)
        }
        Standard::TurningCircle(turn) => {
            let how = format!("order {helm}, hold it until {}° off", degrees(turn.turn_rad));
            ("turning circle".to_owned(), true, how)
        }
        Standard::PullOut(turn) => {
            let how = format!("order {helm} for {} s, then amidships, from", turn.turn_s);
            ("pull-out".to_owned(), true, how)
        }
        Standard::SpiralTest(spiral) => {
            let how = format!("{helm} in {} steps of {} s, from", spiral.steps, spiral.dwell_s);
            ("spiral".to_owned(), true, how)
        }
        Standard::ReverseSpiral(spiral) => {
            let rate = degrees(60.0 * spiral.yaw_rate_rad_s);
            let how = format!("{rate}°/min in {} steps of {} s, from", spiral.steps, spiral.dwell_s);
            ("reverse spiral".to_owned(), true, how)
        }
        Standard::Stop(_) if helm.is_empty() => {
            ("stop".to_owned(), false, "all engines stopped, from".to_owned())
        }
        Standard::Stop(_) => ("crash stop".to_owned(), false, format!("order {helm}, from")),
    };
    Spoken { what, has_side, how }
}

impl Program for Orders {
    fn spoken(&self) -> Option<&Spoken> {
        Some(&self.0.spoken)
    }

    fn begin(&self) -> Box<dyn Command> {
        Box::new(Helmsman {
            program: Arc::clone(&self.0),
            now: 0,
            since_s: 0.0,
            due_s: None,
            sample: 0,
            course: (self.0.course_at == 0).then_some(0.0),
            heading: 0.0,
            turned: 0.0,
            is_round: false,
            speed: None,
            part: 0.0,
            turning: Loop::default(),
            ends: None,
        })
    }
}

/// Orders while they are carried out.
struct Helmsman {
    program: Arc<Sequence>,
    /// The present order and when it began \[s\].
    now: usize,
    since_s: f64,
    /// When the next one is executed, once that is known \[s\].
    due_s: Option<f64>,
    sample: usize,
    /// Heading of the approach \[rad\]; `None` before its end.
    course: Option<f64>,
    /// Integral of the logged yaw rate \[rad\].
    heading: f64,
    /// Change of heading after the last sample, as expected at its beginning \[rad\].
    turned: f64,
    /// Whether every order has been given once.
    is_round: bool,
    /// Speed at the sample before \[m/s\].
    speed: Option<f64>,
    /// Part of the greatest helm that holds a yaw rate.
    part: f64,
    turning: Loop,
    /// Inputs at the beginning and the end of the last sample, where they changed within it.
    ends: Option<[Vec<f64>; 2]>,
}

/// What is seen at the beginning of a sample, and what is expected within it.
#[derive(Clone, Copy)]
struct Look {
    /// Its time and length \[s\].
    at_s: f64,
    length_s: f64,
    heading: f64,
    yaw_rate: f64,
    speed: f64,
    /// The change of the speed in a sample.
    gain: f64,
}

impl Look {
    /// When the condition is met within the sample, after `since_s`: heading and speed change evenly.
    fn met(&self, until: Until, since_s: f64, course: f64) -> Option<f64> {
        let (left, change) = match until {
            Until::Seconds(seconds) => return Some(since_s + seconds),
            Until::End => return None,
            Until::Heading(to) => {
                let side = to.signum();
                (side * (to - (self.heading - course)), side * self.yaw_rate * self.length_s)
            }
            Until::Speed(most) => (self.speed - most, -self.gain),
        };
        match left {
            _ if left <= 0.0 => Some(self.at_s.max(since_s)),
            _ if left < change => Some((self.at_s + left / change * self.length_s).max(since_s)),
            _ => None,
        }
    }
}

impl Helmsman {
    /// When the present order ends, as far as that is known in this sample.
    fn end_s(&mut self, look: &Look) -> f64 {
        if let Some(due_s) = self.due_s {
            return due_s;
        }
        let until = self.program.orders[self.now].until;
        let Some(met_s) = look.met(until, self.since_s, self.course.unwrap_or(0.0)) else {
            return f64::INFINITY;
        };
        if matches!(until, Until::Seconds(_)) {
            return met_s;
        }
        // Rounding of times of samples must not cost a look.
        let seen = |every: f64| (met_s / every - 1e-9).ceil() * every;
        let due_s = self.program.every_s.map_or(met_s, seen) + self.program.delay_s;
        self.due_s = Some(due_s);
        due_s
    }

    /// The inputs of the present order.
    fn present(&self, width: usize) -> Vec<f64> {
        let mut inputs = vec![0.0; width];
        self.add(1.0, &mut inputs);
        inputs
    }

    /// Adds `weight` times the inputs of the present order.
    fn add(&self, weight: f64, inputs: &mut [f64]) {
        match (&self.program.orders[self.now].act, &self.program.turning) {
            (Act::Set(set), _) => inputs.iter_mut().zip(set).for_each(|(to, u)| *to += weight * u),
            (Act::Turn(_), Some(turning)) => {
                let rows = turning.amidships.iter().zip(&turning.helm);
                inputs.iter_mut().zip(rows).for_each(|(to, (u, h))| *to += weight * (u + self.part * h));
            }
            (Act::Turn(_), None) => {}
        }
    }

    /// The helm for the yaw rate of the present order.
    fn turn(&mut self, yaw_rate: f64) {
        if let (Act::Turn(rate), Some(turning)) = (&self.program.orders[self.now].act, &self.program.turning)
        {
            let wanted = self.turning.wanted(&turning.gains, [0.0, 0.0, rate - yaw_rate]);
            let part = wanted[2] / turning.authority;
            self.part = part.clamp(-1.0, 1.0);
            if part == self.part {
                self.turning.learn(&turning.gains, [0.0, 0.0, rate - yaw_rate]);
            }
        }
    }
}

impl Command for Helmsman {
    /// An order that is executed within a sample has its part of the sample's inputs.
    fn command(&mut self, seen: &Seen, inputs: &mut [f64]) {
        let program = Arc::clone(&self.program);
        let length_s = 1.0 / program.rate_hz;
        let ([speed, _, yaw_rate], heading) = match program.sensors {
            Sensors::Own => (seen.own, seen.pose.psi),
            Sensors::Logged => (seen.state, self.heading),
        };
        let gain = self.speed.map_or(0.0, |before| speed - before);
        let at_s = self.sample as f64 * length_s;
        let look = Look { at_s, length_s, heading, yaw_rate, speed, gain };
        inputs.fill(0.0);
        self.turn(yaw_rate);
        self.ends = None;
        let (mut from, mut first) = (0.0, None);
        // Each order ends once in a sample at most: a yaw rate beyond all bounds would end them for ever.
        let mut left = program.orders.len();
        loop {
            let to = ((self.end_s(&look) - at_s) / length_s).clamp(from, 1.0);
            if to > from {
                self.add(to - from, inputs);
                if to < 1.0 {
                    first.get_or_insert_with(|| self.present(inputs.len()));
                }
            }
            let next = if self.now + 1 < program.orders.len() { Some(self.now + 1) } else { program.again };
            let Some(next) = next.filter(|_| to < 1.0 && left > 0) else {
                if to < 1.0 {
                    self.add(1.0 - to, inputs);
                }
                break;
            };
            left -= 1;
            self.is_round |= next <= self.now;
            (self.now, self.since_s, self.due_s, from) = (next, at_s + to * length_s, None, to);
            if self.course.is_none() && next == program.course_at {
                self.course = Some(heading + yaw_rate * to * length_s);
            }
            self.turn(yaw_rate);
        }
        self.ends = first.map(|first| [first, self.present(inputs.len())]);
        self.sample += 1;
        self.speed = Some(speed);
        self.turned = heading + yaw_rate * length_s - self.course.unwrap_or(heading);
        self.heading += length_s * yaw_rate;
    }

    fn ends(&self) -> Option<[&[f64]; 2]> {
        self.ends.as_ref().map(|ends| ends.each_ref().map(Vec::as_slice))
    }

    fn progress(&self) -> Progress {
        let program = &self.program;
        let is_last = self.now + 1 == program.orders.len();
        let is_given = if program.again.is_some() { self.is_round } else { is_last };
        let until = program.orders[self.now].until;
        match program.ending {
            _ if !is_given => Progress::Waiting(until.what()),
            Ending::Open => Progress::Open,
            Ending::Turned(turn) if self.turned.abs() < turn => Progress::Waiting("change of heading"),
            Ending::Turned(_) => Progress::Done,
            Ending::Last => match until {
                Until::Seconds(seconds) if self.sample as f64 / program.rate_hz < self.since_s + seconds => {
                    Progress::Waiting(until.what())
                }
                _ => Progress::Done,
            },
        }
    }
}
