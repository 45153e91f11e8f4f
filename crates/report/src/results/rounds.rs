//! Trials designed in rounds against trials designed once.

use std::path::PathBuf;

use files::{Error, Loaded};
use study::documents::{SequentialDocument, Stopping};

use super::{Table, documents, label, left_out, quantile, seed_of, share};
use crate::number::{exact, or_dash, three, three_or_dash};

pub(super) fn section(folders: &[PathBuf]) -> Result<Option<String>, Error> {
    let (found, missing) = documents::<SequentialDocument>(folders, "sequential.json")?;
    let mut text = String::new();
    for (folder, Loaded { data: document, provenance, .. }) in &found {
        text += &format!(
            "\n{}: {} maneuvers, {} realizations, seed {}.\n\n{}{}",
            label(folder),
            document.maneuvers,
            document.realizations,
            or_dash(seed_of(provenance)),
            errors(document).unwrap_or_default(),
            stopping(document).map_or(String::new(), |table| format!("\n{table}"))
        );
    }
    let note = left_out(&missing, "not computed");
    let about = "Median parameter error after equal time at sea, and the error in rounds over that of the trial designed once, pair by pair \
        (geometric mean). Then trials that stop when they promise the accuracy.";
    Ok((!found.is_empty()).then(|| format!("## Rounds\n\n{about}\n{text}{note}")))
}

/// A row per time, a column per arm.
fn errors(document: &SequentialDocument) -> Option<String> {
    let times = Table::of(document.gains.iter().enumerate())
        .column("after", |(_, gain)| format!("{} s", exact(gain.time_s)));
    let arms = document.arms.iter().fold(times, |table, arm| {
        table.column(arm.name.name(), |(i, _)| {
            or_dash(arm.points.get(*i).map(|point| quantile(point.median, point.median_interval)))
        })
    });
    let table = arms
        .column("rounds / once", |(_, gain)| {
            let ends =
                gain.low.zip(gain.high).map(|(low, high)| format!(" ({} to {})", three(low), three(high)));
            three_or_dash(gain.ratio) + &ends.unwrap_or(" (–)".to_owned())
        })
        .column("pairs", |(_, gain)| gain.pairs.to_string());
    table.text()
}

/// A row per arm that may stop.
fn stopping(document: &SequentialDocument) -> Option<String> {
    let within = format!("within {}, of those promised", exact(document.accuracy));
    let table = Table::of(&document.stopping)
        .column("", |arm| arm.arm.name().to_owned())
        .column("promised in time", |arm| format!("{} of {}", arm.stopped, document.realizations))
        .column("mean time", |arm| mean_time(arm))
        .column(&within, |arm| {
            or_dash(arm.within_stopped.map(|value| share(value, arm.within_stopped_interval)))
        })
        .column("of all", |arm| share(arm.within, arm.within_interval))
        .column("error over promise, root mean square", |arm| {
            quantile(arm.rms_over_accuracy, arm.rms_over_accuracy_interval.map(|ends| ends.map(Some)))
        });
    table.text()
}

fn mean_time(arm: &Stopping) -> String {
    let within = arm.mean_time_interval_s.map(|[low, high]| format!("{low:.0} to {high:.0}"));
    format!("{:.0} s ({})", arm.mean_time_s, within.as_deref().unwrap_or("–"))
}
