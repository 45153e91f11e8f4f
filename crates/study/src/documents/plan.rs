use std::collections::BTreeMap;

use chart::{Measured, UnitFrom};
use files::{Document, Units};
use plan::voyage::{
    Check, FrontPoint, Gathered, GatheredManeuver, Information, Passage, Primary, Primitive, RestartPoint,
    Secondary, StepState, VoyageLeg,
};
use plan::{DerivedHandling, Handling, Side};
use refusal::{Invalid, check_numbers};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// `plan.json`: a walk over the lattice that uses every maneuver as often as asked, and what becomes of it at sea.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanDocument {
    /// Whether the plan is proved to be the best.
    pub status: PlanStatus,
    /// The status in words.
    pub statement: String,
    /// What the cost counts.
    pub cost_unit: CostUnit,
    /// Cost of the plan.
    pub cost: f64,
    /// No plan costs less.
    pub lower_bound: f64,
    /// By how much another plan might cost less; 0 where the status is `optimal`.
    pub gap: f64,
    /// What breaks ties, and its value; minimal among the cheapest plans where the status is `optimal`.
    pub secondary: Option<SecondaryCost>,
    /// Uses of every informative maneuver.
    pub counts: BTreeMap<String, u64>,
    /// The plan.
    pub steps: Vec<PlanStep>,
    /// The plan at sea; absent for a problem file.
    pub voyage: Option<Voyage>,
    /// What became of the objects of electronic charts, and what depths are measured in.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub charts: Vec<PlanChart>,
    /// Where its maneuvers leave what the logs of the model cover, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beyond: Vec<String>,
    /// Of the rest of a plan that was begun, by positions: what is done of it. With nothing left to plan there are no steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub begun: Option<BegunPlan>,
}

impl PlanDocument {
    /// The rest of the plan that is `begun`, where none of its maneuvers are left.
    pub fn done(begun: BegunPlan) -> Self {
        Self {
            status: PlanStatus::Optimal,
            statement: begun.statement.clone(),
            cost_unit: CostUnit::Cost,
            cost: 0.0,
            lower_bound: 0.0,
            gap: 0.0,
            secondary: None,
            counts: BTreeMap::new(),
            steps: Vec::new(),
            voyage: None,
            charts: Vec::new(),
            beyond: Vec::new(),
            begun: Some(begun),
        }
    }

    /// Its status; of a feasible plan with its gap.
    pub fn known(&self) -> String {
        match self.status {
            PlanStatus::Optimal => self.status.name().to_owned(),
            PlanStatus::Feasible => format!("feasible (at most {} dearer than the best)", self.gap),
        }
    }

    /// What to print of it, and its figures by name.
    pub fn summary(&self) -> (String, Value) {
        let Self { status, cost, cost_unit, lower_bound, gap, .. } = self;
        let steps = self.steps.len();
        let mut said = format!("{}, {cost} {}, {steps} steps", self.known(), cost_unit.name());
        let mut details =
            json!({"status": status, "cost": cost, "lower_bound": lower_bound, "gap": gap, "steps": steps});
        let Some(voyage) = &self.voyage else { return (said, details) };
        let Voyage { duration_s, check, .. } = voyage;
        let more = if check.clearance_m >= check.sight_m { "more than " } else { "" };
        said += &format!(", {duration_s} s at sea, {more}{:.0} m clear", check.clearance_m);
        if check.left_area > 0 {
            said += &format!(", {} of {} runs outside of the area", check.left_area, check.runs);
        }
        for (file, depths) in
            self.charts.iter().filter_map(|chart| Some((&chart.file, chart.depths.as_ref()?)))
        {
            said += &format!("; {file}: {}", depths.words());
        }
        if let Some(aborts) = voyage.aborts() {
            said += &format!("; {aborts}");
        }
        if !check.safe {
            said += &format!("; UNSAFE: {}", check.faults.join(", "));
        }
        let further = json!({"duration_s": duration_s, "clearance_m": check.clearance_m, "safe": check.safe,
            "faults": check.faults, "aground": check.aground, "runs": check.runs, "left_area": check.left_area,
            "rounds": check.rounds, "aborts": voyage.legs.iter().filter(|leg| leg.abort.is_some()).count()});
        if let (Value::Object(all), Value::Object(further)) = (&mut details, further) {
            all.extend(further);
        }
        (said, details)
    }

