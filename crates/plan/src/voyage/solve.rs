//! The lattice problem of a trial, and its solution.

use std::sync::Arc;

use crate::lattice::{Lattice, MoveId, NoPlan, Poll, Pose, Problem, Reason, Solution};

use super::error::VoyageError;
use super::front::FrontPoint;
use super::moves::Moves;
use super::off_nominal::parameters_in_words;
use super::prepared::Prepared;
use super::search::{Search, in_words};
use super::settled_legs::SettledLeg;
use super::task::Secondary;
use super::waters::Waters;

/// The nodes around one, the nearest first.
const AROUND: [[isize; 2]; 8] = [[1, 0], [0, 1], [-1, 0], [0, -1], [1, 1], [-1, 1], [-1, -1], [1, -1]];

/// A solved trial.
#[derive(Clone, Debug)]
pub struct Solved {
    /// The waters of the legs.
    pub waters: Waters,
    /// The lattice's moves and their legs.
    pub moves: Moves,
    /// The lattice problem.
    pub problem: Problem,
    /// The plan.
    pub solution: Solution,
    /// Counts that no others beat in both cost and information, cheapest first; empty if the search was not
    /// exhaustive, and before a plan has passed its check.
    pub front: Vec<FrontPoint>,
}

impl Prepared {
    /// Sets up the lattice problem and searches.
    ///
    /// # Errors
    /// A start or goal outside the lattice or without a free pose; no plan; the limits of time or memory.
    pub fn solve(&self, search: &Search) -> Result<Solved, VoyageError> {
        let (task, rate_hz) = (&self.brief.task, self.brief.vessel.sample_rate_hz);
        let moves = Moves::new(&self.legs, &self.wanted, &task.cost, rate_hz);
        let search = &self.within(&moves, search)?;
        let waters = self.waters(search.keep_going)?;
        let problem = self.problem(&waters, &moves, search.keep_going)?;
        let solution = search.plan(&problem).map_err(|why| match why {
            NoPlan::Infeasible(reason) => {
                VoyageError::Infeasible(self.infeasible(&reason, &self.front(&problem, None, &moves, search)))
            }
            limit => VoyageError::NoPlan(limit),
        })?;
        Ok(Solved { waters, moves, problem, solution, front: Vec::new() })
    }

    fn problem(
        &self,
        waters: &Waters,
        moves: &Moves,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Problem, VoyageError> {
        let task = &self.brief.task;
        let start = self.pose("start", &task.start)?;
        let mut goal = self.goal(&task.goal, start)?;
        self.check_water(waters, "start", start)?;
        if let crate::lattice::Goal::Poses(poses) = &mut goal {
            poses
                .iter_mut()
                .try_for_each(|pose| self.clear_goal(waters, *pose).map(|clear| *pose = clear))?;
        }
        let lattice = Lattice { nx: self.grid.nx, ny: self.grid.ny, layers: self.grid.layers() };
        let by_class = task.cost.secondary == Secondary::Clearance;
        let mut poll = Poll::new(keep_going);
        let allowed = |id: MoveId, i: usize, j: usize| {
            if !poll.proceed() {
                return false;
            }
            let (leg, class) = moves.legs[id.action][id.index];
            (!by_class || waters.class(i, j) == class) && waters.fits(leg, i, j)
        };
        let problem = Problem::new(lattice, moves.actions.clone(), start, goal, allowed)?;
        if poll.stopped { Err(VoyageError::OutOfTime("the layout of the lattice")) } else { Ok(problem) }
    }

    /// A pose of the goal. Where the lattice was moved to the ship's position, its nodes are others than the place was chosen
    /// for: there, the nearest of the nodes around it counts if it is not clear itself.
    fn clear_goal(&self, waters: &Waters, pose: Pose) -> Result<Pose, VoyageError> {
        let Err(refused) = self.check_water(waters, "goal", pose) else { return Ok(pose) };
        let around = AROUND.iter().filter_map(|[di, dj]| {
            let (i, j) = (pose.i.checked_add_signed(*di)?, pose.j.checked_add_signed(*dj)?);
            (i < self.grid.nx && j < self.grid.ny).then_some(Pose { i, j, ..pose })
        });
        let mut clear = around.filter(|near| self.check_water(waters, "goal", *near).is_ok());
        clear.next().filter(|_| self.brief.task.on_node).ok_or(refused)
    }

    /// The vessel for which a maneuver needs most room, in words.
    pub(super) fn widest(&self) -> Option<String> {
        if self.brief.doubt().is_none() {
            return None;
        }
        let all = self.legs.iter().filter_map(|leg| Some((&leg.name, leg.farthest.as_ref()?)));
        let (name, own) = all.max_by(|a, b| a.1.distance_m.total_cmp(&b.1.distance_m))?;
        let words = parameters_in_words(&self.brief.vessel, &own.parameters);
        Some(format!(
            "`{name}` has room for vessels that end it {:.0} m from the nominal one ({words}): lower \
             `{}`, or run it in shorter pieces (`piece_s`)",
            own.distance_m,
            self.brief.task.safety.key()
        ))
    }

    /// The moves from a mode that have no leg at all, which part the lattice, and why.
    fn moves_without_legs(&self) -> String {
        let mode = |layer: usize| self.grid.level_and_mode(layer).1;
        let mut said: Vec<(&str, usize)> = Vec::new();
        let mut text = String::new();
        for dropped in self.dropped.iter().filter(|own| own.side.is_none()) {
            let own = (dropped.name.as_str(), mode(dropped.from));
            let is_offered = |leg: &Arc<SettledLeg>| (leg.name.as_str(), mode(leg.leg.from)) == own;
            if !said.contains(&own) && !self.legs.iter().any(is_offered) {
                said.push(own);
                let (name, from, why) = (&dropped.name, &self.grid.modes[own.1].name, &dropped.why);
                text += &format!("; no `{name}` from `{from}` settles: {why}");
            }
        }
        text
    }

    /// The changes of speed that take longer than the lattice is, which part it, too.
    fn changes_beyond_the_lattice(&self) -> String {
        let (grid, acceleration_m_s2) = (&self.grid, self.brief.task.handling.acceleration_m_s2);
        let longest_m = grid.nx.max(grid.ny) as f64 * grid.cell_m;
        let pairs = grid.modes.iter().zip(grid.modes.iter().skip(1));
        let said = pairs.filter_map(|(slow, fast)| {
            let way_m = (fast.speed_m_s.powi(2) - slow.speed_m_s.powi(2)) / (2.0 * acceleration_m_s2);
            let (slow, fast) = (&slow.name, &fast.name);
            (way_m > longest_m).then(|| {
                format!(
                    "; between `{slow}` and `{fast}` she takes {way_m:.0} m (`handling.acceleration_m_s2`)"
                )
            })
        });
        said.collect()
    }

    /// Why there is no plan, and the most informative feasible counts.
    fn infeasible(&self, reason: &Reason, front: &[FrontPoint]) -> String {
        let mut text = in_words(reason, |pose| self.words(pose), self.grid.cell_m);
        if !self.brief.task.speed_limits.is_empty() {
            text += "; legs faster than a [[speed_limit]] count as without room in it";
        }
        text += &self.moves_without_legs();
        text += &self.changes_beyond_the_lattice();
        match front.last().filter(|point| point.counts.values().any(|n| *n > 0)) {
            None => text,
            Some(point) => {
                let counts: Vec<String> =
                    point.counts.iter().map(|(name, n)| format!("{name} × {n}")).collect();
                let counts = counts.join(", ");
                format!("{text}; the most informative counts that can be sailed are {counts}")
            }
        }
    }
}
