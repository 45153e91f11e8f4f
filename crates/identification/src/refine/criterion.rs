//! The criterion of one experiment, and what its gradient needs of the way there.

use vessel::{Model, check_diverged, simulate_one};

use crate::fisher::{add_outer, mirror};
use crate::{Noise, lifted, sensitivities};

/// tr(G cov θ̃) of an output-error estimate from one run: G is diagonal, zero for intercepts.
#[derive(Clone, Copy, Debug)]
pub struct TraceCriterion<'a> {
    /// The model.
    pub model: &'a Model,
    /// The parameters that it is simulated with.
    pub parameters: &'a [f64],
    /// Weight of every parameter's variance.
    pub weights: &'a [f64],
    /// What disturbs the run.
    pub noise: Noise,
    /// State at the start: u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
}

/// A run on its way forward, with all that the way back needs. n lifted parameters, N samples.
#[derive(Clone, Debug)]
pub struct Forward {
    /// (N+1) × 3.
    pub states: Vec<f64>,
    /// tr(G cov θ̃).
    pub value: f64,
    /// tr(G F⁻¹E F⁻¹): what is left of it without current.
    pub measurement_value: f64,
    /// Variance of every parameter.
    pub variances: Vec<f64>,
    /// F of the whole run, n × n.
    pub information: Vec<f64>,
    /// S(k), k = 1 to N: N × 3 × n.
    pub(super) s: Vec<f64>,
    /// J(k), k = 0 to N − 1.
    pub(super) jacobians: Vec<[[f64; 3]; 3]>,
    /// λ(k) of the current, k = 1 to N: N × 3 × n; empty without current.
    pub(super) adjoints: Vec<f64>,
    /// E + P.
    pub(super) middle: Vec<f64>,
    /// F⁻¹.
    pub(super) inverse: Vec<f64>,
}

impl TraceCriterion<'_> {
    /// Weights W of the channels and variances R of their errors: W = 1/R where no error is zero.
    pub(super) fn channels(&self) -> ([f64; 3], [f64; 3]) {
        let variances = self.noise.measurement.map(|std| std * std);
        let known = variances.iter().all(|v| *v > 0.0);
        (if known { variances.map(f64::recip) } else { [1.0; 3] }, variances)
    }

    /// The criterion of a run of `exogenous`, N × (inputs and measured disturbances). `None` where the simulation diverges or
    /// the run leaves a direction of the parameters without information.
    pub fn forward(&self, exogenous: &[f64]) -> Option<Forward> {
        let states = simulate_one(self.model, self.parameters, self.initial, exogenous);
        if check_diverged(states.iter().copied()).is_some() {
            return None;
        }
        let (s, jacobians) = sensitivities(self.model, self.parameters, &states, exogenous);
        let n = lifted(self.model);
        let (weights, variances) = self.channels();
        let (mut information, mut measurement) = (vec![0.0; n * n], vec![0.0; n * n]);
        for (row, s) in s.chunks_exact(n).enumerate() {
            let (w, r) = (weights[row % 3], variances[row % 3]);
            add_outer(&mut information, w, s);
            add_outer(&mut measurement, w * w * r, s);
        }
        let mut process = vec![0.0; n * n];
        let adjoints = self.process(&s, &jacobians, &weights, &mut process);
        [&mut information, &mut measurement, &mut process].into_iter().for_each(|m| mirror(n, m));
        let inverse = inverse(n, &information)?;
        let middle: Vec<f64> = measurement.iter().zip(&process).map(|(e, p)| e + p).collect();
        let counted = self.lifted_weights();
        let trace = |variances: &[f64]| counted.iter().zip(variances).map(|(g, v)| g * v).sum::<f64>();
        let all = sandwich(n, &inverse, &middle);
        let (value, measurement_value) = (trace(&all), trace(&sandwich(n, &inverse, &measurement)));
        let variances =
            all.into_iter().zip(self.is_parameter()).filter_map(|(v, is)| is.then_some(v)).collect();
        (value.is_finite() && value > 0.0).then_some(Forward {
            states,
            value,
            measurement_value,
            variances,
            information,
            s,
            jacobians,
            adjoints,
            middle,
            inverse,
        })
    }

    /// Adds P (upper triangle) and returns all λ.
    fn process(&self, s: &[f64], jacobians: &[[[f64; 3]; 3]], weights: &[f64; 3], p: &mut [f64]) -> Vec<f64> {
        let (n, variance) = (p.len().isqrt(), self.noise.current * self.noise.current);
        if variance == 0.0 {
            return Vec::new();
        }
        let mut all = vec![0.0; s.len()];
        for k in (0..jacobians.len()).rev() {
            let (now, after) = all[3 * k * n..].split_at_mut(3 * n);
            for (d, weight) in weights.iter().enumerate() {
                let row = &mut now[d * n..(d + 1) * n];
                row.iter_mut().zip(&s[(3 * k + d) * n..]).for_each(|(l, s)| *l = weight * s);
            }
            if let Some(j) = jacobians.get(k + 1) {
                add_turned(n, j, &after[..3 * n], now);
            }
            for component in 0..2 {
                add_outer(p, variance, &pushed(n, &jacobians[k], component, now));
            }
        }
        all
    }

    /// Whether every lifted parameter is one of the model's.
    fn is_parameter(&self) -> impl Iterator<Item = bool> + '_ {
        self.model
            .degrees
            .iter()
            .flat_map(|degree| std::iter::repeat_n(true, degree.terms.len()).chain([false]))
    }

    /// G's diagonal.
    pub(super) fn lifted_weights(&self) -> Vec<f64> {
        let mut weights = self.weights.iter().copied();
        self.is_parameter().map(|is| if is { weights.next().unwrap_or(0.0) } else { 0.0 }).collect()
    }
}

