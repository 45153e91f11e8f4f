use refusal::Invalid;
use ship::engine::{Changes, Pose, Ship, Streams};
use ship::model::Vessel;
use trial::Piece;

use crate::leg::{turned, turned_back, wrap};
use crate::sampled_vessel::{Candidate, Crew, Doubt, Failed, Underway, goal_value, goals};
use crate::simulate::End;
use crate::{
    Astray, Autopilot, Deviations, Fixed, Grid, Handling, Leg, Purpose, Sailed, SampledVessel, Sensors,
    Stopped, Tolerance, Used, basic_moves, simulate_legs,
};

/// The parts of a leg before and after an informative maneuver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Steady approach at the maneuver's initial speed, with zero yaw rate \[s\].
    pub run_in_s: f64,
    /// The tolerance at the ends of legs and the beginnings of maneuvers.
    pub tolerance: Tolerance,
}

/// The data that legs are made from.
#[derive(Clone, Debug)]
pub struct Repertoire<'a> {
    /// The vessel with its nominal parameters.
    pub vessel: &'a Vessel,
    /// The lattice.
    pub grid: &'a Grid,
    /// How the vessel is handled.
    pub handling: &'a Handling,
    /// The parts before and after a maneuver.
    pub approach: &'a Approach,
    /// Pieces of maneuvers.
    pub pieces: &'a [Piece],
    /// Signs of the inputs that run a piece to the other side, if the vessel has mirror symmetry.
    pub mirror: Option<&'a [f64]>,
    /// North and east components of the known mean current \[m/s\].
    pub mean_current_m_s: [f64; 2],
    /// The vessels that legs have to hold for.
    pub deviations: &'a Deviations,
    /// Bound on the unknown current \[m/s\].
    pub unknown_current_m_s: f64,
    /// The noise of the ship's sensors.
    pub sensors: Sensors,
    /// How current and wind change.
    pub changes: Changes,
    /// The seed of the streams of both.
    pub seed: u64,
}

/// A leg on which all sampled vessels settle at its node.
#[derive(Clone, Debug)]
pub struct Settled {
    /// The leg.
    pub leg: Leg,
    /// The nominal vessel's trajectory from the node.
    pub sailed: Sailed,
    /// The poses of the sampled vessels.
    pub tracks: Vec<Vec<Pose>>,
    /// The sampled vessel that is farthest from the nominal one after a maneuver.
    pub farthest: Option<Farthest>,
}

/// A vessel at the end of a maneuver.
#[derive(Clone, Debug, PartialEq)]
pub struct Farthest {
    /// Distance from the nominal vessel at the same time \[m\].
    pub distance_m: f64,
    /// Its parameters.
    pub parameters: Vec<f64>,
}

/// A leg that cannot be offered to the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Unsettled {
    /// Heading level and mode at its beginning.
    pub from: usize,
    /// Name of the basic move or the piece.
    pub purpose: Purpose,
    /// The best attempt's violation of the tolerance.
    pub why: String,
    /// Parameters of the vessel that violates it; `None` for the nominal one.
    pub parameters: Option<Vec<f64>>,
}

/// The result of trying a leg.
pub type Outcome = Result<Settled, Unsettled>;

impl Unsettled {
    /// The purpose of a leg from a layer, tried by the nominal vessel and `others`; `when` is a beginning of the reason.
    pub(crate) fn of(
        (from, purpose): (usize, Purpose),
        when: String,
        failed: Failed,
        others: &[SampledVessel],
    ) -> Self {
        let parameters = failed.who.and_then(|who| others.get(who)).map(|vessel| vessel.parameters.clone());
        let Failed { used, all, .. } = failed;
        let others = if all == used { String::new() } else { format!("; of all vessels {all}") };
        Self { from, purpose, why: format!("{when}{used}{others}"), parameters }
    }
}

/// The best of the attempts that failed.
pub(crate) struct Best {
    failed: Failed,
    leg: Option<Leg>,
}

impl Best {
    /// No attempt.
    pub const NONE: Self = Self { failed: Failed::LOST, leg: None };

    /// The better one of two.
    #[must_use]
    pub fn or(self, failed: Failed, leg: Leg) -> Self {
        if failed.used.part() < self.failed.used.part() { Self { failed, leg: Some(leg) } } else { self }
    }

    /// How it failed, with what any vessel that completes it uses of the tolerance.
    pub fn failed(self, repertoire: &Repertoire, crew: &Crew) -> Failed {
        let Self { mut failed, leg: Some(leg) } = self else { return self.failed };
        for underway in &crew.others {
            if let Ok((_, end)) = repertoire.track(&leg, &mut underway.clone()) {
                failed.all = failed.all.or_more(repertoire.used(&leg, Some(&end)));
            }
        }
        failed
    }
}

