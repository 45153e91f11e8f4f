//! What a model's document tells those that the model is exported to.

use export::Knowledge;

use super::model::ModelDocument;

impl ModelDocument {
    /// Standard errors, what the data covered, what to know before using the model.
    pub fn knowledge(&self) -> Knowledge {
        let parameters = self.degrees.iter().flat_map(|degree| &degree.parameters);
        Knowledge {
            standard_errors: parameters
                .filter_map(|own| Some((own.name.clone(), own.standard_error?)))
                .collect(),
            covered: self.covered.iter().map(|own| (own.name.clone(), [own.low, own.high])).collect(),
            notes: self.statements.clone(),
        }
    }
}
