//! Which columns are heading, yaw rate, speeds and position: increments of some are integrals of others.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::Range;

use numerics::dot;

use super::table::{LoggedTable, STEPS, Sums, extent, increments, scatter};

/// Units that are tried, with their sizes.
const ANGLES: [(&str, f64); 2] = [("rad", 1.0), ("deg", PI / 180.0)];
const RATES: [(&str, f64); 3] = [("rad/s", 1.0), ("deg/s", PI / 180.0), ("deg/min", PI / 10_800.0)];
const SPEEDS: [(&str, f64); 4] = [("m/s", 1.0), ("kn", 1852.0 / 3600.0), ("km/h", 1.0 / 3.6), ("cm/s", 0.01)];
/// Metres in a degree of latitude.
const DEGREE_M: f64 = 111_200.0;

/// A jump of a wrapped angle, and the range of one, as parts of a turn.
const JUMP: [f64; 2] = [0.8, 1.02];
const RANGE: f64 = 1.03;
/// How far the slope of a rate, and the gain of a speed, may be off its unit.
const RATE_OFF: f64 = 0.12;
const GAIN_OFF: f64 = 0.15;
/// Least share of a rate, and of a position, that is explained.
const RATED: f64 = 0.5;
const PLACED: f64 = 0.5;
/// How far a position may lie off an axis, and two off a right angle.
const OFF_AXIS: f64 = 0.35;
const OFF_RIGHT: f64 = 0.25;
/// Sway counts if less than this share of the residual is left, and if it is measured as surge is but for this.
const WITH_SWAY: f64 = 0.75;
const SWAY_OFF: f64 = 0.2;
/// Earth-fixed speeds explain positions to more than this, and point within this angle of the heading \[rad\].
const EARTH: f64 = 0.98;
const POINTS: f64 = 0.35;
/// Scores of what was not found, and of a gain that is off by more than a share.
const NO_RATE: f64 = 0.15;
const GAIN_CLEAR: (f64, f64) = (0.06, 0.05);
/// The least turn that tells angles from other columns \[rad\].
pub(super) const TURN: f64 = 0.2;
/// The share of one position that may be left unexplained, where the other moves more.
const ALONE: f64 = 0.3;
/// Scores that say nothing.
const POOR: f64 = 0.4;
/// Hypotheses that are tried with every sway.
const KEPT: usize = 40;

/// What positions are measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ground {
    /// Metres.
    Metres,
    /// Degrees, and angles count clockwise from north.
    Compass,
    /// Degrees, and angles count counter-clockwise from east.
    East,
}

/// What measures speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speeds {
    /// Surge and perhaps sway, each with its sign.
    Ship([f64; 2], usize, Option<usize>),
    /// Speeds along the two positions.
    Earth([usize; 2]),
}

/// A column with its unit, and its sign against the angle's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateChoice {
    /// The column.
    pub column: usize,
    /// Its unit.
    pub unit: &'static str,
    /// 1 or −1.
    pub sign: f64,
    /// Share of the angle's increments that it explains.
    pub share: f64,
}

/// Columns that may be those of one motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// The heading, or the course.
    pub angle: (usize, &'static str),
    /// The rate of it.
    pub rate: Option<RateChoice>,
    /// The speeds and their unit.
    pub speeds: (Speeds, &'static str),
    /// The position along the zero of the angle and across it, with signs.
    pub position: [(usize, f64); 2],
    /// What these are measured in.
    pub ground: Ground,
    /// The share of the positions' increments that is not explained.
    pub unexplained: f64,
    /// That of the one of them that is explained worse.
    alone: f64,
    /// Whether the speed counts astern.
    pub is_astern: bool,
    /// The smaller the better.
    pub score: f64,
    /// The turn in a recording \[rad\].
    pub turn: f64,
}

struct Angle {
    column: usize,
    unit: &'static str,
    values: Vec<f64>,
    cos: Vec<f64>,
    sin: Vec<f64>,
    turn: f64,
    rates: Vec<RateChoice>,
}

/// What is known of units: whether a column may be in one.
pub(super) type Fits<'a> = &'a dyn Fn(usize, &str) -> bool;

pub(super) struct Motions<'a> {
    table: &'a LoggedTable,
    time: &'a [f64],
    /// Columns that move.
    free: &'a [usize],
    fits: Fits<'a>,
    spans: Vec<Vec<[usize; 2]>>,
    /// Increments of the columns for each step, and their squares about zero and about their mean.
    steps: Vec<Vec<Vec<f64>>>,
    squares: Vec<Vec<[f64; 2]>>,
}

