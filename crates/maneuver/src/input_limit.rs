use std::borrow::Cow;

use refusal::Invalid;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer};

/// The lowest and the highest value of an input, written as the largest modulus or as both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputLimit {
    /// The lowest.
    pub low: f64,
    /// The highest.
    pub high: f64,
}

impl From<f64> for InputLimit {
    fn from(modulus: f64) -> Self {
        Self { low: -modulus, high: modulus }
    }
}

impl InputLimit {
    /// Half of its width.
    pub fn half(&self) -> f64 {
        0.5 * (self.high - self.low)
    }

    /// Its middle: zero where it is a modulus.
    pub fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// The largest modulus within.
    pub fn modulus(&self) -> f64 {
        self.high.max(-self.low)
    }

    /// As much of it as is within the `range` of an actuator; all of that where they have nothing in common.
    #[must_use]
    pub fn within(self, [low, high]: [f64; 2]) -> Self {
        let both = Self { low: self.low.max(low), high: self.high.min(high) };
        if both.low < both.high { both } else { Self { low, high } }
    }

    /// Refuses one without width; `thing` names it.
    ///
    /// # Errors
    /// Ends that are no numbers, or in the wrong order; a modulus that is not above 0.
    pub fn check(&self, thing: String) -> Result<(), Invalid> {
        if self.low < self.high && self.half().is_finite() {
            return Ok(());
        }
        let found = if self.low == -self.high {
            self.high.to_string()
        } else {
            format!("[{}, {}]", self.low, self.high)
        };
        let expected = "a number above 0, or the lowest and a higher, highest value";
        Err(Invalid::new(thing, found, expected, "correct it"))
    }
}

impl JsonSchema for InputLimit {
    fn schema_name() -> Cow<'static, str> {
        "InputLimit".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let (modulus, ends) = (generator.subschema_for::<f64>(), generator.subschema_for::<[f64; 2]>());
        json_schema!({
            "description": "The lowest and the highest value of an input, written as the largest modulus or as both.",
            "anyOf": [modulus, ends]
        })
    }
}

impl<'de> Deserialize<'de> for InputLimit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "a number, or two: the lowest and the highest value")]
        enum Written {
            Modulus(f64),
            Ends([f64; 2]),
        }
        Ok(match Written::deserialize(deserializer)? {
            Written::Modulus(modulus) => modulus.into(),
            Written::Ends([low, high]) => Self { low, high },
        })
    }
}
