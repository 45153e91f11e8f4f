use vessel::{Invalid, Pose};

use crate::{Autopilot, Phase, Repertoire, Ship, Used};

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

impl Repertoire<'_> {
    /// The nominal vessel and `others` at the origin, in `layer`.
    pub(crate) fn crew(&self, layer: usize, others: &[Rehearser]) -> Result<Crew<'_>, Invalid> {
        let others = others.iter().map(|who| self.underway(layer, Some(who)));
        Ok(Crew::new(self.underway(layer, None)?, others.collect::<Result<_, _>>()?))
    }

    /// A vessel at the origin, in `layer`: the nominal one on its node, or another, as it enters a leg. Its autopilot has held
    /// it for a while, so that it knows what to expect.
    fn underway(&self, layer: usize, who: Option<&Rehearser>) -> Result<Underway<'_>, Invalid> {
        let (level, mode) = self.grid.level_and_mode(layer);
        let (heading, speed) = (self.grid.heading_rad(level), self.grid.modes[mode].speed_m_s);
        let parameters = who.map_or(&self.vessel.nominal, |who| &who.parameters);
        let pose = Pose { x: 0.0, y: 0.0, psi: heading };
        let mut ship = Ship::new(self.vessel, parameters, pose, speed);
        let turned = |[ahead, right]: [f64; 2]| {
            let (sin, cos) = libm::sincos(heading);
            [ahead * cos - right * sin, ahead * sin + right * cos]
        };
        let unknown = turned(who.map_or([0.0; 2], |who| who.current_m_s));
        ship.current_m_s = [0, 1].map(|d| self.mean_current_m_s[d] + unknown[d]);
        let mut autopilot = Autopilot::new(self.vessel, &self.vessel.nominal, *self.handling);
        autopilot.known_current_m_s = self.mean_current_m_s;
        let mut underway = Underway { ship, autopilot };
        if let Some(who) = who {
            underway.hold(heading, speed, self.handling.response_s)?;
            let [x, y] = turned([who.off[0], who.off[1]]);
            underway.ship.pose = Pose { x, y, psi: heading + who.off[2] };
            underway.ship.state = [speed + who.motion[0], who.motion[1], who.motion[2]];
        }
        Ok(underway)
    }
}

impl Underway<'_> {
    /// Holds the vessel on its heading and at its speed for a while.
    fn hold(&mut self, heading_rad: f64, speed_m_s: f64, seconds: f64) -> Result<(), Invalid> {
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
