//! A surface vessel: what `vessel.toml` means ([`model`]), her forces in continuous time ([`forces`]), and the ship that steps,
//! with disturbances and sensors ([`engine`]).

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod engine;
pub mod forces;
pub mod model;
