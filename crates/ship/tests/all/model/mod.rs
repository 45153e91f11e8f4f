//! Files, terms, constraints and channels of a vessel.

mod actuators;
mod files;
mod formulas;
mod terms;
