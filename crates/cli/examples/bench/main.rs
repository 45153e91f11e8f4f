//! Measures the hot loops on one thread and prints one JSON object. `make bench` runs it beside its peers.

#![forbid(unsafe_code)]

mod design;
mod forces;
mod monte_carlo;
mod output_error;
mod paper;
mod planner;
mod stage;
mod table;
mod timing;

use std::path::PathBuf;

use clap::Parser;
use serde_json::json;

/// The programs' own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Measures Monte Carlo realizations, output-error estimates, design solves, table throughput and plans on one thread
#[derive(Parser)]
#[command(version, after_help = "Example:\n  bench --json")]
struct Arguments {
    /// One JSON object on stdout (the only format)
    #[arg(long)]
    json: bool,
    /// Measures nothing: writes the realizations that output error is measured on, with starts and estimates, as JSON
    #[arg(long, value_name = "FILE")]
    realizations: Option<PathBuf>,
    /// Measures the loop of the stage monte-carlo alone
    #[arg(long)]
    stage: bool,
    /// Measures fits of a ship with forces alone: of these trajectories of the Esso Osaka, else of simulated ones
    #[arg(long, value_name = "trajectories.parquet")]
    forces: Option<Option<PathBuf>>,
    /// Measures tables alone
    #[arg(long)]
    tables: bool,
    /// Measures nothing: writes the table that writing and reading are measured on
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let Arguments { json: _, realizations, stage, forces, tables, table } = Arguments::parse();
    let paper = paper::Paper::new()?;
    if let Some(file) = realizations {
        return output_error::write(&paper, &file);
    }
    if let Some(file) = table {
        return table::write(&paper, &file);
    }
    if let Some(file) = forces {
        println!("{}", json!({ "forces": forces::measure(file.as_deref())? }));
        return Ok(());
    }
    if stage {
        println!("{}", stage::measure(&paper)?);
        return Ok(());
    }
    if tables {
        println!("{}", json!({ "table": table::measure(&paper)? }));
        return Ok(());
    }
    let monte_carlo = monte_carlo::measure(&paper)?;
    let stage = stage::measure(&paper)?;
    let output_error = output_error::measure(&paper)?;
    let small = design::measure(&paper.candidates()?, 1e-10, 50)?;
    let large = design::measure(&design::generated(&paper, 10_000)?, 1e-6, 3)?;
    let table = table::measure(&paper)?;
    let forces = forces::measure(None)?;
    let planner = planner::measure()?;
    let object = json!({
        "monte_carlo": monte_carlo,
        "stage": stage,
        "output_error": output_error,
        "design_q11": small,
        "design_q10000": large,
        "table": table,
        "forces": forces,
        "planner": planner,
    });
    println!("{object}");
    Ok(())
}
