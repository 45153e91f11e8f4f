//! Flags for additional unknowns of estimates by simulation, for all stages that make such estimates.

use std::collections::BTreeMap;

use clap::Args;
use estimation::Estimator;
use estimation::runs::{AdditionalUnknowns, Intercepts, UnknownCurrent};
use serde_json::{Value, json};

use crate::choice::choice;
use crate::failure::Failure;

/// The flags.
#[derive(Args, Clone, Copy, Debug)]
pub struct AdditionalFlags {
    /// Forces that stay, as unknowns of `output-error` and `prediction-error`
    #[arg(long, value_parser = choice(&Intercepts::ALL, Intercepts::name, Intercepts::description), default_value_t = Intercepts::Each)]
    intercepts: Intercepts,
    /// A current of every run, as two more unknowns of `output-error`
    #[arg(long, value_name = "AXES", value_parser = choice(&UnknownCurrent::ALL, UnknownCurrent::name, UnknownCurrent::description), default_value_t = UnknownCurrent::None)]
    unknown_current: UnknownCurrent,
}

impl AdditionalFlags {
    /// The unknowns of the flags.
    pub fn unknown(self) -> AdditionalUnknowns {
        AdditionalUnknowns { intercepts: self.intercepts, current: self.unknown_current }
    }

    /// Refuses flags that none of the `estimators` uses.
    ///
    /// # Errors
    /// A flag for estimators that are not requested.
    pub fn check(self, estimators: &[Estimator]) -> Result<(), Failure> {
        let simulated = estimators.contains(&Estimator::OutputError);
        let searched = estimators.iter().any(|estimator| estimator.searches());
        let asked = estimators.iter().map(|e| e.name()).collect::<Vec<_>>().join(", ");
        if self.unknown_current != UnknownCurrent::None && !simulated {
            return Err(Failure::Usage(format!(
                "--unknown-current {} is for `output-error`: found {asked}; add it to --estimator or leave the flag out",
                self.unknown_current
            )));
        }
        if self.intercepts != Intercepts::Each && !searched {
            return Err(Failure::Usage(format!(
                "--intercepts {} is for `output-error` and `prediction-error`: found {asked}; --mean-removal is for the others",
                self.intercepts
            )));
        }
        Ok(())
    }

    /// Notes values that are not the default.
    pub fn note(self, settings: &mut BTreeMap<String, Value>) {
        let (usual, AdditionalUnknowns { intercepts, current }) =
            (AdditionalUnknowns::default(), self.unknown());
        if intercepts != usual.intercepts {
            settings.insert("intercepts".into(), json!(intercepts));
        }
        if current != usual.current {
            settings.insert("unknown_current".into(), json!(current));
        }
    }
}
