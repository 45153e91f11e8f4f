//! What a simulated run says of the parameters: the information of an output-error estimate.
//!
//! S(k) = ∂x(k)/∂θ along the simulation, where x(k) is u, v over the ground and r. The information is F = Σ_k S(k)ᵀ W S(k), W
//! the inverse variances of the measurement errors. A white current carries the ship: δx(k+1) = A(k) δx(k) + C(k) c(k). It adds
//! P = σ² Σ_k λ(k+1)ᵀ C(k) C(k)ᵀ λ(k+1) to the variance of the scores, with the adjoint λ(k) = W S(k) + A(k)ᵀ λ(k+1).

use std::convert::Infallible;

use numerics::least_squares::{Ended, Ending, Expansion, Linearization, Residuals, minimize};
use numerics::{Watch, add_outer, congruence, scaled_inverse};
use regression::Noise;
use ship::forces::{Body, Dual, Forces};

use super::fit::conditioned;
use super::{Inputs, Prior, Unfit, add_priors, block, distance};

/// Parameters by which derivatives are computed at once.
const AT_ONCE: usize = 13;

/// A ship that is simulated with inputs held during each sample.
#[derive(Clone, Copy, Debug)]
pub struct SimulatedRun<'a> {
    /// u, v \[m/s\], r \[rad/s\] at the first sample.
    pub initial: [f64; 3],
    /// Inputs and measured disturbances, in the order of the ship's channels: N rows.
    pub inputs: &'a [f64],
    /// Numbers of a row.
    pub width: usize,
    /// From one sample to the next \[s\].
    pub sample_s: f64,
}

/// Sums over the samples of a run: square matrices of θ, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct RunInformation {
    /// F, in the inverse units of θ squared.
    pub measurement: Vec<f64>,
    /// P: what the current adds to the variance of the scores.
    pub current: Vec<f64>,
}

/// How well θ is known after a run and with its priors.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictedErrors {
    /// Covariance of the estimates; rows and columns of those that are not free are 0.
    pub covariance: Vec<f64>,
    /// Condition index of the run's own information, in correlations; infinite where it leaves a direction open.
    pub condition: f64,
    /// The number that the run and its prior know least.
    pub weakest: usize,
}

/// The derivatives of a simulated run's states by θ.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSlopes {
    /// u, v \[m/s\], r \[rad/s\]: N + 1 rows.
    pub states: Vec<[f64; 3]>,
    /// ∂x/∂θ: for each row of `states` three rows of as many numbers as θ has.
    pub by_theta: Vec<f64>,
}

