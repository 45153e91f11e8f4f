//! `report`: a study on one page.

cli::program!(cli::commands::REPORT.main());
