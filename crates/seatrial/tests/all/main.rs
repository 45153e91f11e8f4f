//! Models as source text of other tools.

mod export;