/// Adds (I + J)ᵀ L, both 3 × n.
pub(super) fn add_turned(n: usize, jacobian: &[[f64; 3]; 3], from: &[f64], to: &mut [f64]) {
    for d in 0..3 {
        for q in 0..n {
            let carried: f64 = (0..3).map(|i| jacobian[i][d] * from[i * n + q]).sum();
            to[d * n + q] += from[d * n + q] + carried;
        }
    }
}

/// Jᵀ L of one component of the current.
pub(super) fn pushed(n: usize, jacobian: &[[f64; 3]; 3], component: usize, adjoint: &[f64]) -> Vec<f64> {
    (0..n).map(|q| (0..3).map(|i| jacobian[i][component] * adjoint[i * n + q]).sum()).collect()
}

/// An inverse of the matrix with a unit diagonal with an entry above this is that of a singular matrix.
const SINGULAR: f64 = 1e13;

/// F⁻¹, through the matrix with a unit diagonal.
fn inverse(n: usize, information: &[f64]) -> Option<Vec<f64>> {
    let unit: Vec<f64> = (0..n).map(|i| information[i * n + i].sqrt().recip()).collect();
    let scale = |m: &mut [f64]| (0..n * n).for_each(|e| m[e] *= unit[e / n] * unit[e % n]);
    let mut scaled = information.to_vec();
    scale(&mut scaled);
    let mut out = vec![0.0; n * n];
    numerics::inverse(n, &mut scaled, &mut out)?;
    let regular = out.iter().all(|x| x.abs() <= SINGULAR);
    scale(&mut out);
    let positive = (0..n).all(|i| out[i * n + i] > 0.0);
    (regular && positive && out.iter().all(|x| x.is_finite())).then_some(out)
}

/// The diagonal of C B C, C symmetric.
fn sandwich(n: usize, c: &[f64], b: &[f64]) -> Vec<f64> {
    let row = |m: &[f64], i: usize, j: usize| (0..n).map(|k| c[i * n + k] * m[k * n + j]).sum::<f64>();
    (0..n).map(|i| (0..n).map(|j| row(b, i, j) * c[i * n + j]).sum()).collect()
}
