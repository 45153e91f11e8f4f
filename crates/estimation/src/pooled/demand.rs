use numerics::LANES;
use regression::MeanRemoval;
use regression::pooled::{Parts, PooledRuns, Recorded};
use ship::model::Model;

use super::Pool;
use crate::Estimator;

/// Bytes that an estimate stores per run, and per part, wherever the samples are.
const KNOWN: [f64; 2] = [250.0, 60.0];

/// Bytes of a sample of a run.
fn sample_bytes(model: &Model) -> f64 {
    8.0 * (model.exogenous() + 3) as f64
}

/// Bytes of the sums of one part, and of the row of them that is always stored.
fn sums_bytes(model: &Model) -> [f64; 2] {
    let degree = |p: usize| (p + 1) * (p + 2) + 2 * p;
    let terms = || model.degrees.iter().map(|degree| degree.terms.len());
    // Including the vectors' own size.
    let sums = 8 * terms().map(degree).sum::<usize>() + 3 * 160 + 80;
    [sums as f64, 8.0 * terms().map(|p| p + 1).sum::<usize>() as f64]
}

/// Bytes of a sample of a part while it is processed: regressions with two kinds of instruments, scores, signals.
fn look_bytes(model: &Model) -> f64 {
    let terms: usize = model.degrees.iter().map(|degree| degree.terms.len()).sum();
    8.0 * (6 * terms + 12) as f64
}

impl Pool<'_> {
    /// Upper bound on the bytes of memory of a pooled estimate of `runs`, on `threads` threads.
    pub fn bytes<R: Recorded>(
        &self,
        runs: &PooledRuns<R>,
        estimator: Estimator,
        replicates: u32,
        threads: usize,
    ) -> f64 {
        let [sums, end] = sums_bytes(&self.model);
        let parts = self.cut(runs);
        // Least squares and instruments; means of every part; sums for resamples.
        let own = if self.removal == MeanRemoval::Batch { 4.0 * end + 400.0 } else { 2.0 * end };
        // `auto` draws from sums with two kinds of instruments; every thread adds those of its own resample.
        let kinds = if estimator == Estimator::Auto { 2.0 } else { 1.0 };
        let drawn = if replicates > 0 { kinds * sums + 24.0 + threads as f64 * (own + 16.0) } else { 0.0 };
        let resamples = f64::from(replicates) * (16.0 * self.vessel.model.parameters() as f64 + 60.0);
        let known = KNOWN[0] * runs.count() as f64 + KNOWN[1] * parts.count() as f64;
        let (simulates, searches) = match estimator {
            used if used.searches() && replicates > 0 => (threads, threads),
            used if used.searches() => (threads, 1),
            _ => (0, 1),
        };
        let (samples, longest) = runs.samples();
        let held = if runs.held() { samples } else { 0 };
        let windows = held + 3 * longest + searches * samples.min(runs.window());
        let together = 2 * LANES * simulates * longest_of(&parts).min(samples);
        known
            + resamples
            + parts.count() as f64 * (3.0 * own + drawn)
            + (windows + together) as f64 * sample_bytes(&self.model)
            + longest_of(&parts) as f64 * look_bytes(&self.model)
    }

    /// Upper bound on the bytes of memory of estimates from picked or left-out parts of `runs`, with all runs and
    /// parts in memory, on `threads` threads.
    pub fn bytes_of_many(&self, runs: &PooledRuns, threads: usize) -> f64 {
        let [sums, end] = sums_bytes(&self.model);
        let parts = self.cut(runs);
        let several = parts.count() as f64 * (3.0 * sums + 200.0 + threads as f64 * (6.0 * end + 16.0));
        let looks = (threads * longest_of(&parts)) as f64 * look_bytes(&self.model);
        4.0 * runs.samples().0 as f64 * sample_bytes(&self.model) + several + looks
    }
}

/// Samples of the longest part.
fn longest_of(parts: &impl Parts) -> usize {
    (0..parts.count()).map(|i| parts.samples(i)).max().unwrap_or(0)
}
