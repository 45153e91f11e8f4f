//! Estimates with the noise that is found of their runs.

use rayon::prelude::*;

use super::noise::Guess;
use super::problems::{Problems, State};

/// Estimates with the noise that was found of each, in turns: from where they start, else from least squares. `before`: see
/// [`heard`].
pub(super) fn listened(problems: &Problems, starts: &[Vec<f64>], before: &[(Guess, f64)]) -> Vec<State> {
    let each = starts.par_iter().enumerate().map(|(problem, start)| {
        let found = heard(problems, problem, std::slice::from_ref(start), before);
        found.unwrap_or(State { parameters: start.clone(), noise: None })
    });
    each.collect()
}

/// The same of one of them, from the first of `starts` that leads to any, else from least squares. `before`: the kinds of noise
/// that were found of nearly the same model, the likeliest first.
pub(super) fn heard(
    problems: &Problems,
    problem: usize,
    starts: &[Vec<f64>],
    before: &[(Guess, f64)],
) -> Option<State> {
    let turns = problems.turns(problem);
    let elsewhere = || {
        let simple = problems.least_squares(&[problem]).pop();
        simple.and_then(|(_, parameters)| turns.found(&parameters, before))
    };
    let found = starts.iter().find_map(|start| turns.found(start, before)).or_else(elsewhere);
    found.map(|(parameters, noise)| State { parameters, noise: Some(noise) })
}
