//! The lattice problem of a trial, and its solution.

use std::collections::BTreeMap;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::{Search, VoyageError, parameters_in_words, reason_in_words};
use super::moment_sums::MomentSums;
use super::prepared::Prepared;
use super::settled_legs::{SettledLeg, Wanted};
use super::task::{AbortRule, CostRule, Primary, Secondary};
use super::waters::{CLEARANCE_CLASSES, Waiting, Waters};
use crate::lattice::{
    Action, Cost, KeyOf, Lattice, Limit, Move, MoveId, NoPlan, Poll, Pose, Problem, Reason, Solution, Step,
    Watch, WaysOut,
};
use crate::{Leg, Purpose};

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
        let mut problem = self.problem(&waters, &moves, search.keep_going)?;
        if task.failing.abort == AbortRule::Required {
            let waiting = self.waiting(search.keep_going)?;
            let ways = self.ways_out(&problem, &moves, &waiting, search);
            let late = VoyageError::OutOfTime("the search of abort tracks");
            let closed = ways.map_err(|limit| match limit {
                Limit::Time => late,
                Limit::Memory => VoyageError::NoPlan(NoPlan::OutOfMemory { lower_bound: Cost::default() }),
            })?;
            problem.close(&closed.closed());
        }
        let solution = search.plan(&problem).map_err(|why| match why {
            NoPlan::Infeasible(reason) => {
                let front = self.front(&problem, None, &moves, search);
                let room = self.room_by_class(&waters).unwrap_or_default();
                VoyageError::Infeasible(self.infeasible(&reason, &front) + &room)
            }
            limit => VoyageError::NoPlan(limit),
        })?;
        Ok(Solved { waters, moves, problem, solution, front: Vec::new() })
    }

    /// The cheapest basic moves, in samples, from all poses to where she may wait.
    pub(super) fn ways_out<'a>(
        &'a self,
        problem: &'a Problem,
        moves: &'a Moves,
        waiting: &'a Waiting,
        search: &Search,
    ) -> Result<WaysOut<'a>, Limit> {
        let key = |id: MoveId| {
            let leg = &self.legs[moves.legs[id.action][id.index].0];
            (!leg.is_informative()).then_some(leg.sailed.samples.len().max(1) as u64)
        };
        let mut keep_going = |_| (search.keep_going)();
        let watch = &mut Watch::new(problem, search.options.poll_every, &mut keep_going);
        let keys: (KeyOf<Pose>, KeyOf<MoveId>) = (Box::new(|pose| waiting.key(pose)), Box::new(key));
        WaysOut::new(problem, keys, search.options.memory_bytes, watch)
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
            for pose in poses {
                *pose = self.clear_goal(waters, *pose)?;
            }
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
        let (name, farthest) = all.max_by(|a, b| a.1.distance_m.total_cmp(&b.1.distance_m))?;
        let words = parameters_in_words(&self.brief.vessel, &farthest.parameters);
        Some(format!(
            "`{name}` has room for vessels that end it {:.0} m from the nominal one ({words}): lower \
             `{}`, or run it in shorter pieces (`piece_s`)",
            farthest.distance_m,
            self.brief.task.safety.key()
        ))
    }

    /// The moves from a mode that have no leg at all, which part the lattice, and why.
    fn moves_without_legs(&self) -> String {
        let mode = |layer: usize| self.grid.level_and_mode(layer).1;
        let mut said: Vec<(&str, usize)> = Vec::new();
        let mut text = String::new();
        for dropped in self.dropped.iter().filter(|dropped| dropped.side.is_none()) {
            let move_of = (dropped.name.as_str(), mode(dropped.from));
            let is_offered = |leg: &Arc<SettledLeg>| (leg.name.as_str(), mode(leg.leg.from)) == move_of;
            if !said.contains(&move_of) && !self.legs.iter().any(is_offered) {
                said.push(move_of);
                let (name, from, why) = (&dropped.name, &self.grid.modes[move_of.1].name, &dropped.why);
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
            let key = "handling.acceleration_m_s2";
            (way_m > longest_m)
                .then(|| format!("; between `{slow}` and `{fast}` she takes {way_m:.0} m (`{key}`)"))
        });
        said.collect()
    }

    /// Why there is no plan, and the most informative feasible counts.
    fn infeasible(&self, reason: &Reason, front: &[FrontPoint]) -> String {
        let mut text = reason_in_words(reason, |pose| self.words(pose), self.grid.cell_m);
        if !self.brief.task.speed_limits.is_empty() {
            text += "; legs faster than a [[speed_limit]] count as without room in it";
        }
        if self.brief.task.failing.abort == AbortRule::Required {
            text += "; legs without an abort track count as without room (`abort`)";
        }
        if self.chart.traffic().next().is_some() {
            text += "; legs against the traffic of lanes and zones count as without room in them (`rules`, \
                     `traffic.crossing_deg`)";
        }
        text += &self.moves_without_legs();
        text += &self.changes_beyond_the_lattice();
        match front.last().filter(|point| point.counts.values().any(|n| *n > 0)) {
            None => text,
            Some(point) => {
                let counts: Vec<String> =
                    point.counts.iter().map(|(name, n)| format!("{name} × {n}")).collect();
                let all = counts.join(", ");
                format!("{text}; the most informative counts that can be sailed are {all}")
            }
        }
    }
}