    /// Messages about its charts, one line each.
    pub fn messages(&self) -> impl Iterator<Item = String> {
        let uncharted = self.voyage.as_ref().and_then(Voyage::uncharted);
        self.charts.iter().map(PlanChart::message).chain(uncharted).chain(self.beyond.iter().cloned())
    }
}

/// A chart with objects or depths that the plan was made on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanChart {
    /// Name of its file.
    pub file: String,
    /// Edition of a cell.
    pub edition: Option<String>,
    /// Its last update.
    pub update: Option<u64>,
    /// When that was issued, as YYYYMMDD.
    pub issued: Option<String>,
    /// Its compilation scale: 1 to this.
    pub scale: Option<u64>,
    /// What its depths are measured from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sounding_datum: Option<String>,
    /// What its heights and clearances are measured from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertical_datum: Option<String>,
    /// What is to be said of its files: updates that are not there or not applied, checksums.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// What became of its objects, by class.
    pub classes: BTreeMap<String, PlanChartClass>,
    /// What its depths are measured in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depths: Option<PlanDepths>,
}

/// What became of the objects of one class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanChartClass {
    /// Objects of the class on the whole chart.
    pub objects: u64,
    /// Of which the ship keeps clear, or which it judges by their depth.
    pub avoided: u64,
    /// Of which only informative maneuvers keep clear.
    pub maneuvers_avoid: u64,
    /// Of which without effect.
    pub ignored: u64,
    /// Why they are, with their numbers.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub reasons: BTreeMap<String, u64>,
}

/// Objects of one class that are left out, for one reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeftOut<'a> {
    /// The class.
    pub class: &'a str,
    /// How many.
    pub objects: u64,
    /// The reason or the purpose.
    pub why: &'a str,
}

impl PlanChart {
    /// A chart in `file` that has depths and no objects.
    pub(crate) fn measured(file: String, measured: &chart::Measured) -> Self {
        Self { file, depths: Some(PlanDepths::of(measured)), ..Self::default() }
    }

    /// The name of the chart, with the kind of its depths.
    pub fn named(&self) -> String {
        let Self { file, edition, update, scale, .. } = self;
        let below = |datum: &String| format!(", depths below {datum}");
        let datum = self.sounding_datum.as_ref().map_or(String::new(), below);
        match (edition, update, scale) {
            (Some(edition), Some(update), Some(scale)) => {
                format!("{file} (edition {edition}, update {update}, 1 : {scale}){datum}")
            }
            _ => file.clone(),
        }
    }

    /// Objects without effect, or for maneuvers only, by class and reason.
    pub fn left_out(&self) -> impl Iterator<Item = LeftOut<'_>> {
        self.classes.iter().flat_map(|(class, counts)| {
            let maneuvers = (counts.maneuvers_avoid, "only maneuvers avoid it");
            let reasons = counts.reasons.iter().map(|(why, count)| (*count, why.as_str()));
            let all = reasons.chain([maneuvers]).filter(|(count, _)| *count > 0);
            all.map(move |(objects, why)| LeftOut { class, objects, why })
        })
    }

    /// A message with the chart's name, its depths, the classes without or with less effect, their numbers and
    /// reasons, and notes on its files.
    pub fn message(&self) -> String {
        let depths = self.depths.as_ref().map(PlanDepths::words);
        if let Some(depths) = depths.as_ref().filter(|_| self.classes.is_empty()) {
            return format!("{}: {depths}", self.file);
        }
        let mut by_reason: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for LeftOut { class, objects, why } in self.left_out() {
            by_reason.entry(why).or_default().push(format!("{objects} {class}"));
        }
        let maneuvers = by_reason.remove("only maneuvers avoid it");
        let listed = |names: Option<Vec<String>>| names.map_or("none".to_owned(), |names| names.join(", "));
        let reasons = by_reason.into_iter().map(|(why, files)| format!("{} ({why})", files.join(", ")));
        let reasons: Vec<String> = reasons.collect();
        let ignored = if reasons.is_empty() { "none".to_owned() } else { reasons.join(", ") };
        let notes: String = depths.iter().chain(&self.notes).map(|note| format!("; {note}")).collect();
        format!("{}: ignored {ignored}; only maneuvers avoid {}{notes}", self.named(), listed(maneuvers))
    }
}

