//! The most probable parameters after one simulated run with known noise, by Levenberg's and Marquardt's method.

use numerics::scaled_inverse;
use ship::forces::Forces;

use crate::fitting::bounded::{distance, held, moved, pulls};
use crate::fitting::{Prior, SimulatedRun, Unfit};

/// The search has ended where Newton's step promises less than this, in squares of standard errors.
const ENOUGH: f64 = 1e-3;
/// Damping at the beginning, and where no step helps any more.
const DAMPING: [f64; 2] = [1e-3, 1e10];
/// Most steps of the search.
const MOST_STEPS: usize = 300;

/// A simulated run that was measured.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredRun<'a> {
    /// The run, which starts from a known state.
    pub run: SimulatedRun<'a>,
    /// Measured u, v \[m/s\] and r \[rad/s\]: N + 1 rows; the first one does not count.
    pub measured: &'a [f64],
    /// Standard deviations of the errors of u, v \[m/s\], r \[rad/s\], above 0, white in every sample.
    pub noise: [f64; 3],
}

/// The search's problem.
struct Search<'a> {
    of: &'a MeasuredRun<'a>,
    forces: &'a Forces,
    priors: &'a [Option<Prior>],
}

/// Second and first derivatives of half the cost.
struct Normal {
    products: Vec<f64>,
    gradient: Vec<f64>,
}

impl MeasuredRun<'_> {
    /// θ of least squares of errors over the noise, plus those of distances from the priors over their deviations; the search
    /// begins at `theta`.
    ///
    /// # Errors
    /// No free number, no sample, a simulation at the start that diverges, a number that nothing determines, no end of the
    /// search.
    pub fn most_probable(
        &self,
        forces: &Forces,
        priors: &[Option<Prior>],
        theta: &[f64],
    ) -> Result<Vec<f64>, Unfit> {
        if theta.is_empty() {
            return Err(Unfit::NoParameter);
        }
        if self.run.samples() == 0 {
            return Err(Unfit::NoSample);
        }
        Search { of: self, forces, priors }.from(theta)
    }
}

impl Search<'_> {
    fn from(&self, theta: &[f64]) -> Result<Vec<f64>, Unfit> {
        let (mut theta, mut cost, mut damping) = (theta.to_vec(), self.cost(theta), DAMPING[0]);
        if !cost.is_finite() {
            return Err(Unfit::Diverged { recording: "run".to_owned(), first_s: 0.0 });
        }
        for _ in 0..MOST_STEPS {
            let normal = self.normal(&theta).ok_or(Unfit::Unfinished(MOST_STEPS))?;
            let held = held(self.forces, &theta, &normal.gradient);
            let free: Vec<usize> = (0..theta.len()).filter(|i| !held[*i]).collect();
            let newton = self.step(&normal, &free, 0.0)?;
            let promised: f64 = free.iter().zip(&newton).map(|(i, own)| -normal.gradient[*i] * own).sum();
            if promised < ENOUGH {
                return Ok(theta);
            }
            loop {
                let step = self.step(&normal, &free, damping)?;
                let next = moved(self.forces, &theta, &free, step.into_iter());
                let own = self.cost(&next);
                if own < cost {
                    (theta, cost, damping) = (next, own, 0.1 * damping);
                    break;
                }
                damping *= 5.0;
                if damping > DAMPING[1] {
                    // Where flow across a rudder changes its sign, the cost has an edge: no step is lower.
                    return Ok(theta);
                }
            }
        }
        Err(Unfit::Unfinished(MOST_STEPS))
    }

    /// Squares of errors over the noise, and of distances from the priors.
    fn cost(&self, theta: &[f64]) -> f64 {
        let MeasuredRun { run, measured, noise } = self.of;
        let states = run.states(self.forces, theta);
        let errors = states.iter().zip(measured.as_chunks::<3>().0).skip(1);
        let square = |(own, measured): (&[f64; 3], &[f64; 3])| -> f64 {
            (0..3).map(|d| ((own[d] - measured[d]) / noise[d]).powi(2)).sum()
        };
        errors.map(square).sum::<f64>() + distance(theta, self.priors)
    }

    fn normal(&self, theta: &[f64]) -> Option<Normal> {
        let MeasuredRun { run, measured, noise } = self.of;
        let (n, slopes) = (theta.len(), run.slopes(self.forces, theta)?);
        let weights = noise.map(|std| 1.0 / (std * std));
        let (mut products, mut gradient) = (slopes.weighted(n, weights), vec![0.0; n]);
        for (row, own) in slopes.by_theta.chunks_exact(n).enumerate() {
            let (k, d) = (row / 3, row % 3);
            let error = weights[d] * (slopes.states[k][d] - measured[row]);
            gradient.iter_mut().zip(own).for_each(|(sum, own)| *sum += error * own);
        }
        for (i, [pull, slope]) in pulls(theta, self.priors, 1.0).into_iter().enumerate() {
            products[i * n + i] += pull;
            gradient[i] += slope;
        }
        Some(Normal { products, gradient })
    }

    /// The step of the `free` parameters, with this share of the diagonal added to it.
    fn step(&self, normal: &Normal, free: &[usize], damping: f64) -> Result<Vec<f64>, Unfit> {
        let (n, m) = (normal.gradient.len(), free.len());
        let own = |i: usize, j: usize| normal.products[free[i] * n + free[j]];
        if let Some(i) = (0..m).find(|i| own(*i, *i) <= 0.0) {
            return Err(self.undetermined(free[i]));
        }
        let damped = |k: usize| own(k / m, k % m) * if k / m == k % m { 1.0 + damping } else { 1.0 };
        let products: Vec<f64> = (0..m * m).map(damped).collect();
        let inverse = scaled_inverse(m, &products).ok_or_else(|| self.undetermined(free[0]))?;
        let row = |i: usize| -> f64 { (0..m).map(|j| -inverse[i * m + j] * normal.gradient[free[j]]).sum() };
        Ok((0..m).map(row).collect())
    }

    fn undetermined(&self, i: usize) -> Unfit {
        Unfit::Undetermined(self.forces.parameters()[i].name.clone())
    }
}