/// Counts with what they cost and tell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrontPoint {
    /// Uses of every maneuver.
    pub counts: BTreeMap<String, u64>,
    /// Cost of the best plan with them.
    pub cost: f64,
    /// Time in informative legs \[s\].
    pub informative_s: f64,
    /// log|det| of their information.
    pub log_det: f64,
}

impl Prepared {
    /// Counts that no others beat in both cost and information, cheapest first; empty if the search is not
    /// exhaustive. A known `plan` beats all that are dearer, since more uses never carry less information.
    pub(super) fn front(
        &self,
        problem: &Problem,
        plan: Option<&Solution>,
        moves: &Moves,
        search: &Search,
    ) -> Vec<FrontPoint> {
        let order = self.pieces_in_order(moves);
        let all = search.affordable(problem, plan).into_iter().map(|counts| self.front_point(&order, counts));
        let mut points: Vec<FrontPoint> = all.filter(|p| p.log_det.is_finite()).collect();
        let time = |p: &FrontPoint| match self.brief.task.cost.primary {
            Primary::BasicMoves => p.informative_s,
            Primary::Seconds => 0.0,
        };
        points.sort_by(|a, b| {
            a.cost.total_cmp(&b.cost).then(b.log_det.total_cmp(&a.log_det)).then(time(a).total_cmp(&time(b)))
        });
        let mut best = f64::NEG_INFINITY;
        points.retain(|p| {
            let before = best;
            best = best.max(p.log_det);
            p.log_det > before
        });
        points
    }

    /// The piece of every informative action, in the order of the lattice's counts.
    fn pieces_in_order(&self, moves: &Moves) -> Vec<usize> {
        let informative = moves.actions.iter().filter(|a| a.required > 0);
        let piece = |name: &String| self.wanted.iter().position(|w| w.piece.maneuver == *name);
        informative.filter_map(|action| piece(&action.name)).collect()
    }

    fn front_point(&self, order: &[usize], (uses, cost): (Vec<u32>, f64)) -> FrontPoint {
        let mut information = MomentSums::default();
        let mut counts = BTreeMap::new();
        let mut informative_s = 0.0;
        for (piece, count) in order.iter().zip(&uses) {
            information.add(&self.information[*piece], f64::from(*count));
            counts.insert(self.wanted[*piece].piece.maneuver.clone(), u64::from(*count));
            informative_s += f64::from(*count) * self.shortest_leg_s(*piece);
        }
        FrontPoint { counts, cost, informative_s, log_det: information.log_det() }
    }