impl Settled {
    /// The leg rotated to port by quarter turns.
    pub fn turned(&self, quarters: usize, grid: &Grid) -> Self {
        let pose = |pose: &Pose| {
            let [x, y] = turned([pose.x, pose.y], quarters);
            Pose { x, y, psi: pose.psi - quarters as f64 * std::f64::consts::FRAC_PI_2 }
        };
        let mut sailed = self.sailed.clone();
        sailed.samples.iter_mut().for_each(|sample| sample.pose = pose(&sample.pose));
        sailed.ends.iter_mut().for_each(|end| end.0 = pose(&end.0));
        let tracks = self.tracks.iter().map(|track| track.iter().map(pose).collect()).collect();
        let (leg, farthest) = (self.leg.turned(quarters, grid), self.farthest.clone());
        Self { leg, sailed, tracks, farthest }
    }
}

impl Repertoire<'_> {
    /// The basic moves from a heading level and mode, each the shortest on which `others` settle.
    ///
    /// # Errors
    /// As [`simulate_legs`].
    pub fn basic(&self, level: usize, mode: usize, fleet: &[SampledVessel]) -> Result<Vec<Outcome>, Invalid> {
        let moves = basic_moves(self.grid, self.handling, level, mode);
        let mut crew = self.crew(self.grid.layer(level, mode), fleet)?;
        let moves = moves.into_iter().filter(|legs| !legs.is_empty());
        moves.map(|legs| self.shortest(legs, &mut crew, fleet)).collect()
    }

    /// The first of `legs` on which all settle.
    fn shortest(&self, legs: Vec<Leg>, crew: &mut Crew, fleet: &[SampledVessel]) -> Result<Outcome, Invalid> {
        let from = (legs[0].from, legs[0].purpose.clone());
        let mut best = Best::NONE;
        for leg in legs {
            match self.all_settle(&leg, crew)? {
                Ok(settled) => return Ok(Ok(settled)),
                Err(failed) => best = best.or(failed, leg),
            }
        }
        Ok(Err(Unsettled::of(from, String::new(), best.failed(self, crew), fleet)))
    }

    /// The trajectories of `crew` on `leg`, unless one vessel does not settle.
    pub(crate) fn all_settle(&self, leg: &Leg, crew: &mut Crew) -> Result<Result<Settled, Failed>, Invalid> {
        let sailed = self.simulated(leg, &mut crew.nominal.clone())?;
        let used = self.used(leg, sailed.ends.last());
        if used.part() > 1.0 {
            return Ok(Err(used.into()));
        }
        let tracks = crew.each(|mut underway| {
            let (poses, end) = self.track(leg, &mut underway)?;
            let used = self.used(leg, Some(&end));
            if used.part() > 1.0 { Err(used) } else { Ok(poses) }
        });
        Ok(tracks.map(|tracks| Settled { leg: leg.clone(), sailed, tracks, farthest: None }))
    }

    /// The trajectory of a vessel on `leg`.
    pub(crate) fn simulated(&self, leg: &Leg, underway: &mut Underway) -> Result<Sailed, Invalid> {
        let Underway { ship, autopilot } = underway;
        Sailed::of([([0.0; 2], leg)], self.pieces, self.mirror.unwrap_or(&[]), ship, autopilot)
    }

    /// Its poses, and its end.
    pub(crate) fn track(&self, leg: &Leg, underway: &mut Underway) -> Result<(Vec<Pose>, End), Stopped> {
        let Underway { ship, autopilot } = underway;
        let mut poses = Vec::new();
        let mirror = self.mirror.unwrap_or(&[]);
        simulate_legs([([0.0; 2], leg)], self.pieces, mirror, ship, autopilot, |sample| {
            poses.push(sample.pose)
        })?;
        poses.push(ship.pose);
        Ok((poses, (ship.pose, ship.state)))
    }

    /// The used part of the stricter tolerance at the end of `leg`.
    pub(crate) fn used(&self, leg: &Leg, end: Option<&End>) -> Used {
        let Some((pose, state)) = end else { return Used::Lost };
        let tolerance = self.approach.tolerance.ended();
        self.used_at(&tolerance, leg.to, self.grid.displacement(leg.di, leg.dj), (*pose, *state))
    }

    /// The part of a tolerance that a vessel uses at a node in `layer`.
    pub(crate) fn used_at(&self, tolerance: &Tolerance, layer: usize, node: [f64; 2], end: End) -> Used {
        let (vessel, heading_rad, speed_m_s) = self.at_node(layer, node, end);
        tolerance.used(&vessel, heading_rad, speed_m_s)
    }

    /// A vessel relative to a node in `layer`, with the heading and the speed there.
    pub(crate) fn at_node(&self, layer: usize, node: [f64; 2], (pose, state): End) -> (Astray, f64, f64) {
        let (level, mode) = self.grid.level_and_mode(layer);
        (Astray::of(pose, state, node), self.grid.heading_rad(level), self.grid.modes[mode].speed_m_s)
    }

    /// Whether all directions are equivalent.
    pub fn is_isotropic(&self) -> bool {
        self.mean_current_m_s == [0.0; 2]
    }

    /// The nominal vessel and `others` at the origin, in `layer`.
    pub(crate) fn crew(&self, layer: usize, others: &[SampledVessel]) -> Result<Crew<'_>, Invalid> {
        let others = others.iter().zip(0..).map(|(who, run)| self.underway(layer, Some(who), Some(run)));
        Ok(Crew::new(self.underway(layer, None, None)?, others.collect::<Result<_, _>>()?))
    }

    /// A vessel at the origin, in `layer`: the nominal one on its node, or a sampled one at its offset. Its
    /// autopilot has held it for a while to learn its model errors. `noise`: the run of its sensors' noise and
    /// of the changes of current and wind; without it there are none.
    pub(crate) fn underway(
        &self,
        layer: usize,
        who: Option<&SampledVessel>,
        noise: Option<u32>,
    ) -> Result<Underway<'_>, Invalid> {
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
        if let Some(run) = noise {
            let draws = |purpose: &str| Streams::new(self.seed, purpose);
            autopilot = autopilot.with_sensors(self.sensors, draws("rehearsal-sensors"), run);
            ship.changing = self.changes.of_run(draws("rehearsal-changes"), run, self.vessel.sample_rate_hz);
        }
        let mut underway = Underway { ship, autopilot };
        if let Some(who) = who {
            underway.hold(heading, speed, self.handling.response_s)?;
            let [x, y] = turned([who.off[0], who.off[1]]);
            underway.ship.pose = Pose { x, y, psi: heading + who.off[2] };
            underway.ship.state = [speed + who.motion[0], who.motion[1], who.motion[2]];
            underway.autopilot.see(Fixed::from(&underway.ship), true);
        }
        Ok(underway)
    }
}

