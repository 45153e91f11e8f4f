//! The criterion of one experiment, with the intermediate results that its gradient needs.

use numerics::{LANES, Lane, dot, product};
use regression::Noise;
use ship::engine::check_diverged;
use ship::model::Model;

use crate::sensitivity::{Dynamics, Recordings, RunInformation, Sensitivities, channels};

/// tr(G cov θ̃) of an output-error estimate from one run: G is diagonal, zero for intercepts.
#[derive(Clone, Copy, Debug)]
pub struct TraceCriterion<'a> {
    /// The model.
    pub model: &'a Model,
    /// The parameters that it is simulated with.
    pub parameters: &'a [f64],
    /// Weight of every parameter's variance.
    pub weights: &'a [f64],
    /// The disturbances of the run.
    pub noise: Noise,
    /// State at the start: u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
}

/// The forward pass of a run, with all that the backward pass needs. n parameters with intercepts, N samples.
#[derive(Clone, Debug)]
pub struct Forward {
    /// (N+1) × 3.
    pub states: Vec<f64>,
    /// tr(G cov θ̃).
    pub value: f64,
    /// tr(G F⁻¹E F⁻¹): its value without current.
    pub measurement_value: f64,
    /// Variance of every parameter.
    pub variances: Vec<f64>,
    /// F of the whole run, n × n.
    pub information: Vec<f64>,
    /// S(k), k = 0 to N.
    path: Sensitivities<f64>,
    /// Columns of λ(k) of the current, k = N to 1; empty without current.
    adjoints: Vec<[Lane; 3]>,
    /// E + P.
    meat: Vec<f64>,
    /// F⁻¹.
    inverse: Vec<f64>,
}

impl Forward {
    /// Root of the criterion.
    pub fn parameter_error(&self) -> f64 {
        self.value.sqrt()
    }

    /// Of every parameter.
    pub fn standard_errors(&self) -> impl Iterator<Item = f64> {
        self.variances.iter().map(|v| v.max(0.0).sqrt())
    }

    /// log|det| of the information of one of its `samples`, on average; `None` if that is singular.
    pub fn log_det(&self, samples: u64) -> Option<f64> {
        let mut mean: Vec<f64> = self.information.iter().map(|f| f / samples as f64).collect();
        numerics::log_det(self.information.len().isqrt(), &mut mean).map(|log_det| log_det.log_abs)
    }

    /// −log of the criterion of one of its `samples`, by which designs are compared.
    pub fn log_value(&self, samples: u64) -> f64 {
        -libm::log(self.value * samples as f64)
    }
}

impl TraceCriterion<'_> {
    /// The criterion of a run of `exogenous`, N × (inputs and measured disturbances). `None` if the simulation
    /// diverges or the run has no information about a direction of the parameters.
    pub fn forward(&self, exogenous: &[f64]) -> Option<Forward> {
        let (model, parameters) = self.lifted();
        let run = Recordings::simulated(&model, self.initial, exogenous);
        let mut adjoints = Vec::new();
        let keep = |columns: &[[Lane; 3]]| adjoints.extend_from_slice(columns);
        let mut sums = RunInformation::by(&run, &parameters, &self.noise, Sensitivities::default(), keep);
        let states = std::mem::take(&mut sums.path.states);
        if check_diverged(states.iter().copied()).is_some() {
            return None;
        }
        let n = parameters.len();
        let inverse = inverse(n, &sums.information)?;
        let meat = sums.meat();
        let layout = model.layout();
        let counted = layout.woven(self.weights, [0.0; 3]);
        let trace = |variances: &[f64]| counted.iter().zip(variances).map(|(g, v)| g * v).sum::<f64>();
        let all = sandwich(n, &inverse, &meat);
        let (value, measurement_value) = (trace(&all), trace(&sandwich(n, &inverse, &sums.measurement)));
        (value.is_finite() && value > 0.0).then(|| Forward {
            states,
            value,
            measurement_value,
            variances: layout.theta(&all),
            information: sums.information,
            path: sums.path,
            adjoints,
            meat,
            inverse,
        })
    }

    fn lifted(&self) -> (Model, Vec<f64>) {
        let model = self.model.with_intercepts();
        let parameters = model.layout().woven(self.parameters, [0.0; 3]);
        (model, parameters)
    }
}

/// The matrix with a unit diagonal is singular if its inverse has an entry above this.
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

fn sandwich(n: usize, c: &[f64], b: &[f64]) -> Vec<f64> {
    product(n, c, b).chunks_exact(n).zip(c.chunks_exact(n)).map(|(row, c)| dot(row, c)).collect()
}

// The backward pass: the gradient of log tr(G cov θ̃) by all inputs of all samples.
//
struct Rows {
    columns: usize,
    rows: Vec<Lane>,
}

