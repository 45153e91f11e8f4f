//! `sequential`: trials designed in rounds.

cli::program!(cli::commands::SEQUENTIAL.main());
