//! Maneuvers, disturbances and motion.

mod maneuvers;
mod noise;
mod oracle;
