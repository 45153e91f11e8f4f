use super::problems::{Problems, State, newton_step};
use crate::predictor::Linear;

/// Maximum number of refinements under the noise.
const ROUNDS: usize = 12;
/// Above this variance of the white errors another start is tried.
const FAR: f64 = 1.3;
/// The estimate has converged at a smaller decrease of the squared white errors.
const SETTLED: f64 = 1e-2;
/// Maximum number of halvings of a step.
const SHORTER: i32 = 6;

/// Estimates while they are refined to the least white errors under stated noise.
pub(super) struct Refinement<'a> {
    problems: &'a Problems<'a>,
    states: Vec<State>,
    errors: Vec<Option<Linear>>,
}

impl<'a> Refinement<'a> {
    pub fn new(problems: &'a Problems<'a>, starts: &[Vec<f64>]) -> Self {
        let state = |start: &Vec<f64>| State { parameters: start.clone(), noise: None };
        Self { problems, states: starts.iter().map(state).collect(), errors: Vec::new() }
    }

    pub fn run(mut self) -> Vec<State> {
        self.settle((0..self.states.len()).collect());
        self.elsewhere();
        self.states
    }

    /// If errors are far above the noise, restarts from least squares and keeps the better result.
    fn elsewhere(&mut self) {
        let far = |errors: &Option<Linear>| {
            errors.as_ref().is_none_or(|errors| squares(errors) > FAR * 3.0 * errors.samples)
        };
        let open: Vec<usize> = (0..self.errors.len()).filter(|problem| far(&self.errors[*problem])).collect();
        if open.is_empty() {
            return;
        }
        let (states, errors) = (self.states.clone(), self.errors.clone());
        for (problem, parameters) in self.problems.least_squares(&open) {
            self.states[problem] = State { parameters, noise: None };
        }
        self.settle(open.clone());
        let err = |errors: &Option<Linear>| errors.as_ref().map_or(f64::INFINITY, squares);
        for problem in open {
            if err(&self.errors[problem]) >= err(&errors[problem]) {
                self.states[problem] = states[problem].clone();
                self.errors[problem].clone_from(&errors[problem]);
            }
        }
    }

    fn settle(&mut self, mut open: Vec<usize>) {
        let found = self.problems.white(&open, &self.states);
        self.errors.resize(found.len(), None);
        for (problem, found) in found.into_iter().enumerate().filter(|(problem, _)| open.contains(problem)) {
            self.errors[problem] = found;
        }
        for _ in 0..ROUNDS {
            open = self.step(&open);
            if open.is_empty() {
                break;
            }
        }
    }

    /// Makes a step of each of the `open` ones; returns those that improved.
    fn step(&mut self, open: &[usize]) -> Vec<usize> {
        let newton = |problem: &usize| {
            let (step, decrement) = newton_step(self.errors[*problem].as_ref()?)?;
            (decrement >= SETTLED).then_some((*problem, step))
        };
        let mut left: Vec<(usize, Vec<f64>)> = open.iter().filter_map(newton).collect();
        let mut helped = Vec::new();
        // Halved steps if the whole one diverges.
        for share in (0..SHORTER).map(|halved| 0.5_f64.powi(halved)) {
            if left.is_empty() {
                break;
            }
            let mut trials = self.states.clone();
            for (problem, step) in &left {
                let own = trials[*problem].parameters.iter_mut().zip(step);
                own.for_each(|(p, s)| *p += share * s);
            }
            let tried: Vec<usize> = left.iter().map(|(problem, _)| *problem).collect();
            let mut found = self.problems.white(&tried, &trials);
            left.retain(|(problem, _)| {
                let better = found[*problem].as_ref().is_some_and(|found| {
                    self.errors[*problem].as_ref().is_none_or(|before| nearer(found, before))
                });
                if better {
                    self.states[*problem] = trials[*problem].clone();
                    self.errors[*problem] = found[*problem].take();
                    helped.push(*problem);
                }
                !better
            });
        }
        helped.sort_unstable();
        helped
    }
}

/// Whether white errors are smaller, or closer to a stationary point: the filter depends on the estimate, so sums of
/// squares may rise on the way.
fn nearer(found: &Linear, before: &Linear) -> bool {
    let left = |sums: &Linear| newton_step(sums).map_or(f64::INFINITY, |(_, decrement)| decrement);
    squares(found) < squares(before) || left(found) < left(before)
}

fn squares(sums: &Linear) -> f64 {
    sums.squares.iter().sum()
}
