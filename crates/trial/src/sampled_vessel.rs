use engine::Ship;
use refusal::Invalid;

use crate::{Autopilot, Phase, Used};

/// Who rehearses a leg: a vessel, the current that nobody knows of, and how far off its node it begins.
#[derive(Clone, Debug)]
pub struct Rehearser {
    /// Its parameters; the autopilot goes by the nominal ones.
    pub parameters: Vec<f64>,
    /// Unknown current along and across the first heading, to starboard \[m/s\].
    pub current_m_s: [f64; 2],
    /// Off the node along and across the first heading \[m\], and off the heading \[rad\].
    pub off: [f64; 3],
    /// Off the mode's u, and v and r \[m/s, m/s, rad/s\].
    pub motion: [f64; 3],
}

/// A vessel with its autopilot.
#[derive(Clone, Debug)]
pub(crate) struct Underway<'a> {
    pub ship: Ship<'a>,
    pub autopilot: Autopilot<'a>,
}

/// All who rehearse, wherever they are by now: the nominal vessel and others.
#[derive(Clone, Debug)]
pub(crate) struct Crew<'a> {
    pub nominal: Underway<'a>,
    pub others: Vec<Underway<'a>>,
    /// Places of the others: who failed last is asked first, and mostly fails again.
    order: Vec<usize>,
}

impl<'a> Crew<'a> {
    /// The nominal vessel and others.
    pub fn new(nominal: Underway<'a>, others: Vec<Underway<'a>>) -> Self {
        let order = (0..others.len()).collect();
        Self { nominal, others, order }
    }

    /// What `tried` gives for each of the others, in their order, unless one fails.
    pub fn each<T>(&mut self, tried: impl Fn(Underway<'a>) -> Result<T, Used>) -> Result<Vec<T>, Used> {
        let mut found: Vec<Option<T>> = self.others.iter().map(|_| None).collect();
        for place in 0..self.order.len() {
            let index = self.order[place];
            match tried(self.others[index].clone()) {
                Ok(own) => found[index] = Some(own),
                Err(used) => {
                    self.order[..=place].rotate_right(1);
                    return Err(used);
                }
            }
        }
        Ok(found.into_iter().flatten().collect())
    }
}

impl Underway<'_> {
    /// Holds the vessel on its heading and at its speed for a while.
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
        let samples = (seconds / ship.sample_s()).ceil().min(HELD_SAMPLES) as usize;
        for _ in 0..samples {
            let wanted = autopilot.steer(&phase, [0.0; 2], start, ship)?;
            let (pose, state) = (ship.pose, ship.state);
            let inputs = ship.reach(wanted).to_vec();
            autopilot.observe(pose, state, &inputs, ship.state);
        }
        Ok(())
    }
}

/// Most samples that a vessel is held for before it rehearses.
const HELD_SAMPLES: f64 = 1000.0;
