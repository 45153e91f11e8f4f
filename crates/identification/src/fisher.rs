//! What free simulation tells about the parameters: forward sensitivities, and the information matrix and covariance of an
//! output-error estimate that they predict.
//!
//! The lifted parameters are those of surge, then its intercept, then sway's and yaw's. With s_d = ∂x_d/∂θ̃ and the Jacobian
//! J(k) = ∂(φᵀθ)/∂x at x(k): S(k+1) = (I + J(k)) S(k) + Φ̃(k), S(0) = 0. The estimate minimises Σ_k Σ_d w_d (y_d − x_d)²; its
//! covariance is F⁻¹ (E + P) F⁻¹ with F = Σ Sᵀ W S, E = Σ Sᵀ W R W S of the measurement errors and P of the current, which
//! moves the vessel: δx(k+1) = (I + J) δx(k) − J c(k), so that P = Σ_l λᵀ J σ_c² Jᵀ λ with the adjoint
//! λ(k) = W S(k) + (I + J(k))ᵀ λ(k+1) at k = l + 1.

use vessel::{Model, simulate_one};

use crate::Noise;

/// Information of one run about the lifted parameters, per sample: n × n matrices, row-major, symmetric.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputInformation {
    /// F.
    pub information: Vec<f64>,
    /// E: what measurement errors add to the middle matrix; F where every channel is weighted by its variance.
    pub measurement: Vec<f64>,
    /// P: what the current adds.
    pub process: Vec<f64>,
}

/// Number of lifted parameters of all degrees of freedom.
pub fn lifted(model: &Model) -> usize {
    model.parameters() + model.degrees.len()
}

/// The sensitivities ∂x_d(k)/∂θ̃ of a free simulation, k = 1 to N: N × 3 × n, row-major, with the Jacobians J(k) of k = 0 to
/// N − 1: N × 3 × 3. `states`: (N+1) × 3 of the same simulation.
pub fn sensitivities(
    model: &Model,
    theta: &[f64],
    states: &[f64],
    exogenous: &[f64],
) -> (Vec<f64>, Vec<[[f64; 3]; 3]>) {
    let (n, width) = (lifted(model), model.exogenous());
    let samples = states.len() / 3 - 1;
    let (mut all, mut jacobians) = (Vec::with_capacity(3 * n * samples), Vec::with_capacity(samples));
    let mut now = vec![0.0; 3 * n];
    let mut values = vec![0.0; model.variables.len()];
    for k in 0..samples {
        values[..3].copy_from_slice(&states[3 * k..3 * k + 3]);
        values[3..].copy_from_slice(&exogenous[width * k..width * (k + 1)]);
        let jacobian = jacobian(model, theta, &values);
        let mut next = now.clone();
        for d in 0..3 {
            for i in 0..3 {
                for p in 0..n {
                    next[d * n + p] += jacobian[d][i] * now[i * n + p];
                }
            }
        }
        let mut place = 0;
        for (d, degree) in model.degrees.iter().enumerate() {
            for term in &degree.terms {
                next[d * n + place] += term.evaluate(&values);
                place += 1;
            }
            next[d * n + place] += 1.0;
            place += 1;
        }
        all.extend_from_slice(&next);
        jacobians.push(jacobian);
        now = next;
    }
    (all, jacobians)
}

/// ∂(φ_dᵀθ_d)/∂x_i.
fn jacobian(model: &Model, theta: &[f64], values: &[f64]) -> [[f64; 3]; 3] {
    let mut theta = theta.iter();
    model.degrees.each_ref().map(|degree| {
        let mut row = [0.0; 3];
        for (term, t) in degree.terms.iter().zip(&mut theta) {
            row.iter_mut().enumerate().for_each(|(i, entry)| *entry += t * term.derivative(values, i));
        }
        row
    })
}

