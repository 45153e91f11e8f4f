//! `export`: a model for other tools.

cli::program!(cli::commands::EXPORT.main());
