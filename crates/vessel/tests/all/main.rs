//! Maneuvers, disturbances and motion.

mod compiled;
mod files;
mod layout;
mod maneuvers;
mod noise;
mod oracle;
mod terms;
