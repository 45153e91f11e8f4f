use std::f64::consts::TAU;

use refusal::Invalid;
use ship::engine::Ship;

use crate::{Autopilot, Fixed, Phase, Used};

/// A sampled vessel: its parameters, an unknown current, and its initial offset from the node.
#[derive(Clone, Debug)]
pub struct SampledVessel {
    /// Its parameters; the autopilot uses the nominal ones.
    pub parameters: Vec<f64>,
    /// Unknown current along and across the first heading, to starboard \[m/s\].
    pub current_m_s: [f64; 2],
    /// Offset from the node along and across the first heading \[m\], and from the heading \[rad\].
    pub off: [f64; 3],
    /// Offset from the mode's u, and v and r \[m/s, m/s, rad/s\].
    pub motion: [f64; 3],
}

/// A vessel with its autopilot.
#[derive(Clone, Debug)]
pub(crate) struct Underway<'a> {
    pub ship: Ship<'a>,
    pub autopilot: Autopilot<'a>,
}

/// The nominal vessel and the sampled ones, at their current poses.
#[derive(Clone, Debug)]
pub(crate) struct Crew<'a> {
    pub nominal: Underway<'a>,
    pub others: Vec<Underway<'a>>,
    /// Order in which the sampled vessels are tried: the one that failed last is first, since it usually fails again.
    order: Vec<usize>,
}

/// A vessel that does not settle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Failed {
    /// The used parts of its tolerance.
    pub used: Used,
    /// Those of any vessel, as far as known.
    pub all: Used,
    /// Index among the sampled vessels; `None` for the nominal one.
    pub who: Option<usize>,
}

impl Failed {
    /// The nominal vessel, if it is lost.
    pub const LOST: Self = Self { used: Used::Lost, all: Used::Lost, who: None };

    /// The better one of two.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        if other.used.part() < self.used.part() { other } else { self }
    }
}

impl From<Used> for Failed {
    fn from(used: Used) -> Self {
        Self { used, all: used, who: None }
    }
}

impl<'a> Crew<'a> {
    /// The nominal vessel and the sampled ones.
    pub fn new(nominal: Underway<'a>, others: Vec<Underway<'a>>) -> Self {
        let order = (0..others.len()).collect();
        Self { nominal, others, order }
    }

    /// Applies `tried` to every sampled vessel, unless one fails; results are in their order.
    pub fn each<T>(&mut self, tried: impl Fn(Underway<'a>) -> Result<T, Used>) -> Result<Vec<T>, Failed> {
        let mut ends: Vec<Option<T>> = self.others.iter().map(|_| None).collect();
        for place in 0..self.order.len() {
            let index = self.order[place];
            match tried(self.others[index].clone()) {
                Ok(end) => ends[index] = Some(end),
                Err(used) => {
                    self.order[..=place].rotate_right(1);
                    return Err(Failed { who: Some(index), ..used.into() });
                }
            }
        }
        Ok(ends.into_iter().flatten().collect())
    }
}

impl Underway<'_> {
    /// Holds the vessel on its heading and at its speed for a while, or until its simulation diverges.
    pub fn hold(&mut self, heading_rad: f64, speed_m_s: f64, seconds: f64) -> Result<(), Invalid> {
        let Self { ship, autopilot } = self;
        let far = 10.0 * speed_m_s * seconds;
        let to = [far * libm::cos(heading_rad), far * libm::sin(heading_rad)];
        let phase = if speed_m_s > 0.0 {
            Phase::Line { to, heading_rad, from_m_s: speed_m_s, to_m_s: speed_m_s }
        } else {
            Phase::Hold { at: [0.0; 2], heading_rad }
        };
        let start = ship.pose;
        let mut seen = autopilot.see(Fixed::from(&*ship), true);
        let samples = (seconds / ship.sample_s()).ceil().min(HELD_SAMPLES) as usize;
        for _ in 0..samples {
            let wanted = autopilot.steer(&phase, [0.0; 2], start, &seen)?;
            let inputs = ship.reach(wanted).to_vec();
            if !ship.state.iter().all(|velocity| velocity.abs() <= ship::engine::DIVERGED) {
                break;
            }
            seen = autopilot.observe(seen, &inputs, Fixed::from(&*ship));
        }
        Ok(())
    }
}

