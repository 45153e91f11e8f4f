//! Models from sub-experiments that a design picked against random picks.

use std::path::{Path, PathBuf};

use files::{Error, Loaded};
use study::documents::{SelectionDocument, SimulatedLogsDocument};

use super::{Table, documents, label, left_out, median, reference, seed_of, share};
use crate::loader::document_at;
use crate::number::{or_dash, three};

pub(super) fn section(folders: &[PathBuf], written: Option<&Path>) -> Result<Option<String>, Error> {
    let (found, missing) = documents::<SelectionDocument>(folders, "selection.json")?;
    let mut rows = Vec::new();
    let mut notes: Vec<String> = Vec::new();
    for (folder, Loaded { data: selection, .. }) in &found {
        let (name, seed) = (label(folder), seed(folder)?);
        rows.extend(selection.designs.iter().map(|scores| (study(&name).to_owned(), seed, scores)));
        let published = reference(written, &name)?.and_then(|r| r.selection);
        let statements = published.map_or(Vec::new(), |published| published.statements);
        let statements =
            statements.into_iter().map(|said| format!("- Published of {}: {said}", study(&name)));
        let new: Vec<String> = statements.filter(|said| !notes.contains(said)).collect();
        notes.extend(new);
    }
    let plain = |value: Option<f64>| value.map_or("∞".to_owned(), three);
    let table = Table::of(rows)
        .column("study", |(name, ..)| name.clone())
        .column("seed of the logs", |(_, seed, _)| or_dash(*seed))
        .column("picks", |(.., d)| d.design.clone())
        .column("realizations", |(.., d)| d.realizations.to_string())
        .column("median", |(.., d)| median(&d.overlapping.rmse_norm))
        .column("90 %", |(.., d)| plain(d.overlapping.rmse_norm.q90))
        .column("worst", |(.., d)| plain(d.overlapping.rmse_norm.max))
        .column("degenerate", |(.., d)| share(d.degenerate_share, d.degenerate_share_interval));
    let notes = if notes.is_empty() { String::new() } else { format!("\n{}\n", notes.join("\n")) };
    let note = left_out(&missing, "not computed");
    let about = "Norm of the RMSE of surge, sway and yaw rate (m/s, m/s, rad/s as numbers) over all sub-experiments, of models from as many \
        sub-experiments each: picked by the design's counts, or at random. ∞: its simulation diverges.";
    Ok(table.text().map(|table| format!("## Selected sub-experiments\n\n{about}\n\n{table}{notes}{note}")))
}

/// The study's name without the seed.
fn study(label: &str) -> &str {
    label.split(' ').next().unwrap_or(label)
}

/// The seed of simulated logs, which are next to the results from them.
fn seed(folder: &Path) -> Result<Option<u64>, Error> {
    let path = folder.parent().unwrap_or(folder).join("logs/simulated.json");
    Ok(document_at::<SimulatedLogsDocument>(path)?.and_then(|logs| seed_of(&logs.provenance)))
}
