//! The finished plan in continuous space: how near the hull comes to what is charted as an obstacle.

use chart::Obstacles;
use numerics::statistics::{quantile, sorted};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vessel::{Invalid, Pose, Streams};

use super::script::Script;
use super::task::Brief;
use crate::Sailed;

/// The plan simulated in continuous space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// Least distance of the hull from anything charted as an obstacle, nominal model, known current \[m\].
    pub clearance_m: f64,
    /// Whether the hull stays clear.
    pub clear: bool,
    /// Bound on the unknown current \[m/s\].
    pub unknown_current_m_s: f64,
    /// Simulations with a constant current of that strength from every side and less, and the true parameters where known.
    pub runs: u64,
    /// Of which touched an obstacle.
    pub aground: u64,
    /// Least clearance of each run: smallest, 5 %, median \[m\].
    pub clearance_quantiles_m: [f64; 3],
    /// The same runs without corrections between maneuvers (the autopilot reckons with the nominal track only).
    pub aground_open_loop: u64,
}

/// Distance of the hull from obstacles.
pub(super) struct Clearance<'a> {
    /// Outline about the reference point, x forward, y to starboard \[m\].
    pub outline: &'a [[f64; 2]],
    /// In transit.
    pub transit: &'a Obstacles,
    /// In informative maneuvers.
    pub trial: &'a Obstacles,
}

impl Clearance<'_> {
    /// Of the hull at a pose.
    fn at(&self, pose: Pose, informative: bool) -> f64 {
        let (sin, cos) = pose.psi.sin_cos();
        let place = |[x, y]: [f64; 2]| [pose.y + x * sin + y * cos, pose.x + x * cos - y * sin];
        let obstacles = if informative { self.trial } else { self.transit };
        let next = |i: usize| self.outline[(i + 1) % self.outline.len()];
        let between = |a: [f64; 2], b: [f64; 2]| [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0];
        let points = self.outline.iter().enumerate().flat_map(|(i, p)| [*p, between(*p, next(i))]);
        let distance = |[east, north]: [f64; 2]| obstacles.distance_m(east, north);
        points.map(|p| distance(place(p))).fold(f64::INFINITY, f64::min)
    }

    /// The least along a track.
    pub(super) fn least(&self, sailed: &Sailed) -> f64 {
        let own = sailed.samples.iter().map(|s| self.at(s.pose, s.informative));
        own.fold(f64::INFINITY, f64::min)
    }

    /// Sails the script in unknown currents: the check and the tracks. `nominal` is the script sailed by the nominal model
    /// without unknown current.
    ///
    /// # Errors
    /// A command that the model cannot hold, a simulation that diverges.
    pub(super) fn check(
        &self,
        script: &Script<'_>,
        nominal: &Sailed,
    ) -> Result<(Check, Vec<Sailed>), Invalid> {
        let Brief { vessel, task, seed, .. } = &script.prepared.brief;
        let (bound_m_s, runs) = (task.safety.unknown_current_m_s, task.safety.runs);
        let known: Option<Vec<f64>> = vessel.value.iter().copied().collect();
        let truth = known.unwrap_or_else(|| vessel.nominal.clone());
        let one = |run: u32| {
            let unknown = current(*seed, run, bound_m_s);
            let sailed = script.sail(&truth, unknown)?;
            let open = script.repeat(nominal, &truth, unknown);
            Ok((self.least(&sailed), self.least(&open), sailed))
        };
        let found: Vec<(f64, f64, Sailed)> =
            (0..runs).into_par_iter().map(one).collect::<Result<_, Invalid>>()?;
        let least = sorted(found.iter().map(|(clearance, ..)| Some(*clearance)));
        let clearance_m = self.least(nominal);
        let check = Check {
            clearance_m,
            clear: clearance_m > 0.0,
            unknown_current_m_s: bound_m_s,
            runs: u64::from(runs),
            aground: least.iter().filter(|c| **c <= 0.0).count() as u64,
            clearance_quantiles_m: [0.0, 0.05, 0.5].map(|q| quantile(&least, q).unwrap_or(0.0)),
            aground_open_loop: found.iter().filter(|(_, open, _)| *open <= 0.0).count() as u64,
        };
        Ok((check, found.into_iter().map(|(_, _, sailed)| sailed).collect()))
    }
}

/// A constant current of run `run`, north and east: any direction, any strength up to the bound.
fn current(seed: u64, run: u32, bound_m_s: f64) -> [f64; 2] {
    const STEPS: u32 = 1 << 20;
    let drawn = Streams::new(seed, "unknown-current").choices(run, 0, STEPS, 2);
    let part = |i: usize| (f64::from(drawn[i]) + 0.5) / f64::from(STEPS);
    let (sin, cos) = (std::f64::consts::TAU * part(0)).sin_cos();
    let speed = bound_m_s * part(1);
    [speed * cos, speed * sin]
}
