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
    /// Order in which the sampled vessels are tried: the one that failed last is first, since it usually
    /// fails again.
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
        let mut found: Vec<Option<T>> = self.others.iter().map(|_| None).collect();
        for place in 0..self.order.len() {
            let index = self.order[place];
            match tried(self.others[index].clone()) {
                Ok(own) => found[index] = Some(own),
                Err(used) => {
                    self.order[..=place].rotate_right(1);
                    return Err(Failed { who: Some(index), ..used.into() });
                }
            }
        }
        Ok(found.into_iter().flatten().collect())
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
            if !ship.state.iter().all(|own| own.abs() <= ship::engine::DIVERGED) {
                break;
            }
            seen = autopilot.observe(seen, &inputs, Fixed::from(&*ship));
        }
        Ok(())
    }
}

/// Most samples for which a vessel is held before a leg.
const HELD_SAMPLES: f64 = 1000.0;
