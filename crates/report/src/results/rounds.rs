//! Trials designed in rounds against trials designed once.

use std::path::PathBuf;

use artifact::{Error, read_document};
use study::documents::SequentialDocument;
use trial::rounds::{ArmPoint, Stopping};

use super::folder::{documents, label, left_out, seed_of};
use super::table::{Table, quantile, share, whole};
use crate::number::{exact, three, three_or_dash};

/// The document of trials in rounds.
const FILE: &str = "sequential.json";

pub(super) fn section(folders: &[PathBuf]) -> Result<Option<String>, Error> {
    let (found, missing) = documents::<SequentialDocument>(folders, FILE)?;
    let mut text = String::new();
    for (folder, document) in &found {
        let seed = seed_of(&read_document::<SequentialDocument>(folder.join(FILE))?.provenance);
        text += &format!(
            "\n{}: {} maneuvers, {} realizations, seed {}.\n\n{}{}",
            label(folder),
            document.maneuvers,
            document.realizations,
            whole(seed),
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
    let names = document.arms.iter().map(|arm| arm.name.name());
    let heads: Vec<&str> = ["after"].into_iter().chain(names).chain(["rounds / once", "pairs"]).collect();
    let mut table = Table::new(&heads);
    for (i, gain) in document.gains.iter().enumerate() {
        let cell = |point: Option<&ArmPoint>| {
            point.map_or("–".to_owned(), |point| quantile(point.median, point.median_interval))
        };
        let arms = document.arms.iter().map(|arm| cell(arm.points.get(i)));
        let within =
            gain.low.zip(gain.high).map(|(low, high)| format!(" ({} to {})", three(low), three(high)));
        let ratio = format!("{}{}", three_or_dash(gain.ratio), within.unwrap_or(" (–)".to_owned()));
        let cells = [format!("{} s", exact(gain.time_s))]
            .into_iter()
            .chain(arms)
            .chain([ratio, gain.pairs.to_string()]);
        table.row(&cells.collect::<Vec<_>>());
    }
    table.text()
}

/// A row per arm that may stop.
fn stopping(document: &SequentialDocument) -> Option<String> {
    let within = format!("within {}, of those promised", exact(document.accuracy));
    let heads =
        ["", "promised in time", "mean time", &within, "of all", "error over promise, root mean square"];
    let mut table = Table::new(&heads);
    for arm in &document.stopping {
        table.row(&[
            arm.arm.name().to_owned(),
            format!("{} of {}", arm.stopped, document.realizations),
            mean_time(arm),
            arm.within_stopped.map_or("–".to_owned(), |value| share(value, arm.within_stopped_interval)),
            share(arm.within, arm.within_interval),
            quantile(arm.rms_over_accuracy, arm.rms_over_accuracy_interval.map(|ends| ends.map(Some))),
        ]);
    }
    table.text()
}

fn mean_time(arm: &Stopping) -> String {
    let within = arm.mean_time_interval_s.map(|[low, high]| format!("{low:.0} to {high:.0}"));
    format!("{:.0} s ({})", arm.mean_time_s, within.as_deref().unwrap_or("–"))
}