impl SimulatedRun<'_> {
    /// Number of samples N.
    pub fn samples(&self) -> usize {
        self.inputs.len() / self.width.max(1)
    }

    /// The states of `forces` with parameters `theta`: N + 1 rows.
    pub fn states(&self, forces: &Forces, theta: &[f64]) -> Vec<[f64; 3]> {
        let (body, mut state) = (forces.body(theta), self.initial);
        let steps = (0..self.samples()).map(|k| {
            state = body.step_held(state, self.row(k), self.sample_s);
            state
        });
        std::iter::once(self.initial).chain(steps).collect()
    }

    /// The states of `forces` with parameters `theta`, and their derivatives; `None` where they are not finite.
    pub fn slopes(&self, forces: &Forces, theta: &[f64]) -> Option<StateSlopes> {
        self.slopes_by(forces, theta, Inputs::Held)
    }

    /// As [`Self::slopes`], where inputs do this between samples; linear ones are held after the last row.
    pub fn slopes_by(&self, forces: &Forces, theta: &[f64], inputs: Inputs) -> Option<StateSlopes> {
        let (n, rows) = (theta.len(), 3 * (self.samples() + 1));
        let mut by_theta = vec![0.0; rows * n];
        let mut states = Vec::new();
        for first in (0..n.max(1)).step_by(AT_ONCE) {
            states = self.columns(forces, theta, (first, inputs), &mut by_theta);
        }
        let finite = states.iter().flatten().chain(&by_theta).all(|entry| entry.is_finite());
        finite.then_some(StateSlopes { states, by_theta })
    }

    fn columns(
        &self,
        forces: &Forces,
        theta: &[f64],
        (first, inputs): (usize, Inputs),
        out: &mut [f64],
    ) -> Vec<[f64; 3]> {
        let (n, width) = (theta.len(), self.width);
        let dual = |(i, value): (usize, &f64)| Dual::<f64, AT_ONCE>::unknown(*value, i.wrapping_sub(first));
        let parameters: Vec<_> = theta.iter().enumerate().map(dual).collect();
        let body = forces.body(&parameters);
        let mut state = self.initial.map(Dual::constant);
        let mut states = vec![self.initial];
        let acting = (inputs == Inputs::Linear).then(|| body.acting(self.inputs, width, self.sample_s));
        for k in 0..self.samples() {
            state = match &acting {
                None => body.step_held(state, self.row(k), self.sample_s),
                Some(rows) => {
                    let row = &rows[k * width..][..width];
                    let end = rows[(k + 1) * width..].get(..width).unwrap_or(row);
                    body.step(state, row, end, self.sample_s)
                }
            };
            for (d, dual) in state.iter().enumerate() {
                let to = &mut out[(3 * (k + 1) + d) * n + first..(3 * (k + 1) + d + 1) * n];
                to.iter_mut().zip(dual.tangents).for_each(|(to, tangent)| *to = tangent);
            }
            states.push(state.map(|dual| dual.value));
        }
        states
    }

    fn row(&self, k: usize) -> &[f64] {
        &self.inputs[k * self.width..(k + 1) * self.width]
    }

    /// The information about θ under `noise` of samples after the known start; `None` where a simulation is not finite.
    pub fn information(&self, forces: &Forces, theta: &[f64], noise: &Noise) -> Option<RunInformation> {
        let slopes = self.slopes(forces, theta)?;
        let n = theta.len();
        let weights = noise.measurement.map(|std| 1.0 / (std * std));
        let measurement = slopes.weighted(n, weights);
        let current = match noise.current > 0.0 {
            true => self.carried(forces, theta, &slopes, (weights, noise.current)),
            false => vec![0.0; n * n],
        };
        let finite = measurement.iter().chain(&current).all(|entry| entry.is_finite());
        finite.then_some(RunInformation { measurement, current })
    }

    /// P, backwards through the run.
    fn carried(
        &self,
        forces: &Forces,
        theta: &[f64],
        slopes: &StateSlopes,
        (weights, std): ([f64; 3], f64),
    ) -> Vec<f64> {
        let n = theta.len();
        let constants: Vec<Dual<f64, 5>> = theta.iter().map(|value| Dual::constant(*value)).collect();
        let body = forces.body(&constants);
        let (mut sum, mut draw) = (vec![0.0; n * n], vec![0.0; n]);
        let mut adjoint = vec![0.0; 3 * n];
        for k in (0..self.samples()).rev() {
            let slope = &slopes.by_theta[3 * (k + 1) * n..3 * (k + 2) * n];
            for (d, weight) in weights.iter().enumerate() {
                (0..n).for_each(|i| adjoint[d * n + i] += weight * slope[d * n + i]);
            }
            let (by_state, by_current) = self.transition(&body, slopes.states[k], k);
            for column in by_current {
                (0..n).for_each(|i| {
                    draw[i] = std * (0..3).map(|d| column[d] * adjoint[d * n + i]).sum::<f64>();
                });
                add_outer(&mut sum, &draw, &draw);
            }
            for i in 0..n {
                let old = [0, 1, 2].map(|d: usize| adjoint[d * n + i]);
                (0..3).for_each(|j| adjoint[j * n + i] = (0..3).map(|d| by_state[d][j] * old[d]).sum());
            }
        }
        sum
    }

    /// A of sample `k`, a row for each state at its end, and the columns of C.
    fn transition(&self, body: &Body<Dual<f64, 5>>, state: [f64; 3], k: usize) -> Transition {
        let relative = [0, 1, 2].map(|d: usize| Dual::unknown(state[d], d));
        let current = [3, 4].map(|i| Dual::unknown(0.0, i));
        let change = body.changes_in_current(relative, self.row(k), current, self.sample_s);
        let stays = |d: usize, j: usize| if d == j { 1.0 } else { 0.0 };
        let by_state =
            [0, 1, 2].map(|d: usize| [0, 1, 2].map(|j: usize| change[d].tangents[j] + stays(d, j)));
        // The state relative to the water is that over the ground less the current.
        let by_current = [0, 1].map(|i: usize| change.map(|x| x.tangents[3 + i] - x.tangents[i]));
        (by_state, by_current)
    }
}

/// Derivatives of the next state by the state, row by row, and by the current, column by column.
type Transition = ([[f64; 3]; 3], [[f64; 3]; 2]);

impl RunInformation {
    /// Errors of an output-error estimate of `free` parameters with 1/σ² of the `prior`; `None` where one is open.
    pub fn errors(&self, prior: &[f64], free: &[bool]) -> Option<PredictedErrors> {
        let (n, places) = (prior.len(), (0..prior.len()).filter(|i| free[*i]).collect::<Vec<_>>());
        let m = places.len();
        let information = block(&self.measurement, n, &places);
        let mut bread = information.clone();
        (0..m).for_each(|i| bread[i * m + i] += prior[places[i]]);
        let inverted = scaled_inverse(m, &bread)?;
        let meat: Vec<f64> = bread.iter().zip(block(&self.current, n, &places)).map(|(a, b)| a + b).collect();
        let known = congruence(m, &inverted, &meat);
        let mut covariance = vec![0.0; n * n];
        (0..m * m).for_each(|k| covariance[places[k / m] * n + places[k % m]] = known[k]);
        let scaled: Vec<f64> =
            (0..m * m).map(|k| bread[k] / (bread[k / m * (m + 1)] * bread[k % m * (m + 1)]).sqrt()).collect();
        let weakest = numerics::weakest(m, &scaled).map_or(0, |weakest| weakest.dominant(m));
        let weakest = places.get(weakest).copied().unwrap_or(0);
        Some(PredictedErrors { covariance, condition: conditioned(m, &information).0, weakest })
    }
}

