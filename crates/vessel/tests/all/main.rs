//! Maneuvers, disturbances and motion.

mod compiled;
mod constraints;
mod files;
mod layout;
mod maneuvers;
mod noise;
mod oracle;
mod structure;
mod terms;