refusal::choices! {
    /// What is known of a plan.
    pub enum PlanStatus {
        /// No plan is cheaper: proved.
        Optimal = "optimal",
        /// The plan is valid; the lower bound says how much cheaper another one might be.
        Feasible = "feasible",
    }
}

refusal::choices! {
    /// What the cost of a plan counts.
    pub enum CostUnit {
        /// Basic moves.
        BasicMoves = "basic-moves",
        /// Seconds.
        Seconds = "seconds",
        /// Whatever a problem file counts.
        Cost = "cost",
    }
}

impl From<Primary> for CostUnit {
    fn from(primary: Primary) -> Self {
        match primary {
            Primary::BasicMoves => Self::BasicMoves,
            Primary::Seconds => Self::Seconds,
        }
    }
}

/// What breaks ties between plans of the same cost.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SecondaryCost {
    /// What it counts.
    pub name: Secondary,
    /// Its value.
    pub value: f64,
}

/// One move.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanStep {
    /// Name of the action.
    pub action: String,
    /// Index among the action's moves from this heading (and speed mode).
    pub variant: u64,
    /// Where it begins.
    pub from: PlanPose,
    /// Where it ends.
    pub to: PlanPose,
    /// What it costs.
    pub cost: f64,
}

/// A pose of the lattice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanPose {
    /// Column, eastward.
    pub i: u64,
    /// Row, northward.
    pub j: u64,
    /// Heading level, counter-clockwise from east.
    pub h: u64,
    /// Speed mode, where there are any.
    pub mode: Option<String>,
}

/// A plan at sea.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Voyage {
    /// The lattice.
    pub lattice: PlanLattice,
    /// One per step.
    pub legs: Vec<VoyageLeg>,
    /// How the maneuvers became moves, one per heading and side.
    pub primitives: Vec<Primitive>,
    /// Moves that are not offered to the search, since not all who rehearsed them end settled.
    pub dropped: Vec<DroppedMove>,
    /// How the vessel is handled, and what it can do.
    pub handling: PlanHandling,
    /// Time from start to end \[s\].
    pub duration_s: f64,
    /// Of which in informative maneuvers \[s\].
    pub informative_s: f64,
    /// The simulated plan against the chart.
    pub check: Check,
    /// The part of the area that no chart shows, from 0 to 1.
    pub uncharted_share: f64,
    /// Whether that counts as water; else it is an obstacle.
    pub uncharted_is_water: bool,
    /// The same from waypoint to waypoint.
    pub passage: Passage,
    /// Information of what is sailed against what the counts promise.
    pub information: Information,
    /// Fewer uses for less time: the counts that no others beat, cheapest first. Empty where the search was not exhaustive.
    pub front: Vec<FrontPoint>,
}

