//! Maneuvers, disturbances and motion.

mod actuators;
mod compiled;
mod constraints;
mod derived;
mod equilibria;
mod files;
mod formulas;
mod layout;
mod maneuvers;
mod noise;
mod oracle;
mod steps;
mod terms;
