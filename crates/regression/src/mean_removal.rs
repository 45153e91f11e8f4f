use refusal::Invalid;
use ship::model::{DegreeOfFreedom, Model};

refusal::choices! {
    /// How the instruments' mean is removed: how many intercepts a degree of freedom has, none, one per segment or
    /// one.
    pub enum MeanRemoval {
        /// Not at all.
        None = "none",
        /// Segment by segment.
        Batch = "batch",
        /// Over the whole experiment.
        Complete = "complete",
    }
}

impl MeanRemoval {
    /// Refuses an intercept per segment if `model` has a term 1: the constant cannot be distinguished from them.
    ///
    /// # Errors
    /// Names the parameter.
    pub fn check(self, model: &Model) -> Result<(), Invalid> {
        let constant = DegreeOfFreedom::ALL.into_iter().find_map(|d| {
            let degree = &model.degrees[d as usize];
            degree.constant().map(|i| (d, &degree.parameters[i]))
        });
        match constant.filter(|_| self == Self::Batch) {
            None => Ok(()),
            Some((d, name)) => Err(Invalid::new(
                format!("parameter `{name}`"),
                format!("the term `1` in {} beside an intercept for every segment", d.name()),
                "one intercept: instruments without their mean over each segment see no constant",
                "take --mean-removal complete or none, or remove the term",
            )),
        }
    }
}
