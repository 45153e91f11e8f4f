//! From logs to a model: recordings of a ship's instruments, one model of them, and its errors on a recording that
//! was left out.

use std::error::Error;
use std::path::Path;

use seatrial::{Comparison, Estimator, Logs, Pooling, Tried, Vessel};

fn main() -> Result<(), Box<dyn Error>> {
    let vessel = Vessel::from_file(include_str!("../../../fixtures/logs/vessel.toml").parse()?)?;
    let config = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/logs/ingest.toml"));
    let ingested = Logs::read(config, &vessel)?.ingested()?;
    for recording in &ingested.document.recordings {
        println!(
            "recording {}: runs {:?}, warnings {}",
            recording.name,
            recording.runs,
            recording.warnings.len()
        );
    }

    // One recording is left out for validation.
    let mut fitted = ingested.pooled()?;
    let mut left_out = fitted.clone();
    fitted.select(&[], &["b".to_owned()])?;
    left_out.select(&["b".to_owned()], &[])?;

    let set = Pooling::new(&vessel).by_least_squares().model(&fitted, Some(Estimator::OutputError))?;
    set.trust.statements.iter().for_each(|statement| println!("pool: {statement}"));
    let model = set.model.ok_or("some parameters are not determined")?;
    for parameter in model.degrees.iter().flat_map(|degree| &degree.parameters) {
        let error = parameter.standard_error.unwrap_or(f64::NAN);
        println!("{} = {:.4} ± {error:.4} {}", parameter.name, parameter.value, parameter.unit);
    }

    let model = Tried::of(model)?;
    let (compared, _) = Comparison::of(&model).over(&left_out)?;
    compared.statements.iter().for_each(|statement| println!("compare: {statement}"));
    Ok(())
}
