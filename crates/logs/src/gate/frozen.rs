//! Sensors that repeat a value while the ship moves.

use super::limit::{pair, without};
use crate::{Channels, Omissions, Reason, Series};

/// Velocities; where one stands still, the others show whether the ship did.
const VELOCITIES: [&str; 5] = ["y_u", "y_v", "y_r", "v_x", "v_y"];

/// A turn beyond which the heading was not constant \[rad\].
const TURNED: f64 = 0.035;

/// A speed beyond which the position was not constant \[m/s\].
const MOVED_M_S: f64 = 0.1;

/// Leaves out of `channels` the values that a frozen sensor repeats, and counts them. Values that are
/// constant because the ship is at rest, or moves steadily, stay.
pub(crate) fn keep_alive(channels: &mut Channels, omitted: &mut Omissions) {
    let names = ["psi"].into_iter().chain(VELOCITIES);
    let mut frozen: Vec<(&str, Vec<Hold>)> = names
        .filter_map(|name| {
            let series = channels.get(name)?;
            let holds = Holds::of(series, None, |[from, _], [to, _]| (to - from).abs());
            Some((name, holds.long().filter(|hold| is_frozen(name, hold, &holds, channels)).collect()))
        })
        .collect();
    if let Some((names, metres)) = pair(channels)
        && let [Some(first), Some(second)] = names.map(|name| channels.get(name))
    {
        let holds = Holds::of(first, Some(second), metres);
        let stuck: Vec<Hold> = holds.long().filter(|hold| is_stuck(hold, &holds, channels)).collect();
        frozen.extend(names.map(|name| (name, stuck.clone())));
    }
    for (name, holds) in frozen.iter().filter(|(_, holds)| !holds.is_empty()) {
        let Some(series) = channels.get_mut(*name) else { continue };
        let mut count = 0;
        *series = without(
            series,
            holds,
            |hold| hold.times[1],
            |hold, time| {
                let repeats = hold.times[0] < time;
                count += u64::from(repeats);
                repeats
            },
        );
        omitted.add(name, Reason::Frozen, count);
    }
}

/// Whether the position stood still while the ship moved: by its speed, or by how abruptly the position stopped or resumed.
fn is_stuck(hold: &Hold, holds: &Holds, channels: &Channels) -> bool {
    let speed = ["y_u", "v_x"].iter().zip(["y_v", "v_y"]).find_map(|(first, second)| {
        let [first, second] = [channels.get(*first)?, channels.get(second)?];
        mean_speed(first, second, hold)
    });
    match speed {
        Some(speed) => {
            let way = speed * hold.duration_s();
            speed >= MOVED_M_S && way >= 5.0 * holds.step && hold.is_abrupt(0.25 * holds.step)
        }
        None => hold.step_out >= 3.0 * holds.step || hold.step_in >= 0.5 * holds.step,
    }
}

fn mean_speed(first: &Series, second: &Series, hold: &Hold) -> Option<f64> {
    let times = || hold.moments();
    let speeds = first.at(times()).zip(second.at(times())).map(|(a, b)| libm::hypot(a, b));
    let (sum, count) =
        speeds.filter(|speed| speed.is_finite()).fold((0.0, 0), |(sum, n), speed| (sum + speed, n + 1));
    (count > 0).then(|| sum / f64::from(count))
}

fn is_frozen(name: &str, hold: &Hold, holds: &Holds, channels: &Channels) -> bool {
    let step = holds.step;
    match name {
        "psi" => match channels.get("y_r") {
            Some(rate) => is_caught_up(hold, step, rate),
            None => hold.step_out >= 3.0 * step,
        },
        _ => {
            let abrupt = match hold.value {
                // Sway and yaw rate are exactly zero on a simulated straight course, or below the resolution.
                0.0 => hold.step_in > 3.0 * step && (hold.step_out.is_nan() || hold.step_out > 3.0 * step),
                _ if hold.is_cut() => hold.is_abrupt(0.05 * step),
                _ => hold.is_abrupt(0.25 * step),
            };
            let turned = || name == "y_r" && channels.get("psi").is_some_and(|psi| turns_unevenly(hold, psi));
            // Noise that stops all at once: a motion that becomes steady, in a simulation say, gets there by
            // ever smaller steps.
            let stopped = || {
                hold.value != 0.0
                    && holds.usual == 1
                    && hold.step_in > 0.25 * step
                    && all_stop(name, hold, channels)
            };
            abrupt && (turned() || others_vary(name, hold, channels) || stopped())
        }
    }
}

