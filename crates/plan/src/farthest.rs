use refusal::Invalid;
use ship::engine::Pose;

use crate::deviations::{Candidate, Doubt, goal_value, goals};
use crate::grid::wrap;
use crate::leg::turned_back;
use crate::{Leg, Repertoire, SampledVessel};

/// What a vessel has at the end of a maneuver: along and across \[m\], turned \[rad\], u, r.
const FEATURES: usize = 5;

/// The end of a maneuver.
type Ended = [f64; FEATURES];

impl Repertoire<'_> {
    /// The vessels and currents within the stated errors that end a maneuver farthest off: in position in any
    /// direction, in heading, speed and yaw rate. `approached` is the maneuver with its steady approach.
    ///
    /// The slopes of these quantities say which corner of the errors comes first; its neighbours are tried
    /// after it.
    ///
    /// # Errors
    /// As [`crate::simulate_legs`], for the nominal vessel.
    pub(crate) fn farthest(&self, approached: &Leg) -> Result<Vec<SampledVessel>, Invalid> {
        let doubt = self.doubt();
        if doubt.is_none() {
            return Ok(Vec::new());
        }
        let search = Search { repertoire: self, approached, doubt };
        let axes = doubt.axes().iter().map(|who| search.ended(who)).collect::<Result<Vec<_>, _>>()?;
        let mut found: Vec<Candidate> = Vec::new();
        for goal in goals() {
            let values: Vec<f64> = axes.iter().map(|ended| goal_value(&goal, ended)).collect();
            let who = search.climbed(doubt.extreme(&values), &goal)?;
            if !found.contains(&who) {
                found.push(who);
            }
        }
        Ok(found.iter().map(|who| search.sampled(who)).collect())
    }

    pub(crate) fn doubt(&self) -> Doubt<'_> {
        Doubt {
            nominal: &self.vessel.nominal,
            deviations: self.deviations,
            current_m_s: self.unknown_current_m_s,
        }
    }
}

struct Search<'a> {
    repertoire: &'a Repertoire<'a>,
    approached: &'a Leg,
    doubt: Doubt<'a>,
}

impl Search<'_> {
    /// The better one of a candidate and its neighbours.
    fn climbed(&self, first: Candidate, goal: &Ended) -> Result<Candidate, Invalid> {
        let mut best = (goal_value(goal, &self.ended(&first)?), first.clone());
        for who in self.doubt.neighbours(&first) {
            let own = goal_value(goal, &self.ended(&who)?);
            if own > best.0 {
                best = (own, who);
            }
        }
        Ok(best.1)
    }

    /// How a candidate ends; that of the nominal vessel if it cannot be simulated, which the check finds.
    fn ended(&self, who: &Candidate) -> Result<Ended, Invalid> {
        let layer = self.approached.from;
        let mut underway = self.repertoire.underway(layer, Some(&self.sampled(who)), None)?;
        let (pose, [u, _, r]) = match self.repertoire.track(self.approached, &mut underway) {
            Ok((_, end)) => end,
            Err(_) => (Pose::default(), [0.0; 3]),
        };
        let heading = self.heading();
        let [along, across] = turned_back([pose.x, pose.y], heading);
        Ok([along, across, wrap(pose.psi - heading), u, r])
    }

    fn heading(&self) -> f64 {
        let (level, _) = self.repertoire.grid.level_and_mode(self.approached.from);
        self.repertoire.grid.heading_rad(level)
    }

    /// The vessel of a candidate, on its node.
    fn sampled(&self, who: &Candidate) -> SampledVessel {
        self.doubt.on_node(who)
    }
}
