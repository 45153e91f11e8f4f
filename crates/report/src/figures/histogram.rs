/// Counts of values in equal bins from 0 to a limit, with everything else accounted for.
///
/// `counts`, `beyond` and `missing` sum to the number of runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Histogram {
    /// Values per bin; bin i holds i·limit/bins ≤ value < (i+1)·limit/bins. Negative values are in the first.
    pub counts: Vec<usize>,
    /// Values at or above the limit.
    pub beyond: usize,
    /// Runs without a finite value.
    pub missing: usize,
}

impl Histogram {
    /// Counts `values` in `bins` bins from 0 to `limit` (in the values' unit).
    #[must_use]
    pub fn new(values: &[Option<f64>], limit: f64, bins: usize) -> Self {
        let mut histogram = Self { counts: vec![0; bins.max(1)], beyond: 0, missing: 0 };
        for value in values {
            histogram.add(*value, limit);
        }
        histogram
    }

    /// Number of runs.
    #[must_use]
    pub fn runs(&self) -> usize {
        self.counts.iter().sum::<usize>() + self.beyond + self.missing
    }

    pub(crate) fn tallest(&self) -> usize {
        self.counts.iter().copied().max().unwrap_or(0)
    }

    fn add(&mut self, value: Option<f64>, limit: f64) {
        match value.filter(|v| v.is_finite()) {
            None => self.missing += 1,
            Some(value) if value >= limit => self.beyond += 1,
            Some(value) => {
                let last = self.counts.len() - 1;
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates")]
                let bin = (value / limit * self.counts.len() as f64) as usize;
                self.counts[bin.min(last)] += 1;
            }
        }
    }
}