/// Most samples for which a vessel is held before a leg.
const HELD_SAMPLES: f64 = 1000.0;

/// How far the parameters of a vessel may be from the nominal ones.
#[derive(Clone, Debug, PartialEq)]
pub enum Deviations {
    /// Each within this fraction of its nominal value.
    Box(f64),
    /// Jointly within so many standard errors of a covariance: the rows of its lower factor, times that number.
    Ellipsoid(Vec<Vec<f64>>),
    /// As another says, but no number beyond its bounds.
    Within {
        /// Bounds of every number, infinite at an open end.
        bounds: Vec<[f64; 2]>,
        /// How far they may be off otherwise.
        of: std::boxed::Box<Self>,
    },
}

impl Deviations {
    /// The ellipsoid of `errors` standard errors of a covariance with `rows`. Parameters that are not estimated
    /// have rows of zeros.
    ///
    /// # Errors
    /// A covariance that is not positive definite, apart from such rows.
    pub fn ellipsoid(rows: &[Vec<f64>], errors: f64) -> Result<Self, NotPositive> {
        let mut factor = vec![vec![0.0; rows.len()]; rows.len()];
        for (i, row) in rows.iter().enumerate() {
            if row.iter().all(|entry| *entry == 0.0) {
                continue;
            }
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
                let left = row[j] - known;
                let symmetric = (row[j] - rows[j][i]).abs() <= ASYMMETRIC * (row[j].abs() + rows[j][i].abs());
                if !symmetric {
                    let found = format!("{} and {} across", row[j], rows[j][i]);
                    return Err(NotPositive { parameter: i, found });
                }
                if i == j && !(left > SINGULAR * row[i] && left.is_finite()) {
                    return Err(NotPositive::of(i, row[i], left));
                }
                let diagonal = factor[j][j];
                factor[i][j] = match i == j {
                    true => left.sqrt(),
                    false if diagonal > 0.0 => left / diagonal,
                    false => 0.0,
                };
            }
        }
        factor.iter_mut().flatten().for_each(|entry| *entry *= errors);
        Ok(Self::Ellipsoid(factor))
    }

    /// The ellipsoid of `errors` standard deviations of independent numbers.
    pub fn independent(deviations: &[f64], errors: f64) -> Self {
        let entry = |i: usize, j: usize| if i == j { errors * deviations[i] } else { 0.0 };
        let places = 0..deviations.len();
        Self::Ellipsoid(places.clone().map(|i| places.clone().map(|j| entry(i, j)).collect()).collect())
    }

    /// The same, but no number beyond its `bounds`; as it is without any.
    #[must_use]
    pub fn within(self, bounds: Option<Vec<[f64; 2]>>) -> Self {
        let Some(bounds) = bounds else { return self };
        Self::Within { bounds, of: std::boxed::Box::new(self) }
    }

    /// Whether only the nominal vessel is among them.
    pub fn is_none(&self) -> bool {
        match self {
            Self::Box(error) => *error == 0.0,
            Self::Ellipsoid(factor) => factor.iter().flatten().all(|entry| *entry == 0.0),
            Self::Within { of, .. } => of.is_none(),
        }
    }

    /// The parameters at a point: of a cube from −1 to 1 for a box, of the unit ball for an ellipsoid.
    pub(crate) fn parameters(&self, nominal: &[f64], at: &[f64]) -> Vec<f64> {
        match self {
            Self::Box(error) => nominal.iter().zip(at).map(|(p, at)| p * (1.0 + error * at)).collect(),
            Self::Ellipsoid(factor) => {
                let off = |row: &Vec<f64>| row.iter().zip(at).map(|(entry, at)| entry * at).sum::<f64>();
                nominal.iter().zip(factor).map(|(p, row)| p + off(row)).collect()
            }
            Self::Within { bounds, of } => {
                let all = of.parameters(nominal, at).into_iter().zip(bounds);
                all.map(|(p, [low, high])| p.clamp(*low, *high)).collect()
            }
        }
    }

    /// The point where a function of these slopes is greatest.
    fn extreme(&self, slopes: &[f64]) -> Vec<f64> {
        match self {
            Self::Box(_) => slopes.iter().map(|slope| if *slope < 0.0 { -1.0 } else { 1.0 }).collect(),
            Self::Ellipsoid(_) => within_ball(slopes, 1.0),
            Self::Within { of, .. } => of.extreme(slopes),
        }
    }

    /// The nearest point that belongs to them.
    fn kept(&self, at: Vec<f64>) -> Vec<f64> {
        match self {
            Self::Box(_) => at.into_iter().map(|x| x.clamp(-1.0, 1.0)).collect(),
            Self::Ellipsoid(_) if length(&at) > 1.0 => within_ball(&at, 1.0),
            Self::Ellipsoid(_) => at,
            Self::Within { of, .. } => of.kept(at),
        }
    }

    /// A point from `uniform` numbers from −1 to 1 and as many `normal` ones, of which each kind takes its own.
    pub fn drawn(&self, uniform: &[f64], normal: &[f64]) -> Vec<f64> {
        match self {
            Self::Box(_) => uniform.to_vec(),
            Self::Ellipsoid(_) => {
                let part = uniform.first().map_or(0.0, |first| (first + 1.0) / 2.0);
                within_ball(normal, libm::pow(part, 1.0 / normal.len().max(1) as f64))
            }
            Self::Within { of, .. } => of.drawn(uniform, normal),
        }
    }
}

