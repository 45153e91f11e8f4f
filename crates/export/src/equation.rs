//! The right-hand sides of the model as expressions.

use model::{DerivedChannel, Factor, Function};

use crate::portable::{Portable, Summand};
use crate::text::number;

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
        let expression = |own: &'m DerivedChannel| {
            let written = own.formula.written(|function, source| {
                self.function(function, &model.channels[own.sources[source]].identifier)
            });
            (model.channels[own.variable].identifier.as_str(), written)
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
    /// [`engine::Compiled::step`].
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

#[cfg(test)]
mod tests {
    use model::{Source, Vessel};

    use crate::{Knowledge, Origin, Portable, Target};

    const SHIP: &str = "name = \"ship\"\nsample_rate_hz = 1.0\n\
        input = [{ name = \"n\", unit = \"1/s\" }, { name = \"δ\", unit = \"rad\" }]\n\
        derived = [{ name = \"thrust\", unit = \"1\", formula = \"-2 ahead^2 cos(δ)\" }, \
        { name = \"ahead\", unit = \"1/s\", formula = \"positive(n)\" }, \
        { name = \"idle\", unit = \"1/s\", formula = \"|n|\" }]\n\
        surge = [{ parameter = \"X\", term = \"u thrust\", nominal = 0.1 }]\n\
        sway = [{ parameter = \"Y\", term = \"v\", nominal = 0.1 }]\n\
        yaw = [{ parameter = \"N\", term = \"r\", nominal = 0.1 }]\n";

    #[test]
    fn channels_are_computed_before_they_are_taken_and_are_no_inputs() {
        let vessel = Vessel::from_file(toml::from_str(SHIP).unwrap()).unwrap();
        let known = Knowledge { covered: vec![("ahead".to_owned(), [0.0, 1.0])], ..Knowledge::default() };
        let portable = Portable::new(&vessel, Source::Nominal, &known, Origin::default()).unwrap();
        assert_eq!((portable.inputs().len(), portable.ranges.len()), (2, 0));
        let lines = [
            (
                Target::Python,
                "    ahead = (0.5 * (n + abs(n)))\n    thrust = -2.0 * (ahead * ahead) * cos(delta)\n",
            ),
            (
                Target::Matlab,
                "ahead = (0.5 * (n + abs(n)));\nthrust = -2.0 * (ahead * ahead) * cos(delta);\n",
            ),
            (
                Target::C,
                "    const double ahead = (0.5 * (n + fabs(n)));\n    \
                 const double thrust = -2.0 * (ahead * ahead) * cos(delta);\n",
            ),
        ];
        for (target, expected) in lines {
            let files = portable.files(target, None).unwrap();
            let text = String::from_utf8(files[0].clone()).unwrap();
            assert!(text.contains(expected) && !text.contains("abs(n);\n"), "{text}");
        }
        assert!(!portable.unit_sources()[0].1.contains("thrust"));
    }
}
