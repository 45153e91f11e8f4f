use engine::{Pose, Ship};
use model::Vessel;
use refusal::Invalid;

use crate::leg::turned;
use crate::rehearser::{Crew, Underway};
use crate::sail::End;
use crate::{
    Astray, Autopilot, Grid, Handling, Leg, Piece, Purpose, Rehearser, Sailed, Tolerance, Used, basic_moves,
    sail,
};

/// What comes before and after an informative maneuver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Steady approach at the maneuver's initial speed, with zero yaw rate \[s\].
    pub run_in_s: f64,
    /// What legs end within, and maneuvers begin within.
    pub tolerance: Tolerance,
}

/// Everything that legs are made from.
#[derive(Clone, Debug)]
pub struct Repertoire<'a> {
    /// The vessel; its nominal parameters count.
    pub vessel: &'a Vessel,
    /// The lattice.
    pub grid: &'a Grid,
    /// How the vessel is handled.
    pub handling: &'a Handling,
    /// What comes before and after a maneuver.
    pub approach: &'a Approach,
    /// Pieces of maneuvers.
    pub pieces: &'a [Piece],
    /// Signs of the inputs that run a piece to the other side, where the vessel has a mirror image.
    pub mirror: Option<&'a [f64]>,
    /// North and east components of the known mean current \[m/s\].
    pub mean_current_m_s: [f64; 2],
}

/// A leg that all who rehearsed it end settled at its node.
#[derive(Clone, Debug)]
pub struct Settled {
    /// What is carried out.
    pub leg: Leg,
    /// From its node by the nominal vessel.
    pub sailed: Sailed,
    /// Where it leads those who rehearsed it: their poses.
    pub tracks: Vec<Vec<Pose>>,
}

/// A leg that cannot be offered.
#[derive(Clone, Debug, PartialEq)]
pub struct Unsettled {
    /// Heading level and mode that it begins from.
    pub from: usize,
    /// Name of the basic move or the piece.
    pub purpose: Purpose,
    /// What the best that was tried leaves, and by whom.
    pub why: String,
}

/// What rehearsals of a leg come to.
pub type Outcome = Result<Settled, Unsettled>;

impl Settled {
    /// The same leg turned to port by quarter turns.
    pub fn turned(&self, quarters: usize, grid: &Grid) -> Self {
        let pose = |pose: &Pose| {
            let [x, y] = turned([pose.x, pose.y], quarters);
            Pose { x, y, psi: pose.psi - quarters as f64 * std::f64::consts::FRAC_PI_2 }
        };
        let mut sailed = self.sailed.clone();
        sailed.samples.iter_mut().for_each(|sample| sample.pose = pose(&sample.pose));
        sailed.ends.iter_mut().for_each(|end| end.0 = pose(&end.0));
        let tracks = self.tracks.iter().map(|track| track.iter().map(pose).collect()).collect();
        Self { leg: self.leg.turned(quarters, grid), sailed, tracks }
    }
}

impl Repertoire<'_> {
    /// The basic moves from a heading level and mode, each the shortest that `others` end settled.
    ///
    /// # Errors
    /// As [`sail`].
    pub fn basic(&self, level: usize, mode: usize, others: &[Rehearser]) -> Result<Vec<Outcome>, Invalid> {
        let moves = basic_moves(self.grid, self.handling, level, mode);
        let mut crew = self.crew(self.grid.layer(level, mode), others)?;
        let moves = moves.into_iter().filter(|legs| !legs.is_empty());
        moves.map(|legs| self.shortest(legs, &mut crew)).collect()
    }

    /// The first of `legs` that all end settled.
    fn shortest(&self, legs: Vec<Leg>, crew: &mut Crew) -> Result<Outcome, Invalid> {
        let from = (legs[0].from, legs[0].purpose.clone());
        let mut best = Used::LOST;
        for leg in legs {
            match self.all_settle(&leg, crew)? {
                Ok(settled) => return Ok(Ok(settled)),
                Err(used) => best = best.or(used),
            }
        }
        Ok(Err(Unsettled { from: from.0, purpose: from.1, why: best.to_string() }))
    }

    /// What all of `crew` sail on `leg`, unless one does not end settled.
    pub(crate) fn all_settle(&self, leg: &Leg, crew: &mut Crew) -> Result<Result<Settled, Used>, Invalid> {
        let sailed = self.sailed(leg, &mut crew.nominal.clone())?;
        let used = self.used(leg, sailed.ends.last());
        if used.part > 1.0 {
            return Ok(Err(used));
        }
        let tracks = crew.each(|mut underway| {
            // Who cannot be simulated is lost.
            let (poses, end) = self.track(leg, &mut underway).map_err(|_| Used::LOST)?;
            let used = self.used(leg, Some(&end));
            if used.part > 1.0 { Err(used) } else { Ok(poses) }
        });
        Ok(tracks.map(|tracks| Settled { leg: leg.clone(), sailed, tracks }))
    }

    /// What a vessel sails on `leg`.
    pub(crate) fn sailed(&self, leg: &Leg, underway: &mut Underway) -> Result<Sailed, Invalid> {
        let Underway { ship, autopilot } = underway;
        Sailed::of([([0.0; 2], leg)], self.pieces, self.mirror.unwrap_or(&[]), ship, autopilot)
    }

    /// Its poses, and where it ends.
    pub(crate) fn track(&self, leg: &Leg, underway: &mut Underway) -> Result<(Vec<Pose>, End), Invalid> {
        let Underway { ship, autopilot } = underway;
        let mut poses = Vec::new();
        let mirror = self.mirror.unwrap_or(&[]);
        sail([([0.0; 2], leg)], self.pieces, mirror, ship, autopilot, |sample| poses.push(sample.pose))?;
        poses.push(ship.pose);
        Ok((poses, (ship.pose, ship.state)))
    }

    /// What of the tolerance of rehearsals is used where `leg` ends.
    pub(crate) fn used(&self, leg: &Leg, end: Option<&End>) -> Used {
        let Some((pose, state)) = end else { return Used::LOST };
        let tolerance = self.approach.tolerance.ended();
        self.used_at(&tolerance, leg.to, self.grid.displacement(leg.di, leg.dj), (*pose, *state))
    }

    /// What of a tolerance a vessel uses at a node in `layer`.
    pub(crate) fn used_at(
        &self,
        tolerance: &Tolerance,
        layer: usize,
        node: [f64; 2],
        (pose, state): End,
    ) -> Used {
        let (level, mode) = self.grid.level_and_mode(layer);
        let (heading, speed) = (self.grid.heading_rad(level), self.grid.modes[mode].speed_m_s);
        tolerance.used(&Astray::of(pose, state, node), heading, speed)
    }

    /// Whether all directions of the sea are alike.
    pub fn is_isotropic(&self) -> bool {
        self.mean_current_m_s == [0.0; 2]
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
