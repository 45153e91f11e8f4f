use numerics::{add_outer, congruence, transposed};

use super::residual_tests::residuals_of;
use super::{Centring, Regressions, Solution};

/// Bandwidth by the rule of thumb 4 (N/100)^(2/9): Newey & West, *Review of Economic Studies* 61, 1994.
pub fn default_bandwidth(samples: usize) -> usize {
    (4.0 * libm::pow(samples as f64 / 100.0, 2.0 / 9.0)).floor() as usize
}

/// Covariance of θ̂ of degree of freedom `d`, p × p row-major: G B Gᵀ with
/// B = N/(N − p − intercepts) Σ_l w_l Σ_k (g(k) g(k−l)ᵀ), g = ζᶜ ε, the weights w_l = 1 − |l|/(bandwidth + 1) of Bartlett and
/// no lags across parts (Newey & West, *Econometrica* 55, 1987). ζᶜ are the instruments without the mean that was removed.
pub fn sandwich(
    parts: &dyn Regressions,
    centring: &Centring,
    solution: &Solution,
    d: usize,
    bandwidth: usize,
) -> Vec<f64> {
    let p = solution.theta.len();
    let mut middle = vec![0.0; p * p];
    let (mut samples, mut zeta) = (0, Vec::new());
    parts.each(&mut |i, part| {
        samples += part.samples;
        let mut scores = Vec::with_capacity(part.degrees[d].zeta.len());
        for (k, residual) in residuals_of(part, i, centring, solution, d).iter().enumerate() {
            centring.zeta(i, d, part.degrees[d].zeta(k), &mut zeta);
            scores.extend(zeta.iter().map(|z| z * residual));
        }
        add_part(&mut middle, &scores, p, bandwidth);
    });
    let freedom = samples.saturating_sub(p + centring.intercepts()).max(1);
    middle.iter_mut().for_each(|m| *m *= samples as f64 / freedom as f64);
    congruence(p, &solution.gain, &middle)
}

fn add_part(middle: &mut [f64], scores: &[f64], p: usize, bandwidth: usize) {
    let samples = scores.len() / p.max(1);
    for lag in 0..=bandwidth.min(samples.saturating_sub(1)) {
        let weight = 1.0 - lag as f64 / (bandwidth as f64 + 1.0);
        let mut products = vec![0.0; p * p];
        for k in lag..samples {
            let (now, before) = (&scores[k * p..(k + 1) * p], &scores[(k - lag) * p..(k - lag + 1) * p]);
            add_outer(&mut products, now, before);
        }
        for ((entry, own), other) in middle.iter_mut().zip(&products).zip(transposed(p, &products)) {
            *entry += weight * if lag == 0 { *own } else { own + other };
        }
    }
}
