//! What the pipeline's binaries share: parse, read, call the science, write.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod campaign_file;
pub mod cli;
pub mod documents;
pub mod estimates;
pub mod failure;
pub mod instruments;
pub mod lanes;
pub mod ordered;
pub mod progress;
pub mod report;
pub mod scores;
pub mod simulate;
pub mod statistics;
pub mod study_files;
pub mod trajectories;
