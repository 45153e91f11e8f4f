//! Models as source text of other tools.

mod equations;
mod identifiers;
mod ships;
mod template;
mod text;