impl<'a> Motions<'a> {
    pub(super) fn new(table: &'a LoggedTable, time: &'a [f64], free: &'a [usize], fits: Fits<'a>) -> Self {
        let all = STEPS.map(|step| table.spans(step));
        let enough = |spans: &Vec<[usize; 2]>| spans.len() >= 8;
        let spans: Vec<Vec<[usize; 2]>> = all.into_iter().filter(enough).collect();
        let of = |spans: &Vec<[usize; 2]>| table.columns.iter().map(|c| increments(c, spans)).collect();
        let steps: Vec<Vec<Vec<f64>>> = spans.iter().map(of).collect();
        let squares =
            steps.iter().map(|all| all.iter().map(|entry| [dot(entry, entry), scatter(entry)]).collect());
        Self { table, time, free, fits, spans, squares: squares.collect(), steps }
    }

    /// All that are possible, the best first.
    pub(super) fn hypotheses(&self) -> Vec<Hypothesis> {
        if self.spans.len() < 2 {
            return Vec::new();
        }
        let angles: Vec<Angle> = self.free.iter().flat_map(|column| self.angles(*column)).collect();
        let mut plain: Vec<Hypothesis> = angles.iter().flat_map(|angle| self.with_speed(angle)).collect();
        plain.sort_by(|a, b| a.score.total_cmp(&b.score));
        plain.truncate(KEPT);
        let angle_of = |known: &Hypothesis| {
            angles.iter().find(|angle| (angle.column, angle.unit) == known.angle).into_iter().next()
        };
        let swaying: Vec<Hypothesis> = plain
            .iter()
            .filter_map(|known| Some((known, angle_of(known)?)))
            .flat_map(|(known, angle)| self.with_sway(known, angle))
            .collect();
        let mut all: Vec<Hypothesis> = plain.into_iter().chain(swaying).collect();
        all.extend(self.earth_fixed(&angles));
        // Each with the second best rate, too.
        let others: Vec<Hypothesis> = all
            .iter()
            .filter_map(|known| {
                let rate = *angle_of(known)?.rates.get(1)?;
                let score = known.score - rate_score(known.rate) + rate_score(Some(rate));
                Some(Hypothesis { rate: Some(rate), score, ..known.clone() })
            })
            .collect();
        all.extend(others);
        all.retain(|known| known.score < POOR && known.alone < ALONE);
        all.sort_by(|a, b| a.score.total_cmp(&b.score));
        all
    }

    /// `column` as an angle, in each unit that it may be in.
    fn angles(&self, column: usize) -> Vec<Angle> {
        let values = &self.table.columns[column];
        let [least, most] = extent(values);
        let unit_is_known = ANGLES.iter().any(|(unit, _)| !(self.fits)(column, unit));
        let wrapped =
            ANGLES.into_iter().filter(|(_, size)| self.is_wrapped(values, TAU / size, most - least));
        let wrapped: Vec<(&str, f64)> = wrapped.collect();
        let units = if wrapped.is_empty() || unit_is_known { ANGLES.to_vec() } else { wrapped };
        let units = units.into_iter().filter(|(unit, _)| (self.fits)(column, unit));
        units.filter_map(|(unit, size)| self.angle(column, unit, size)).collect()
    }

    fn is_wrapped(&self, values: &[f64], period: f64, range: f64) -> bool {
        let mut jumps = self.pairs().map(|[a, b]| (values[b] - values[a]).abs() / period);
        range <= RANGE * period && jumps.any(|jump| (JUMP[0]..=JUMP[1]).contains(&jump))
    }

