use thiserror::Error;

/// Why nothing can be left out.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CrossError {
    /// There is one run or recording only, or all are left out.
    #[error("no run or recording that could be left out, or none that would be left")]
    OneSource,
    /// No run is as long as a window.
    #[error("no run is as long as a window")]
    NoWindow,
    /// No run or recording has the name that a fold names.
    #[error("no run or recording `{name}`; the nearest is `{nearest}`")]
    Unknown {
        /// The name.
        name: String,
        /// The nearest known name.
        nearest: String,
    },
    /// A run or recording stands in two folds.
    #[error("`{0}` stands in two folds")]
    Twice(String),
}
