use schemars::JsonSchema;
use serde::Deserialize;

/// `terms.toml`: terms that a search may add to the structure of `vessel.toml`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TermLists {
    /// Of the surge equation.
    #[serde(default)]
    pub surge: Vec<String>,
    /// Of the sway equation.
    #[serde(default)]
    pub sway: Vec<String>,
    /// Of the yaw equation.
    #[serde(default)]
    pub yaw: Vec<String>,
}