impl Voyage {
    /// Which legs have an abort track, and from which she drifts aground with her engine stopped, in words; `None` of a plan from
    /// before these were told.
    pub fn aborts(&self) -> Option<String> {
        let lasts_s = self.legs.iter().find_map(|leg| Some(leg.drift.as_ref()?.lasts_s))?;
        let named = |is: &dyn Fn(&VoyageLeg) -> bool| {
            let legs = self.legs.iter().zip(1..).filter(|(leg, _)| is(leg));
            legs.map(|(leg, step): (_, usize)| format!("{step} {}", leg.name)).collect::<Vec<_>>()
        };
        let (without, all) = (named(&|leg| leg.abort.is_none()), self.legs.len());
        let none =
            if without.is_empty() { String::new() } else { format!(" (none for {})", without.join(", ")) };
        let adrift = named(&|leg| leg.drift.as_ref().is_some_and(|drift| drift.aground > 0));
        let drift = match adrift.is_empty() {
            true => format!("clear for {lasts_s:.0} s"),
            false => format!("aground within {lasts_s:.0} s from {} of them", adrift.len()),
        };
        Some(format!("abort track for {} of {all} legs{none}; engine stopped: {drift}", all - without.len()))
    }

    /// A message about uncharted positions; `None` if there are none.
    pub fn uncharted(&self) -> Option<String> {
        let percent = 100.0 * self.uncharted_share;
        let part = if percent < 0.05 { "less than 0.1".to_owned() } else { format!("{percent:.1}") };
        let counts = if self.uncharted_is_water { "which counts as water" } else { "which is kept out of" };
        (percent > 0.0).then(|| format!("{part} % of the area is on no chart, {counts}"))
    }
}

/// The lattice of a voyage.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanLattice {
    /// Nodes eastward.
    pub nx: u64,
    /// Nodes northward.
    pub ny: u64,
    /// Heading levels.
    pub headings: u64,
    /// Distance of neighbouring nodes \[m\].
    pub cell_m: f64,
    /// Longitude of node (0, 0).
    pub longitude_deg: f64,
    /// Latitude of node (0, 0).
    pub latitude_deg: f64,
    /// Speeds of the modes \[m/s\].
    pub modes: BTreeMap<String, f64>,
}

/// How the vessel is handled between maneuvers.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanHandling {
    /// As planned: what `plan.toml` states, else what follows from the vessel.
    pub used: Handling,
    /// What follows from the vessel.
    pub derived: DerivedHandling,
}

/// A move that is not offered to the search.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DroppedMove {
    /// Action.
    pub name: String,
    /// Which way, for a maneuver.
    pub side: Option<Side>,
    /// Heading level that it would begin from.
    pub h: u64,
    /// Speed mode that it would begin from.
    pub mode: String,
    /// Of which tolerance how much is used at the end of the best that was tried.
    pub why: String,
}

/// Where a ship was in the plan before, by her positions so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BegunPlan {
    /// What is known, in words.
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
    /// Where the ship continues.
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

impl BegunPlan {
    /// What to print of it.
    pub fn summary(&self) -> String {
        let uses =
            |of: fn(&GatheredManeuver) -> u64| -> u64 { self.information.maneuvers.iter().map(of).sum() };
        let share = self
            .information
            .share
            .map_or(String::new(), |share| format!(" with {:.0} % of the information", 100.0 * share));
        format!(
            "step {} of {}, {} of {} maneuvers done{share}",
            self.step,
            self.steps.len(),
            uses(|step| step.done),
            uses(|step| step.planned)
        )
    }
}

