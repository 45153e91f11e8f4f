use identification::pooled::{Centring, Options, Part, Regression, default_bandwidth, fit, sandwich};
use identification::{MeanRemoval, Sums};
use vessel::{Model, check_diverged, simulate_one};

use super::SequentialEstimator;
use super::planner::sums;

/// What one leg of a trial brought home.
#[derive(Clone, Debug)]
pub struct Leg {
    /// Where the vessel started: u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// Inputs: N × inputs, row-major.
    pub exogenous: Vec<f64>,
    /// Measured states: (N+1) × 3, row-major.
    pub measured: Vec<f64>,
    /// Parameters of the model that the leg was designed with.
    pub nominal: Vec<f64>,
}

/// An estimate from all legs so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// θ̂.
    pub theta: Vec<f64>,
    /// Standard error of each.
    pub standard_errors: Vec<f64>,
}

impl Found {
    /// 2-norm over the parameters of standard error over the parameter in `model`: an estimate near zero would make it large.
    pub fn predicted_error(&self, model: &[f64]) -> f64 {
        let relative = self.standard_errors.iter().zip(model).map(|(error, theta)| error / theta);
        relative.map(|x| x * x).sum::<f64>().sqrt()
    }
}

/// How often refined instruments are simulated again at most.
const ROUNDS: usize = 4;

/// Instruments are refined until no parameter moves by more than this share of itself.
const SETTLED: f64 = 1e-3;

/// Estimates the parameters of `model` from `legs`. `None` where a direction is not excited or the nominal simulation
/// diverges. A refinement that diverges or loses the excitation ends with the estimate before it.
pub fn estimate(model: &Model, legs: &[Leg], estimator: SequentialEstimator) -> Option<Found> {
    let own = |leg: &Leg| leg.nominal.clone();
    let mut found = once(model, legs, own)?;
    if estimator == SequentialEstimator::Iv {
        return Some(found);
    }
    for _ in 0..ROUNDS {
        let theta = found.theta.clone();
        let Some(next) = once(model, legs, |_| theta.clone()) else { break };
        let moved = next.theta.iter().zip(&theta).map(|(a, b)| ((a - b) / b).abs()).fold(0.0, f64::max);
        found = next;
        if moved < SETTLED {
            break;
        }
    }
    Some(found)
}

fn once(model: &Model, legs: &[Leg], nominal: impl Fn(&Leg) -> Vec<f64>) -> Option<Found> {
    let data: Vec<Regression> =
        legs.iter().map(|leg| regression(model, leg, &nominal(leg))).collect::<Option<_>>()?;
    let data: Vec<&Regression> = data.iter().collect();
    let sums: Vec<Sums> = data.iter().map(|leg| leg.sums()).collect();
    let sums: Vec<&Sums> = sums.iter().collect();
    let removal = MeanRemoval::Complete;
    let options = Options { removal, prior: None, most: f64::INFINITY };
    let centring = Centring::new(&sums, removal);
    let samples: usize = data.iter().map(|leg| leg.samples).sum();
    let (mut theta, mut standard_errors) = (Vec::new(), Vec::new());
    for (d, degree) in fit(&sums, &options).into_iter().enumerate() {
        let solution = degree.solution?;
        let p = solution.theta.len();
        let covariance = sandwich(&data, &centring, &solution, d, default_bandwidth(samples));
        standard_errors.extend((0..p).map(|i| covariance[i * p + i].max(0.0).sqrt()));
        theta.extend(solution.theta);
    }
    let found = Found { theta, standard_errors };
    found.theta.iter().chain(&found.standard_errors).all(|x| x.is_finite()).then_some(found)
}

fn regression(model: &Model, leg: &Leg, nominal: &[f64]) -> Option<Regression> {
    let states = simulate_one(model, nominal, leg.initial, &leg.exogenous);
    if check_diverged(states.iter().copied()).is_some() {
        return None;
    }
    let mut part = Part::new("", "", leg.exogenous.clone(), leg.measured.clone());
    part.instrument_states = states;
    Some(Regression::of(model, &part))
}

/// Sums of the motion that the model with parameters `theta` makes in all legs; `None` where it diverges.
pub fn predicted_sums(model: &Model, legs: &[Leg], theta: &[f64]) -> Option<Sums> {
    let mut whole = Sums::default();
    for leg in legs {
        let states = simulate_one(model, theta, leg.initial, &leg.exogenous);
        if check_diverged(states.iter().copied()).is_some() {
            return None;
        }
        whole.merge(&sums(model, leg.exogenous.clone(), states));
    }
    Some(whole)
}
