use std::fmt;

/// The drawing library failed. Drawing into memory does not, so this stands for a defect rather than for bad input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FigureError {
    message: String,
}

impl FigureError {
    pub(crate) fn new(message: impl fmt::Display) -> Self {
        let message = message.to_string().replace('\n', " ");
        Self { message }
    }
}

impl fmt::Display for FigureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "figure: found {}, expected a drawing; report this", self.message)
    }
}

impl std::error::Error for FigureError {}
