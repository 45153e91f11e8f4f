//! The right-hand sides of the model as expressions.

use ship::model::{DerivedChannel, Factor, Function};

use crate::export::portable::{Portable, Summand};
use crate::export::text::number;

/// Where the expressions of a language differ from the others'.
pub struct Syntax {
    /// The function for the modulus.
    pub modulus: &'static str,
    /// A parameter, from its identifier.
    pub parameter: fn(&Portable, &str) -> String,
    /// Separator between two summands.
    pub between: &'static str,
}

impl Syntax {
    /// The computed channels that some equation uses: identifier and expression.
    pub fn derived<'m>(&self, model: &'m Portable) -> Vec<(&'m str, String)> {
        let used = model.used();
        let needed = model.derived.iter().filter(|own| used.contains(&own.variable));
        let expression = |derived_channel: &'m DerivedChannel| {
            let written = derived_channel.formula.written(|function, source| {
                self.function(function, &model.channels[derived_channel.sources[source]].identifier)
            });
            (model.channels[derived_channel.variable].identifier.as_str(), written)
        };
        needed.map(expression).collect()
    }

    fn function(&self, function: Function, name: &str) -> String {
        let modulus = format!("{}({name})", self.modulus);
        match function {
            Function::Itself => name.to_owned(),
            Function::Modulus => modulus,
            Function::PositivePart => format!("(0.5 * ({name} + {modulus}))"),
            Function::NegativePart => format!("(0.5 * ({name} - {modulus}))"),
            Function::Sine => format!("sin({name})"),
            Function::Cosine => format!("cos({name})"),
        }
    }

    /// The increment of degree of freedom `d` of `model` in a step. Products and sums are in the order of
    /// [`ship::engine::Compiled::step`].
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
