use refusal::Invalid;
use thiserror::Error;

/// Why nothing can be left out.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CrossError {
    /// There is only one run or recording, or all are left out.
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
    /// A run or recording is in two folds.
    #[error("`{0}` stands in two folds")]
    Twice(String),
}

impl CrossError {
    /// What is invalid.
    pub fn invalid(&self) -> Invalid {
        let (expected, remedy) =
            ("at least two, so that one can be left out", "add runs, or leave out fewer");
        match self {
            Self::OneSource => Invalid::new("runs or recordings", "one", expected, remedy),
            Self::NoWindow => {
                Invalid::new("windows", "no run as long as a window", "at least one", "shorten --window-s")
            }
            Self::Unknown { name, nearest } => Invalid::new(
                format!("run or recording `{name}`"),
                "no such run or recording",
                "one of those that are read",
                format!("did you mean `{nearest}`?"),
            ),
            Self::Twice(name) => Invalid::new(
                format!("run or recording `{name}`"),
                "in two folds",
                "each left out once",
                "name it in one --fold",
            ),
        }
    }
}
