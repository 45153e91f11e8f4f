use files::{Document, Units};
use plan::voyage::{Gathered, RestartPoint, StepState};
use refusal::{Invalid, check_numbers};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `follow.json`: where a ship is in a plan, by her positions so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FollowDocument {
    /// The same in words.
    pub statement: String,
    /// What is left to do.
    pub status: FollowStatus,
    /// When the plan began, in UTC; absent where neither the plan nor the positions say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub departure: Option<String>,
    /// When the last position was, in UTC; absent as above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<String>,
    /// The same after the departure; after the first position where the plan has no departure and positions have times of
    /// day \[s\].
    pub at_s: f64,
    /// Number of positions.
    pub positions: u64,
    /// How many more were left out: without a fix, at 0 N 0 E, or where she cannot have come to and back from.
    #[serde(default)]
    pub left_out: u64,
    /// What is odd about them, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
    /// Number of the step that the ship is at, from 1.
    pub step: u64,
    /// Distance of the ship from where the plan has her, the delay apart \[m\].
    pub deviation_m: f64,
    /// How much later she is there than planned; negative where she is earlier \[s\].
    pub delay_s: f64,
    /// All steps of the plan.
    pub steps: Vec<FollowedStep>,
    /// How much of the information of the plan's maneuvers those have that are done.
    pub information: Gathered,
    /// Where the ship goes on.
    pub from: RestartPoint,
}

refusal::choices! {
    /// What is left to do of a plan.
    pub enum FollowStatus {
        /// Maneuvers.
        UnderWay = "under-way",
        /// The way to its end.
        ManeuversDone = "maneuvers-done",
        /// Nothing.
        Finished = "finished",
    }
}

/// A step of a plan, and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FollowedStep {
    /// Name of its action.
    pub action: String,
    /// Whether it is an informative maneuver.
    pub informative: bool,
    /// What became of it.
    pub state: StepState,
    /// The greatest distance of the ship from its track, where she came along it; absent where she did not \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviation_m: Option<f64>,
    /// Within which it counts as done \[m\].
    pub within_m: f64,
    /// Why its maneuver is spoiled; absent where it is not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
}

impl FollowDocument {
    /// What to print of it.
    pub fn summary(&self) -> String {
        let uses = |of: fn(&plan::voyage::GatheredManeuver) -> u64| -> u64 {
            self.information.maneuvers.iter().map(of).sum()
        };
        let share = self
            .information
            .share
            .map_or(String::new(), |share| format!(" with {:.0} % of the information", 100.0 * share));
        format!(
            "step {} of {}, {} of {} maneuvers done{share}",
            self.step,
            self.steps.len(),
            uses(|own| own.done),
            uses(|own| own.planned)
        )
    }
}

impl Document for FollowDocument {
    const ID: &'static str = "follow";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("s", "at_s delay_s"),
        ("m", "deviation_m within_m"),
        ("deg", "longitude_deg latitude_deg heading_deg"),
        ("m/s", "speed_m_s"),
        ("1", "positions left_out step share efficiency dimension planned done"),
    ];

    fn check(&self) -> Result<(), Invalid> {
        let most = self.steps.len() as f64;
        let expected = format!("a step from 1 to {most}");
        check_numbers([("data.step", self.step as f64)], &expected, |step| (1.0..=most).contains(&step))
    }
}
