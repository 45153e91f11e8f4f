//! `seatrial`: every stage in one program.

cli::program!(cli::umbrella::main());
