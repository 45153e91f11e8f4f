use numerics::statistics::{quantile, sorted, spread};
use vessel::Streams;

use super::{Options, fit};
use crate::Sums;

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

/// Draws as many of `parts` as there are, with replacement, `replicates` times, and estimates anew. `None` for a degree of
/// freedom with fewer than two estimates. What a replicate draws depends on `streams` and its number alone.
pub fn bootstrap(
    parts: &[&Sums],
    options: &Options,
    replicates: u32,
    streams: &Streams,
) -> [Option<Bootstrap>; 3] {
    let count = parts.len();
    let mut found: [Vec<Vec<f64>>; 3] = Default::default();
    for replicate in 0..replicates {
        let resample: Vec<&Sums> = redraw(streams, replicate, count).into_iter().map(|i| parts[i]).collect();
        for (d, degree) in fit(&resample, options).into_iter().enumerate() {
            found[d].extend(degree.solution.map(|s| s.theta));
        }
    }
    found.map(|thetas| Bootstrap::of(&thetas, replicates as usize))
}

/// Places of the parts that replicate number `replicate` draws from `count`: as many, with replacement.
pub fn redraw(streams: &Streams, replicate: u32, count: usize) -> Vec<usize> {
    streams.choices(replicate, 0, count.max(1) as u32, count).into_iter().map(|i| i as usize).collect()
}

impl Bootstrap {
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
