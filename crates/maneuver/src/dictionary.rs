use std::collections::BTreeSet;
use std::str::FromStr;

use refusal::{Invalid, check_name};
use schemars::JsonSchema;
use serde::Deserialize;
use ship::model::Source;

use super::generate_spec::GenerateSpec;
use super::spec::ManeuverSpec;
use crate::reached::Tolerance;

/// `dictionary.toml` as written.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DictionaryFile {
    /// Duration of every maneuver that states none \[s\].
    pub duration_s: Option<f64>,
    /// The parameters that turn maneuvers into inputs.
    #[serde(default)]
    pub inputs_from: Source,
    /// By how much written motions may differ from what they are called.
    #[serde(default)]
    pub tolerance: Tolerance,
    /// The maneuvers, in order.
    #[serde(default, rename = "maneuver")]
    pub maneuvers: Vec<ManeuverSpec>,
    /// More maneuvers, by generation.
    pub generate: Option<GenerateSpec>,
}

/// From the text of `dictionary.toml`, compiled here alone: others would have code of their own for every type in it.
impl FromStr for DictionaryFile {
    type Err = toml::de::Error;

    fn from_str(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }
}

impl DictionaryFile {
    /// The written maneuvers, then the generated ones, with unique names.
    ///
    /// # Errors
    /// An empty dictionary, a duplicate name and meaningless numbers: names the maneuver and the key.
    pub fn expanded(&self) -> Result<Vec<ManeuverSpec>, Invalid> {
        let generated = self.generate.as_ref().map(GenerateSpec::candidates).transpose()?;
        let all: Vec<ManeuverSpec> =
            self.maneuvers.iter().cloned().chain(generated.into_iter().flatten()).collect();
        check_all(&all, self.duration_s)?;
        self.tolerance.check()?;
        Ok(all)
    }

    /// Refuses swings that are too fast for `rate_hz`.
    pub(super) fn check_sampling(&self, rate_hz: f64) -> Result<(), Invalid> {
        self.maneuvers.iter().try_for_each(|maneuver| maneuver.check_sampling(rate_hz))?;
        self.generate.as_ref().map_or(Ok(()), |generate| generate.check_sampling(rate_hz))
    }
}

pub(crate) fn check_all(maneuvers: &[ManeuverSpec], default_s: Option<f64>) -> Result<(), Invalid> {
    if maneuvers.is_empty() {
        return Err(Invalid::new("[[maneuver]]", "none", "at least one maneuver", "add one, or [generate]"));
    }
    let mut names = BTreeSet::new();
    for maneuver in maneuvers {
        check_name("`name` of a [[maneuver]]", &maneuver.name)?;
        if !names.insert(maneuver.name.as_str()) {
            return Err(Invalid::new(
                format!("maneuver `{}`", maneuver.name),
                "a name that is used twice",
                "a name of its own for every maneuver",
                "rename one of them",
            ));
        }
        maneuver.check(default_s)?;
    }
    Ok(())
}
