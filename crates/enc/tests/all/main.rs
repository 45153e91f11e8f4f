//! Cells as they are read, whole and damaged.

mod damaged;
mod oracle;
