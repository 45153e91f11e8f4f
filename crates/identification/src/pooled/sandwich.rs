use super::{Centring, Regression, Solution};

/// Bandwidth by the rule of thumb 4 (N/100)^(2/9): Newey & West, *Review of Economic Studies* 61, 1994.
pub fn default_bandwidth(samples: usize) -> usize {
    (4.0 * (samples as f64 / 100.0).powf(2.0 / 9.0)).floor() as usize
}

/// Covariance of θ̂ of degree of freedom `d`, p × p row-major: G B Gᵀ with
/// B = N/(N − p − intercepts) Σ_l w_l Σ_k (g(k) g(k−l)ᵀ), g = ζᶜ ε, the weights w_l = 1 − |l|/(bandwidth + 1) of Bartlett and
/// no lags across parts (Newey & West, *Econometrica* 55, 1987). ζᶜ are the instruments without the mean that was removed.
pub fn sandwich(
    parts: &[&Regression],
    centring: &Centring,
    solution: &Solution,
    d: usize,
    bandwidth: usize,
) -> Vec<f64> {
    let p = solution.theta.len();
    let mut middle = vec![0.0; p * p];
    let mut samples = 0;
    for (i, part) in parts.iter().enumerate() {
        samples += part.samples;
        add_part(&mut middle, &scores(part, i, centring, solution, d), p, bandwidth);
    }
    let freedom = samples.saturating_sub(p + centring.intercepts()).max(1);
    middle.iter_mut().for_each(|m| *m *= samples as f64 / freedom as f64);
    between(&solution.gain, &middle, p)
}

/// g(k) = ζᶜ(k) ε(k): N × p.
fn scores(part: &Regression, i: usize, centring: &Centring, solution: &Solution, d: usize) -> Vec<f64> {
    let degree = &part.degrees[d];
    let intercept = centring.intercept(i, d, &solution.theta);
    let (mut out, mut zeta) = (Vec::with_capacity(degree.zeta.len()), Vec::new());
    for (k, target) in degree.target.iter().enumerate() {
        let predicted: f64 = degree.phi(k).iter().zip(&solution.theta).map(|(f, t)| f * t).sum();
        let residual = target - predicted - intercept;
        centring.zeta(i, d, degree.zeta(k), &mut zeta);
        out.extend(zeta.iter().map(|z| z * residual));
    }
    out
}

fn add_part(middle: &mut [f64], scores: &[f64], p: usize, bandwidth: usize) {
    let samples = scores.len() / p.max(1);
    for lag in 0..=bandwidth.min(samples.saturating_sub(1)) {
        let weight = 1.0 - lag as f64 / (bandwidth as f64 + 1.0);
        let mut products = vec![0.0; p * p];
        for k in lag..samples {
            let (now, before) = (&scores[k * p..(k + 1) * p], &scores[(k - lag) * p..(k - lag + 1) * p]);
            for i in 0..p {
                for j in 0..p {
                    products[i * p + j] += now[i] * before[j];
                }
            }
        }
        for i in 0..p {
            for j in 0..p {
                let both =
                    if lag == 0 { products[i * p + j] } else { products[i * p + j] + products[j * p + i] };
                middle[i * p + j] += weight * both;
            }
        }
    }
}

/// G B Gᵀ.
fn between(gain: &[f64], middle: &[f64], p: usize) -> Vec<f64> {
    let product = |a: &dyn Fn(usize, usize) -> f64, b: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        (0..p * p).map(|k| (0..p).map(|l| a(k / p, l) * b(l, k % p)).sum()).collect()
    };
    let left = product(&|i, j| gain[i * p + j], &|i, j| middle[i * p + j]);
    product(&|i, j| left[i * p + j], &|i, j| gain[j * p + i])
}
