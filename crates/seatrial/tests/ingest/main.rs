//! The `ingest` stage, run as a program on files.

mod attitudes;
mod clocks;
mod derived;
mod document;
#[path = "../support/draw.rs"]
mod draw;
mod field;
mod files;
mod forces;
mod known;
mod real;
mod refusals;
mod runner;
mod segments;
mod shapes;
mod silent;
mod topics;
