//! The `ingest` stage, run as a program on files.

mod attitudes;
mod bags;
mod clocks;
mod derived;
mod document;
#[path = "../support/draw.rs"]
mod draw;
mod encodings;
mod faulty;
mod field;
mod files;
mod fixes;
mod forces;
mod gate;
mod kinds;
mod known;
mod real;
mod refusals;
mod robots;
mod runner;
mod sea_clocks;
mod segments;
mod sentence_times;
mod sentences;
mod shafts;
mod shapes;
mod shared;
mod silent;
mod silent_tables;
mod strangers;
mod table_clocks;
mod talkers;
mod topics;
mod typed;
