use faer::MatRef;

/// The direction in which a matrix does least.
#[derive(Clone, Debug, PartialEq)]
pub struct Weakest {
    /// Smallest over largest singular value: the reciprocal condition number.
    pub ratio: f64,
    /// The right singular vector of the smallest singular value.
    pub direction: Vec<f64>,
}

impl Weakest {
    /// Which of the first `n` entries dominates the direction.
    pub fn dominant(&self, n: usize) -> usize {
        let size = |i: &usize| self.direction[*i].abs();
        (0..n).max_by(|i, j| size(i).total_cmp(&size(j))).unwrap_or(0)
    }
}

/// The weakest direction of A (n × n). `None` where an entry is not finite or A is zero.
pub fn weakest(n: usize, a: &[f64]) -> Option<Weakest> {
    if !a.iter().all(|x| x.is_finite()) || a.iter().all(|x| *x == 0.0) {
        return None;
    }
    let svd = MatRef::from_row_major_slice(a, n, n).svd().ok()?;
    let values = svd.S().column_vector();
    let direction = (0..n).map(|i| svd.V()[(i, n - 1)]).collect();
    Some(Weakest { ratio: values[n - 1] / values[0], direction })
}
