//! The finished plan in continuous space: how near the hull comes to what is charted as an obstacle.

use rayon::prelude::*;
use trial::{Autopilot, Handling, Leg, Piece, Sailed, Ship, sail};
use vessel::{Invalid, Pose, Streams, Vessel};

use study::documents::Check;

/// What is sailed: legs from their nodes (north, east), in order.
pub(super) struct Script<'a> {
    pub vessel: &'a Vessel,
    pub handling: Handling,
    pub pieces: &'a [Piece],
    pub mirror: &'a [f64],
    pub legs: &'a [([f64; 2], Leg)],
    pub start: Pose,
    pub speed_m_s: f64,
    pub known_current_m_s: [f64; 2],
}

impl Script<'_> {
    /// Carried out by a vessel with `parameters` in the known current and `unknown` (north, east).
    pub(super) fn sail(&self, parameters: &[f64], unknown: [f64; 2]) -> Result<Sailed, Invalid> {
        let mut ship = self.ship(parameters, unknown);
        let mut autopilot = Autopilot::new(self.vessel, &self.vessel.nominal, self.handling);
        autopilot.known_current_m_s = self.known_current_m_s;
        let legs = self.legs.iter().map(|(node, leg)| (*node, leg));
        sail(legs, self.pieces, self.mirror, &mut ship, &mut autopilot)
    }

    fn ship<'s>(&'s self, parameters: &[f64], unknown: [f64; 2]) -> Ship<'s> {
        let mut ship = Ship::new(self.vessel, parameters, self.start, self.speed_m_s);
        ship.current_m_s = [0, 1].map(|d| self.known_current_m_s[d] + unknown[d]);
        ship
    }
}

/// Distance of the hull from obstacles.
pub(super) struct Clearance<'a> {
    /// Outline about the reference point, x forward, y to starboard \[m\].
    pub outline: &'a [[f64; 2]],
    /// Distance of a place (east, north) from the nearest obstacle \[m\]: for transit, and for informative maneuvers.
    pub distance_m: [&'a (dyn Fn([f64; 2]) -> f64 + Sync); 2],
}

impl Clearance<'_> {
    /// Of the hull at a pose.
    fn at(&self, pose: Pose, informative: bool) -> f64 {
        let (sin, cos) = pose.psi.sin_cos();
        let place = |[x, y]: [f64; 2]| [pose.y + x * sin + y * cos, pose.x + x * cos - y * sin];
        let distance = self.distance_m[usize::from(informative)];
        let next = |i: usize| self.outline[(i + 1) % self.outline.len()];
        let between = |a: [f64; 2], b: [f64; 2]| [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0];
        let points = self.outline.iter().enumerate().flat_map(|(i, p)| [*p, between(*p, next(i))]);
        points.map(|p| distance(place(p))).fold(f64::INFINITY, f64::min)
    }

    /// The least along a track.
    pub(super) fn least(&self, sailed: &Sailed) -> f64 {
        let own = sailed.samples.iter().map(|s| self.at(s.pose, s.informative));
        own.fold(f64::INFINITY, f64::min)
    }
}

/// Sails the script in unknown currents.
pub(super) struct Trials<'a> {
    pub script: &'a Script<'a>,
    pub clearance: &'a Clearance<'a>,
    pub unknown_current_m_s: f64,
    pub runs: u32,
    pub seed: u64,
}

impl Trials<'_> {
    /// `nominal` is the script sailed by the nominal model without unknown current. Returns the check and the tracks.
    ///
    /// # Errors
    /// A command that the model cannot hold, a simulation that diverges.
    pub(super) fn check(&self, nominal: &Sailed) -> Result<(Check, Vec<Sailed>), Invalid> {
        let vessel = self.script.vessel;
        let known: Option<Vec<f64>> = vessel.value.iter().copied().collect();
        let truth = known.unwrap_or_else(|| vessel.nominal.clone());
        let one = |run: u32| {
            let unknown = self.current(run);
            let sailed = self.script.sail(&truth, unknown)?;
            let open = self.open_loop(nominal, &truth, unknown);
            Ok((self.clearance.least(&sailed), self.clearance.least(&open), sailed))
        };
        let found: Vec<(f64, f64, Sailed)> =
            (0..self.runs).into_par_iter().map(one).collect::<Result<_, Invalid>>()?;
        let mut least: Vec<f64> = found.iter().map(|(clearance, ..)| *clearance).collect();
        least.sort_by(f64::total_cmp);
        let quantile = |p: f64| {
            let place = (p * least.len().saturating_sub(1) as f64).floor() as usize;
            least.get(place).copied().unwrap_or(0.0)
        };
        let clearance_m = self.clearance.least(nominal);
        let check = Check {
            clearance_m,
            clear: clearance_m > 0.0,
            unknown_current_m_s: self.unknown_current_m_s,
            runs: u64::from(self.runs),
            aground: least.iter().filter(|c| **c <= 0.0).count() as u64,
            clearance_quantiles_m: [quantile(0.0), quantile(0.05), quantile(0.5)],
            aground_open_loop: found.iter().filter(|(_, open, _)| *open <= 0.0).count() as u64,
        };
        Ok((check, found.into_iter().map(|(_, _, sailed)| sailed).collect()))
    }

    /// A constant current of run `run`, north and east: any direction, any strength up to the bound.
    fn current(&self, run: u32) -> [f64; 2] {
        const STEPS: u32 = 1 << 20;
        let drawn = Streams::new(self.seed, "unknown-current").choices(run, 0, STEPS, 2);
        let part = |i: usize| (f64::from(drawn[i]) + 0.5) / f64::from(STEPS);
        let (sin, cos) = (std::f64::consts::TAU * part(0)).sin_cos();
        let speed = self.unknown_current_m_s * part(1);
        [speed * cos, speed * sin]
    }

    /// The nominal track's inputs, sample by sample, without corrections.
    fn open_loop(&self, nominal: &Sailed, truth: &[f64], unknown: [f64; 2]) -> Sailed {
        let mut ship = self.script.ship(truth, unknown);
        let mut sailed = Sailed { samples: Vec::with_capacity(nominal.samples.len()), ends: Vec::new() };
        for sample in &nominal.samples {
            sailed.samples.push(trial::Sample { pose: ship.pose, state: ship.state, ..sample.clone() });
            ship.step(&sample.inputs);
        }
        sailed
    }
}
