//! `new` and `run`: a study from nothing to its page, and what is refused on the way.

#[path = "../support/mod.rs"]
mod support;

mod anywhere;
mod logs;
mod observed;
#[allow(dead_code)]
#[path = "../plans/planned.rs"]
mod planned;
mod presets;
mod refusals;
mod ships;
mod studies;
