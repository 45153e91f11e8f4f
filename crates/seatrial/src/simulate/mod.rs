//! `simulate`: trajectories of dictionaries, campaigns and validation maneuvers.

pub mod campaign;
pub mod logs;
pub(crate) mod sea;
pub mod undisturbed;

use std::path::Path;

use artifact::{Provenance, TableWriter, commit};
use vessel::{Diverged, Model, Vessel};

use crate::failure::Failure;
use study::trajectories::Layout;

/// The longest run that is simulated \[samples\].
pub(crate) const MOST_SAMPLES: usize = 1 << 22;

/// Refuses runs of more than [`MOST_SAMPLES`] samples, which `file` asks for in `thing`.
pub(crate) fn refuse_endless(file: &Path, thing: &str, samples: usize) -> Result<(), Failure> {
    if samples <= MOST_SAMPLES {
        return Ok(());
    }
    let (found, expected) = (format!("{samples} samples"), format!("at most {MOST_SAMPLES} samples"));
    Err(Failure::refuse(file, thing, &found, &expected, "shorten it"))
}

/// Inputs N × inputs with zeros appended for the measured disturbances: N × exogenous.
pub(crate) fn exogenous(model: &Model, inputs: &[f64]) -> Vec<f64> {
    let rows = inputs.chunks_exact(model.inputs);
    rows.flat_map(|row| row.iter().copied().chain(std::iter::repeat_n(0.0, model.exogenous() - model.inputs)))
        .collect()
}

/// Says where a simulation of `what` diverged.
pub(crate) fn diverged(vessel_file: &Path, what: &str, at: Diverged) -> Failure {
    let state = ["u", "v", "r"][at.state.min(2)];
    Failure::refuse(
        vessel_file,
        what,
        &format!("a simulation that diverges: {state} leaves every bound at sample {}", at.sample),
        "bounded motion",
        "make the damping terms stronger (per sample between -1 and 0 for a linear one), or the inputs or the sampling interval smaller",
    )
}

/// Opens the output table.
pub(crate) fn writer(
    out: &Path,
    vessel: &Vessel,
    provenance: &Provenance,
) -> Result<(Layout, TableWriter), Failure> {
    let layout = Layout::new(&vessel.model);
    let writer = TableWriter::create(out, &layout.schema(), provenance)?;
    Ok((layout, writer))
}

/// Finishes and publishes a table.
pub(crate) fn publish(writer: TableWriter) -> Result<(), Failure> {
    Ok(commit(vec![writer.finish()?])?)
}
