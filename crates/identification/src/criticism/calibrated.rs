//! What disturbs a run where nobody says so: by the likelihood of the run itself.

use vessel::{Model, RunView};

use super::noise::{Guess, Search};
use crate::sensitivity::{Flow, Levels};

/// Noise and a drifting current that make a run most likely, found in turns with its parameters.
pub(crate) struct Calibration<'a> {
    search: Search<'a>,
    rate_hz: f64,
    found: Option<Guess>,
}

impl<'a> Calibration<'a> {
    /// Of `run` under `model`, which it starts with at a state that may be known.
    pub(crate) fn new(model: &'a Model, run: RunView, rate_hz: f64, known_start: bool) -> Self {
        let search = Search::new(model, std::iter::once(run), rate_hz, known_start);
        Self { search, rate_hz, found: None }
    }

    /// What is most likely under `parameters`, and twice its log-likelihood. Searches begin at what was found before, the
    /// first ones where the root mean square `errors` of free simulations say. None where the filter's numbers end.
    pub(crate) fn levels(&mut self, errors: [f64; 3], parameters: &[f64]) -> Option<(Levels, f64)> {
        let starts = match self.found {
            Some(found) => vec![found],
            None => Guess::first(errors, self.rate_hz),
        };
        let (found, worth) = self.search.from(&starts, parameters)?;
        self.found = Some(found);
        let (std, time_s) = found.current(self.rate_hz);
        let current = match time_s {
            None => Flow::White { std },
            Some(time_s) => {
                let (factor, turning) = (libm::exp(-1.0 / (self.rate_hz * time_s)), 1.0 / self.rate_hz);
                Flow::Markov { std, factor, turning }
            }
        };
        Some((Levels { measurement: found.measurement(), current, force: None }, worth))
    }
}
