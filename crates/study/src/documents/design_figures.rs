use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::figure_goals::{FigureGoal, FigureGoals};

/// What the experiment leaves uncertain of figures of merit, where `--figures` was given.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignFigures {
    /// Number of samples of the experiment that standard errors are for; 1 where none was asked for. They are in proportion
    /// to 1/√samples.
    pub samples: u64,
    /// All figures with slopes, those without a weight too.
    pub figures: Vec<DesignFigure>,
    /// Which figures are left out or have no weight, and why.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
}

/// A figure of merit and its standard errors.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignFigure {
    /// The maneuver.
    pub maneuver: String,
    /// Its name.
    pub name: String,
    /// What it is.
    pub what: String,
    /// Unit of its value and errors.
    pub unit: String,
    /// Its value for the model.
    pub value: f64,
    /// Its weight in the criterion `figures`.
    pub weight: f64,
    /// The standard error that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wanted: Option<f64>,
    /// Its standard error after this experiment.
    pub standard_error: f64,
    /// That after the D-optimal experiment of the same maneuvers and time: the one of `design` without `--criterion`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub d_optimal: Option<f64>,
    /// The first over the second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratio: Option<f64>,
}

/// Figures and their standard errors for an experiment.
pub struct SolvedFigures<'a> {
    /// The figures.
    pub goals: &'a FigureGoals,
    /// The standard error of each after the experiment.
    pub errors: Vec<f64>,
    /// After the D-optimal one, if there is one.
    pub d_optimal: Option<Vec<f64>>,
}

impl SolvedFigures<'_> {
    /// For the document. `samples`: of the experiment.
    pub(super) fn document(&self, samples: u64) -> DesignFigures {
        let one = |(index, goal): (usize, &FigureGoal)| {
            let (error, other) = (self.errors[index], self.d_optimal.as_ref().map(|errors| errors[index]));
            DesignFigure {
                maneuver: goal.maneuver.clone(),
                name: goal.name.clone(),
                what: goal.what.clone(),
                unit: goal.unit.clone(),
                value: goal.figure.value,
                weight: goal.figure.weight,
                wanted: goal.wanted,
                standard_error: error,
                d_optimal: other,
                ratio: other.filter(|other| *other > 0.0).map(|other| error / other),
            }
        };
        DesignFigures {
            samples,
            figures: self.goals.goals.iter().enumerate().map(one).collect(),
            left_out: self.goals.left_out.clone(),
        }
    }
}
