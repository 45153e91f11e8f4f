//! Ships before their first trial: the same ship at another size, or one from her main dimensions.

pub use crate::ships::{Size, guessed, scaled};
pub use ship::forces::MainDimensions;

/// A `vessel.toml` and what to say about it.
#[derive(Clone, Debug)]
pub struct Written {
    /// The file.
    pub text: String,
    /// One line.
    pub said: String,
}
