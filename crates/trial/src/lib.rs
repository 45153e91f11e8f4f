//! From a vessel and its dictionary to moves on a lattice, and from a plan on the lattice back to sea.
//!
//! A [`Leg`] is a move of the lattice: a script of phases that an [`Autopilot`] carries out, with an
//! informative maneuver between a steady approach and a recovery onto the lattice. Poses are
//! north, east \[m\] and compass heading \[rad\]; the lattice counts headings counter-clockwise from east,
//! and only [`Grid`] converts.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod arranging;
pub mod campaign;
pub mod moments;
mod piece;
pub mod refining;
pub mod rounds;

pub use piece::{Piece, period};
