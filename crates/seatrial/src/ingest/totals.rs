//! All recordings together.

use std::path::Path;

use study::documents::{ManeuverCount, RecordingSummary};

use super::segments::RunPart;

/// Counts over all recordings.
#[derive(Clone, Debug, Default)]
pub struct Totals {
    /// Runs so far; the number of the next run.
    pub runs: u32,
    /// Samples of all runs.
    pub samples: u64,
    /// Per maneuver, in the order of appearance.
    pub maneuvers: Vec<ManeuverCount>,
    /// What the recordings' data are like.
    pub recordings: Vec<RecordingSummary>,
}

impl Totals {
    /// Counts the next run of a recording and gives it its number.
    pub fn number(&mut self, run: &RunPart, summary: &mut RecordingSummary) -> u32 {
        let number = self.runs;
        self.runs += 1;
        self.samples += run.samples as u64;
        summary.runs.push(u64::from(number));
        let ends = run.segments.iter().skip(1).map(|(_, start)| *start).chain([run.samples]);
        for ((maneuver, start), end) in run.segments.iter().zip(ends) {
            let count = self.count(maneuver);
            count.segments += 1;
            count.samples += (end - start) as u64;
        }
        number
    }

    fn count(&mut self, maneuver: &str) -> &mut ManeuverCount {
        let place = self.maneuvers.iter().position(|count| count.name == maneuver).unwrap_or_else(|| {
            self.maneuvers.push(ManeuverCount { name: maneuver.to_owned(), segments: 0, samples: 0 });
            self.maneuvers.len() - 1
        });
        &mut self.maneuvers[place]
    }

    /// The sum of a count over all recordings.
    pub fn sum(&self, count: impl Fn(&RecordingSummary) -> u64) -> u64 {
        self.recordings.iter().map(count).sum()
    }

    /// Rows that were left out.
    pub fn dropped_rows(&self) -> u64 {
        self.sum(|r| r.rows.empty + r.rows.cut + r.rows.without_time + r.rows.repeated)
    }
}

/// The summary for people.
pub fn line(out: &Path, totals: &Totals) -> String {
    let warnings = totals.sum(|r| r.warnings.iter().map(|w| w.count).sum());
    let warned = if warnings > 0 { format!("; {warnings} warnings, see ingest.json") } else { String::new() };
    format!(
        "{}: {} runs, {} samples, {} maneuvers from {} recordings; {} rows dropped, {} gaps that split a recording, \
         {} segments too short{warned}",
        out.display(),
        totals.runs,
        totals.samples,
        totals.maneuvers.len(),
        totals.recordings.len(),
        totals.dropped_rows(),
        totals.sum(|r| r.splits),
        totals.sum(|r| r.short_segments),
    )
}