    /// Rows one after another.
    fn pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        self.table.recordings.iter().flat_map(|rows| (rows.start + 1..rows.end).map(|row| [row - 1, row]))
    }

    fn angle(&self, column: usize, unit: &'static str, size: f64) -> Option<Angle> {
        let entry = &self.table.columns[column];
        let [least, most] = extent(entry);
        let is_wrapped = self.is_wrapped(entry, TAU / size, most - least);
        let mut values: Vec<f64> = entry.iter().map(|value| size * value).collect();
        if is_wrapped {
            for [before, row] in self.pairs() {
                let step = values[row] - values[before];
                values[row] -= TAU * (step / TAU).round();
            }
        }
        let turns = self.table.recordings.iter().map(|rows| extent(&values[rows.clone()]));
        let turn = turns.map(|[low, high]| high - low).fold(0.0, f64::max);
        if turn < TURN {
            return None;
        }
        let (sin, cos) = values.iter().map(|angle| libm::sincos(*angle)).unzip();
        let rates = self.rates(column, &values);
        Some(Angle { column, unit, values, cos, sin, turn, rates })
    }

    /// The two best rates of an angle.
    fn rates(&self, angle: usize, values: &[f64]) -> Vec<RateChoice> {
        let mut rates: Vec<RateChoice> = Vec::new();
        for column in self.free.iter().copied().filter(|column| *column != angle) {
            let entry = &self.table.columns[column];
            let integral = self.table.integral(|row| entry[row], self.time);
            let best = self.spans.iter().filter_map(|spans| {
                let [angle, integral] = [values, &integral].map(|all| increments(all, spans));
                let lengths = increments(self.time, spans);
                let sums = Sums::of(&[&integral, &lengths], &angle);
                let solution = sums.solution()?;
                let share = 1.0 - sums.residual(&solution) / scatter(&angle);
                let is = |(unit, size): &(&str, f64)| {
                    (self.fits)(column, unit) && (solution[0].abs() / size - 1.0).abs() < RATE_OFF
                };
                let (unit, _) = RATES.into_iter().find(is)?;
                Some(RateChoice { column, unit, sign: solution[0].signum(), share })
            });
            rates.extend(best.filter(|rate| rate.share > RATED).max_by(|a, b| a.share.total_cmp(&b.share)));
        }
        rates.sort_by(|a, b| b.share.total_cmp(&a.share));
        rates.truncate(2);
        rates
    }

    /// Hypotheses with each column as the speed, without sway.
    fn with_speed(&self, angle: &Angle) -> Vec<Hypothesis> {
        let mut all = Vec::new();
        let is_fit = |column: &&usize| SPEEDS.iter().any(|(unit, _)| (self.fits)(**column, unit));
        for speed in self.free.iter().copied().filter(|s| *s != angle.column && is_fit(&s)) {
            let entry = &self.table.columns[speed];
            let along = self.table.integral(|row| entry[row] * angle.cos[row], self.time);
            let across = self.table.integral(|row| entry[row] * angle.sin[row], self.time);
            let [cosines, sines] = self.places([angle.column, speed], [&along, &across]);
            let pairs = cosines.iter().flat_map(|c| sines.iter().map(move |s| (*c, *s)));
            for ((c, [cc, cs]), (s, [sc, ss])) in pairs {
                let right = (cc * sc + cs * ss).abs() / (libm::hypot(cc, cs) * libm::hypot(sc, ss));
                if c == s || right > OFF_RIGHT {
                    continue;
                }
                let ahead = [cc, ss].map(|slope| slope * entry.iter().sum::<f64>() > 0.0);
                let position = [(c, cc.signum()), (s, ss.signum())];
                for (ground, metres) in self.grounds(position) {
                    // North and east are where they are.
                    if !ahead[0] && ground != Ground::Metres || !ahead[1] && ground == Ground::East {
                        continue;
                    }
                    let fit = self.explained(position, metres, &[[&along, &across]]);
                    let Some((unexplained, gains, alone)) = fit else { continue };
                    let Some((unit, off)) = self.speed_unit(speed, gains[0]) else { continue };
                    let signs = [1.0; 2];
                    all.push(self.hypothesis(
                        angle,
                        (Speeds::Ship(signs, speed, None), unit),
                        (position, ground),
                        [unexplained, alone],
                        off,
                    ));
                }
            }
        }
        all
    }

    /// The columns that go along the zero of an angle, and across it, with these integrals: each with its slopes, the best three.
    fn places(&self, used: [usize; 2], [along, across]: [&Vec<f64>; 2]) -> [Vec<(usize, [f64; 2])>; 2] {
        let mut axes: [Vec<(f64, usize, [f64; 2])>; 2] = [Vec::new(), Vec::new()];
        let most = self.spans.len();
        let usual: Vec<_> = [1, 2, 3]
            .into_iter()
            .filter(|at| *at < most)
            .map(|at| {
                let [a, b] = [along, across].map(|all| increments(all, &self.spans[at]));
                let products = [dot(&a, &a), dot(&a, &b), dot(&b, &b)];
                (at, a, b, products)
            })
            .collect();
        for column in self.free.iter().copied().filter(|column| !used.contains(column)) {
            let best = usual.iter().filter_map(|(at, a, b, [aa, ab, bb])| {
                let entry = &self.steps[*at][column];
                let (ya, yb, whole) = (dot(entry, a), dot(entry, b), aa * bb - ab * ab);
                if whole <= 1e-9 * aa * bb {
                    return None;
                }
                let slopes = [(bb * ya - ab * yb) / whole, (aa * yb - ab * ya) / whole];
                let [square, scatter] = self.squares[*at][column];
                Some((1.0 - (square - slopes[0] * ya - slopes[1] * yb) / scatter, slopes))
            });
            let Some((share, [c, s])) = best.max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
            let length = libm::hypot(c, s);
            if share > PLACED && s.abs() <= OFF_AXIS * length {
                axes[0].push((share, column, [c, s]));
            } else if share > PLACED && c.abs() <= OFF_AXIS * length {
                axes[1].push((share, column, [c, s]));
            }
        }
        axes.map(|mut axis| {
            axis.sort_by(|a, b| b.0.total_cmp(&a.0));
            axis.into_iter().take(3).map(|(_, column, slopes)| (column, slopes)).collect()
        })
    }

    /// What two positions may be measured in, with the metres of each unit.
    fn grounds(&self, position: [(usize, f64); 2]) -> Vec<(Ground, [f64; 2])> {
        let mut all = Vec::new();
        if position.iter().all(|(column, _)| (self.fits)(*column, "m")) {
            all.push((Ground::Metres, [1.0; 2]));
        }
        let extents = position.map(|(column, _)| extent(&self.table.columns[column]));
        let is_small = |at: usize, most: f64| {
            let [low, high] = extents[at];
            low.abs().max(high.abs()) <= most && high - low < 5.0 && (self.fits)(position[at].0, "deg")
        };
        let east = |at: usize| DEGREE_M * libm::cos((0.5 * (extents[at][0] + extents[at][1])).to_radians());
        if is_small(0, 89.0) && is_small(1, 360.0) {
            all.push((Ground::Compass, [DEGREE_M, east(0)]));
        }
        if is_small(0, 360.0) && is_small(1, 89.0) {
            all.push((Ground::East, [east(1), DEGREE_M]));
        }
        all
    }

    /// The share of the positions' increments that integrals do not explain, at the best step, the integrals' gains, and that share
    /// of the position that is explained worse.
    fn explained(
        &self,
        position: [(usize, f64); 2],
        metres: [f64; 2],
        integrals: &[[&Vec<f64>; 2]],
    ) -> Option<(f64, Vec<f64>, f64)> {
        let of = |at: usize| {
            let [x, y] = [0, 1].map(|i| {
                let (column, sign) = position[i];
                self.steps[at][column].iter().map(move |step| sign * metres[i] * step)
            });
            let target: Vec<f64> = x.chain(y).collect();
            let regressors: Vec<Vec<f64>> = integrals
                .iter()
                .map(|pair| pair.iter().flat_map(|all| increments(all, &self.spans[at])).collect())
                .collect();
            let all: Vec<&[f64]> = regressors.iter().map(Vec::as_slice).collect();
            let sums = Sums::of(&all, &target);
            let gains = sums.solution()?;
            let half = target.len() / 2;
            let of_axis = |rows: Range<usize>| {
                let parts: Vec<&[f64]> = all.iter().map(|entry| &entry[rows.clone()]).collect();
                let sums = Sums::of(&parts, &target[rows]);
                sums.residual(&gains) / sums.square()
            };
            let worse = of_axis(0..half).max(of_axis(half..target.len()));
            Some((sums.residual(&gains) / sums.square(), gains, worse))
        };
        (1..self.spans.len()).filter_map(of).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The unit that a gain of a speed is nearest to, and whether it is clearly off.
    fn speed_unit(&self, column: usize, gain: f64) -> Option<(&'static str, bool)> {
        let off = |size: f64| (gain.abs() / size - 1.0).abs();
        let fits = |(unit, size): &(&str, f64)| off(*size) < GAIN_OFF && (self.fits)(column, unit);
        SPEEDS.into_iter().find(fits).map(|(unit, size)| (unit, off(size) > GAIN_CLEAR.0))
    }

    fn hypothesis(
        &self,
        angle: &Angle,
        speeds: (Speeds, &'static str),
        (position, ground): ([(usize, f64); 2], Ground),
        [unexplained, alone]: [f64; 2],
        is_off: bool,
    ) -> Hypothesis {
        let used = match speeds.0 {
            Speeds::Ship(_, u, v) => [Some(u), v],
            Speeds::Earth([x, y]) => [Some(x), Some(y)],
        };
        let is_used = |column: usize| {
            used.contains(&Some(column)) || position.iter().any(|(entry, _)| *entry == column)
        };
        let rate = angle.rates.iter().copied().find(|rate| !is_used(rate.column));
        let score = unexplained + rate_score(rate) + if is_off { GAIN_CLEAR.1 } else { 0.0 };
        Hypothesis {
            angle: (angle.column, angle.unit),
            rate,
            speeds,
            position,
            ground,
            unexplained,
            alone,
            is_astern: match speeds.0 {
                Speeds::Ship(_, surge, _) => self.table.columns[surge].iter().sum::<f64>() < 0.0,
                Speeds::Earth(_) => false,
            },
            score,
            turn: angle.turn,
        }
    }

    /// `known` with each column as the sway that explains more.
    fn with_sway(&self, known: &Hypothesis, angle: &Angle) -> Vec<Hypothesis> {
        let (Speeds::Ship(_, surge, None), unit) = known.speeds else { return Vec::new() };
        let [x, y] = known.position.map(|(column, _)| column);
        let used = [angle.column, surge, x, y];
        let metres = self.grounds(known.position).into_iter().find(|(ground, ..)| *ground == known.ground);
        let Some((_, metres)) = metres else { return Vec::new() };
        let entry = &self.table.columns[surge];
        let along = self.table.integral(|row| entry[row] * angle.cos[row], self.time);
        let across = self.table.integral(|row| entry[row] * angle.sin[row], self.time);
        let rate = known.rate.map(|rate| rate.column);
        let mut all = Vec::new();
        for sway in self.free.iter().copied().filter(|column| !used.contains(column) && rate != Some(*column))
        {
            if !(self.fits)(sway, unit) {
                continue;
            }
            let entry = &self.table.columns[sway];
            let back = self.table.integral(|row| -entry[row] * angle.sin[row], self.time);
            let out = self.table.integral(|row| entry[row] * angle.cos[row], self.time);
            let fit = self.explained(known.position, metres, &[[&along, &across], [&back, &out]]);
            let Some((unexplained, gains, alone)) = fit else { continue };
            let (ratio, speed) = (gains[1] / gains[0], self.speed_unit(surge, gains[0]));
            let Some((unit, off)) = speed else { continue };
            if unexplained < WITH_SWAY * known.unexplained && (ratio.abs() - 1.0).abs() < SWAY_OFF {
                let speeds = (Speeds::Ship([1.0, ratio.signum()], surge, Some(sway)), unit);
                all.push(self.hypothesis(
                    angle,
                    speeds,
                    (known.position, known.ground),
                    [unexplained, alone],
                    off,
                ));
            }
        }
        all
    }

    /// Speeds along the axes of the positions, and angles that point where they do.
    fn earth_fixed(&self, angles: &[Angle]) -> Vec<Hypothesis> {
        // Position, speed, sign, metres, unit, and what is not explained.
        let mut pairs: Vec<(usize, usize, f64, &str, f64)> = Vec::new();
        for speed in self.free.iter().copied() {
            let entry = &self.table.columns[speed];
            let integral = self.table.integral(|row| entry[row], self.time);
            let steps: Vec<Vec<f64>> = self.spans.iter().map(|spans| increments(&integral, spans)).collect();
            for place in self.free.iter().copied().filter(|place| *place != speed && (self.fits)(*place, "m"))
            {
                let best = (1..self.spans.len()).filter_map(|at| {
                    let (x, y) = (&steps[at], &self.steps[at][place]);
                    let slope = dot(x, y) / dot(x, x);
                    let left = (dot(y, y) - slope * dot(x, y)) / scatter(y);
                    let (unit, is_off) = self.speed_unit(speed, slope)?;
                    (1.0 - left > EARTH && !is_off).then_some((place, speed, slope.signum(), unit, left))
                });
                pairs.extend(best.min_by(|a, b| a.4.total_cmp(&b.4)));
            }
        }
        let mut all = Vec::new();
        for (north, east) in pairs.iter().flat_map(|a| pairs.iter().map(move |b| (a, b))) {
            let apart = [north.0, north.1].iter().all(|column| *column != east.0 && *column != east.1);
            if !apart || north.3 != east.3 {
                continue;
            }
            for angle in
                angles.iter().filter(|angle| ![north.0, north.1, east.0, east.1].contains(&angle.column))
            {
                let [vx, vy] = [north, east].map(|entry| &self.table.columns[entry.1]);
                for sign in [1.0, -1.0] {
                    let off = off_course(angle, vx, vy, sign);
                    if off < POINTS && !angle.rates.is_empty() {
                        let position = [(north.0, north.2), (east.0, sign * east.2)];
                        let speeds = (Speeds::Earth([north.1, east.1]), north.3);
                        let unexplained = 0.5 * (north.4 + east.4) + 0.5 * off * off;
                        all.push(self.hypothesis(
                            angle,
                            speeds,
                            (position, Ground::Metres),
                            [unexplained; 2],
                            false,
                        ));
                    }
                }
            }
        }
        all
    }
}

fn rate_score(rate: Option<RateChoice>) -> f64 {
    rate.map_or(NO_RATE, |rate| (0.5 * (1.0 - rate.share)).min(NO_RATE))
}

/// The mean angle between where speeds point and `angle` \[rad\].
fn off_course(angle: &Angle, vx: &[f64], vy: &[f64], sign: f64) -> f64 {
    let speeds: Vec<f64> = vx.iter().zip(vy).map(|(x, y)| libm::hypot(*x, *y)).collect();
    let usual = 0.5 * speeds.iter().sum::<f64>() / speeds.len() as f64;
    let (mut sum, mut count) = (0.0, 0.0);
    for row in (0..speeds.len()).filter(|row| speeds[*row] > usual) {
        let off = libm::atan2(sign * vy[row], vx[row]) - angle.values[row];
        sum += (off - TAU * (off / TAU).round()).abs();
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { FRAC_PI_2 }
}
