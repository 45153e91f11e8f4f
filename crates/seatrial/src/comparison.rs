//! A model on recordings that it was not fitted to.

use model::Vessel;
use regression::pooled::PooledRuns;
use study::Tried;
use study::documents::CompareDocument;
use validation::comparison::{CompareOptions, Contestant, Ship, Standing, Traced, compare};
use validation::crossval::CrossError;

/// Compares a model with least squares of the same data, the mean of the recordings, and another model.
pub struct Comparison<'a> {
    /// The model, or several whose trajectories are averaged.
    pub model: &'a Tried,
    /// Another model of the same channels.
    pub other: Option<&'a Vessel>,
    /// Length of the simulated windows in samples; whole runs without it.
    pub window: Option<usize>,
}

impl Comparison<'_> {
    /// The verdict of `runs`, and the model's simulation of them sample by sample.
    ///
    /// # Errors
    /// No run as long as a window.
    pub fn over(&self, runs: &PooledRuns) -> Result<(CompareDocument, Vec<Traced>), CrossError> {
        let Self { model, other, window } = *self;
        let others = [(Standing::Other, other), (Standing::LeastSquares, model.by_least_squares())];
        let mut contestants = vec![Contestant { standing: model.standing(), ships: model.ships() }];
        contestants.extend(others.into_iter().filter_map(|(standing, vessel)| {
            let Vessel { model, nominal, .. } = vessel?;
            Some(Contestant { standing, ships: vec![Ship { model, theta: nominal }] })
        }));
        let (covered, magnitudes, vessel) = (model.covered(), model.magnitudes(), model.vessel());
        let rate_hz = vessel.sample_rate_hz;
        let options = CompareOptions { window, known: model.known(), covered, magnitudes, rate_hz };
        let found = compare(&contestants, runs, &options)?;
        let window_s = window.map(|samples| samples as f64 / rate_hz);
        Ok((CompareDocument::new(&vessel.name, window_s, &found), found.trace))
    }
}
