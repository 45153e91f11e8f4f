//! How a search is executed, and why it found nothing, in terms of the chart.

use crate::lattice::{Options, Pose, Problem, Progress, Reason, Solution, front, plan};

/// Polled by a search; cancels it by returning false.
pub type Watch = Box<dyn FnMut(Progress) -> bool>;

/// How to search the lattice.
#[derive(Clone)]
pub struct Search<'a> {
    /// Memory.
    pub options: Options,
    /// Creates the watch of every search: for a plan, and for the front.
    pub watch: &'a (dyn Fn() -> Watch + Sync),
    /// Polled by the other phases; cancels them by returning false.
    pub keep_going: &'a (dyn Fn() -> bool + Sync),
}

impl Search<'static> {
    /// In the usual memory, for as long as it takes.
    pub fn unlimited() -> Self {
        Self { options: Options::default(), watch: &|| Box::new(|_| true), keep_going: &|| true }
    }
}

impl Search<'_> {
    /// The search with less memory.
    pub(super) fn reserving(&self, bytes: u128) -> Self {
        let mut left = self.clone();
        let bytes = u64::try_from(bytes).unwrap_or(u64::MAX);
        left.options.memory_bytes = left.options.memory_bytes.saturating_sub(bytes);
        left
    }

    /// The cheapest plan.
    ///
    /// # Errors
    /// As [`plan`].
    pub fn plan(&self, problem: &Problem) -> Result<Solution, crate::lattice::NoPlan> {
        plan(problem, &self.options, &mut *(self.watch)())
    }

    /// The least primary cost of every feasible count vector, up to that of a known plan; empty if the exhaustive search does not fit in
    /// the memory.
    pub(super) fn affordable(&self, problem: &Problem, plan: Option<&Solution>) -> Vec<(Vec<u32>, f64)> {
        let points = front(problem, plan, &self.options, &mut *(self.watch)()).unwrap_or_default();
        points.into_iter().filter_map(|p| Some((p.counts, p.primary?))).collect()
    }
}

/// Why there is no plan, with poses in the words of `pose`.
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
