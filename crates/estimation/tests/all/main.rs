//! Properties of estimates, and comparisons with independent computations.

mod collinear;
mod constraints;
mod criticism;
mod cross_validation;
mod entangled;
mod fitting;
mod found_noise;
mod free_runs;
mod names;
mod output_error_laws;
mod output_error_oracle;
mod output_information;
mod pooled_again;
mod pooled_ambient;
mod pooled_continued;
mod pooled_laws;
mod quantiles;
mod recommendation;
mod refine_laws;
mod repeated;
mod restricted_likelihood;
mod search;
#[path = "../../../regression/tests/all/support/mod.rs"]
mod support;