impl Rows {
    fn of(n: usize, matrix: &[f64]) -> Self {
        let columns = n.div_ceil(LANES);
        let mut rows = vec![Lane::ZERO; n * columns];
        for (e, entry) in matrix.iter().enumerate() {
            rows[e / n * columns + e % n / LANES][e % n % LANES] = *entry;
        }
        Self { columns, rows }
    }

    /// Adds x × the matrix, where x and the result are entry `d` of columns.
    #[inline(always)]
    fn add_times<const M: usize>(&self, x: &[[Lane; M]], to: &mut [[Lane; M]], d: usize) {
        for (i, row) in self.rows.chunks_exact(self.columns).enumerate() {
            let factor = Lane::splat(x[i / LANES][d][i % LANES]);
            for (to, entry) in to.iter_mut().zip(row) {
                to[d] += factor * *entry;
            }
        }
    }
}

impl TraceCriterion<'_> {
    /// ∂(log tr(G cov θ̃) + h)/∂inputs, N × inputs, at the run of `forward`, with the same `exogenous`.
    /// `state_slopes`: ∂h/∂x of any further function of the states, (N+1) × 3.
    pub fn gradient(&self, forward: &Forward, exogenous: &[f64], state_slopes: &[f64]) -> Vec<f64> {
        let (model, parameters) = self.lifted();
        let run = &Recordings::simulated(&model, self.initial, exogenous);
        let (m, q) = self.weighing(&model, forward);
        let n = parameters.len();
        let (weights, variances) = channels(&self.noise);
        let source = |d: usize| -> Vec<f64> {
            let (of_q, of_m) = (2.0 * weights[d], 2.0 * weights[d] * weights[d] * variances[d]);
            q.iter().zip(&m).map(|(q, m)| of_q * q + of_m * m).collect()
        };
        let sources = [0, 1, 2].map(|d| Rows::of(n, &source(d)));
        let factor = 2.0 * self.noise.current * self.noise.current;
        let response = Rows::of(n, &m.iter().map(|m| factor * m).collect::<Vec<f64>>());
        let parameters = &parameters[..];
        let followed = numerics::vectorized!(follow(run, parameters, forward, &response));
        let back = Back { run, parameters, forward, state_slopes, followed, sources, weights };
        numerics::vectorized!(back.gradient())
    }

    fn weighing(&self, model: &Model, forward: &Forward) -> (Vec<f64>, Vec<f64>) {
        let (c, g) = (&forward.inverse, model.layout().woven(self.weights, [0.0; 3]));
        let (n, share) = (g.len(), forward.value.recip());
        let m: Vec<f64> = (0..n * n)
            .map(|e| share * (0..n).map(|k| c[e / n * n + k] * g[k] * c[k * n + e % n]).sum::<f64>())
            .collect();
        let x = product(n, &product(n, &m, &forward.meat), c);
        let q = (0..n * n).map(|e| -(x[e] + x[e % n * n + e / n])).collect();
        (m, q)
    }
}

impl Forward {
    fn state(&self, k: usize) -> &[f64; 3] {
        &self.states.as_chunks().0[k]
    }

    /// λ(k + 1); empty without current.
    fn adjoint(&self, k: usize) -> &[[Lane; 3]] {
        let columns = self.path.columns();
        match self.adjoints.len().checked_sub((k + 1) * columns) {
            Some(first) if !self.adjoints.is_empty() => &self.adjoints[first..first + columns],
            _ => &[],
        }
    }
}

/// By sample, columns of γ(k), one for each component of the current, and of κ(k+1); empty without current.
struct Followed {
    forced: Vec<[Lane; 2]>,
    followed: Vec<[Lane; 3]>,
}

#[inline(always)]
fn follow(run: &Recordings<f64>, parameters: &[f64], forward: &Forward, response: &Rows) -> Followed {
    let mut all = Followed { forced: Vec::new(), followed: Vec::new() };
    if forward.adjoints.is_empty() {
        return all;
    }
    let mut dynamics = Dynamics::<f64, 3>::new(run.model, parameters, None);
    let columns = forward.path.columns();
    let mut now = vec![[Lane::ZERO; 3]; columns];
    let mut pushed = vec![[Lane::ZERO; 2]; columns];
    for k in 0..run.longest() {
        let local = dynamics.at(forward.state(k), run.exogenous(k));
        let slope = |d: usize, i: usize| Lane::splat(local.slopes[d][i]);
        for (pushed, l) in pushed.iter_mut().zip(forward.adjoint(k)) {
            for (i, pushed) in pushed.iter_mut().enumerate() {
                *pushed = slope(0, i) * l[0] + slope(1, i) * l[1] + slope(2, i) * l[2];
            }
        }
        for column in &mut now {
            *column = dynamics.motion.forward(&local, column);
        }
        let first = all.forced.len();
        all.forced.resize(first + columns, [Lane::ZERO; 2]);
        let forced = &mut all.forced[first..];
        for i in 0..2 {
            response.add_times(&pushed, forced, i);
        }
        for (column, force) in now.iter_mut().zip(forced) {
            for (d, state) in column.iter_mut().enumerate() {
                *state += slope(d, 0) * force[0] + slope(d, 1) * force[1];
            }
        }
        all.followed.extend_from_slice(&now);
    }
    all
}

