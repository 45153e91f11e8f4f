//! Minimisation within bounds: limited-memory BFGS on the free variables, steps projected onto the bounds.
//!
//! Source: Bertsekas 1982, Projected Newton methods for optimization problems with simple constraints.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use argmin::core::observers::{Observe, ObserverMode};
use argmin::core::{Error, Executor, IterState, KV, Problem, Solver, TerminationReason, TerminationStatus};

use crate::dot;

/// The objective that is minimised.
pub trait Objective {
    /// The workspace of a value, for the gradient.
    type Point;
    /// The value; `None` where it is not defined.
    fn value(&mut self, x: &[f64]) -> Option<(f64, Self::Point)>;
    /// The gradient there.
    fn gradient(&self, point: &Self::Point) -> Vec<f64>;
    /// Called with every accepted point.
    fn keep(&mut self, x: &[f64], point: &Self::Point);
}

/// Stored pairs of steps and gradient differences.
const MEMORY: usize = 20;
/// Maximum halvings of a step along a direction.
const HALVINGS: usize = 30;
/// Sufficient share of the predicted decrease (Armijo).
const SUFFICIENT: f64 = 1e-4;
/// The first step moves no variable further than this.
const FIRST: f64 = 0.01;
/// A decrease below this, relative, ends the iterations.
const SMALL: f64 = 1e-10;

/// Minimises from `x`, where the objective must be defined, within `bounds`, the lowest and the highest values. Returns
/// how many of at most `iterations` improved; `watch` may end them earlier.
pub fn minimise<O: Objective>(
    objective: &mut O,
    x: &mut Vec<f64>,
    bounds: [&[f64]; 2],
    iterations: usize,
    watch: &Watch,
) -> usize {
    let Some((value, point)) = objective.value(x) else { return 0 };
    let mut at = (value, objective.gradient(&point));
    let (mut memory, mut taken) = (VecDeque::with_capacity(MEMORY), 0);
    iterate("projected limited-memory BFGS", iterations, watch, || {
        let (value, gradient) = &at;
        let Some((next, new, point)) = searched(objective, bounds, &memory, x, *value, gradient) else {
            // Retries along the gradient alone, unless that failed.
            let further = (!memory.is_empty()).then_some(());
            taken += usize::from(further.is_some());
            memory.clear();
            return further;
        };
        objective.keep(&next, &point);
        let slopes = objective.gradient(&point);
        let moved: Vec<f64> = next.iter().zip(x.iter()).map(|(a, b)| a - b).collect();
        let turned: Vec<f64> = slopes.iter().zip(gradient).map(|(a, b)| a - b).collect();
        if dot(&moved, &turned) > 1e-10 * dot(&turned, &turned).sqrt() * dot(&moved, &moved).sqrt() {
            memory.truncate(MEMORY - 1);
            memory.push_front((moved, turned));
        }
        taken += 1;
        let nothing_gained = value - new <= SMALL * new.abs().max(1.0);
        (*x, at) = (next, (new, slopes));
        (!nothing_gained).then_some(())
    });
    taken
}

/// The first point with sufficient decrease, starting from a whole step.
fn searched<O: Objective>(
    objective: &mut O,
    [low, high]: [&[f64]; 2],
    memory: &VecDeque<(Vec<f64>, Vec<f64>)>,
    x: &[f64],
    value: f64,
    gradient: &[f64],
) -> Option<(Vec<f64>, f64, O::Point)> {
    let free: Vec<bool> = (0..x.len())
        .map(|i| !((x[i] <= low[i] && gradient[i] > 0.0) || (x[i] >= high[i] && gradient[i] < 0.0)))
        .collect();
    let direction = direction(gradient, &free, memory);
    let step = |share: f64| -> Vec<f64> {
        (0..x.len()).map(|i| (x[i] + share * direction[i]).clamp(low[i], high[i])).collect()
    };
    (0..HALVINGS).find_map(|halvings| {
        let next = step(0.5_f64.powi(halvings as i32));
        let promised: f64 = (0..x.len()).map(|i| gradient[i] * (x[i] - next[i])).sum();
        let (new, point) = objective.value(&next)?;
        (promised > 0.0 && new <= value - SUFFICIENT * promised).then_some((next, new, point))
    })
}

