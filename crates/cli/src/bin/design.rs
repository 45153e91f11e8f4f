//! `design`: how long to run each maneuver.

cli::program!(cli::commands::DESIGN.main());
