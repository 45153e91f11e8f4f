//! The way back: the gradient of log tr(G cov θ̃) by all inputs of all samples.
//!
//! With C = F⁻¹, M = C G C and Q = −(M(E + P)C + its transpose), dφ = tr(M dE) + tr(M dP) + tr(Q dF). P's adjoints λ(k) (going back)
//! are followed by κ(k) (going forward): κ(k+1) = (I + J(k)) κ(k) + Σ_c J_c(k) γ_c(k)ᵀ, γ_c = 2 σ_c² M λᵀJ_c. Then Λ(k) = 2 W S Q +
//! 2 W R W S M + W κ(k) + (I + J(k))ᵀ Λ(k+1) belongs to the sensitivities, and H weighs what J(k) changes.

use super::criterion::{Forward, TraceCriterion, add_turned, pushed};
use crate::lifted;

/// The matrices of the way back, n × n, divided by φ.
struct Weighing {
    m: Vec<f64>,
    q: Vec<f64>,
}

impl TraceCriterion<'_> {
    /// ∂(log tr(G cov θ̃) + h)/∂inputs, N × inputs, at a run that `forward` went through, with `exogenous` as there.
    /// `state_slopes`: ∂h/∂x of anything else that depends on the states, (N+1) × 3.
    pub fn gradient(&self, forward: &Forward, exogenous: &[f64], state_slopes: &[f64]) -> Vec<f64> {
        let (n, width) = (lifted(self.model), self.model.exogenous());
        let samples = forward.jacobians.len();
        let weighing = self.weighing(n, forward);
        let (forced, followed) = self.follow(n, forward, &weighing);
        let (mut big, mut small) = (vec![0.0; 3 * n], [0.0; 3]);
        let mut values = vec![0.0; 3 + width];
        let mut out = vec![0.0; samples * self.model.inputs];
        for k in (0..samples).rev() {
            let mut next = vec![0.0; 3 * n];
            self.add_sources(n, forward, &weighing, &followed, k, &mut next);
            if let Some(j) = forward.jacobians.get(k + 1) {
                add_turned(n, j, &big, &mut next);
            }
            big = next;
            (0..3).for_each(|d| small[d] += state_slopes[3 * (k + 1) + d]);
            values[..3].copy_from_slice(&forward.states[3 * k..3 * k + 3]);
            values[3..].copy_from_slice(&exogenous[width * k..width * (k + 1)]);
            let seconds = weight_of_jacobian(n, forward, &big, &forced, &followed, k);
            let slopes = self.step(n, &values, &big, small, &seconds);
            (0..3).for_each(|d| small[d] += slopes[d]);
            let own = &mut out[k * self.model.inputs..(k + 1) * self.model.inputs];
            own.copy_from_slice(&slopes[3..3 + self.model.inputs]);
        }
        out
    }

    fn weighing(&self, n: usize, forward: &Forward) -> Weighing {
        let c = &forward.inverse;
        let g = self.lifted_weights();
        let share = forward.value.recip();
        let m: Vec<f64> = (0..n * n)
            .map(|e| share * (0..n).map(|k| c[e / n * n + k] * g[k] * c[k * n + e % n]).sum::<f64>())
            .collect();
        let x = product(n, &product(n, &m, &forward.middle), c);
        let q = (0..n * n).map(|e| -(x[e] + x[e % n * n + e / n])).collect();
        Weighing { m, q }
    }

    /// γ(k), N × 2 × n, and κ(k+1), N × 3 × n; empty without current.
    fn follow(&self, n: usize, forward: &Forward, weighing: &Weighing) -> (Vec<f64>, Vec<f64>) {
        let factor = 2.0 * self.noise.current * self.noise.current;
        let (mut forced, mut followed) = (Vec::new(), Vec::new());
        let mut now = vec![0.0; 3 * n];
        for (adjoint, j) in forward.adjoints.chunks_exact(3 * n).zip(&forward.jacobians) {
            let mut next = now.clone();
            for d in 0..3 {
                for q in 0..n {
                    next[d * n + q] += (0..3).map(|i| j[d][i] * now[i * n + q]).sum::<f64>();
                }
            }
            for component in 0..2 {
                let mut force = vec![0.0; n];
                add_times(n, factor, &pushed(n, j, component, adjoint), &weighing.m, &mut force);
                for (d, row) in j.iter().enumerate() {
                    let to = &mut next[d * n..(d + 1) * n];
                    to.iter_mut().zip(&force).for_each(|(to, f)| *to += row[component] * f);
                }
                forced.extend(force);
            }
            followed.extend_from_slice(&next);
            now = next;
        }
        (forced, followed)
    }

    /// Adds what depends on S(k+1) itself.
    fn add_sources(
        &self,
        n: usize,
        forward: &Forward,
        weighing: &Weighing,
        followed: &[f64],
        k: usize,
        to: &mut [f64],
    ) {
        let (weights, variances) = self.channels();
        for d in 0..3 {
            let rows = (3 * k + d) * n..(3 * k + d + 1) * n;
            let (s, to, w) = (&forward.s[rows.clone()], &mut to[d * n..(d + 1) * n], weights[d]);
            add_times(n, 2.0 * w, s, &weighing.q, to);
            add_times(n, 2.0 * w * w * variances[d], s, &weighing.m, to);
            if let Some(own) = followed.get(rows) {
                to.iter_mut().zip(own).for_each(|(to, x)| *to += w * x);
            }
        }
    }

    /// Slopes by every variable of one step: through the states, the sensitivities and the Jacobian.
    fn step(
        &self,
        n: usize,
        values: &[f64],
        big: &[f64],
        small: [f64; 3],
        seconds: &[[f64; 3]; 3],
    ) -> Vec<f64> {
        let mut slopes = vec![0.0; values.len()];
        let mut theta = self.parameters.iter();
        let mut place = 0;
        for (d, degree) in self.model.degrees.iter().enumerate() {
            for (term, t) in degree.terms.iter().zip(&mut theta) {
                let first = big[d * n + place] + small[d] * t;
                term.add_slopes(values, first, seconds[d].map(|h| t * h), &mut slopes);
                place += 1;
            }
            place += 1;
        }
        slopes
    }
}

