//! What disturbs runs where nobody says so: by the likelihood of the runs themselves.

use vessel::{Model, RunView};

use super::noise::{Guess, Search};
use crate::sensitivity::{Flow, Levels};

/// How often noise and parameters are found in turns.
const TURNS: usize = 3;

/// Noise and a drifting current that make runs most likely, found in turns with the parameters.
pub(crate) struct Calibration<'a> {
    search: Search<'a>,
    rate_hz: f64,
    /// Root mean square errors of free simulations, which the first searches begin at.
    errors: [f64; 3],
}

impl<'a> Calibration<'a> {
    /// Of `runs` under `model`, which start at states that may be known; free simulations of it err by `errors`.
    pub(crate) fn new<'r>(
        model: &'a Model,
        runs: impl Iterator<Item = RunView<'r>>,
        rate_hz: f64,
        known_start: bool,
        errors: [f64; 3],
    ) -> Self {
        Self { search: Search::new(model, runs, rate_hz, known_start), rate_hz, errors }
    }

    /// The most likely of what `fit` finds in turns with disturbances, beginning with parameters `theta`: `fit` is called with
    /// disturbances and parameters, and gives others and whatever it has found, which comes with twice its log-likelihood. Each search of disturbances goes on from the last
    /// one's and judges the parameters before it. None where the filter's numbers end.
    ///
    /// # Errors
    /// Those of `fit`.
    pub(crate) fn in_turns<T, E>(
        &self,
        mut theta: Vec<f64>,
        mut fit: impl FnMut(&Levels, &[f64]) -> Result<Option<(Vec<f64>, T)>, E>,
    ) -> Result<Option<(f64, T)>, E> {
        let mut best: Option<(f64, T)> = None;
        let Some((mut guess, _)) = self.search.from(&Guess::first(self.errors, self.rate_hz), &theta) else {
            return Ok(None);
        };
        for _ in 0..TURNS {
            let levels = self.levels(&guess);
            let Some((next, found)) = fit(&levels, &theta)? else { break };
            let Some((again, worth)) = self.search.from(&[guess], &next) else { break };
            if best.as_ref().is_none_or(|(most, _)| worth > *most) {
                best = Some((worth, found));
            }
            (guess, theta) = (again, next);
        }
        Ok(best)
    }

    fn levels(&self, guess: &Guess) -> Levels {
        let (std, time_s) = guess.current(self.rate_hz);
        let current = match time_s {
            None => Flow::White { std },
            Some(time_s) => {
                let (factor, turning) = (libm::exp(-1.0 / (self.rate_hz * time_s)), 1.0 / self.rate_hz);
                Flow::Markov { std, factor, turning }
            }
        };
        Levels { measurement: guess.measurement(), current, force: None }
    }
}