/// Least part of a variance that others of a positive covariance leave unexplained.
const SINGULAR: f64 = 1e-12;

/// Largest relative difference of entries that should be equal.
const ASYMMETRIC: f64 = 1e-6;

/// A covariance that is not positive definite.
#[derive(Clone, Debug, PartialEq)]
pub struct NotPositive {
    /// Index of the first parameter where this shows.
    pub parameter: usize,
    /// What was found, in words.
    pub found: String,
}

impl NotPositive {
    fn of(parameter: usize, variance: f64, left: f64) -> Self {
        let found = format!("a variance of {variance:e}, of which those before it leave {left:e}");
        Self { parameter, found }
    }
}

fn length(at: &[f64]) -> f64 {
    at.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The point of this `radius` in a direction; its centre for none.
fn within_ball(direction: &[f64], radius: f64) -> Vec<f64> {
    let whole = length(direction);
    let factor = if whole > 0.0 { radius / whole } else { 0.0 };
    direction.iter().map(|x| x * factor).collect()
}

/// The vessels and currents that a plan has to hold for.
#[derive(Clone, Copy, Debug)]
pub struct Doubt<'a> {
    /// The nominal parameters.
    pub nominal: &'a [f64],
    /// How far others are from them.
    pub deviations: &'a Deviations,
    /// Bound on the unknown current \[m/s\].
    pub current_m_s: f64,
}

/// A vessel and a current among them: a point of [`Deviations`], and one of the unit disc.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The deviation of every parameter, within −1 and 1 or in the unit ball.
    pub at: Vec<f64>,
    /// The current as a part of its bound, in the axes of the search.
    pub current: [f64; 2],
}

/// Turns of the current that a search tries: by an eighth either way, and right round.
const TURNS: [f64; 3] = [0.25, -0.25, 1.0];
/// Fractions of the whole deviation that it tries, since dangers may lie between extremes.
const PARTS: [f64; 3] = [0.75, 0.5, 0.25];

/// Directions in which a vessel may be farthest off.
const DIRECTIONS: u32 = 8;

/// Weights of the `N` quantities by which a vessel is off: each says what is to be greatest. The first two are a position, which
/// is to be greatest in one of eight directions; each other one may be greatest or least.
pub fn goals<const N: usize>() -> Vec<[f64; N]> {
    let position = (0..DIRECTIONS).map(|direction| {
        let (sin, cos) = libm::sincos(TAU * f64::from(direction) / f64::from(DIRECTIONS));
        std::array::from_fn(|k| [cos, sin].get(k).copied().unwrap_or(0.0))
    });
    let others = (2..N).flat_map(|axis| [1.0, -1.0].map(|sign| (axis, sign)));
    let along = |(axis, sign)| std::array::from_fn(|k| if k == axis { sign } else { 0.0 });
    position.chain(others.map(along)).collect()
}

