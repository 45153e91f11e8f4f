//! Plans, why there are none, and problems that are refused.

mod brute_force;
mod collision;
mod exported;
mod files;
mod random;
mod reasons;
mod refusals;
mod synthetic;
