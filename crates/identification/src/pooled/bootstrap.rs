use std::ops::Range;

use engine::Streams;
use numerics::statistics::{quantile, sorted, spread};

/// The estimate from parts drawn again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resample {
    /// Which of the resamples it is.
    pub number: u32,
    /// θ̂: surge, sway, yaw; none where this resample has no estimate of the degree of freedom.
    pub theta: Vec<Option<f64>>,
}

/// What resampling the parts says about one degree of freedom.
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

/// Places of the parts that replicate number `replicate` draws from `count`: as many, with replacement.
pub fn redraw(streams: &Streams, replicate: u32, count: usize) -> Vec<usize> {
    streams.choices(replicate, 0, count.max(1) as u32, count).into_iter().map(|i| i as usize).collect()
}

impl Bootstrap {
    /// Of the parameters at `places` in all `resamples`; `None` where fewer than two of these have an estimate.
    pub fn of_resamples(resamples: &[Resample], places: &Range<usize>) -> Option<Self> {
        let own = |resample: &Resample| resample.theta[places.clone()].iter().copied().collect();
        let thetas: Vec<Vec<f64>> = resamples.iter().filter_map(own).collect();
        Self::of(&thetas, resamples.len())
    }

    /// Of the estimates `thetas` that `replicates` resamples gave; `None` from fewer than two.
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
