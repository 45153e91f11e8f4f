//! Validation of models on recordings that they were not fitted to: left out of an estimate ([`crossval`]), not
//! picked from many sub-experiments ([`selection`]), or given ([`comparison`]). And statistics of the scores of many
//! runs ([`tally`]), and their figures of merit ([`merit`]).

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod comparison;
pub mod crossval;
pub mod merit;
pub mod selection;
pub mod tally;