/// Information of a run of `exogenous` (N × inputs and measured disturbances) from `initial`, simulated with `theta`. The
/// channels are weighted by their variances; evenly where one has none. `None` where the simulation is not finite.
pub fn output_information(
    model: &Model,
    theta: &[f64],
    initial: [f64; 3],
    exogenous: &[f64],
    noise: &Noise,
) -> Option<OutputInformation> {
    let states = simulate_one(model, theta, initial, exogenous);
    let (s, jacobians) = sensitivities(model, theta, &states, exogenous);
    let n = lifted(model);
    let mut found = OutputInformation {
        information: vec![0.0; n * n],
        measurement: vec![0.0; n * n],
        process: vec![0.0; n * n],
    };
    let variances = noise.measurement.map(|std| std * std);
    let weights = if variances.iter().all(|v| *v > 0.0) { variances.map(|v| 1.0 / v) } else { [1.0; 3] };
    for rows in s.chunks_exact(3 * n) {
        for (d, row) in rows.chunks_exact(n).enumerate() {
            add_outer(&mut found.information, weights[d], row);
            add_outer(&mut found.measurement, weights[d] * weights[d] * variances[d], row);
        }
    }
    add_process(&mut found.process, &s, &jacobians, &weights, noise.current * noise.current);
    let share = 1.0 / jacobians.len().max(1) as f64;
    for matrix in [&mut found.information, &mut found.measurement, &mut found.process] {
        mirror(n, matrix);
        matrix.iter_mut().for_each(|entry| *entry *= share);
    }
    found.information.iter().chain(&found.process).all(|x| x.is_finite()).then_some(found)
}

/// Adds P, the upper triangle of it.
fn add_process(p: &mut [f64], s: &[f64], jacobians: &[[[f64; 3]; 3]], weights: &[f64; 3], variance: f64) {
    if variance == 0.0 {
        return;
    }
    let n = p.len().isqrt();
    // λ of the sample after k.
    let mut adjoint = vec![0.0; 3 * n];
    for k in (0..jacobians.len()).rev() {
        // λ(k+1) = W S(k+1) + (I + J(k+1))ᵀ λ(k+2)
        let mut next = vec![0.0; 3 * n];
        for d in 0..3 {
            for q in 0..n {
                let carried: f64 = jacobians.get(k + 1).map_or(0.0, |j| {
                    adjoint[d * n + q] + (0..3).map(|i| j[i][d] * adjoint[i * n + q]).sum::<f64>()
                });
                next[d * n + q] = weights[d] * s[(3 * k + d) * n + q] + carried;
            }
        }
        adjoint = next;
        let jacobian = &jacobians[k];
        let moved =
            |q: usize, component: usize| (0..3).map(|i| jacobian[i][component] * adjoint[i * n + q]).sum();
        for g in [0, 1].map(|component| (0..n).map(|q| moved(q, component)).collect::<Vec<f64>>()) {
            add_outer(p, variance, &g);
        }
    }
}

/// Mean over the samples of Sᵀ S, n × n, rows and columns of intercepts zero: the variance that parameters' errors give a
/// free run, summed over the states, is tr(cov G). `None` where the simulation is not finite.
pub fn prediction_weights(
    model: &Model,
    theta: &[f64],
    initial: [f64; 3],
    exogenous: &[f64],
) -> Option<Vec<f64>> {
    let states = simulate_one(model, theta, initial, exogenous);
    let (s, jacobians) = sensitivities(model, theta, &states, exogenous);
    let n = lifted(model);
    let mut sum = vec![0.0; n * n];
    s.chunks_exact(n).for_each(|row| add_outer(&mut sum, 1.0, row));
    mirror(n, &mut sum);
    let mut place = 0;
    for degree in &model.degrees {
        place += degree.terms.len() + 1;
        (0..n).for_each(|i| {
            sum[i * n + place - 1] = 0.0;
            sum[(place - 1) * n + i] = 0.0;
        });
    }
    sum.iter_mut().for_each(|entry| *entry /= jacobians.len().max(1) as f64);
    sum.iter().all(|x| x.is_finite()).then_some(sum)
}

/// Adds the upper triangle of weight × row rowᵀ.
pub(crate) fn add_outer(sum: &mut [f64], weight: f64, row: &[f64]) {
    let n = row.len();
    if weight == 0.0 {
        return;
    }
    for (i, a) in row.iter().enumerate() {
        let scaled = weight * a;
        sum[i * n + i..(i + 1) * n].iter_mut().zip(&row[i..]).for_each(|(entry, b)| *entry += scaled * b);
    }
}

/// Copies the upper triangle below.
pub(crate) fn mirror(n: usize, matrix: &mut [f64]) {
    for i in 0..n {
        for j in 0..i {
            matrix[i * n + j] = matrix[j * n + i];
        }
    }
}
