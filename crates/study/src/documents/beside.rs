use estimation::pooled::FreeRunErrors;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Forces of the ship that were fitted beside a search, and what `average.json` delivers of the two.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BesideForces {
    /// What `average.json` has.
    pub delivered: DeliveredKind,
    /// How the forces may be fitted.
    pub tried: Vec<TriedFit>,
    /// The forces alone on recordings that were left out of them; none where a fold lacks a fit, or a window diverged.
    pub errors: Option<FreeRunErrors>,
    /// The same over windows of which one begins at every quarter of another.
    pub overlapping: Option<FreeRunErrors>,
}

/// What is delivered of a search and of forces beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DeliveredKind {
    /// The mean of both trajectories.
    Average,
    /// The terms that the search found.
    Search,
    /// The forces.
    Forces,
}

/// A way to fit forces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TriedFit {
    /// The longest windows that are fitted \[s\].
    pub window_s: f64,
    /// Whether windows start at their first measured sample.
    pub measured_starts: bool,
    /// Mean fit of u, v, r of recordings that were left out of it \[%\]; null where a fold lacks a fit, or a window diverged.
    pub score: Option<f64>,
    /// Whether it is the delivered one.
    pub chosen: bool,
}

impl DeliveredKind {
    /// Whether the searched terms, and the forces, are delivered.
    pub fn members(self) -> [bool; 2] {
        [self != Self::Forces, self != Self::Search]
    }
}
