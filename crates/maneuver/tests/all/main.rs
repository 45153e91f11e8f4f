//! Maneuvers and the inputs that they become.

mod derived;
mod equilibria;
mod maneuvers;
mod oracle;
