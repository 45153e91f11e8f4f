//! The crate as its users see it.

mod engine;
mod forces;
mod model;