/// Whether the heading, which stood still, resumes where the yaw rate says that it must be.
fn is_caught_up(hold: &Hold, step: f64, rate: &Series) -> bool {
    let moments = || hold.moments();
    let (mut turned, mut most, mut before) = (0.0_f64, 0.0_f64, hold.times[0]);
    for (time, rate) in moments().zip(rate.at(moments())).filter(|(_, rate)| rate.is_finite()) {
        turned += rate * (time - before);
        (most, before) = (most.max(turned.abs()), time);
    }
    let missed = (hold.step_out - turned.abs()).abs();
    let is_missed = missed > 0.5 * turned.abs() + 0.5 * TURNED + step;
    most >= TURNED.max(3.0 * step) && !is_missed
}

/// Whether the heading turned differently from the yaw rate that stood still.
fn turns_unevenly(hold: &Hold, psi: &Series) -> bool {
    let moments = || hold.moments();
    let known = || moments().zip(psi.at(moments())).filter(|(_, psi)| psi.is_finite());
    let Some((start, first)) = known().next() else { return false };
    // The sense of either is unknown here.
    [1.0, -1.0].into_iter().all(|sign| {
        known().any(|(time, psi)| (psi - first - sign * hold.value * (time - start)).abs() >= TURNED)
    })
}

/// Whether another velocity varied in the meantime as it does elsewhere.
fn others_vary(name: &str, hold: &Hold, channels: &Channels) -> bool {
    others(name, hold, channels).any(|[(inside, rows), (all, all_rows)]| {
        rows > 0 && inside / f64::from(rows) > 0.25 * all / f64::from(all_rows)
    })
}

/// Rows over which all velocities may be constant by chance.
const TOGETHER: u32 = 20;

/// Whether there are other velocities and all of them stood still in the meantime.
fn all_stop(name: &str, hold: &Hold, channels: &Channels) -> bool {
    let mut others = others(name, hold, channels).peekable();
    others.peek().is_some() && others.all(|[(inside, rows), _]| inside == 0.0 && rows >= TOGETHER)
}

/// For every other velocity, sum and number of its steps, during a hold and overall.
fn others<'a>(
    name: &'a str,
    hold: &'a Hold,
    channels: &'a Channels,
) -> impl Iterator<Item = [(f64, u32); 2]> + 'a {
    VELOCITIES.into_iter().filter(move |other| *other != name).filter_map(move |other| {
        let series = channels.get(other)?;
        let (mut inside, mut all, mut before) = ((0.0, 0_u32), (0.0, 0_u32), f64::NAN);
        for (time, value) in series.t.iter().zip(series.values.iter()) {
            let step = (value - before).abs();
            before = value;
            if step.is_finite() {
                all = (all.0 + step, all.1 + 1);
                if time > hold.times[0] && time <= hold.times[1] {
                    inside = (inside.0 + step, inside.1 + 1);
                }
            }
        }
        Some([inside, all])
    })
}

/// Equal values in a row that may occur by chance, on a channel that hardly ever repeats one.
const ROWS: usize = 5;

/// Seconds that they may take.
const SHORT_S: f64 = 3.0;

/// Hold lengths that are counted individually.
const LENGTHS: usize = 1024;

/// Consecutive rows with one value.
#[derive(Clone, Debug, PartialEq)]
struct Hold {
    /// The value; for a position the first of its two coordinates.
    pub(super) value: f64,
    /// The first and the last time \[s\].
    pub(super) times: [f64; 2],
    /// Modulus of the steps to it and from it; NaN where there is none, or a gap.
    step_in: f64,
    step_out: f64,
    rows: usize,
}

