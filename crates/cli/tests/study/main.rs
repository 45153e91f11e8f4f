//! A small study through the real binaries: outputs, refusals and repeatability of the stages.

#[path = "../support/mod.rs"]
mod support;

mod budgets;
mod changed;
mod command_line;
mod covariances;
mod criteria;
mod documents;
mod estimates;
mod estimators;
mod export;
mod few;
mod figures;
mod first_trial;
mod generated;
mod golden;
mod in_memory;
mod interactive;
mod lines;
mod logged_merit;
mod makefile;
mod mixed;
mod monte_carlo;
mod names;
mod oracle;
mod paper;
mod physics;
mod pipeline;
mod promises;
mod propeller;
mod rates;
mod refine;
mod refusals_files;
mod refusals_output;
mod refusals_toml;
mod same_bytes;
mod sequential;
mod ships;
mod tables;
mod trials;
mod unexcited;
mod units;
