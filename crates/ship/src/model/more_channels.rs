//! Models with additional channels.

use refusal::Invalid;

use crate::model::derived::derive;
use crate::model::{DerivedChannel, DerivedSpec, Model, Variable};

impl Model {
    /// The model with the channels of `specs` after its own.
    ///
    /// # Errors
    /// A formula that cannot be parsed, or of channels that the model does not have.
    pub fn with_derived(&self, specs: &[DerivedSpec]) -> Result<Self, Invalid> {
        let mut model = self.clone();
        let variable = |spec: &DerivedSpec| Variable { name: spec.name.clone(), unit: spec.unit.clone() };
        model.variables.extend(specs.iter().map(variable));
        let names: Vec<&str> = model.variables.iter().map(|own| own.name.as_str()).collect();
        model.derived.extend(derive(specs, &names, self.variables.len())?);
        Ok(model)
    }

    /// The model with the channels of `other`; `None` unless `other` has all of its own first, and computes
    /// the additional ones.
    pub fn with_channels_of(&self, other: &Self) -> Option<Self> {
        let own = self.variables.len();
        let first: Vec<&DerivedChannel> = other.derived.iter().filter(|d| d.variable < own).collect();
        let computed = other.variables.len() - own.min(other.variables.len()) + first.len();
        let same = other.variables.starts_with(&self.variables)
            && other.derived.len() == computed
            && first.into_iter().eq(&self.derived);
        let (variables, derived) = (other.variables.clone(), other.derived.clone());
        same.then(|| Self { variables, derived, ..self.clone() })
    }
}