/// What is to be greatest by a goal.
pub fn goal_value<const N: usize>(goal: &[f64; N], off: &[f64; N]) -> f64 {
    goal.iter().zip(off).map(|(weight, x)| weight * x).sum()
}

impl Doubt<'_> {
    /// Whether there is only the nominal vessel in the known current.
    pub fn is_none(&self) -> bool {
        self.deviations.is_none() && self.current_m_s == 0.0
    }

    /// The parameters of a candidate.
    pub fn parameters(&self, who: &Candidate) -> Vec<f64> {
        self.deviations.parameters(self.nominal, &who.at)
    }

    /// Its current, in the axes of the search \[m/s\].
    pub fn current(&self, who: &Candidate) -> [f64; 2] {
        who.current.map(|part| part * self.current_m_s)
    }

    /// The vessel of a candidate on its node, whose axes are those of the search.
    pub fn on_node(&self, who: &Candidate) -> SampledVessel {
        let (parameters, current_m_s) = (self.parameters(who), self.current(who));
        SampledVessel { parameters, current_m_s, off: [0.0; 3], motion: [0.0; 3] }
    }

    /// The nominal vessel with one coordinate at either end: parameters first, then the current.
    pub fn axes(&self) -> Vec<Candidate> {
        let count = self.nominal.len();
        let along = |(axis, sign): (usize, f64)| {
            let mut who = Candidate { at: vec![0.0; count], current: [0.0; 2] };
            match axis.checked_sub(count) {
                None => who.at[axis] = sign,
                Some(axis) => who.current[axis] = sign,
            }
            who
        };
        (0..count + 2).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]).map(along).collect()
    }

    /// Where a function is greatest that has these `values` at the [axes](Self::axes), were it linear.
    pub fn extreme(&self, values: &[f64]) -> Candidate {
        let slopes: Vec<f64> = values.chunks_exact(2).map(|ends| ends[0] - ends[1]).collect();
        let (parameters, current) = slopes.split_at(self.nominal.len());
        let current = within_ball(current, 1.0);
        Candidate { at: self.deviations.extreme(parameters), current: [current[0], current[1]] }
    }

    /// What such a function would be at a candidate.
    pub fn predicted(&self, values: &[f64], who: &Candidate) -> f64 {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let along = values.chunks_exact(2).zip(who.at.iter().chain(&who.current));
        mean + along.map(|(ends, at)| 0.5 * (ends[0] - ends[1]) * at).sum::<f64>()
    }

    /// The candidates that a search tries next to `who`: one coordinate mirrored, all of them reduced, or its
    /// current turned or left out.
    pub fn neighbours(&self, who: &Candidate) -> Vec<Candidate> {
        let mirrored = (0..who.at.len()).filter(|axis| who.at[*axis] != 0.0).map(|axis| {
            let mut at = who.at.clone();
            at[axis] = -at[axis];
            Candidate { at: self.deviations.kept(at), ..who.clone() }
        });
        let reduced =
            PARTS.map(|part| Candidate { at: who.at.iter().map(|x| x * part).collect(), ..who.clone() });
        let [x, y] = who.current;
        let turned = TURNS.map(|turn| {
            let (sin, cos) = libm::sincos(turn * std::f64::consts::PI);
            Candidate { current: [x * cos - y * sin, x * sin + y * cos], ..who.clone() }
        });
        let still = Candidate { current: [0.0; 2], ..who.clone() };
        let all = (self.current_m_s > 0.0 && [x, y] != [0.0; 2]).then_some(turned.into_iter().chain([still]));
        let deviates = !self.deviations.is_none();
        mirrored.chain(reduced).filter(|_| deviates).chain(all.into_iter().flatten()).collect()
    }
}
