//! What must hold of estimates, and what independent computations found.

mod any_model;
mod collinear;
mod constraints;
mod criticism;
mod found_noise;
mod laws;
mod names;
mod oracle;
mod output_error_laws;
mod output_error_oracle;
mod output_information;
mod pooled_again;
mod pooled_around;
mod pooled_continued;
mod pooled_laws;
mod pooled_oracle;
mod predicted_errors;
mod quantiles;
mod recommendation;
mod refine_laws;
mod repeated;
mod scalar_example;
mod standard_errors;
mod support;