    /// Time of the shortest leg that uses a piece \[s\].
    pub(super) fn shortest_leg_s(&self, one: usize) -> f64 {
        let uses = |purpose: &Purpose| matches!(purpose, Purpose::Informative { piece, .. } if *piece == one);
        let legs = self.legs.iter().filter(|leg| uses(&leg.leg.purpose));
        legs.map(|leg| leg.seconds(self.brief.vessel.sample_rate_hz)).fold(f64::INFINITY, f64::min)
    }
}

/// The unit of costs in seconds of ships whose samples are not whole multiples of it \[s\].
const TICK_S: f64 = 0.01;

/// The lattice's actions, and the legs of their moves.
#[derive(Clone, Debug)]
pub struct Moves {
    /// The actions.
    pub actions: Vec<Action>,
    /// Per action and move: index of the leg, and its clearance class.
    pub(super) legs: Vec<Vec<(usize, usize)>>,
}

impl Moves {
    /// Groups legs by name; costs follow `rule`.
    pub(super) fn new(legs: &[Arc<SettledLeg>], wanted: &[Wanted], rule: &CostRule, rate_hz: f64) -> Self {
        let mut moves = Self { actions: Vec::new(), legs: Vec::new() };
        // Sums of costs are exact in a common unit, which samples of 0.6762 s lack.
        let per_sample = 1.0 / rate_hz / TICK_S;
        let is_tidy = (per_sample - per_sample.round()).abs() < 1e-9;
        let classes = if rule.secondary == Secondary::Clearance { CLEARANCE_CLASSES } else { 1 };
        for (index, leg) in legs.iter().enumerate() {
            let action = moves.action(leg, wanted);
            // The time of a maneuver that reacts differs by vessel: the cost bounds it.
            let reacts = leg.leg.purpose.piece().is_some_and(|piece| wanted[piece].piece.helm.is_some());
            let seconds = if reacts { leg.longest as f64 / rate_hz } else { leg.seconds(rate_hz) };
            let seconds = if is_tidy { seconds } else { (seconds / TICK_S).round() * TICK_S };
            for class in 0..classes {
                let cost = cost(leg, rule, class, seconds);
                let Leg { from, di, dj, to, .. } = leg.leg;
                moves.actions[action].moves.push(Move { from, di, dj, to, cost });
                moves.legs[action].push((index, class));
            }
        }
        moves
    }

    fn action(&mut self, leg: &SettledLeg, wanted: &[Wanted]) -> usize {
        if let Some(known) = self.actions.iter().position(|a| a.name == leg.name) {
            return known;
        }
        let required = leg.leg.purpose.piece().map_or(0, |piece| wanted[piece].count);
        self.actions.push(Action { name: leg.name.clone(), required, moves: Vec::new() });
        self.legs.push(Vec::new());
        self.actions.len() - 1
    }

    /// The leg of a step.
    pub(super) fn leg_of_step(&self, step: &Step) -> usize {
        let moves = self.actions[step.action].moves.iter().enumerate();
        let alike = moves.filter(|(_, m)| m.from == step.from.layer);
        let index = alike.map(|(index, _)| index).nth(step.variant).unwrap_or(0);
        self.legs[step.action][index].0
    }
}

fn cost(leg: &SettledLeg, rule: &CostRule, class: usize, seconds: f64) -> Cost {
    let primary = match rule.primary {
        Primary::BasicMoves => f64::from(u8::from(!leg.is_informative())),
        Primary::Seconds => seconds,
    };
    let secondary = match rule.secondary {
        Secondary::Seconds if rule.primary == Primary::Seconds => 0.0,
        Secondary::Seconds => seconds,
        Secondary::Turns => f64::from(u8::from(leg.name.starts_with("turn-"))),
        Secondary::Clearance => class as f64,
    };
    Cost { primary, secondary }
}