struct Back<'a> {
    run: &'a Recordings<'a, f64>,
    parameters: &'a [f64],
    forward: &'a Forward,
    state_slopes: &'a [f64],
    followed: Followed,
    /// 2 W Q + 2 W R W M, of each channel.
    sources: [Rows; 3],
    weights: [f64; 3],
}

impl Back<'_> {
    #[inline(always)]
    fn gradient(&self) -> Vec<f64> {
        let Self { run, parameters, forward, .. } = *self;
        let (samples, inputs) = (run.longest(), run.model.inputs);
        let mut dynamics = Dynamics::<f64, 3>::new(run.model, parameters, None);
        let degrees: Vec<usize> = run.model.layout().degrees().collect();
        let (mut big, mut small) = (vec![[Lane::ZERO; 3]; forward.path.columns()], [0.0; 3]);
        let known: Vec<(usize, f64)> = run.model.known().map(|(d, known)| (d, known.coefficient)).collect();
        let mut terms = vec![0.0; parameters.len() + known.len()];
        let mut slopes = vec![0.0; run.model.variables.len()];
        let mut after = None;
        let mut out = vec![0.0; samples * inputs];
        for k in (0..samples).rev() {
            if let Some(local) = &after {
                for column in &mut big {
                    *column = dynamics.motion.backward(local, column);
                }
            }
            self.add_sources(k, &mut big);
            for (slope_sum, slope) in small.iter_mut().zip(&self.state_slopes[3 * (k + 1)..]) {
                *slope_sum += slope;
            }
            for (p, (term, d)) in terms.iter_mut().zip(&degrees).enumerate() {
                *term = big[p / LANES][*d][p % LANES] + small[*d] * parameters[p];
            }
            for (term, (d, value)) in terms[parameters.len()..].iter_mut().zip(&known) {
                *term = small[*d] * value;
            }
            let local = dynamics.at(forward.state(k), run.exogenous(k));
            dynamics.model.pull_back(&terms, &self.by_slopes(k, &big), &mut slopes);
            run.model.by_sources(run.exogenous(k), slopes.as_chunks_mut::<1>().0);
            for (slope_sum, slope) in small.iter_mut().zip(&slopes) {
                *slope_sum += slope;
            }
            out[k * inputs..(k + 1) * inputs].copy_from_slice(&slopes[3..3 + inputs]);
            after = Some(local);
        }
        out
    }

    #[inline(always)]
    fn add_sources(&self, k: usize, to: &mut [[Lane; 3]]) {
        let s = self.forward.path.at(k + 1);
        for (d, rows) in self.sources.iter().enumerate() {
            rows.add_times(s, to, d);
        }
        let columns = to.len();
        if let Some(followed) = self.followed.followed.get(k * columns..(k + 1) * columns) {
            for (to, kept) in to.iter_mut().zip(followed) {
                for d in 0..3 {
                    to[d] += Lane::splat(self.weights[d]) * kept[d];
                }
            }
        }
    }

    /// H\[d\]\[i\], the slope by J(k)\[d\]\[i\].
    #[inline(always)]
    fn by_slopes(&self, k: usize, big: &[[Lane; 3]]) -> [[f64; 3]; 3] {
        let Followed { forced, followed } = &self.followed;
        let (s, adjoint, columns) = (self.forward.path.at(k), self.forward.adjoint(k), big.len());
        let before =
            k.checked_sub(1).and_then(|k| followed.get(k * columns..(k + 1) * columns)).unwrap_or(&[]);
        let forced = forced.get(k * columns..(k + 1) * columns).unwrap_or(&[]);
        let mut h = [[Lane::ZERO; 3]; 3];
        for (d, row) in h.iter_mut().enumerate() {
            for (i, entry) in row.iter_mut().enumerate() {
                for (b, s) in big.iter().zip(s) {
                    *entry += b[d] * s[i];
                }
                for (l, kappa) in adjoint.iter().zip(before) {
                    *entry += l[d] * kappa[i];
                }
                for (l, force) in adjoint.iter().zip(forced).filter(|_| i < 2) {
                    *entry += l[d] * force[i];
                }
            }
        }
        h.map(|row| row.map(|entry| entry.0.iter().sum()))
    }
}
