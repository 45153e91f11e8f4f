//! The `ingest` stage, run as a program on files.

mod derived;
mod document;
mod files;
mod real;
mod refusals;
mod runner;
mod segments;
mod topics;
