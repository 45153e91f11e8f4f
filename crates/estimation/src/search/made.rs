use refusal::Invalid;
use ship::model::{DerivedSpec, Formula, Model};

/// Channels that are derived from those of a model.
pub(crate) struct Made<'a> {
    pub model: &'a Model,
    specs: Vec<DerivedSpec>,
}

impl<'a> Made<'a> {
    /// No derived channels yet.
    pub fn new(model: &'a Model) -> Self {
        Self { model, specs: Vec::new() }
    }

    /// The model with the derived channels.
    ///
    /// # Errors
    /// A channel that cannot be computed.
    pub fn finish(self) -> Result<Model, Invalid> {
        self.model.with_derived(&self.specs)
    }

    /// The index of the channel that is computed by `formula`: the model's own, or a new one with this name.
    pub fn channel(&mut self, mut name: String, unit: String, formula: String) -> usize {
        let own = Formula::parse(&formula).ok();
        if let Some(known) = self.model.derived.iter().find(|known| Some(&known.formula) == own.as_ref()) {
            return known.variable;
        }
        while self.model.variables.iter().any(|taken| taken.name == name) {
            name.push_str("_more");
        }
        self.specs.push(DerivedSpec { name, unit, formula });
        self.model.variables.len() + self.specs.len() - 1
    }

    /// Whether the model computes `formula` up to a factor.
    pub fn computes(&self, formula: &str) -> bool {
        let own = Formula::parse(formula);
        own.is_ok_and(|own| self.model.derived.iter().any(|known| known.formula.is_multiple_of(&own)))
    }
}
