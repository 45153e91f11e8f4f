//! The compiled model, its steps, and what disturbs them.

mod compiled;
mod constraints;
mod layout;
mod noise;
mod steps;
