use std::ops::Range;

use numerics::statistics::{quantile, sorted, spread};
use rayon::prelude::*;
use regression::Sums;
use regression::pooled::{AnyParts, Options, Unread, fit};
use ship::engine::Streams;

use super::{Estimated, NoEstimate, Pool};
use crate::Estimator;

/// The source of the resamples of a bootstrap.
#[derive(Clone, Copy)]
pub enum Resampling<'a> {
    /// They are drawn now; called with the number of finished ones.
    Drawn(&'a (dyn Fn(usize) + Sync)),
    /// They were drawn before, all of them: in shards.
    Given(&'a [Resample]),
}

/// Draws as many parts as there are, with replacement, and estimates again. Depends on seed and index alone.
pub(super) struct Resampler<'a> {
    pool: &'a Pool<'a>,
    estimated: &'a Estimated,
    parts: &'a AnyParts<'a>,
    streams: Streams,
    /// Sums part by part, for each estimator of a degree of freedom; empty if each resample is simulated.
    sums: Vec<(Estimator, Vec<Sums>)>,
}

impl<'a> Resampler<'a> {
    /// Makes a pass over the parts for each estimator that needs their sums.
    ///
    /// # Errors
    /// Parts that cannot be read.
    pub fn new(pool: &'a Pool, of: &'a Estimated, parts: &'a AnyParts, seed: u64) -> Result<Self, Unread> {
        let mut sums = Vec::new();
        for used in Estimator::ALL {
            let by = |d: &usize| of.used[*d] == used && of.degrees[*d].solution.is_some();
            let Some(d) = [0, 1, 2].into_iter().find(by) else { continue };
            let mut part_sums = Vec::new();
            if !used.searches() {
                match pool.sums_any(parts, of.simulated(d), &mut |_, sums| part_sums.push(sums.clone())) {
                    Err(NoEstimate::Unread(e)) => return Err(e),
                    // Parts that diverge were refused before.
                    Err(NoEstimate::Lost(_)) => continue,
                    Ok(_) => {}
                }
            }
            sums.push((used, part_sums));
        }
        let streams = Streams::new(seed, "bootstrap over sub-experiments");
        Ok(Self { pool, estimated: of, parts, streams, sums })
    }

    /// Resample `number`.
    ///
    /// # Errors
    /// Parts that cannot be read.
    pub fn draw(&self, number: u32) -> Result<Resample, Unread> {
        let places = redraw(&self.streams, number, self.parts.count());
        let mut theta: [Option<Vec<f64>>; 3] = Default::default();
        for (used, sums) in &self.sums {
            let mut thetas = match used {
                used if used.searches() => self.searched_again(&places)?,
                _ => self.fitted(*used, &places.iter().map(|i| &sums[*i]).collect::<Vec<_>>()),
            };
            for d in (0..3).filter(|d| self.estimated.used[*d] == *used) {
                theta[d] = thetas[d].take();
            }
        }
        let layout = self.pool.vessel.model.layout();
        let of = |(d, estimate): (usize, Option<Vec<f64>>)| match estimate {
            Some(theta) => theta.into_iter().map(Some).collect(),
            None => vec![None; layout.terms(d).len()],
        };
        Ok(Resample { number, theta: theta.into_iter().enumerate().flat_map(of).collect() })
    }

    /// The first `count` of them. `done` is called with the number of finished ones.
    ///
    /// # Errors
    /// Parts that cannot be read.
    pub fn first(&self, count: u32, done: &(dyn Fn(usize) + Sync)) -> Result<Vec<Resample>, Unread> {
        let work = |number: u32| {
            let resample = self.draw(number);
            done(1);
            resample
        };
        (0..count).into_par_iter().map(work).collect()
    }

    fn fitted(&self, used: Estimator, sums: &[&Sums]) -> [Option<Vec<f64>>; 3] {
        let nominal = self.estimated.nominal.as_ref().map(|(theta, _)| theta.as_slice());
        // Collinear resamples are accepted: their spread is the result.
        let options = Options { most: f64::INFINITY, ..self.pool.options(nominal, used) };
        fit(sums, &options).map(|degree| degree.solution.map(|solution| solution.theta))
    }

    fn searched_again(&self, places: &[usize]) -> Result<[Option<Vec<f64>>; 3], Unread> {
        let thetas = self.pool.searched_again(self.parts, places, self.estimated)?;
        Ok(thetas.map_or_else(Default::default, |thetas| thetas.map(Some)))
    }
}

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
    /// The bootstrap of the parameters at `places`; `None` if fewer than two resamples have an estimate.
    pub fn of_resamples(resamples: &[Resample], places: &Range<usize>) -> Option<Self> {
        let theta_of = |resample: &Resample| resample.theta[places.clone()].iter().copied().collect();
        let thetas: Vec<Vec<f64>> = resamples.iter().filter_map(theta_of).collect();
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
