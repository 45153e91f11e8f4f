use numerics::{add_outer, congruence, transposed};

use super::residual_tests::residuals_of;
use super::{Centring, DegreeRegression, Regression, Solution};

/// Bandwidth by the rule of thumb 4 (N/100)^(2/9): Newey & West, *Review of Economic Studies* 61, 1994.
pub fn default_bandwidth(samples: usize) -> usize {
    (4.0 * libm::pow(samples as f64 / 100.0, 2.0 / 9.0)).floor() as usize
}

/// Covariance of θ̂ of degree of freedom `d`, p × p row-major: G B Gᵀ with B = N/(N − p − intercepts) Σ_l w_l Σ_k
/// (g(k) g(k−l)ᵀ), g = ζᶜ ε, the weights w_l = 1 − |l|/(bandwidth + 1) of Bartlett and no lags across parts (Newey &
/// West, *Econometrica* 55, 1987). ζᶜ are the instruments without the removed mean.
pub fn sandwich(
    parts: &[&Regression],
    centring: &Centring,
    solution: &Solution,
    d: usize,
    bandwidth: usize,
) -> Vec<f64> {
    let mut meat = Meat::new(solution.theta.len(), bandwidth);
    for (i, part) in parts.iter().enumerate() {
        let residuals = residuals_of(part, i, centring, solution, d);
        meat.add(&part.degrees[d], &residuals, |row, out| centring.zeta(i, d, row, out));
    }
    meat.covariance(centring, solution, d)
}

/// The meat B while it is accumulated, without its factor.
pub struct Meat {
    p: usize,
    bandwidth: usize,
    samples: usize,
    meat: Vec<f64>,
}

impl Meat {
    /// Of `p` parameters.
    pub fn new(p: usize, bandwidth: usize) -> Self {
        Self { p, bandwidth, samples: 0, meat: vec![0.0; p * p] }
    }

    /// Adds a part with its residuals; `centred` removes the mean from a row of instruments.
    pub fn add(
        &mut self,
        part: &DegreeRegression,
        residuals: &[f64],
        centred: impl Fn(&[f64], &mut Vec<f64>),
    ) {
        self.samples += residuals.len();
        let (mut scores, mut zeta) = (Vec::with_capacity(part.zeta.len()), Vec::new());
        for (k, residual) in residuals.iter().enumerate() {
            centred(part.zeta(k), &mut zeta);
            scores.extend(zeta.iter().map(|z| z * residual));
        }
        add_part(&mut self.meat, &scores, self.p, self.bandwidth);
    }

    /// The covariance of `solution` of degree of freedom `d`.
    pub fn covariance(mut self, centring: &Centring, solution: &Solution, d: usize) -> Vec<f64> {
        let freedom = self.samples.saturating_sub(centring.unknowns(d, &solution.gain, self.p)).max(1);
        self.meat.iter_mut().for_each(|m| *m *= self.samples as f64 / freedom as f64);
        congruence(self.p, &solution.gain, &self.meat)
    }
}

fn add_part(meat: &mut [f64], scores: &[f64], p: usize, bandwidth: usize) {
    let samples = scores.len() / p.max(1);
    for lag in 0..=bandwidth.min(samples.saturating_sub(1)) {
        let weight = 1.0 - lag as f64 / (bandwidth as f64 + 1.0);
        let mut products = vec![0.0; p * p];
        for k in lag..samples {
            let (now, before) = (&scores[k * p..(k + 1) * p], &scores[(k - lag) * p..(k - lag + 1) * p]);
            add_outer(&mut products, now, before);
        }
        for ((entry, own), other) in meat.iter_mut().zip(&products).zip(transposed(p, &products)) {
            *entry += weight * if lag == 0 { *own } else { own + other };
        }
    }
}
