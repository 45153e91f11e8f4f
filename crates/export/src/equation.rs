//! The right-hand sides of the model as expressions.

use vessel::Factor;

use crate::portable::{Portable, Summand};
use crate::text::number;

/// How a language writes what all of them write alike otherwise.
pub struct Syntax {
    /// What takes the modulus.
    pub modulus: &'static str,
    /// A parameter, from its identifier.
    pub parameter: fn(&Portable, &str) -> String,
    /// What stands between two summands.
    pub between: &'static str,
}

impl Syntax {
    /// What degree of freedom `d` of `model` gains in a sample. Products and sums stand in the order in which
    /// [`vessel::Compiled::step`] computes them.
    pub fn gain(&self, model: &Portable, d: usize) -> String {
        let summands: Vec<String> = model.equations[d].iter().map(|own| self.summand(model, own)).collect();
        summands.join(self.between)
    }

    fn summand(&self, model: &Portable, summand: &Summand) -> String {
        let parameter = (self.parameter)(model, &model.parameters[summand.parameter].identifier);
        match summand.products.as_slice() {
            [] => parameter,
            [(factors, None)] if factors.len() == 1 => {
                format!("{parameter} * {}", self.product(model, factors, None))
            }
            products => {
                let each = products.iter().map(|(factors, own)| self.product(model, factors, *own));
                format!("{parameter} * ({})", each.collect::<Vec<_>>().join(" + "))
            }
        }
    }

    fn product(&self, model: &Portable, factors: &[Factor], coefficient: Option<f64>) -> String {
        let factor = |factor: &Factor| {
            let name = &model.channels[factor.variable].identifier;
            if factor.modulus { format!("{}({name})", self.modulus) } else { name.clone() }
        };
        let written = factors.iter().map(factor).chain(coefficient.map(number));
        written.collect::<Vec<_>>().join(" * ")
    }
}
