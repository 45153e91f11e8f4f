//! The lattice problem of a trial, and its solution.

use lattice::{Lattice, MoveId, NoPlan, Poll, Pose, Problem, Reason, Solution};

use super::error::VoyageError;
use super::front::FrontPoint;
use super::moves::Moves;
use super::off_nominal::parameters_in_words;
use super::prepared::Prepared;
use super::search::{Search, in_words};
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
                VoyageError::Infeasible(self.infeasible(&reason, &self.front(&problem, &moves, search)))
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
        if let lattice::Goal::Poses(poses) = &mut goal {
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
        let all = self.legs.iter().filter_map(|own| Some((&own.name, own.farthest.as_ref()?)));
        let (name, own) = all.max_by(|a, b| a.1.distance_m.total_cmp(&b.1.distance_m))?;
        let words = parameters_in_words(&self.brief.vessel, &own.parameters);
        Some(format!(
            "`{name}` has room for vessels that end it {:.0} m from the nominal one ({words}): lower \
             `safety.parameter_error`, or run it in shorter pieces (`piece_s`)",
            own.distance_m
        ))
    }

    /// Why there is no plan, and the most informative feasible counts.
    fn infeasible(&self, reason: &Reason, front: &[FrontPoint]) -> String {
        let mut text = in_words(reason, |pose| self.words(pose), self.grid.cell_m);
        if !self.brief.task.speed_limits.is_empty() {
            text += "; legs faster than a [[speed_limit]] count as without room in it";
        }
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
