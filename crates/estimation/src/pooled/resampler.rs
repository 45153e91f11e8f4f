use rayon::prelude::*;
use regression::Sums;
use regression::pooled::{AnyParts, Options, Unread, fit};
use ship::engine::Streams;

use super::{Estimated, NoEstimate, Pool, Resample, redraw};
use crate::Estimator;

/// The source of the resamples of a bootstrap.
#[derive(Clone, Copy)]
pub enum Resampling<'a> {
    /// They are drawn now; called with the number of finished ones.
    Drawn(&'a (dyn Fn(usize) + Sync)),
    /// They were drawn before, all of them: in shards.
    Given(&'a [Resample]),
}

/// Draws as many parts as there are, with replacement, and estimates as `found` was. The result depends on the seed
/// and the index of the resample alone.
pub(super) struct Resampler<'a> {
    pool: &'a Pool<'a>,
    found: &'a Estimated,
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
    pub fn new(pool: &'a Pool, found: &'a Estimated, parts: &'a AnyParts, seed: u64) -> Result<Self, Unread> {
        let mut sums = Vec::new();
        for used in Estimator::ALL {
            let by = |d: &usize| found.used[*d] == used && found.degrees[*d].solution.is_some();
            let Some(d) = [0, 1, 2].into_iter().find(by) else { continue };
            let mut own = Vec::new();
            if !used.searches() {
                match pool.sums_any(parts, found.simulated(d), &mut |_, sums| own.push(sums.clone())) {
                    Err(NoEstimate::Unread(e)) => return Err(e),
                    // Parts that diverge were refused before.
                    Err(NoEstimate::Lost(_)) => continue,
                    Ok(_) => {}
                }
            }
            sums.push((used, own));
        }
        let streams = Streams::new(seed, "bootstrap over sub-experiments");
        Ok(Self { pool, found, parts, streams, sums })
    }

    /// Resample `number`.
    ///
    /// # Errors
    /// Parts that cannot be read.
    pub fn draw(&self, number: u32) -> Result<Resample, Unread> {
        let places = redraw(&self.streams, number, self.parts.count());
        let mut theta: [Option<Vec<f64>>; 3] = Default::default();
        for (used, sums) in &self.sums {
            let mut own = match used {
                used if used.searches() => self.searched_again(&places)?,
                _ => self.fitted(*used, &places.iter().map(|i| &sums[*i]).collect::<Vec<_>>()),
            };
            for d in (0..3).filter(|d| self.found.used[*d] == *used) {
                theta[d] = own[d].take();
            }
        }
        let layout = self.pool.vessel.model.layout();
        let of = |(d, own): (usize, Option<Vec<f64>>)| match own {
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
        let nominal = self.found.nominal.as_ref().map(|(theta, _)| theta.as_slice());
        // Collinear resamples are accepted: their spread is the result.
        let options = Options { most: f64::INFINITY, ..self.pool.options(nominal, used) };
        fit(sums, &options).map(|degree| degree.solution.map(|solution| solution.theta))
    }

    /// For a search: simulates or predicts the parts and fits again.
    fn searched_again(&self, places: &[usize]) -> Result<[Option<Vec<f64>>; 3], Unread> {
        let thetas = self.pool.searched_again(self.parts, places, self.found)?;
        Ok(thetas.map_or_else(Default::default, |thetas| thetas.map(Some)))
    }
}
