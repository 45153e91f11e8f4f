use std::ops::Range;

use numerics::statistics::{quantile, sorted, spread};
use ship::engine::Streams;

/// The estimate from resampled parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resample {
    /// The index of the resample.
    pub number: u32,
    /// θ̂: surge, sway, yaw; `None` if this resample has no estimate of the degree of freedom.
    pub theta: Vec<Option<f64>>,
}

/// The bootstrap over parts for one degree of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct Bootstrap {
    /// One entry per parameter.
    pub parameters: Vec<Resampled>,
    /// Resamples without an estimate.
    pub failed: usize,
}

/// One parameter over the resamples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resampled {
    /// Standard deviation.
    pub std: f64,
    /// 2.5 % quantile.
    pub low: f64,
    /// 97.5 % quantile.
    pub high: f64,
}

/// Indices of the parts that replicate `replicate` draws from `count`: as many, with replacement.
pub fn redraw(streams: &Streams, replicate: u32, count: usize) -> Vec<usize> {
    streams.choices(replicate, 0, count.max(1) as u32, count).into_iter().map(|i| i as usize).collect()
}

impl Bootstrap {
    /// The bootstrap of the parameters at `places` in all `resamples`; `None` if fewer than two of these have an
    /// estimate.
    pub fn of_resamples(resamples: &[Resample], places: &Range<usize>) -> Option<Self> {
        let own = |resample: &Resample| resample.theta[places.clone()].iter().copied().collect();
        let thetas: Vec<Vec<f64>> = resamples.iter().filter_map(own).collect();
        Self::of(&thetas, resamples.len())
    }

    /// The bootstrap from the estimates `thetas` of `replicates` resamples; `None` from fewer than two.
    pub fn of(thetas: &[Vec<f64>], replicates: usize) -> Option<Self> {
        let parameter = |i: usize| {
            let values = sorted(thetas.iter().map(|theta| Some(theta[i])));
            let at = |q: f64| quantile(&values, q);
            Some(Resampled { std: spread(&values)?, low: at(0.025)?, high: at(0.975)? })
        };
        let parameters: Option<Vec<Resampled>> = (0..thetas.first()?.len()).map(parameter).collect();
        Some(Self { parameters: parameters?, failed: replicates - thetas.len() })
    }
}
