//! `sweep`: a study over a grid of its values.

cli::program!(cli::commands::SWEEP.main());
