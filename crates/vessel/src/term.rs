use crate::{Invalid, Number, nearest};

/// One factor of a term: a variable or its modulus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Factor {
    /// Index of the variable in [`crate::Model::variables`].
    pub variable: usize,
    /// Whether the modulus is meant.
    pub modulus: bool,
}

/// A product of variables and moduli, such as `u |u|`, `v r` or `u |u| delta`. A power is a repeated factor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Term {
    /// As written.
    pub text: String,
    /// At least one factor.
    pub factors: Vec<Factor>,
}

impl Term {
    /// Parses `text`: names side by side or with `*` between them, `|name|` for the modulus, `^2` for a power.
    ///
    /// # Errors
    /// A name that is none of `variables`, an unclosed `|`, a power that is no whole number from 1 to 9, no factor.
    pub fn parse(text: &str, variables: &[&str]) -> Result<Self, Invalid> {
        let mut rest = text.trim_start();
        let mut factors = Vec::new();
        while !rest.is_empty() {
            let (factor, power, after) = parse_factor(text, rest, variables)?;
            factors.extend(std::iter::repeat_n(factor, power));
            rest = after.trim_start().trim_start_matches('*').trim_start();
        }
        if factors.is_empty() {
            return Err(malformed(text, "no factor"));
        }
        Ok(Self { text: text.split_whitespace().collect::<Vec<_>>().join(" "), factors })
    }

    /// The term's values at `N` samples at once; `values` holds one array per variable.
    #[inline(always)]
    pub fn values<X: Number, const N: usize>(&self, values: &[[X; N]], out: &mut [X; N]) {
        // What is decided per factor stays out of the loops, so that they are whole vectors.
        let first = self.factors[0];
        *out = values[first.variable];
        if first.modulus {
            out.iter_mut().for_each(|o| *o = o.modulus());
        }
        for factor in &self.factors[1..] {
            let pairs = out.iter_mut().zip(&values[factor.variable]);
            if factor.modulus {
                pairs.for_each(|(o, value)| *o = *o * value.modulus());
            } else {
                pairs.for_each(|(o, value)| *o = *o * *value);
            }
        }
    }

    /// The term's value for one set of variables.
    pub fn evaluate(&self, values: &[f64]) -> f64 {
        self.factors.iter().map(|f| scalar(*f, values)).product()
    }

    /// Partial derivative with respect to variable `variable` (at a zero modulus: 0).
    pub fn derivative(&self, values: &[f64], variable: usize) -> f64 {
        let mut sum = 0.0;
        for (i, factor) in self.factors.iter().enumerate() {
            if factor.variable == variable {
                let inner = if factor.modulus { sign(values[variable]) } else { 1.0 };
                let others = self.factors.iter().enumerate().filter(|(j, _)| *j != i);
                sum += inner * others.map(|(_, f)| scalar(*f, values)).product::<f64>();
            }
        }
        sum
    }

    /// Adds `first` ∂φ/∂z + Σ_i `second`\[i\] ∂²φ/∂(state i)∂z to `out`\[z\] for every variable z (slope of a modulus at
    /// zero: 0).
    pub fn add_slopes(&self, values: &[f64], first: f64, second: [f64; 3], out: &mut [f64]) {
        let inner = |f: Factor| if f.modulus { sign(values[f.variable]) } else { 1.0 };
        for (b, factor) in self.factors.iter().enumerate() {
            let others = |a: usize| -> f64 {
                let rest = self.factors.iter().enumerate().filter(|(j, _)| *j != a && *j != b);
                rest.map(|(_, f)| scalar(*f, values)).product()
            };
            let mut sum = first * others(b);
            for (a, other) in self.factors.iter().enumerate().filter(|(a, f)| *a != b && f.variable < 3) {
                sum += second[other.variable] * inner(*other) * others(a);
            }
            out[factor.variable] += inner(*factor) * sum;
        }
    }
}

fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

fn scalar(factor: Factor, values: &[f64]) -> f64 {
    let value = values[factor.variable];
    if factor.modulus { value.abs() } else { value }
}

fn parse_factor<'a>(
    text: &str,
    rest: &'a str,
    variables: &[&str],
) -> Result<(Factor, usize, &'a str), Invalid> {
    let (modulus, start) = match rest.strip_prefix('|') {
        Some(inner) => (true, inner.trim_start()),
        None => (false, rest),
    };
    let end = start.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(start.len());
    let (name, mut after) = start.split_at(end);
    if modulus {
        after = after.trim_start().strip_prefix('|').ok_or_else(|| malformed(text, "an unclosed `|`"))?;
    }
    let variable = variables.iter().position(|v| *v == name).ok_or_else(|| unknown(text, name, variables))?;
    let (power, after) = parse_power(text, after)?;
    Ok((Factor { variable, modulus }, power, after))
}

