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

/// Sweeps over all pairs of columns; a handful is enough.
const SWEEPS: usize = 60;

/// The weakest direction of A (n × n). `None` where an entry is not finite or A is zero.
///
/// One-sided Jacobi rotations make the columns of AV orthogonal: their lengths are the singular values. Sums and square roots
/// alone, in a fixed order, so every processor finds the same bits; a library's decomposition fuses where it can.
pub fn weakest(n: usize, a: &[f64]) -> Option<Weakest> {
    let largest = a.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    if !a.iter().all(|x| x.is_finite()) || largest == 0.0 {
        return None;
    }
    // Column after column; entries of at most 1, so that squares neither overflow nor all vanish.
    let mut product: Vec<f64> = (0..n * n).map(|k| a[k % n * n + k / n] / largest).collect();
    let mut v: Vec<f64> = (0..n * n).map(|k| f64::from(u8::from(k / n == k % n))).collect();
    for _ in 0..SWEEPS {
        let mut turned = false;
        for j in 1..n {
            for i in 0..j {
                if let Some(turn) = Turn::between(column(&product, n, i), column(&product, n, j)) {
                    turn.apply(&mut product, n, [i, j]);
                    turn.apply(&mut v, n, [i, j]);
                    turned = true;
                }
            }
        }
        if !turned {
            break;
        }
    }
    let lengths: Vec<f64> =
        (0..n).map(|i| dot(column(&product, n, i), column(&product, n, i)).sqrt()).collect();
    let by_length = |i: &usize, j: &usize| lengths[*i].total_cmp(&lengths[*j]);
    let (least, most) = ((0..n).min_by(by_length)?, (0..n).max_by(by_length)?);
    Some(Weakest { ratio: lengths[least] / lengths[most], direction: column(&v, n, least).to_vec() })
}

/// A rotation of two columns.
struct Turn {
    cos: f64,
    sin: f64,
}

impl Turn {
    /// That which makes two columns orthogonal; none where they are.
    fn between(one: &[f64], other: &[f64]) -> Option<Self> {
        let (a, b, c) = (dot(one, one), dot(other, other), dot(one, other));
        if c.abs() <= f64::EPSILON * (a * b).sqrt() {
            return None;
        }
        let zeta = (b - a) / (2.0 * c);
        let tan = 1.0f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
        let cos = 1.0 / (1.0 + tan * tan).sqrt();
        Some(Self { cos, sin: cos * tan })
    }

    fn apply(&self, columns: &mut [f64], n: usize, [i, j]: [usize; 2]) {
        for row in 0..n {
            let (x, y) = (columns[i * n + row], columns[j * n + row]);
            columns[i * n + row] = self.cos * x - self.sin * y;
            columns[j * n + row] = self.sin * x + self.cos * y;
        }
    }
}

fn column(columns: &[f64], n: usize, i: usize) -> &[f64] {
    &columns[i * n..(i + 1) * n]
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(x, y)| x * y).sum()
}
