//! Models as source text of other tools.

mod equations;
mod identifiers;
mod template;
mod text;
