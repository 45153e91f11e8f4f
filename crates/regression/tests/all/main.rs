//! Properties of regressions, and comparisons with independent computations.

mod any_model;
mod bounded;
mod erased;
mod lanes;
mod laws;
mod names;
mod oracle;
mod pooled_laws;
mod pooled_oracle;
mod predicted_errors;
mod scalar_example;
mod standard_errors;
mod support;
