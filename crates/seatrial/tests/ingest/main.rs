//! The `ingest` stage, run as a program on files.

mod attitudes;
mod clocks;
mod derived;
mod document;
mod faulty;
mod field;
mod files;
mod forces;
mod gate;
mod known;
mod real;
mod refusals;
mod runner;
mod segments;
mod shapes;
mod topics;