/// All potentially long holds of a channel.
struct Holds {
    candidates: Vec<Hold>,
    /// Length that nine tenths of all holds do not exceed, most of them a single row.
    usual: usize,
    /// Mean modulus of the steps between holds.
    pub(super) step: f64,
}

/// Counts during a pass over a channel.
struct Counting {
    candidates: Vec<Hold>,
    lengths: Vec<u64>,
    steps: (f64, u64),
}

impl Hold {
    fn duration_s(&self) -> f64 {
        self.times[1] - self.times[0]
    }

    /// Whether it begins or ends by a step of more than `step`.
    fn is_abrupt(&self, step: f64) -> bool {
        self.step_in > step || self.step_out > step
    }

    /// Whether it lasts from the first known row, or until the last.
    fn is_cut(&self) -> bool {
        self.step_in.is_nan() || self.step_out.is_nan()
    }

    /// Times within it, one per row up to a limit.
    fn moments(&self) -> impl Iterator<Item = f64> + use<> {
        const MOST: usize = 1000;
        let ([from, to], steps) = (self.times, self.rows.clamp(2, MOST) - 1);
        (0..=steps).map(move |i| from + (to - from) * i as f64 / steps as f64)
    }
}

impl Holds {
    /// The holds of `first`, or of a position whose other coordinate is `second`; `step` is the distance between two values.
    pub(super) fn of(
        first: &Series,
        second: Option<&Series>,
        step: impl Fn([f64; 2], [f64; 2]) -> f64,
    ) -> Self {
        let mut counting = Counting { candidates: Vec::new(), lengths: vec![0; LENGTHS], steps: (0.0, 0) };
        let mut seconds = second.map(|second| second.at(first.t.iter()));
        let (mut hold, mut value): (Option<Hold>, _) = (None, [f64::NAN; 2]);
        for (time, first_value) in first.t.iter().zip(first.values.iter()) {
            let next =
                [first_value, seconds.as_mut().map_or(0.0, |seconds| seconds.next().unwrap_or(f64::NAN))];
            let gap = hold.as_ref().is_some_and(|hold| time - hold.times[1] > first.max_gap_s);
            match &mut hold {
                Some(hold) if !gap && next == value => (hold.times[1], hold.rows) = (time, hold.rows + 1),
                _ => {
                    let change = if gap { f64::NAN } else { step(value, next) };
                    if let Some(hold) = hold.take() {
                        counting.close(Hold { step_out: change, ..hold });
                    }
                    let begun = Hold {
                        value: first_value,
                        times: [time; 2],
                        step_in: change,
                        step_out: f64::NAN,
                        rows: 1,
                    };
                    (hold, value) = (Some(begun), next);
                }
            }
        }
        hold.into_iter().for_each(|hold| counting.close(hold));
        counting.done()
    }

    /// Those that are far longer than the channel's usual ones.
    fn long(&self) -> impl Iterator<Item = Hold> {
        self.candidates.iter().filter(|hold| hold.rows >= ROWS * self.usual).cloned()
    }
}

impl Counting {
    fn close(&mut self, hold: Hold) {
        self.lengths[hold.rows.min(LENGTHS) - 1] += 1;
        if hold.step_out > 0.0 {
            self.steps = (self.steps.0 + hold.step_out, self.steps.1 + 1);
        }
        if hold.rows >= ROWS && hold.duration_s() >= SHORT_S {
            self.candidates.push(hold);
        }
    }

    fn done(self) -> Holds {
        let all: u64 = self.lengths.iter().sum();
        let mut so_far = 0;
        let usual = self.lengths.iter().position(|count| {
            so_far += count;
            so_far * 10 >= all * 9
        });
        let step = self.steps.0 / self.steps.1.max(1) as f64;
        Holds { candidates: self.candidates, usual: usual.map_or(1, |place| place + 1), step }
    }
}
