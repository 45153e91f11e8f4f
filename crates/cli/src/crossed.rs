//! The result of a cross-validation.

use std::path::Path;

use files::{Provenance, commit, stage_document};
use serde_json::json;
use study::documents::CrossvalDocument;

use crate::failure::Failure;
use crate::stage::Summary;

/// Writes the result, and says it in short.
///
/// # Errors
/// Output that fails.
pub fn written(out: &Path, provenance: &Provenance, document: &CrossvalDocument) -> Result<Summary, Failure> {
    commit(vec![stage_document(out, provenance, document)?])?;
    let (windows, folds, said) = (document.windows, document.folds, document.statements.join("; "));
    Ok(Summary::of(
        out,
        format!("{windows} windows, {folds} folds; {said}"),
        json!({"windows": windows, "folds": folds,
            "recommended": document.recommended, "statements": document.statements}),
    ))
}