/// H\[d\]\[i\], the slope by J(k)\[d\]\[i\].
fn weight_of_jacobian(
    n: usize,
    forward: &Forward,
    big: &[f64],
    forced: &[f64],
    followed: &[f64],
    k: usize,
) -> [[f64; 3]; 3] {
    let mut h = [[0.0; 3]; 3];
    for (d, row) in h.iter_mut().enumerate() {
        for (i, entry) in row.iter_mut().enumerate() {
            let before = |rows: &[f64], of: &[f64]| match k {
                0 => 0.0,
                _ => dot(&rows[d * n..(d + 1) * n], &of[(3 * (k - 1) + i) * n..(3 * (k - 1) + i + 1) * n]),
            };
            *entry = before(big, &forward.s);
            if forward.adjoints.is_empty() {
                continue;
            }
            let adjoint = &forward.adjoints[3 * k * n..3 * (k + 1) * n];
            *entry += before(adjoint, followed);
            if i < 2 {
                *entry += dot(&adjoint[d * n..(d + 1) * n], &forced[(2 * k + i) * n..(2 * k + i + 1) * n]);
            }
        }
    }
    h
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Adds factor × row × matrix, the matrix symmetric.
fn add_times(n: usize, factor: f64, row: &[f64], matrix: &[f64], to: &mut [f64]) {
    for (x, line) in row.iter().zip(matrix.chunks_exact(n)) {
        let x = factor * x;
        to.iter_mut().zip(line).for_each(|(to, m)| *to += x * m);
    }
}

fn product(n: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
    (0..n * n).map(|e| (0..n).map(|k| a[e / n * n + k] * b[k * n + e % n]).sum()).collect()
}
