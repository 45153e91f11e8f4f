use super::Estimated;
use super::windows::{StateDeviations, StateMeans};

/// How well the instruments' u, v, r follow the measured ones, part by part.
#[derive(Clone, Debug)]
pub struct InstrumentFit {
    squares: [f64; 3],
    samples: f64,
    deviations: StateDeviations,
}

impl InstrumentFit {
    /// The fit over the parts that `found` was estimated from.
    pub fn new(found: &Estimated) -> Self {
        Self::from_deviations(found.means().deviations())
    }

    /// The fit over parts with these `measured` states.
    pub fn of<'a>(measured: impl Iterator<Item = &'a [f64]>) -> Self {
        let mut means = StateMeans::default();
        measured.for_each(|states| means.add(states));
        Self::from_deviations(means.deviations())
    }

    fn from_deviations(deviations: StateDeviations) -> Self {
        Self { squares: [0.0; 3], samples: 0.0, deviations }
    }

    /// Adds a part: the states that its instruments are formed with, and the measured ones.
    pub fn add(&mut self, states: &[f64], measured: &[f64]) {
        self.deviations.add(measured);
        for (z, y) in states.chunks_exact(3).zip(measured.chunks_exact(3)).skip(1) {
            (0..3).for_each(|d| self.squares[d] += (z[d] - y[d]) * (z[d] - y[d]));
            self.samples += 1.0;
        }
    }

    /// 100 (1 − RMSE/std) \[%\]; `None` if a state does not vary, and without instruments.
    pub fn found(&self) -> Option<[f64; 3]> {
        let std = self.deviations.found();
        let fits = [0, 1, 2].map(|d: usize| 100.0 * (1.0 - (self.squares[d] / self.samples).sqrt() / std[d]));
        fits.iter().all(|f| f.is_finite()).then_some(fits)
    }
}
