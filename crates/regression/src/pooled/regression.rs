use ship::engine::{Compiled, RunView};
use ship::model::Model;

use super::PartView;
use crate::{DegreeSums, Known, Sums};

/// The regressors, instruments and increments of one part.
#[derive(Clone, Debug, PartialEq)]
pub struct Regression {
    /// Number of pairs N.
    pub samples: usize,
    /// Surge, sway, yaw.
    pub degrees: [DegreeRegression; 3],
}

/// Those of one degree of freedom with p parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct DegreeRegression {
    /// p.
    pub parameters: usize,
    /// Regressors φ: N × p, row-major.
    pub phi: Vec<f64>,
    /// Instruments ζ: N × p, row-major.
    pub zeta: Vec<f64>,
    /// Increments Δy less the model's constant and known terms: N.
    pub target: Vec<f64>,
    /// The constraints on the parameters.
    pub known: Known,
}

impl Regression {
    /// Evaluates the terms of `model` over `part`, with its regressors as instruments.
    pub fn of(model: &Model, part: &PartView) -> Self {
        let RunView { measured, exogenous, .. } = part.run;
        let run = RunView { instrument_exogenous: exogenous, ..part.run };
        Self::with(model, &PartView { run, ..*part }, measured)
    }

    /// The same with instruments at `states`, (N+1) × 3.
    pub fn with(model: &Model, part: &PartView, states: &[f64]) -> Self {
        let RunView { measured, exogenous, instrument_exogenous, .. } = part.run;
        let samples = part.run.samples();
        let (phi, zeta) = (terms(model, exogenous, measured), terms(model, instrument_exogenous, states));
        let gains = known_gains(model, exogenous, measured);
        let mut signals = phi.into_iter().zip(zeta);
        let degrees = [0, 1, 2].map(|d| {
            let (phi, zeta) = signals.next().unwrap_or_default();
            let gained = |k: usize| measured[3 * (k + 1) + d] - measured[3 * k + d];
            let increment = |k: usize| gained(k) - gains.get(k).map_or(model.constant[d], |known| known[d]);
            DegreeRegression {
                parameters: model.degrees[d].terms.len(),
                phi,
                zeta,
                target: (0..samples).map(increment).collect(),
                known: Known::of(&model.degrees[d]),
            }
        });
        Self { samples, degrees }
    }

    /// The mean residual Δy − φᵀθ of surge, sway and yaw.
    pub fn left(&self, theta: &[f64]) -> [f64; 3] {
        let mut first = 0;
        self.degrees.each_ref().map(|degree| {
            let own = &theta[first..first + degree.parameters];
            first += degree.parameters;
            degree.residuals(own).sum::<f64>() / self.samples.max(1) as f64
        })
    }

    /// The same without the first pair. Instruments that start at the measured state share its noise with the first
    /// increment, and with no later one if the noise is white.
    pub fn after_start(mut self) -> Self {
        if self.samples > 0 {
            self.samples -= 1;
            for degree in &mut self.degrees {
                degree.phi.drain(..degree.parameters);
                degree.zeta.drain(..degree.parameters);
                degree.target.remove(0);
            }
        }
        self
    }

    /// A = Σ ζ̃ φ̃ᵀ, b = Σ ζ̃ Δy and the sums of squares.
    pub fn sums(&self) -> Sums {
        Sums {
            samples: self.samples as u64,
            degrees: self.degrees.iter().map(DegreeRegression::sums).collect(),
        }
    }
}

/// The terms of surge, sway and yaw at all `states` but the last: N × p each.
fn terms(model: &Model, exogenous: &[f64], states: &[f64]) -> [Vec<f64>; 3] {
    let (width, samples) = (model.exogenous(), states.len() / 3 - 1);
    let mut compiled = Compiled::new(model, &vec![0.0; model.parameters()]);
    let mut out = model.degrees.each_ref().map(|d| Vec::with_capacity(samples * d.terms.len()));
    for (k, state) in states.as_chunks().0.iter().take(samples).enumerate() {
        compiled.look(*state, &exogenous[width * k..width * (k + 1)], None);
        let mut first = 0;
        for (out, degree) in out.iter_mut().zip(&model.degrees) {
            let own = first..first + degree.terms.len();
            first = own.end;
            out.extend(own.map(|i| compiled.term(i)));
        }
    }
    out
}

/// The increments of surge, sway and yaw due to constant and known terms at all `states` but the last; empty without
/// such terms.
fn known_gains(model: &Model, exogenous: &[f64], states: &[f64]) -> Vec<[f64; 3]> {
    if model.known().next().is_none() {
        return Vec::new();
    }
    let width = model.exogenous();
    let mut compiled = Compiled::new(model, &vec![0.0; model.parameters()]);
    let at = |(k, state): (usize, &[f64; 3])| {
        compiled.look(*state, &exogenous[width * k..width * (k + 1)], None);
        compiled.known()
    };
    let states = states.as_chunks().0;
    states[..states.len() - 1].iter().enumerate().map(at).collect()
}

impl DegreeRegression {
    /// Row k of φ.
    pub fn phi(&self, k: usize) -> &[f64] {
        &self.phi[k * self.parameters..(k + 1) * self.parameters]
    }

    /// Row k of ζ.
    pub fn zeta(&self, k: usize) -> &[f64] {
        &self.zeta[k * self.parameters..(k + 1) * self.parameters]
    }

    /// Δy − φᵀθ of every pair.
    pub fn residuals<'a>(&'a self, theta: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let predicted = move |k: usize| self.phi(k).iter().zip(theta).map(|(f, t)| f * t).sum::<f64>();
        self.target.iter().enumerate().map(move |(k, target)| target - predicted(k))
    }

    fn sums(&self) -> DegreeSums {
        let mut sums = DegreeSums { known: self.known.clone(), ..DegreeSums::zero(self.parameters) };
        for (k, increment) in self.target.iter().enumerate() {
            sums.add_sample(self.zeta(k), self.phi(k), 1.0, *increment);
        }
        sums
    }
}
