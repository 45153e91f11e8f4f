//! Logs, and chains of instruments that make them.

mod actuator;
mod allocation;
mod angles;
mod assembled;
mod chain;
mod clocks;
mod declared;
mod formulas;
mod frames;
mod grid;
mod lever;
mod motion;
mod oracle;
mod oracle_chain;
mod patterns;
mod prepared;
mod quality;
mod sensors;
mod series;
mod smoother;
mod thrusters;
mod units;
mod weather;
mod wind;
