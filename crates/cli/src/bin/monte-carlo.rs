//! `monte-carlo`: a campaign's runs, estimated and scored in memory.

cli::program!(cli::commands::MONTE_CARLO.main());
