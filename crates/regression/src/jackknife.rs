/// Number of blocks of samples that are left out in turn.
pub const BLOCKS: usize = 10;
/// Quantile of Student's t with nine degrees of freedom over that of the normal distribution, for 95 % intervals.
const STUDENT: f64 = 2.262_157_163 / 1.959_963_985;

/// Jackknife covariance of an estimate, from its changes `without` each block, scaled so that 1.96 standard errors
/// give a 95 % interval. `None` if it is not finite.
pub fn jackknife<B>(
    blocks: impl ExactSizeIterator<Item = B>,
    without: impl Fn(B) -> Option<Vec<f64>>,
) -> Option<Vec<f64>> {
    let count = blocks.len() as f64;
    let share = STUDENT * STUDENT * (count - 1.0) / count;
    let mut covariance: Vec<f64> = Vec::new();
    for block in blocks {
        let moved = without(block)?;
        let p = moved.len();
        covariance.resize(p * p, 0.0);
        for (k, sum) in covariance.iter_mut().enumerate() {
            *sum += share * moved[k / p] * moved[k % p];
        }
    }
    covariance.iter().all(|c| c.is_finite()).then_some(covariance)
}
