//! Shares of good models and median errors, by study and design.

use std::path::{Path, PathBuf};

use artifact::Error;
use study::documents::{DesignScores, Published, PublishedShare, ValidationDocument};

use super::folder::{documents, label, left_out, reference, seed};
use super::table::{Table, quantile, share, whole};
use crate::number::{exact, published};

const HEADS: [&str; 8] = [
    "study",
    "design",
    "trials",
    "seed",
    "parameter error below the bound",
    "simulation error below the bound",
    "median parameter error",
    "median simulation error",
];

pub(super) fn section(folders: &[PathBuf], written: Option<&Path>) -> Result<Option<String>, Error> {
    let (found, missing) = documents::<ValidationDocument>(folders, "validation.json")?;
    let mut table = Table::new(&HEADS);
    let mut bounds = Vec::new();
    for (folder, validation) in &found {
        let (name, seed, validation) = (label(folder), seed(folder)?, &validation.data);
        let reference = reference(written, &name)?;
        for d in &validation.designs {
            let published = reference.as_ref().and_then(|r| r.designs.get(&d.design));
            table.row(&row(&name, seed, d, published));
        }
        let (parameter, simulation) = (validation.bounds.parameter_error, validation.bounds.simulation_error);
        bounds.push(format!("{name} {} and {}", exact(parameter), exact(simulation)));
    }
    let note = left_out(&missing, "not computed");
    Ok(table.text().map(|table| {
        let bounds = bounds.join(", ");
        format!("## Designs\n\n{table}\nBounds on parameter and simulation error: {bounds}.\n{note}")
    }))
}

fn row(
    name: &str,
    seed: Option<u64>,
    d: &DesignScores,
    published: Option<&Published>,
) -> [String; HEADS.len()] {
    let told = |share: Option<PublishedShare>| {
        share.map_or(String::new(), |share| format!("; published {}", told(share)))
    };
    [
        name.to_owned(),
        d.design.clone(),
        d.runs.to_string(),
        whole(seed),
        share(d.parameter_error_share, d.parameter_error_share_interval)
            + &told(published.map(|p| p.parameter_error_share)),
        share(d.simulation_error_share, d.simulation_error_share_interval)
            + &told(published.map(|p| p.simulation_error_share)),
        quantile(d.parameter_error.median, d.parameter_error.median_interval),
        quantile(d.simulation_error.median, d.simulation_error.median_interval),
    ]
}

fn told(share: PublishedShare) -> String {
    match share {
        PublishedShare::Value(value) => published(value),
        PublishedShare::Above { above } => format!("> {}", published(above)),
    }
}
