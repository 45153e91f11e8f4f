//! Designs known by theory, by enumeration and by independent computation.

mod counts;
mod covariance;
mod designs;
mod figures;
mod oracle;
mod oracle_covariance;
mod oracle_output_error;
mod restrictions;
mod rounding;
mod shortest;
mod small_cases;
mod streamed;
mod update;
