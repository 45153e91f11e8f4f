//! Maneuvers and their inputs.

mod derived;
mod equilibria;
mod feedback;
mod logged;
mod maneuvers;
mod oracle;
mod reference_ships;
mod signals;
mod stamps;
mod standard;
