//! Models on recordings that they were not fitted to: left out of an estimate ([`crossval`]), left over where few sub-experiments
//! were picked ([`selection`]), or any that are given ([`comparison`]). And what the scores of many runs say together
//! ([`tally`]).

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod comparison;
pub mod crossval;
pub mod selection;
pub mod tally;
