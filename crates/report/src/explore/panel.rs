use maud::Markup;
use serde_json::Value;

use super::assets::Library;

/// A section with its data, which the script draws.
pub(super) struct Panel {
    pub(super) id: String,
    pub(super) title: String,
    pub(super) about: Markup,
    pub(super) data: Value,
    pub(super) library: Library,
}
