//! Cells as they are read, whole and damaged.

mod amplified;
mod damaged;
mod exchange;
mod made;
mod oracle;
