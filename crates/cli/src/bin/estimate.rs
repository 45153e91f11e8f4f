//! `estimate`: parameters of every run.

cli::program!(cli::commands::ESTIMATE.main());