impl StateSlopes {
    /// Σ SᵀS over all states and samples: with the covariance of θ its trace is the sum of squared errors of a free run.
    pub fn squares(&self, parameters: usize) -> Vec<f64> {
        self.weighted(parameters, [1.0; 3])
    }

    /// Σ SᵀWS with the `weights` W of u, v and r.
    pub(crate) fn weighted(&self, parameters: usize, weights: [f64; 3]) -> Vec<f64> {
        let (n, roots) = (parameters, weights.map(f64::sqrt));
        let (mut sum, mut scaled) = (vec![0.0; n * n], vec![0.0; n]);
        for (row, row_slopes) in self.by_theta.chunks_exact(n.max(1)).enumerate() {
            scaled.iter_mut().zip(row_slopes).for_each(|(to, slope)| *to = roots[row % 3] * slope);
            add_outer(&mut sum, &scaled, &scaled);
        }
        sum
    }
}

const ENDING: Ending = Ending { steps: 300, enough: 0.03, damping: 1e-3 };

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

struct Search<'a> {
    of: &'a MeasuredRun<'a>,
    forces: &'a Forces,
    priors: &'a [Option<Prior>],
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
        let mut search = Search { of: self, forces, priors };
        let Ok(mut minima) = minimize(&mut search, vec![theta.to_vec()], ENDING, &Watch::default());
        let minimum = minima.pop().ok_or(Unfit::NoParameter)?;
        match minimum.status {
            Ended::Diverged if minimum.steps == 0 => {
                Err(Unfit::Diverged { recording: "run".to_owned(), first_s: 0.0 })
            }
            Ended::Singular(i) => Err(Unfit::Undetermined(forces.parameters()[i].name.clone())),
            Ended::Converged => Ok(minimum.point),
            // Where flow across a rudder changes its sign, the cost has an edge: no step is lower.
            Ended::Stalled if minimum.steps < ENDING.steps => Ok(minimum.point),
            Ended::Stalled | Ended::Diverged => Err(Unfit::Unfinished(ENDING.steps)),
        }
    }
}

impl Residuals for Search<'_> {
    fn linearize(&mut self, asked: &[Linearization]) -> Result<Vec<(Expansion, ())>, Infallible> {
        let nowhere = || Expansion { cost: f64::NAN, ..Expansion::default() };
        Ok(asked.iter().map(|at| (self.expansion(&at.point).unwrap_or_else(nowhere), ())).collect())
    }

    fn has_costs(&self) -> bool {
        true
    }

    fn cost(&mut self, trial: &Linearization) -> f64 {
        let squares = self.squares(&self.of.run.states(self.forces, &trial.point));
        squares + distance(&trial.point, self.priors)
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        self.forces.parameters().iter().map(|parameter| parameter.bounds).collect()
    }
}

impl Search<'_> {
    /// Squares of errors over the noise.
    fn squares(&self, states: &[[f64; 3]]) -> f64 {
        let MeasuredRun { measured, noise, .. } = self.of;
        let errors = states.iter().zip(measured.as_chunks::<3>().0).skip(1);
        let square = |(state, measured): (&[f64; 3], &[f64; 3])| -> f64 {
            (0..3).map(|d| ((state[d] - measured[d]) / noise[d]).powi(2)).sum()
        };
        errors.map(square).sum()
    }

    fn expansion(&self, theta: &[f64]) -> Option<Expansion> {
        let MeasuredRun { run, measured, noise } = self.of;
        let (n, slopes) = (theta.len(), run.slopes(self.forces, theta)?);
        let weights = noise.map(|std| 1.0 / (std * std));
        let (normal, mut gradient) = (slopes.weighted(n, weights), vec![0.0; n]);
        for (row, by_theta) in slopes.by_theta.chunks_exact(n).enumerate() {
            let (k, d) = (row / 3, row % 3);
            let error = weights[d] * (measured[row] - slopes.states[k][d]);
            gradient.iter_mut().zip(by_theta).for_each(|(sum, slope)| *sum += error * slope);
        }
        let cost = self.squares(&slopes.states);
        let mut expansion = Expansion { cost, unit: 1.0, normal, gradient };
        add_priors(&mut expansion, theta, self.priors, 1.0);
        Some(expansion)
    }
}