/// −H g on the free variables, H by the two loops of limited-memory BFGS.
fn direction(gradient: &[f64], free: &[bool], memory: &VecDeque<(Vec<f64>, Vec<f64>)>) -> Vec<f64> {
    let masked =
        |x: &[f64]| -> Vec<f64> { x.iter().zip(free).map(|(x, f)| if *f { *x } else { 0.0 }).collect() };
    let pairs: Vec<(Vec<f64>, Vec<f64>, f64)> = memory
        .iter()
        .map(|(s, y)| (masked(s), masked(y)))
        .map(|(s, y)| (dot(&s, &y), s, y))
        .filter(|(sy, s, y)| *sy > 1e-10 * (dot(s, s) * dot(y, y)).sqrt() && *sy > 0.0)
        .map(|(sy, s, y)| (s, y, sy))
        .collect();
    let mut q = masked(gradient);
    let mut parts = Vec::with_capacity(pairs.len());
    for (s, y, sy) in &pairs {
        let part = dot(s, &q) / sy;
        q.iter_mut().zip(y).for_each(|(q, y)| *q -= part * y);
        parts.push(part);
    }
    let scale = match pairs.first() {
        Some((_, y, sy)) => sy / dot(y, y),
        None => FIRST / q.iter().fold(f64::MIN_POSITIVE, |most, g| most.max(g.abs())),
    };
    q.iter_mut().for_each(|q| *q *= scale);
    for ((s, y, sy), part) in pairs.iter().zip(&parts).rev() {
        let back = dot(y, &q) / sy;
        q.iter_mut().zip(s).for_each(|(q, s)| *q += (part - back) * s);
    }
    q.iter().map(|q| -q).collect()
}

/// Watches searches: is called after every iteration, to report progress and to end the search, because its time is over or nobody
/// waits for it any more. The default one lets all go on.
#[derive(Clone, Default)]
pub struct Watch(Option<Arc<Asked>>);

struct Asked {
    goes_on: Box<dyn Fn() -> bool + Send + Sync>,
    ended: AtomicBool,
}

impl Watch {
    /// Searches go on for as long as `goes_on` says so.
    pub fn new(goes_on: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(Asked { goes_on: Box::new(goes_on), ended: AtomicBool::new(false) })))
    }

    /// Whether it has ended a search.
    pub fn ended(&self) -> bool {
        self.0.as_ref().is_some_and(|asked| asked.ended.load(Ordering::Relaxed))
    }
}

impl<I> Observe<I> for Watch {
    fn observe_iter(&mut self, _state: &I, _kv: &KV) -> Result<(), Error> {
        match &self.0 {
            Some(asked) if !(asked.goes_on)() => {
                asked.ended.store(true, Ordering::Relaxed);
                Err(Error::msg("ended by its watch"))
            }
            _ => Ok(()),
        }
    }
}

/// What argmin keeps of a search that keeps its own state: the number of iterations.
type Counted = IterState<(), (), (), (), (), f64>;

/// The solver whose iteration is a call of the problem.
struct Steps {
    name: &'static str,
    ended: bool,
}

impl<F: FnMut() -> Option<()>> Solver<F, Counted> for Steps {
    fn name(&self) -> &str {
        self.name
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<F>,
        state: Counted,
    ) -> Result<(Counted, Option<KV>), Error> {
        self.ended = problem.problem.as_mut().and_then(|step| step()).is_none();
        Ok((state, None))
    }

    fn terminate(&mut self, _state: &Counted) -> TerminationStatus {
        match self.ended {
            true => TerminationStatus::Terminated(TerminationReason::SolverConverged),
            false => TerminationStatus::NotTerminated,
        }
    }
}

/// Takes steps of the search that is called `name`: at most `most`, until one says `None` or `watch` ends it.
pub fn iterate(name: &'static str, most: usize, watch: &Watch, step: impl FnMut() -> Option<()>) {
    let executor = Executor::new(step, Steps { name, ended: false })
        .configure(|state: Counted| state.max_iters(most as u64))
        .timer(false);
    let observed = match watch.0 {
        None => executor,
        Some(_) => executor.add_observer(watch.clone(), ObserverMode::Always),
    };
    // The search keeps what it has found; its steps do not fail, so an error says that the watch has ended it.
    let _ = observed.run();
}
