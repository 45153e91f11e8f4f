//! Maneuvers and their inputs.

mod derived;
mod equilibria;
mod maneuvers;
mod oracle;