impl Document for PlanDocument {
    const ID: &'static str = "plan";
    const VERSION: u32 = 2;
    const UNITS: Units = &[
        ("1 or s, as cost_unit says", "cost lower_bound gap"),
        ("1 or s", "value"),
        (
            "1",
            "counts variant vessels drifted i j h to_h di dj fits nx ny headings runs aground aground_open_loop seed",
        ),
        ("1", "below_margin left_area aground_interval parameter_error searched step standard_errors"),
        ("%", "parameters_percent"),
        ("1", "aground_bound ends ends_astray tolerance_used rounds uncharted_share"),
        ("1", "predicted_log_det realised_log_det whole_log_det efficiency design_efficiency dimension"),
        ("1", "log_det"),
        ("m", "cell_m residual_m end_error_m spread_m clearance_m clearance_quantiles_m"),
        ("m", "margin_m shortfall_m sight_m lookahead_m"),
        ("1", "objects avoided maneuvers_avoid ignored reasons update scale invalid"),
        ("as unit says", "offset"),
        ("deg", "longitude_deg latitude_deg heading_deg residual_deg towards_deg"),
        ("m/s", "modes speed_m_s unknown_current_m_s crawl_m_s current_m_s"),
        ("m/s^2", "acceleration_m_s2 braking_m_s2 coasting_m_s2"),
        ("rad/s", "turn_rate_rad_s"),
        ("rad/s^2", "turn_acceleration_rad_s2"),
        (
            "s",
            "proved_s sailed_s sailed_quantiles_s start_s duration_s informative_s maneuver_start_s maneuver_s leg_s \
             response_s lag_s",
        ),
        ("as declared in vessel.toml", "largest_inputs numbers"),
        ("s", "at_s delay_s"),
        ("m", "deviation_m within_m"),
        ("1", "positions left_out share planned done"),
    ];

    fn check(&self) -> Result<(), Invalid> {
        let Some(BegunPlan { step, steps, .. }) = &self.begun else { return Ok(()) };
        let most = steps.len() as f64;
        let expected = format!("a step from 1 to {most}");
        check_numbers([("data.begun.step", *step as f64)], &expected, |step| (1.0..=most).contains(&step))
    }
}

/// What the depths, or heights, of a chart are measured in, and from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanDepths {
    /// Their unit, as in `plan.toml`: m, dm, cm, mm, km, ft, us-ft or fathom.
    pub unit: String,
    /// Where that comes from.
    pub unit_from: PlanUnitFrom,
    /// The file's numbers were multiplied by this.
    pub scale: f64,
    /// This was added then, in the unit.
    pub offset: f64,
    /// The vertical datum; absent where the file does not state one.
    pub datum: Option<String>,
    /// Cells outside of a range that the file calls valid: none, since no format that is read has one.
    pub invalid: u64,
}

refusal::choices! {
    /// Where the unit of a chart comes from.
    pub enum PlanUnitFrom {
        /// The file states it.
        File = "file",
        /// `depth_unit` in plan.toml states it.
        PlanToml = "plan.toml",
        /// Nobody states it.
        Assumed = "assumed",
    }
}

impl PlanDepths {
    /// In words: `ft (file), datum not stated`.
    pub fn words(&self) -> String {
        let from = match self.unit_from {
            PlanUnitFrom::File => "as the file says",
            PlanUnitFrom::PlanToml => "as plan.toml says",
            PlanUnitFrom::Assumed => "assumed, for neither the file nor plan.toml says",
        };
        let mut words = format!("depths in {} ({from})", self.unit);
        if self.scale != 1.0 || self.offset != 0.0 {
            words += &format!(" after scale {} and offset {}", self.scale, self.offset);
        }
        words += &format!(", datum {}", self.datum.as_deref().unwrap_or("not stated"));
        if self.invalid > 0 {
            words += &format!(", {} cells outside of the valid range without data", self.invalid);
        }
        words
    }
}

impl PlanDepths {
    /// From a chart that was read.
    pub(crate) fn of(measured: &Measured) -> Self {
        let unit_from = match measured.unit_from {
            UnitFrom::File => PlanUnitFrom::File,
            UnitFrom::Declared => PlanUnitFrom::PlanToml,
            UnitFrom::Assumed => PlanUnitFrom::Assumed,
        };
        Self {
            unit: measured.unit.name().to_owned(),
            unit_from,
            scale: measured.scale,
            offset: measured.offset,
            datum: measured.datum.clone(),
            invalid: 0,
        }
    }
}