/// What a vessel has at the end of a maneuver: along and across \[m\], turned \[rad\], u, r.
const FEATURES: usize = 5;

/// The end of a maneuver.
type Ended = [f64; FEATURES];

impl Repertoire<'_> {
    /// The vessels and currents within the stated errors that end a maneuver farthest off: in position in any
    /// direction, in heading, speed and yaw rate. `approached` is the maneuver with its steady approach.
    ///
    /// The slopes of these quantities say which corner of the errors comes first; its neighbours are tried after it.
    pub(crate) fn farthest(&self, approached: &Leg) -> Result<Vec<SampledVessel>, Invalid> {
        let doubt = self.doubt();
        if doubt.is_none() {
            return Ok(Vec::new());
        }
        let search = FarthestSearch { repertoire: self, approached, doubt };
        let axes = doubt.axes().iter().map(|who| search.ended(who)).collect::<Result<Vec<_>, _>>()?;
        let mut farthest: Vec<Candidate> = Vec::new();
        for goal in goals() {
            let values: Vec<f64> = axes.iter().map(|ended| goal_value(&goal, ended)).collect();
            let who = search.climbed(doubt.extreme(&values), &goal)?;
            if !farthest.contains(&who) {
                farthest.push(who);
            }
        }
        Ok(farthest.iter().map(|who| doubt.on_node(who)).collect())
    }

    pub(crate) fn doubt(&self) -> Doubt<'_> {
        let (nominal, current_m_s) = (&self.vessel.nominal, self.unknown_current_m_s);
        Doubt { nominal, deviations: self.deviations, current_m_s }
    }
}

struct FarthestSearch<'a> {
    repertoire: &'a Repertoire<'a>,
    approached: &'a Leg,
    doubt: Doubt<'a>,
}

impl FarthestSearch<'_> {
    /// The better one of a candidate and its neighbours.
    fn climbed(&self, first: Candidate, goal: &Ended) -> Result<Candidate, Invalid> {
        let mut best = (goal_value(goal, &self.ended(&first)?), first.clone());
        for who in self.doubt.neighbours(&first) {
            let value = goal_value(goal, &self.ended(&who)?);
            if value > best.0 {
                best = (value, who);
            }
        }
        Ok(best.1)
    }

    /// How a candidate ends; that of the nominal vessel if it cannot be simulated, which the check finds.
    fn ended(&self, who: &Candidate) -> Result<Ended, Invalid> {
        let layer = self.approached.from;
        let mut underway = self.repertoire.underway(layer, Some(&self.doubt.on_node(who)), None)?;
        let (pose, [u, _, r]) = match self.repertoire.track(self.approached, &mut underway) {
            Ok((_, end)) => end,
            Err(_) => (Pose::default(), [0.0; 3]),
        };
        let (level, _) = self.repertoire.grid.level_and_mode(layer);
        let heading = self.repertoire.grid.heading_rad(level);
        let [along, across] = turned_back([pose.x, pose.y], heading);
        Ok([along, across, wrap(pose.psi - heading), u, r])
    }
}
