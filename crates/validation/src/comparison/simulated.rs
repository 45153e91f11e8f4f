use vessel::{Model, check_diverged, simulate_one};

use super::errors::{ComparedRecording, Sums};
use super::standing::{ComparedModel, Standing};
use identification::pooled::{Part, deviations};

/// A model that takes part.
#[derive(Clone, Copy, Debug)]
pub struct Contestant<'a> {
    /// As what.
    pub standing: Standing,
    /// Its structure.
    pub model: &'a Model,
    /// Its parameters: surge, sway, yaw.
    pub theta: &'a [f64],
}

/// The states of every window of every source, as one model has them; none where it diverges.
pub(super) struct Simulated {
    standing: Standing,
    pub windows: Vec<Vec<Option<Vec<f64>>>>,
    /// Sums by source and window.
    pub sums: Vec<Vec<Sums>>,
}

impl Simulated {
    fn new(
        standing: Standing,
        sources: &[(String, Vec<Part>)],
        simulate: impl Fn(&[Part], &Part) -> Option<Vec<f64>>,
    ) -> Self {
        let (mut windows, mut sums) = (Vec::new(), Vec::new());
        for (_, own) in sources {
            let states: Vec<Option<Vec<f64>>> = own.iter().map(|window| simulate(own, window)).collect();
            let sum = |(window, states): (&Part, &Option<Vec<f64>>)| {
                let mut sum = Sums::default();
                sum.add(window, states.as_deref());
                sum
            };
            sums.push(own.iter().zip(&states).map(sum).collect());
            windows.push(states);
        }
        Self { standing, windows, sums }
    }

    pub fn of(one: &Contestant, sources: &[(String, Vec<Part>)]) -> Self {
        Self::new(one.standing, sources, |_, window| {
            let states = simulate_one(one.model, one.theta, window.view().initial, &window.exogenous);
            check_diverged(states.iter().copied()).is_none().then_some(states)
        })
    }

    /// The mean of each source's windows.
    pub fn mean(sources: &[(String, Vec<Part>)]) -> Self {
        Self::new(Standing::Mean, sources, |all, window| {
            let rows = || all.iter().flat_map(|w| w.measured.as_chunks::<3>().0.iter().skip(1));
            let n = rows().count().max(1) as f64;
            let mean = [0, 1, 2].map(|d: usize| rows().map(|row| row[d]).sum::<f64>() / n);
            Some(mean.repeat(window.samples() + 1))
        })
    }

    pub fn told(&self, sources: &[(String, Vec<Part>)], std: [f64; 3]) -> ComparedModel {
        let mut whole = Sums::default();
        let recording = |((source, windows), sums): (&(String, Vec<Part>), &Vec<Sums>)| {
            let mut own = Sums::default();
            sums.iter().for_each(|sum| own.merge(sum));
            whole.merge(&own);
            let varies = deviations(windows.iter().map(|w| w.measured.as_slice()));
            ComparedRecording { source: source.clone(), errors: own.errors(varies, std) }
        };
        let recordings = sources.iter().zip(&self.sums).map(recording).collect();
        ComparedModel { name: self.standing, errors: whole.errors(std, std), recordings }
    }
}
