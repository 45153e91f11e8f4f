//! Estimates with the noise found for their runs.

use rayon::prelude::*;

use super::noise::Guess;
use super::problems::{Problems, State};

/// Estimates alternating with the noise found for each: from `starts`, else from least squares. `before`: see
/// [`with_noise`].
pub(super) fn each_with_noise(
    problems: &Problems,
    starts: &[Vec<f64>],
    before: &[(Guess, f64)],
) -> Vec<State> {
    let each = starts.par_iter().enumerate().map(|(problem, start)| {
        let found = with_noise(problems, problem, std::slice::from_ref(start), before);
        found.unwrap_or(State { parameters: start.clone(), noise: None })
    });
    each.collect()
}

/// The same for one of them, from the first of `starts` that succeeds, else from least squares. `before`: the kinds
/// of noise that were found for nearly the same model, the likeliest first.
pub(super) fn with_noise(
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
