//! `moments`: what each maneuver tells about the parameters.

cli::program!(cli::commands::MOMENTS.main());
