//! `ingest`: measured logs to trajectories.

cli::program!(cli::commands::INGEST.main());
