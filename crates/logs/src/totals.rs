use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Recorded;

/// Numbers runs and counts them.
#[derive(Clone, Debug, Default)]
pub struct Totals {
    /// Runs so far; the number of the next run.
    pub runs: u32,
    /// Samples of all runs.
    pub samples: u64,
    /// Per maneuver, in the order of appearance.
    pub maneuvers: Vec<ManeuverCount>,
}

/// How much there is of a maneuver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ManeuverCount {
    /// Its name.
    pub name: String,
    /// Number of segments.
    pub segments: u64,
    /// Their samples.
    pub samples: u64,
}

impl Totals {
    /// Counts the runs of a recording and numbers them.
    pub fn number(&mut self, recorded: &mut Recorded) {
        for run in &mut recorded.runs {
            run.number = self.runs as i32;
            recorded.summary.runs.push(u64::from(self.runs));
            self.runs += 1;
            self.samples += run.samples() as u64;
            let ends = run.segments.iter().skip(1).map(|next| next.start).chain([run.samples()]);
            for (segment, end) in run.segments.iter().zip(ends) {
                let count = self.count(&segment.maneuver);
                count.segments += 1;
                count.samples += (end - segment.start) as u64;
            }
        }
    }

    fn count(&mut self, maneuver: &str) -> &mut ManeuverCount {
        let place = self.maneuvers.iter().position(|count| count.name == maneuver).unwrap_or_else(|| {
            self.maneuvers.push(ManeuverCount { name: maneuver.to_owned(), segments: 0, samples: 0 });
            self.maneuvers.len() - 1
        });
        &mut self.maneuvers[place]
    }
}
