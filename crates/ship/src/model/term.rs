use crate::forces::{MOST_FACTORS, parse_name, parse_power};
use numerics::Number;
use refusal::{Invalid, foreign, nearest};

/// One factor of a term: a variable or its modulus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Factor {
    /// Index of the variable in [`crate::model::Model::variables`].
    pub variable: usize,
    /// Whether it is the modulus.
    pub modulus: bool,
}

/// A product of variables and moduli, such as `u |u|`, `v r` or `u |u| delta`. A power is a repeated factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// As written.
    pub text: String,
    /// Its factors; without any it is the constant 1.
    pub factors: Vec<Factor>,
    /// The terms of parameters that are tied to this one's: its parameter multiplies the sum of all. Empty for most.
    pub tied: Vec<Product>,
}

/// A number times variables and moduli.
#[derive(Clone, Debug, PartialEq)]
pub struct Product {
    /// The number.
    pub coefficient: f64,
    /// The others; without any it is the constant.
    pub factors: Vec<Factor>,
}

impl Term {
    /// Parses `text`: names side by side or with `*` between them, `|name|` for the modulus, `^2` for a power. `1` is the
    /// constant.
    ///
    /// # Errors
    /// A name that is not in `variables`, an unclosed `|`, a power that is not an integer from 1 to 9, no factor.
    pub fn parse(text: &str, variables: &[&str]) -> Result<Self, Invalid> {
        if text.trim() == "1" {
            return Ok(Self::constant());
        }
        let mut rest = text.trim_start();
        let mut factors = Vec::new();
        while !rest.is_empty() {
            let (factor, power, after) = parse_factor(text, rest, variables)?;
            factors.extend(std::iter::repeat_n(factor, power.into()));
            if factors.len() > MOST_FACTORS {
                return Err(malformed(text, &format!("more than {MOST_FACTORS} factors")));
            }
            rest = after.trim_start().trim_start_matches('*').trim_start();
        }
        if factors.is_empty() {
            return Err(malformed(text, "no factor"));
        }
        Ok(Self::of(text.split_whitespace().collect::<Vec<_>>().join(" "), factors))
    }

    /// The product of `factors`, written as `text`.
    pub fn of(text: String, factors: Vec<Factor>) -> Self {
        Self { text, factors, tied: Vec::new() }
    }

    /// The constant 1.
    pub(crate) fn constant() -> Self {
        Self::of("1".to_owned(), Vec::new())
    }

    /// Whether it is the constant 1.
    pub fn is_constant(&self) -> bool {
        self.factors.is_empty()
    }

    /// The factors of its products: its own, then those of the terms that are tied to it.
    pub fn products(&self) -> impl Iterator<Item = &[Factor]> {
        [self.factors.as_slice()].into_iter().chain(self.tied.iter().map(|tied| tied.factors.as_slice()))
    }

    /// The term's values at `N` samples at once; `values` holds one array per variable.
    pub fn values<X: Number, const N: usize>(&self, values: &[[X; N]], out: &mut [X; N]) {
        multiply(&self.factors, values, out);
        for tied in &self.tied {
            tied.add(values, out);
        }
    }
}

impl Product {
    /// Adds its values at `N` samples to `out`, see [`Term::values`].
    fn add<X: Number, const N: usize>(&self, values: &[[X; N]], out: &mut [X; N]) {
        let mut product = [X::ZERO; N];
        multiply(&self.factors, values, &mut product);
        let coefficient = X::from(self.coefficient);
        for (o, product) in out.iter_mut().zip(product) {
            *o += coefficient * product;
        }
    }
}

/// The product of `factors`; 1 without any.
fn multiply<X: Number, const N: usize>(factors: &[Factor], values: &[[X; N]], out: &mut [X; N]) {
    *out = [X::ONE; N];
    for factor in factors {
        for (o, value) in out.iter_mut().zip(&values[factor.variable]) {
            *o = *o * if factor.modulus { value.modulus() } else { *value };
        }
    }
}

fn parse_factor<'a>(text: &str, rest: &'a str, variables: &[&str]) -> Result<(Factor, u8, &'a str), Invalid> {
    let (modulus, name, after) = parse_name(rest).map_err(|fault| malformed(text, &fault))?;
    let variable = variables.iter().position(|v| *v == name).ok_or_else(|| unknown(text, name, variables))?;
    let (power, after) = parse_power(after).map_err(|fault| malformed(text, &fault))?;
    Ok((Factor { variable, modulus }, power, after))
}

fn malformed(text: &str, found: &str) -> Invalid {
    Invalid::new(
        format!("term `{}`", foreign(text)),
        found,
        "a product such as `u |u|`, `v r` or `u^2 delta`, or the constant `1`",
        "write the term again",
    )
}

fn unknown(text: &str, name: &str, variables: &[&str]) -> Invalid {
    let remedy = match nearest(name, variables.iter().copied()) {
        Some(near) => {
            format!(
                "did you mean `{near}`? (inputs, measured disturbances and derived channels must be declared)"
            )
        }
        None => "declare it as [[input]], [[measured]] or [[derived]]".to_owned(),
    };
    let given = if name.is_empty() { "a character that starts no name".into() } else { format!("`{name}`") };
    Invalid::new(
        format!("term `{}`", foreign(text)),
        given,
        format!("one of {}", variables.join(", ")),
        remedy,
    )
}
