//! The crate as its users see it.

mod arranging;
mod campaign;
mod closed_loop;
mod golden;
mod moments;
mod parts;
mod planner;
mod rounds;
mod slowed;
mod studied;
