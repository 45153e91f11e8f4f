//! The compiled model, its steps, and their disturbances.

mod changes;
mod compiled;
mod constraints;
mod layout;
mod noise;
mod normals;
mod pace;
mod physics;
mod steps;
