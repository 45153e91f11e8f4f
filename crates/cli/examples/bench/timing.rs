//! How long something takes.

use std::time::Instant;

/// The shortest of `repetitions` timings of `work` \[s\], and its last result.
pub fn fastest<T>(
    repetitions: usize,
    mut work: impl FnMut() -> anyhow::Result<T>,
) -> anyhow::Result<(f64, T)> {
    let mut best = f64::INFINITY;
    let mut last = None;
    for _ in 0..repetitions.max(1) {
        let started = Instant::now();
        last = Some(work()?);
        best = best.min(started.elapsed().as_secs_f64());
    }
    last.map(|result| (best, result)).ok_or_else(|| anyhow::anyhow!("nothing measured"))
}
