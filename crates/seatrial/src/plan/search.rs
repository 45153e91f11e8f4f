//! The search with its limits, and what it ended with in words.

use std::path::Path;
use std::time::{Duration, Instant};

use lattice::{
    Engine, Front, Options, Outcome, Pose, Problem, Progress, Reason, Solution, Status, front, plan,
};

use crate::failure::Failure;
use study::documents::{PlanPose, PlanStep};

/// Limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Which engine to use.
    pub engine: Engine,
    /// Memory it may take \[bytes\].
    pub memory_bytes: u64,
    /// Time it may take.
    pub time: Option<Duration>,
    /// Whether to tell progress.
    pub quiet: bool,
}

impl Limits {
    /// As options of the search.
    pub(super) fn options(&self) -> Options {
        Options { engine: self.engine, memory_bytes: self.memory_bytes, ..Options::default() }
    }

    /// A watch that stops the search when its time is over, and tells progress every few seconds.
    pub(super) fn watch(&self) -> impl FnMut(Progress) -> bool {
        let (limits, started) = (*self, Instant::now());
        let mut told = started;
        move |progress: Progress| {
            if !limits.quiet && told.elapsed() > Duration::from_secs(2) {
                told = Instant::now();
                let best = progress.best.map_or("none yet".to_owned(), |b| b.primary.to_string());
                let bound = progress.lower_bound.primary;
                eprintln!("plan: {:.0} s, best {best}, at least {bound}", started.elapsed().as_secs_f64());
            }
            limits.time.is_none_or(|time| started.elapsed() < time)
        }
    }
}

/// Searches; `file` is what the problem was read from, `reason` puts infeasibility in words.
pub(super) fn search(
    file: &Path,
    problem: &Problem,
    limits: &Limits,
    reason: impl Fn(&Reason) -> String,
) -> Result<Solution, Failure> {
    let no_answer = |found: String, remedy: &str| {
        Err(Failure::NoAnswer(format!(
            "{}: plan: found {found}, expected a feasible plan; {remedy}",
            file.display()
        )))
    };
    match plan(problem, &limits.options(), &mut limits.watch()) {
        Outcome::Solved(solution) => Ok(solution),
        Outcome::Infeasible(why) => {
            no_answer(format!("none (proved): {}", reason(&why)), "change counts, map, start or goal")
        }
        Outcome::OutOfTime { lower_bound } => no_answer(
            format!("none in time (any costs at least {})", lower_bound.primary),
            "raise --time-limit-s",
        ),
        Outcome::OutOfMemory { lower_bound } => no_answer(
            format!("none in memory (any costs at least {})", lower_bound.primary),
            "raise --memory-mib, or reduce counts, headings, speed modes or the lattice",
        ),
        Outcome::TooLarge { states, bytes } => no_answer(
            format!("{states} states, which take {} MiB", bytes.div_ceil(1 << 20)),
            "raise --memory-mib, take --engine auto, or reduce counts, headings, speed modes or the lattice",
        ),
    }
}

/// `optimal` or `feasible`, and the same in words.
pub(super) fn status(problem: &Problem, solution: &Solution) -> (String, String) {
    match solution.status {
        Status::Optimal => {
            let states = problem.states();
            ("optimal".into(), format!("Proved: no plan over the {states} states of the lattice costs less."))
        }
        Status::Feasible { .. } => (
            "feasible".into(),
            format!(
                "Not proved optimal: no plan costs less than {}, so this one is at most {} dearer than the best.",
                solution.lower_bound.primary,
                solution.gap()
            ),
        ),
    }
}

/// The steps as they stand in the file; `pose` names the poses.
pub(super) fn steps(
    problem: &Problem,
    solution: &Solution,
    pose: impl Fn(lattice::Pose) -> PlanPose,
) -> Vec<PlanStep> {
    let step = |s: &lattice::Step| PlanStep {
        action: problem.actions()[s.action].name.clone(),
        variant: s.variant as u64,
        from: pose(s.from),
        to: pose(s.to),
        cost: s.cost.primary,
    };
    solution.steps.iter().map(step).collect()
}

/// Uses of every informative action.
pub(super) fn uses(problem: &Problem, solution: &Solution) -> std::collections::BTreeMap<String, u64> {
    let used = |index: usize| solution.steps.iter().filter(|s| s.action == index).count() as u64;
    let informative = problem.actions().iter().enumerate().filter(|(_, action)| action.required > 0);
    informative.map(|(index, action)| (action.name.clone(), used(index))).collect()
}

/// The least cost of every count vector that can be sailed; nothing where the exhaustive search does not fit.
pub(super) fn affordable(problem: &Problem, limits: &Limits) -> Vec<(Vec<u32>, f64)> {
    match front(problem, &limits.options(), &mut limits.watch()) {
        Front::Known(points) => {
            points.into_iter().filter_map(|p| Some((p.counts, p.cost?.primary))).collect()
        }
        Front::OutOfTime | Front::TooLarge { .. } => Vec::new(),
    }
}

/// Why there is no plan, with poses as `pose` tells them.
pub(super) fn in_words(reason: &Reason, pose: impl Fn(Pose) -> String, cell_m: f64) -> String {
    let near = |what: &str, nearest: &Option<(Pose, f64)>| match nearest {
        Some((at, cells)) => format!("; {what} is {:.0} m away, {}", cells * cell_m, pose(*at)),
        None => "; no pose of the lattice has any".to_owned(),
    };
    let room = "the nearest pose with room";
    match reason {
        Reason::StartEnclosed { start, nearest } => {
            format!("no move has room at the start, {}{}", pose(*start), near(room, nearest))
        }
        Reason::GoalEnclosed { goal, nearest } => {
            format!("no move has room to end at the goal, {}{}", pose(*goal), near(room, nearest))
        }
        Reason::GoalUnreachable { nearest } => {
            let what = "the nearest pose that is reached";
            format!("no moves lead from the start to the goal{}", near(what, nearest))
        }
        Reason::FitsNowhere { name, elsewhere: Some(at), .. } => {
            format!("`{name}` fits nowhere that can be reached, though it would at {}", pose(*at))
        }
        Reason::FitsNowhere { name, .. } => format!("`{name}` fits nowhere on the chart"),
        Reason::NoWayBack { name, .. } => {
            format!("after `{name}` there is no way to the goal, wherever it is used")
        }
        Reason::CountsCannotBeCombined { .. } => {
            "each maneuver can be used, but the counts cannot be combined on any way to the goal".to_owned()
        }
    }
}
