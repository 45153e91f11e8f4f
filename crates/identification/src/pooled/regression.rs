use vessel::{Compiled, Model};

use super::Part;
use crate::{DegreeSums, Sums};

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
    /// Increments Δy less the model's constant: N.
    pub target: Vec<f64>,
}

/// The regressions of many parts.
pub trait Regressions {
    /// Calls `look` with the number of every part and its regression, in order.
    fn each(&self, look: &mut dyn FnMut(usize, &Regression));
}

impl Regressions for Vec<&Regression> {
    fn each(&self, look: &mut dyn FnMut(usize, &Regression)) {
        self.iter().enumerate().for_each(|(i, regression)| look(i, regression));
    }
}

/// The regressions of parts, made anew whenever they are looked at: all of them together are many times the data.
#[derive(Clone, Copy, Debug)]
pub struct Remade<'a> {
    /// The model.
    pub model: &'a Model,
    /// The parts.
    pub parts: &'a [Part],
    /// Whether instruments were simulated from the measured state at the start of every part, see
    /// [`Regression::after_start`]; else they are the regressors.
    pub simulated: bool,
}

impl Regressions for Remade<'_> {
    fn each(&self, look: &mut dyn FnMut(usize, &Regression)) {
        for (i, part) in self.parts.iter().enumerate() {
            let made = match self.simulated {
                true => Regression::of(self.model, part).after_start(),
                false => Regression::with(self.model, part, &part.measured),
            };
            look(i, &made);
        }
    }
}

impl Remade<'_> {
    /// The sums of every part.
    pub fn sums(&self) -> Vec<Sums> {
        let mut sums = Vec::with_capacity(self.parts.len());
        self.each(&mut |_, regression| sums.push(regression.sums()));
        sums
    }
}

impl Regression {
    /// Evaluates the terms of `model` over `part`.
    pub fn of(model: &Model, part: &Part) -> Self {
        Self::with(model, part, &part.instrument_states)
    }

    /// Evaluates the terms of `model` over `part`, those of the instruments at `states`.
    fn with(model: &Model, part: &Part, states: &[f64]) -> Self {
        let (phi, zeta) = (terms(model, part, &part.measured), terms(model, part, states));
        let mut signals = phi.into_iter().zip(zeta);
        let degrees = [0, 1, 2].map(|d| {
            let (phi, zeta) = signals.next().unwrap_or_default();
            let gained = |k: usize| part.measured[3 * (k + 1) + d] - part.measured[3 * k + d];
            let increment = |k: usize| gained(k) - model.constant[d];
            DegreeRegression {
                parameters: model.degrees[d].terms.len(),
                phi,
                zeta,
                target: (0..part.samples()).map(increment).collect(),
            }
        });
        Self { samples: part.samples(), degrees }
    }

    /// The same without the first pair. Instruments that start at the measured state share its noise with the first
    /// increment, and with no later one where the noise is white.
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

/// The terms of surge, sway and yaw at `states`: N × p each.
fn terms(model: &Model, part: &Part, states: &[f64]) -> [Vec<f64>; 3] {
    let width = model.exogenous();
    let mut compiled = Compiled::new(model, &vec![0.0; model.parameters()]);
    let mut out = model.degrees.each_ref().map(|d| Vec::with_capacity(part.samples() * d.terms.len()));
    for (k, state) in states.as_chunks().0.iter().take(part.samples()).enumerate() {
        compiled.look(*state, &part.exogenous[width * k..width * (k + 1)], None);
        let mut first = 0;
        for (out, degree) in out.iter_mut().zip(&model.degrees) {
            let own = first..first + degree.terms.len();
            first = own.end;
            out.extend(own.map(|i| compiled.term(i)));
        }
    }
    out
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

    fn sums(&self) -> DegreeSums {
        let mut sums = DegreeSums::zero(self.parameters);
        for (k, increment) in self.target.iter().enumerate() {
            sums.add_sample(self.zeta(k), self.phi(k), 1.0, *increment);
        }
        sums
    }
}
