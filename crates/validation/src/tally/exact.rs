use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fractions of 1 that numbers are rounded to before they are added: 2⁴⁰.
const FRACTIONS: f64 = (1_u64 << 40) as f64;
/// Larger numbers are not added: 2³⁴ of them fit.
const MOST: f64 = (1_u64 << 53) as f64;

/// A sum of numbers, each rounded to a multiple of 2⁻⁴⁰: whole numbers are added, so any order gives the same. Written as that
/// whole number, in decimal digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(with = "String", extend("pattern" = "^-?[0-9]+$"))]
pub struct ExactSum(i128);

impl ExactSum {
    /// Adds `number`, unless it is too large or NaN; returns whether it did.
    pub fn add(&mut self, number: f64) -> bool {
        let fits = number.abs() <= MOST;
        if fits {
            self.0 = self.0.saturating_add(whole(number * FRACTIONS));
        }
        fits
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: Self) {
        self.0 = self.0.saturating_add(other.0);
    }

    /// The sum.
    pub fn value(self) -> f64 {
        self.0 as f64 / FRACTIONS
    }
}

/// `number` rounded, a half away from zero. Most numbers fit 64 bits, which is faster.
fn whole(number: f64) -> i128 {
    if number.abs() >= (1_u64 << 52) as f64 {
        return number.round() as i128;
    }
    let below = number as i64;
    let rest = number - below as f64;
    i128::from(below + i64::from(rest >= 0.5) - i64::from(rest <= -0.5))
}

impl TryFrom<String> for ExactSum {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse().map(Self).map_err(|_| format!("`{text}` is no whole number"))
    }
}

impl From<ExactSum> for String {
    fn from(sum: ExactSum) -> Self {
        sum.0.to_string()
    }
}
