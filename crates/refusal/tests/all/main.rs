//! Refusals as their users see them.

mod bounded;
mod invalid;
mod names;
mod nearest;
mod numbers;
