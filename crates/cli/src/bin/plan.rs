//! `plan`: one trajectory that uses every maneuver as often as the design wants.

cli::program!(cli::commands::PLAN.main());
