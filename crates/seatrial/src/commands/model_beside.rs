//! The `model.json` that stages which estimate write beside their estimates.

use std::path::{Path, PathBuf};

use artifact::read_document;
use study::documents::EstimateDocument;

use crate::cli::beside;
use crate::failure::Failure;

/// Where the model of the estimates `out`, usually called `usual`, goes. It may be none of `inputs`: a model that is estimated from another would take
/// its place.
///
/// # Errors
/// Usage, naming the input that would be overwritten.
pub fn model_beside<'a>(
    out: &Path,
    usual: &str,
    inputs: impl IntoIterator<Item = &'a PathBuf>,
) -> Result<PathBuf, Failure> {
    let model = beside(out, usual, "model.json");
    let Ok(existing) = model.canonicalize() else { return Ok(model) };
    match inputs.into_iter().find(|input| input.canonicalize().is_ok_and(|path| path == existing)) {
        None => Ok(model),
        Some(input) => Err(Failure::Usage(format!(
            "--out: found that the estimate's model would replace {}, which is also an input, expected another place; name \
             another output",
            input.display()
        ))),
    }
}

/// Whether `model` was written with the estimates that `document` sums up: it is not that of new ones.
pub fn is_of(document: &Path, model: &Path) -> bool {
    let Some(name) = model.file_name().and_then(|name| name.to_str()) else { return false };
    read_document::<EstimateDocument>(document).is_ok_and(|old| old.members.contains_key(name))
}
