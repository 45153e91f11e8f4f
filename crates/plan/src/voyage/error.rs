use std::collections::BTreeMap;
use std::fmt;

use chart::Distances;
use refusal::Invalid;
use ship::model::Vessel;
use thiserror::Error;

use crate::lattice::{Demand, NoPlan, Options, Pose, Problem, Progress, Reason, Solution, front, plan};

/// Why a trial on a chart cannot be planned.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum VoyageError {
    /// A value of the task makes no sense for this vessel, dictionary or chart.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The task names a maneuver that the dictionary lacks.
    #[error("maneuver `{name}`: found none of that name, expected one of {}", known.join(", "))]
    UnknownManeuver {
        /// The name.
        name: String,
        /// Names of the dictionary.
        known: Vec<String>,
    },
    /// A maneuver without a count has no share in the design.
    #[error("maneuver `{maneuver}`: found no share of it, expected one; the design has {}", known.join(", "))]
    NoShare {
        /// The maneuver.
        maneuver: String,
        /// Maneuvers of the design.
        known: Vec<String>,
    },
    /// The task is valid but has no answer: a hull that is not clear at the start, or on the way.
    #[error("{0}")]
    NoAnswer(Invalid),
    /// Proved that no walk over the lattice fulfils the task; the reason, in terms of the chart.
    #[error("no feasible plan (proved): {0}")]
    Infeasible(String),
    /// The time limit was reached before a plan was found and checked: in which phase.
    #[error("no plan: out of time in {0}")]
    OutOfTime(&'static str),
    /// The lattice and the chart's rasters alone exceed the memory.
    #[error("no plan: {0}")]
    TooLarge(Footing),
    /// The search ended before it found a plan.
    #[error("no plan: {0:?}")]
    NoPlan(NoPlan),
}

impl VoyageError {
    /// The same error, where no plan is left because of `why`: after so many checks of plans that failed, if any.
    #[must_use]
    pub(super) fn because(self, rounds: u32, why: Option<String>) -> Self {
        let Self::Infeasible(reason) = self else { return self };
        let checks = match rounds {
            0 => String::new(),
            1 => "; a check showed that plans with less room cannot be sailed".to_owned(),
            _ => format!("; {rounds} checks showed that plans with less room cannot be sailed"),
        };
        let why = why.map_or(String::new(), |why| format!("; {why}"));
        Self::Infeasible(format!("{reason}{checks}{why}"))
    }
}

/// Approximate bytes of a raster cell while obstacles are computed: causes, gaps of rows, distances; and of its distance alone.
const PER_CELL: u128 = 16;
const KEPT_PER_CELL: u128 = 10;

/// The memory of a search and its check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Footing {
    /// Poses and moves of the lattice.
    pub lattice: Demand,
    /// Cells of all rasters of obstacles.
    pub cells: u128,
    /// Cells of the rasters that clearances are measured on.
    pub clearance_cells: u128,
    /// Bytes of the chart, of legs and of the inputs.
    pub other: u128,
    /// Bytes of the check of a plan, and of its output.
    pub check: u128,
}

impl Footing {
    /// Approximate bytes at most.
    pub fn bytes(&self) -> u128 {
        let rasters = self.standing().saturating_add(self.cells.saturating_mul(PER_CELL));
        let checked = self.lattice.kept_bytes().saturating_add(self.check);
        let searched = self.lattice.bytes().max(checked);
        let searched = self.kept_bytes().saturating_add(searched);
        rasters.max(searched)
    }

    /// Bytes that remain while the lattice is searched.
    pub(super) fn kept_bytes(&self) -> u128 {
        self.standing().saturating_add(self.cells.saturating_mul(KEPT_PER_CELL))
    }

    /// Bytes that remain from round to round. The allocator keeps the memory for computing clearances for a while.
    fn standing(&self) -> u128 {
        let clearances = self.clearance_cells.saturating_mul(Distances::FOUND_BYTES.into());
        self.other.saturating_add(clearances)
    }
}

impl fmt::Display for Footing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Demand { poses, moves } = self.lattice;
        let cells = self.cells + self.clearance_cells;
        write!(f, "{poses} poses with up to {moves} moves and {cells} raster cells")
    }
}

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
pub(super) fn reason_in_words(reason: &Reason, pose: impl Fn(Pose) -> String, cell_m: f64) -> String {
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

/// Differences of parameters from the nominal ones, relative to these \[%\]; 0 for a nominal 0, which is left out of a ship
/// with forces.
pub(super) fn percent_off(vessel: &Vessel, parameters: &[f64]) -> BTreeMap<String, f64> {
    let off = |(p, nominal): (&f64, &f64)| {
        if *nominal == 0.0 { 0.0 } else { (1e4 * (p / nominal - 1.0)).round() / 100.0 }
    };
    let is_given = |nominal: f64| nominal != 0.0 || vessel.model.has_regressors();
    let names = vessel.model.parameter_names().map(str::to_owned);
    let all = names.zip(parameters.iter().zip(&vessel.nominal));
    all.filter(|(_, (_, nominal))| is_given(**nominal)).map(|(name, values)| (name, off(values))).collect()
}

/// The numbers of a ship with forces; none of terms per sample.
pub(super) fn numbers(vessel: &Vessel, parameters: &[f64]) -> BTreeMap<String, f64> {
    let given = parameters.iter().filter(|_| !vessel.model.has_regressors());
    vessel.model.parameter_names().map(str::to_owned).zip(given.copied()).collect()
}

/// The parameters of a vessel that are off the nominal ones, in words.
pub(super) fn parameters_in_words(vessel: &Vessel, parameters: &[f64]) -> String {
    in_words(&percent_off(vessel, parameters), &numbers(vessel, parameters))
}

/// Most parameters that are named.
const NAMED: usize = 10;

/// Parameters that are off, in words: those that are most off, where there are many. Of a ship with forces, `numbers` has all
/// of them, and those without a percentage are off a nominal 0.
pub(super) fn in_words(percent: &BTreeMap<String, f64>, numbers: &BTreeMap<String, f64>) -> String {
    let percent_words = percentages_in_words(percent);
    let off_zero = numbers.iter().filter(|(name, value)| !percent.contains_key(*name) && **value != 0.0);
    let off_zero: Vec<String> = off_zero.map(|(name, value)| format!("{name} = {value:.1e}")).collect();
    let more = off_zero.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} others off 0") } else { String::new() };
    let zeros = off_zero[..off_zero.len().min(NAMED)].join(", ") + &more;
    match (percent_words, zeros.is_empty()) {
        (Some(words), true) => words,
        (Some(words), false) => format!("{words}, {zeros}"),
        (None, false) => zeros,
        (None, true) => "nominal parameters".to_owned(),
    }
}

/// Percentages in words; `None` where none is worth naming.
fn percentages_in_words(percent: &BTreeMap<String, f64>) -> Option<String> {
    let mut sizes: Vec<f64> = percent.values().map(|off| off.abs()).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    let least = sizes.get(NAMED - 1).map_or(SAID, |size| size.max(SAID));
    let all = percent.iter().filter(|(_, off)| off.abs() >= SAID);
    let said = all.clone().filter(|(_, off)| off.abs() >= least).take(NAMED);
    let said: Vec<String> = said.map(|(name, off)| format!("{name} {off:+.0}")).collect();
    let others = match all.count() - said.len() {
        0 => String::new(),
        others => format!(" and {others} others"),
    };
    (!said.is_empty()).then(|| format!("{} %{others}", said.join(", ")))
}

/// Smaller differences are not said \[%\].
const SAID: f64 = 0.5;
