//! The paper's equations written out: no lanes, no sums that merge, no shared code.

use super::Recording;

/// Regressors of surge, sway and yaw at a state u, v, r and inputs τ1, τ2, τ3.
pub fn regressors(state: &[f64], tau: &[f64]) -> [Vec<f64>; 3] {
    let (u, v, r) = (state[0], state[1], state[2]);
    [vec![u, u * u.abs(), v * r, tau[0]], vec![v, u * r, tau[1]], vec![r, u * v, tau[2]]]
}

/// One degree of freedom of a run: rows of φ and ζ (N × p) and Δy (N).
pub struct Regression {
    pub phi: Vec<Vec<f64>>,
    pub zeta: Vec<Vec<f64>>,
    pub target: Vec<f64>,
}

impl Regression {
    pub fn of(run: &Recording, d: usize) -> Self {
        let row = |states: &[f64], k: usize| {
            regressors(&states[3 * k..3 * k + 3], &run.exogenous[3 * k..3 * k + 3])[d].clone()
        };
        let n = run.samples();
        Self {
            phi: (0..n).map(|k| row(&run.measured, k)).collect(),
            zeta: (0..n).map(|k| row(&run.instrument_states, k)).collect(),
            target: (0..n).map(|k| run.measured[3 * (k + 1) + d] - run.measured[3 * k + d]).collect(),
        }
    }

    pub fn parameters(&self) -> usize {
        self.phi[0].len()
    }

    /// Subtracts the mean of ζ over each group of samples; `starts` are the groups' first samples.
    pub fn subtract_instrument_means(&mut self, starts: &[usize]) {
        for (group, start) in starts.iter().enumerate() {
            let end = starts.get(group + 1).copied().unwrap_or(self.zeta.len());
            for i in 0..self.parameters() {
                let mean = self.zeta[*start..end].iter().map(|z| z[i]).sum::<f64>() / (end - start) as f64;
                self.zeta[*start..end].iter_mut().for_each(|z| z[i] -= mean);
            }
        }
    }

    /// Appends one column per group to φ and ζ: 1 in the group, 0 elsewhere.
    pub fn lift(&mut self, starts: &[usize]) {
        for k in 0..self.phi.len() {
            let group = starts.iter().rposition(|start| *start <= k);
            for g in 0..starts.len() {
                let indicator = if Some(g) == group { 1.0 } else { 0.0 };
                self.phi[k].push(indicator);
                self.zeta[k].push(indicator);
            }
        }
    }

    /// Solves Σ ζ (Δy − φᵀθ) = 0.
    pub fn solve(&self) -> Vec<f64> {
        let p = self.parameters();
        let (mut a, mut b) = (vec![vec![0.0; p]; p], vec![0.0; p]);
        for ((phi, zeta), target) in self.phi.iter().zip(&self.zeta).zip(&self.target) {
            for i in 0..p {
                for j in 0..p {
                    a[i][j] += zeta[i] * phi[j];
                }
                b[i] += zeta[i] * target;
            }
        }
        solve(a, b)
    }
}

/// Root mean square of each column.
pub fn sizes(rows: &[Vec<f64>]) -> Vec<f64> {
    let square = |i: usize| rows.iter().map(|row| row[i] * row[i]).sum::<f64>() / rows.len() as f64;
    (0..rows[0].len()).map(|i| square(i).sqrt()).collect()
}

/// Gaussian elimination with columns and rows scaled to a largest entry of one and partial pivoting.
pub fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    let scales: Vec<f64> = (0..n).map(|j| a.iter().map(|row| row[j].abs()).fold(0.0, f64::max)).collect();
    for (row, right) in a.iter_mut().zip(&mut b) {
        row.iter_mut().zip(&scales).for_each(|(x, s)| *x /= s);
        let largest = row.iter().map(|x| x.abs()).fold(0.0, f64::max);
        row.iter_mut().for_each(|x| *x /= largest);
        *right /= largest;
    }
    for k in 0..n {
        let pivot = (k..n).max_by(|i, j| a[*i][k].abs().total_cmp(&a[*j][k].abs())).unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        let top = a[k].clone();
        for i in k + 1..n {
            let factor = a[i][k] / top[k];
            a[i].iter_mut().zip(&top).for_each(|(x, t)| *x -= factor * t);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let rest: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - rest) / a[k][k];
    }
    b.iter().zip(&scales).map(|(x, s)| x / s).collect()
}
