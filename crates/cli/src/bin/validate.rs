//! `validate`: how far the estimated models can be trusted.

cli::program!(cli::commands::VALIDATE.main());
