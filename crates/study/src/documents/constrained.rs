use estimation::pooled::Pooled;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::{Constrained, Constraint, Vessel};

/// A parameter that is not estimated by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstrainedParameter {
    /// Its name.
    pub name: String,
    /// Its term.
    pub term: String,
    /// Its unit.
    pub unit: String,
    /// Whether its value is known.
    pub fixed: bool,
    /// Else the parameter that it equals …
    pub tied_to: Option<String>,
    /// … times this factor.
    pub factor: Option<f64>,
    /// Its value; null where it follows from an estimate that there is not, or from one of each run.
    pub estimate: Option<f64>,
    /// Its standard error, where it follows from an estimate.
    pub standard_error: Option<f64>,
}

impl ConstrainedParameter {
    /// The constrained parameters of `vessel`, with their values from an estimate of all runs, if there is one.
    pub fn all(vessel: &Vessel, found: Option<&Pooled>) -> Vec<Self> {
        let estimates: Vec<(Option<f64>, Option<f64>)> = found.map_or(Vec::new(), |found| {
            let parameters = found.degrees.iter().flat_map(|d| &d.parameters);
            parameters.map(|p| (p.estimate, p.standard_error)).collect()
        });
        vessel.constrained.iter().map(|own| Self::of(vessel, own, &estimates)).collect()
    }

    fn of(vessel: &Vessel, constrained: &Constrained, estimates: &[(Option<f64>, Option<f64>)]) -> Self {
        let written = Self {
            name: constrained.name.clone(),
            term: constrained.term.text.clone(),
            unit: vessel.model.unit(constrained.degree, &constrained.term),
            fixed: true,
            tied_to: None,
            factor: None,
            estimate: None,
            standard_error: None,
        };
        match constrained.constraint {
            Constraint::Fixed(value) => Self { estimate: Some(value), ..written },
            Constraint::Tied { to, factor } => {
                let (estimate, error) = estimates.get(to).copied().unwrap_or_default();
                Self {
                    fixed: false,
                    tied_to: vessel.model.parameter_names().nth(to).map(str::to_owned),
                    factor: Some(factor),
                    estimate: estimate.map(|estimate| factor * estimate),
                    standard_error: error.map(|error| factor.abs() * error),
                    ..written
                }
            }
        }
    }
}
