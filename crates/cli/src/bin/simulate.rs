//! `simulate`: trajectories from a vessel and its maneuvers.

cli::program!(cli::commands::SIMULATE.main());
