//! The crate as its users see it.

mod campaign;
mod closed_loop;
mod daylight;
mod golden;
mod grid;
mod handling;
mod legs;
mod moments;
mod pieces;
mod plan_goldens;
mod plan_laws;
mod plan_refusals;
mod planned;
mod reacting;
mod rounds;
mod studied;
mod tide;
