//! Minimisation within bounds: limited-memory BFGS on the free variables, steps projected onto the bounds.
//!
//! Source: Bertsekas 1982, Projected Newton methods for optimization problems with simple constraints.

use std::collections::VecDeque;

use argmin::core::{Error, Executor, IterState, KV, Problem, Solver, TerminationReason, TerminationStatus};
use numerics::dot;

/// What is minimised.
pub(super) trait Objective {
    /// What a value leaves for the gradient.
    type Point;
    /// The value; `None` where it is not defined.
    fn value(&mut self, x: &[f64]) -> Option<(f64, Self::Point)>;
    /// The gradient there.
    fn gradient(&self, point: &Self::Point) -> Vec<f64>;
    /// Is told of every point that is kept.
    fn keep(&mut self, x: &[f64], point: &Self::Point);
}

/// Pairs of steps and gradient differences that are remembered.
const MEMORY: usize = 20;
/// Halvings of a step before a direction is given up.
const HALVINGS: usize = 30;
/// The part of the promised decrease that a step has to bring.
const SUFFICIENT: f64 = 1e-4;
/// The first step moves no variable further than this.
const FIRST: f64 = 0.01;
/// A decrease below this, relative, ends the iterations.
const SMALL: f64 = 1e-10;

/// Minimises from `x`, where the objective must be defined, in at most `iterations`; returns how many it took.
pub(super) fn minimise<O: Objective>(
    objective: &mut O,
    x: &mut Vec<f64>,
    bounds: [&[f64]; 2],
    iterations: usize,
) -> usize {
    let solver = Projected { bounds, at: None, memory: VecDeque::with_capacity(MEMORY), taken: 0, end: None };
    let ran = Executor::new(objective, solver)
        .configure(|state: Kept| state.param(x.clone()).max_iters(iterations as u64))
        .timer(false)
        .run();
    let Ok(mut ran) = ran else { return 0 };
    if let Some(found) = ran.state.take_param() {
        *x = found;
    }
    ran.solver.taken
}

/// Where the search is, as argmin keeps it.
type Kept = IterState<Vec<f64>, (), (), (), (), f64>;

/// Limited-memory BFGS within bounds: an argmin [`Solver`].
struct Projected<'b> {
    bounds: [&'b [f64]; 2],
    /// Value and gradient where it is.
    at: Option<(f64, Vec<f64>)>,
    memory: VecDeque<(Vec<f64>, Vec<f64>)>,
    /// Iterations that were of use.
    taken: usize,
    end: Option<&'static str>,
}

impl<O: Objective> Solver<&mut O, Kept> for Projected<'_> {
    fn name(&self) -> &str {
        "projected limited-memory BFGS"
    }

    fn init(&mut self, problem: &mut Problem<&mut O>, mut state: Kept) -> Result<(Kept, Option<KV>), Error> {
        let x = state.take_param().unwrap_or_default();
        let objective = problem.problem.as_mut().ok_or_else(|| Error::msg("no problem"))?;
        let (value, point) = objective.value(&x).ok_or_else(|| Error::msg("a start without a value"))?;
        self.at = Some((value, objective.gradient(&point)));
        Ok((state.param(x).cost(value), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<&mut O>,
        mut state: Kept,
    ) -> Result<(Kept, Option<KV>), Error> {
        let x = state.take_param().unwrap_or_default();
        let objective = problem.problem.as_mut().ok_or_else(|| Error::msg("no problem"))?;
        let (value, gradient) = self.at.take().ok_or_else(|| Error::msg("no start"))?;
        let Some((next, new, point)) = self.searched(*objective, &x, value, &gradient) else {
            if self.memory.is_empty() {
                self.end = Some("no step lowers the value");
            } else {
                self.taken += 1;
            }
            self.memory.clear();
            self.at = Some((value, gradient));
            return Ok((state.param(x).cost(value), None));
        };
        objective.keep(&next, &point);
        let slopes = objective.gradient(&point);
        let moved: Vec<f64> = next.iter().zip(x.iter()).map(|(a, b)| a - b).collect();
        let turned: Vec<f64> = slopes.iter().zip(&gradient).map(|(a, b)| a - b).collect();
        if dot(&moved, &turned) > 1e-10 * dot(&turned, &turned).sqrt() * dot(&moved, &moved).sqrt() {
            self.memory.truncate(MEMORY - 1);
            self.memory.push_front((moved, turned));
        }
        self.taken += 1;
        if value - new <= SMALL * new.abs().max(1.0) {
            self.end = Some("nothing is gained any more");
        }
        self.at = Some((new, slopes));
        Ok((state.param(next).cost(new), None))
    }

    fn terminate(&mut self, _state: &Kept) -> TerminationStatus {
        let end = |why: &str| TerminationStatus::Terminated(TerminationReason::SolverExit(why.into()));
        self.end.map_or(TerminationStatus::NotTerminated, end)
    }
}

impl Projected<'_> {
    /// The first point, from a whole step on, that lowers the value enough.
    fn searched<O: Objective>(
        &self,
        objective: &mut O,
        x: &[f64],
        value: f64,
        gradient: &[f64],
    ) -> Option<(Vec<f64>, f64, O::Point)> {
        let [low, high] = self.bounds;
        let free: Vec<bool> = (0..x.len())
            .map(|i| !((x[i] <= low[i] && gradient[i] > 0.0) || (x[i] >= high[i] && gradient[i] < 0.0)))
            .collect();
        let direction = direction(gradient, &free, &self.memory);
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

#[cfg(test)]
mod tests {
    use super::*;

    struct Rosenbrock;

    impl Objective for Rosenbrock {
        type Point = [f64; 2];
        fn value(&mut self, x: &[f64]) -> Option<(f64, [f64; 2])> {
            Some(((1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2), [x[0], x[1]]))
        }
        fn gradient(&self, x: &[f64; 2]) -> Vec<f64> {
            let inner = x[1] - x[0] * x[0];
            vec![-2.0 * (1.0 - x[0]) - 400.0 * x[0] * inner, 200.0 * inner]
        }
        fn keep(&mut self, x: &[f64], _: &[f64; 2]) {
            assert!(x[0] <= 0.5);
        }
    }

    #[test]
    fn law_the_bound_that_binds_is_reached_and_the_rest_is_minimal() {
        let mut x = vec![-1.2, 1.0];
        minimise(&mut Rosenbrock, &mut x, [&[-2.0, -2.0], &[0.5, 2.0]], 200);
        // At x = 1/2 the best y is 1/4.
        assert!((x[0] - 0.5).abs() < 1e-8 && (x[1] - 0.25).abs() < 1e-6, "{x:?}");
    }
}
