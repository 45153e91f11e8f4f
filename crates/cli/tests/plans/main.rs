//! `plan`, and the use of its files, through the real binaries. The expected values are computed independently:
//! replays of plans, the vessel's motion, its information, the chart.

#[path = "../../../chart/tests/all/enc/made.rs"]
mod made;
#[path = "../support/mod.rs"]
mod support;
#[path = "../../../chart/tests/all/xml.rs"]
mod xml;

mod area;
mod budget;
mod cells;
mod chart_means;
mod chart_refusals;
mod choices;
mod exchange_sets;
mod file_refusals;
mod fleet;
mod follow;
mod forces;
mod geometry;
mod globe;
mod grid_files;
mod handling;
mod helsinki;
mod in_memory;
mod information;
mod lattice_problems;
mod map;
mod place_refusals;
mod planned;
mod programs;
mod resume;
mod routes;
mod safety;
mod same_bytes;
mod sea;
mod shared;
mod slot;
mod speed_limit;
mod tables;
mod tide;
mod time_limits;
mod traffic;
mod units;
mod waters;