fn parse_power<'a>(text: &str, rest: &'a str) -> Result<(usize, &'a str), Invalid> {
    let Some(exponent) = rest.trim_start().strip_prefix('^') else {
        return Ok((1, rest));
    };
    let exponent = exponent.trim_start();
    let digits = exponent.find(|c: char| !c.is_ascii_digit()).unwrap_or(exponent.len());
    match exponent[..digits].parse::<usize>() {
        Ok(power @ 1..=9) => Ok((power, &exponent[digits..])),
        _ => Err(malformed(text, "a power that is no whole number from 1 to 9")),
    }
}

fn malformed(text: &str, found: &str) -> Invalid {
    Invalid::new(
        format!("term `{text}`"),
        found,
        "a product such as `u |u|`, `v r` or `u^2 delta`",
        "write the term again",
    )
}

fn unknown(text: &str, name: &str, variables: &[&str]) -> Invalid {
    let remedy = match nearest(name, variables.iter().copied()) {
        Some(near) => {
            format!("did you mean `{near}`? (inputs and measured disturbances must be declared)")
        }
        None => "declare it as [[input]] or [[measured]]".to_owned(),
    };
    let found = if name.is_empty() { "a character that starts no name".into() } else { format!("`{name}`") };
    Invalid::new(format!("term `{text}`"), found, format!("one of {}", variables.join(", ")), remedy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Lane;

    const VARIABLES: [&str; 5] = ["u", "v", "r", "n", "delta"];

    fn at(text: &str, values: [f64; 5]) -> f64 {
        Term::parse(text, &VARIABLES).map_or(f64::NAN, |t| t.evaluate(&values))
    }

    #[test]
    fn products_powers_and_moduli_are_read_as_written() {
        let x = [-2.0, 3.0, 0.5, -4.0, 0.1];
        assert_eq!(at("u", x), -2.0);
        assert_eq!(at("u|u|", x), -4.0);
        assert_eq!(at("u |u| delta", x), -0.4);
        assert_eq!(at("v * r", x), 1.5);
        assert_eq!(at("n |n|", x), -16.0);
        assert_eq!(at("u^3 |r|^2", x), -2.0);
    }

    #[test]
    fn a_misspelt_variable_is_refused_with_the_nearest_name() {
        let error = Term::parse("u |u| dleta", &VARIABLES).unwrap_err();
        assert!(error.to_string().contains("`dleta`") && error.remedy.contains("`delta`"), "{error}");
        for text in ["", "|u", "u^0", "u^x", "u +"] {
            assert!(Term::parse(text, &VARIABLES).is_err(), "{text}");
        }
    }

    #[test]
    fn law_lanes_and_derivatives_agree_with_the_scalar_value() {
        let x = [-0.7, 0.3, 0.2, 5.0, -0.4];
        let lanes: Vec<Lane> = x.iter().map(|v| Lane::splat(*v)).collect();
        for text in ["u |u|", "v r", "u^2 |v| delta", "|n| n"] {
            let term = Term::parse(text, &VARIABLES).unwrap();
            let (mut many, mut one) = ([Lane::ZERO; 2], [0.0; 2]);
            term.values(&lanes.iter().map(|lane| [*lane; 2]).collect::<Vec<_>>(), &mut many);
            term.values(&x.map(|x| [x; 2]), &mut one);
            assert_eq!((many[1][3], one[1]), (term.evaluate(&x), term.evaluate(&x)), "{text}");
            for i in 0..5 {
                let (mut hi, mut lo) = (x, x);
                hi[i] += 1e-6;
                lo[i] -= 1e-6;
                let numeric = (term.evaluate(&hi) - term.evaluate(&lo)) / 2e-6;
                approx::assert_relative_eq!(
                    term.derivative(&x, i),
                    numeric,
                    max_relative = 1e-6,
                    epsilon = 1e-8
                );
            }
        }
    }

    #[test]
    fn law_second_slopes_are_the_difference_quotients_of_first_ones() {
        let x = [-0.7, 0.3, 0.2, 5.0, -0.4];
        let (first, second) = (0.3, [1.2, -0.8, 0.5]);
        for text in ["u |u|", "v r", "u^3 |v| delta", "|n| n u", "|u| |r| r^2"] {
            let term = Term::parse(text, &VARIABLES).unwrap();
            let weighted = |x: &[f64]| -> f64 {
                first * term.evaluate(x) + (0..3).map(|i| second[i] * term.derivative(x, i)).sum::<f64>()
            };
            let mut out = [0.0; 5];
            term.add_slopes(&x, first, second, &mut out);
            for (i, found) in out.iter().enumerate() {
                let (mut hi, mut lo) = (x, x);
                hi[i] += 1e-5;
                lo[i] -= 1e-5;
                let numeric = (weighted(&hi) - weighted(&lo)) / 2e-5;
                approx::assert_relative_eq!(*found, numeric, max_relative = 1e-8, epsilon = 1e-9);
            }
        }
    }
}
