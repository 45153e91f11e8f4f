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
    /// Its factors; none make the constant 1.
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

    /// The constant 1, which no text stands for.
    pub(crate) fn constant() -> Self {
        Self { text: "1".to_owned(), factors: Vec::new() }
    }

    /// Whether it is the constant 1.
    pub fn is_constant(&self) -> bool {
        self.factors.is_empty()
    }

    /// The term's values at `N` samples at once; `values` holds one array per variable.
    #[inline(always)]
    pub fn values<X: Number, const N: usize>(&self, values: &[[X; N]], out: &mut [X; N]) {
        // What is decided per factor stays out of the loops, so that they are whole vectors.
        let Some((first, others)) = self.factors.split_first() else {
            *out = [X::ONE; N];
            return;
        };
        *out = values[first.variable];
        if first.modulus {
            out.iter_mut().for_each(|o| *o = o.modulus());
        }
        for factor in others {
            let pairs = out.iter_mut().zip(&values[factor.variable]);
            if factor.modulus {
                pairs.for_each(|(o, value)| *o = *o * value.modulus());
            } else {
                pairs.for_each(|(o, value)| *o = *o * *value);
            }
        }
    }
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
