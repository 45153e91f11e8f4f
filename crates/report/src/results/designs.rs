//! Shares of good models and median errors, by study and design.

use std::path::{Path, PathBuf};

use files::{Error, Loaded};
use study::documents::{Bounds, PublishedShare, ValidationDocument};

use super::folder::{documents, label, left_out, length_s, reference, seed};
use super::table::{Table, median, share};
use crate::number::{exact, or_dash, published};

pub(super) fn section(folders: &[PathBuf], written: Option<&Path>) -> Result<Option<String>, Error> {
    let (found, missing) = documents::<ValidationDocument>(folders, "validation.json")?;
    let (mut rows, mut bounds, mut used) = (Vec::new(), Vec::new(), String::new());
    for (folder, Loaded { data: validation, .. }) in &found {
        let (name, seed) = (label(folder), seed(folder)?);
        let of = (name.clone(), length_s(written, &name)?);
        let reference = reference(written, &name)?;
        let Bounds { parameter_error, simulation_error } = validation.bounds;
        bounds.push(format!("{name} {} and {}", exact(parameter_error), exact(simulation_error)));
        if let Some(own) = reference.as_ref().and_then(|r| r.used.as_ref()) {
            used += &format!("\nOf the published numbers of {name}: {own}\n");
        }
        let published = |design: &str| reference.as_ref()?.designs.get(design).copied();
        rows.extend(validation.designs.iter().map(|d| (of.clone(), seed, d, published(&d.design))));
    }
    let table = Table::of(rows)
        .column("study", |((name, _), ..)| name.clone())
        .column("length, s", |((_, length_s), ..)| or_dash(length_s.map(exact)))
        .column("design", |(_, _, d, _)| d.design.clone())
        .column("trials", |(_, _, d, _)| d.runs.to_string())
        .column("seed", |(_, seed, ..)| or_dash(*seed))
        .column("parameter error below the bound", |(_, _, d, published)| {
            share(d.parameter_error_share, d.parameter_error_share_interval)
                + &published_share(published.map(|p| p.parameter_error_share))
        })
        .column("simulation error below the bound", |(_, _, d, published)| {
            share(d.simulation_error_share, d.simulation_error_share_interval)
                + &published_share(published.map(|p| p.simulation_error_share))
        })
        .column("median parameter error", |(_, _, d, _)| median(&d.parameter_error))
        .column("median simulation error", |(_, _, d, _)| median(&d.simulation_error));
    let note = left_out(&missing, "not computed");
    if found.iter().any(|(_, v)| v.data.designs.iter().any(|d| d.design == "practice")) {
        used = format!("\n{PRACTICE}\n{used}");
    }
    Ok(table.text().map(|table| {
        let bounds = bounds.join(", ");
        format!("## Designs\n\n{table}\nBounds on parameter and simulation error: {bounds}.\n{used}{note}")
    }))
}

/// What the design of that name is.
const PRACTICE: &str = "Practice is today's practice: the maneuvers of the dictionary, one after another, for the same \
     seconds and by the same estimator. Dashes stand where they tell no model, since some parameter is not excited.";

/// The published share.
fn published_share(share: Option<PublishedShare>) -> String {
    match share {
        Some(PublishedShare::Value(value)) => format!("; published {}", published(value)),
        Some(PublishedShare::Above { above }) => format!("; published > {}", published(above)),
        None => String::new(),
    }
}
