/// Blocks of samples that are left out, one after the other.
pub const BLOCKS: usize = 10;
/// Student's t of nine degrees of freedom over the normal distribution's, for intervals of 95 %.
const STUDENT: f64 = 2.262_157_163 / 1.959_963_985;

/// Covariance of an estimate by what it changes where a block is left out, as `without` says; in units in which 1.96 standard
/// errors are an interval of 95 %. None where that is not a number.
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
