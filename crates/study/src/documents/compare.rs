//! Models on recordings or maneuvers that they were not fitted to: `compare.parquet`, `merit.json`, and scores in `estimate.json`.

use std::collections::BTreeMap;

use estimation::pooled::Pool;
use estimation::{Estimator, PairedDifference, Recommendation};
use files::{Columns, Document, Units};
use regression::MeanRemoval;
use regression::pooled::NominalSource;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::DegreeOfFreedom;
use validation::comparison::Traced;
use validation::crossval::{CrossValidation, EstimatorScore};
use validation::merit::{ManeuverMerit, MeritRow};

/// The table of the model over time: one row per sample of a window.
pub fn traces() -> Columns<Traced> {
    let columns = Columns::<Traced>::new("compare", 1)
        .text("source", |r| &r.source, |r, source| r.source = source.to_owned())
        .integer("window", "1", |r| r.window, |r, window| r.window = window)
        .number("t", "s", |r| r.t, |r, t| r.t = t);
    let state = |columns: Columns<Traced>, degree: DegreeOfFreedom| {
        let (d, state, unit) = (degree as usize, degree.state(), degree.unit());
        columns
            .number(format!("y_{state}"), unit, move |r| r.measured[d], move |r, y| r.measured[d] = y)
            .number(state, unit, move |r| r.simulated[d], move |r, x| r.simulated[d] = x)
            .optional(format!("half_{state}"), unit, move |r| r.half[d], move |r, half| r.half[d] = half)
    };
    DegreeOfFreedom::ALL.into_iter().fold(columns, state)
}

/// Free simulation over runs or recordings that were left out of the estimate.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeftOutScores {
    /// How the instruments' mean is removed.
    pub mean_removal: MeanRemoval,
    /// Where the instruments' nominal model comes from.
    pub nominal: NominalSource,
    /// Strength of the pull towards it; of forces the weight of their priors.
    pub prior: f64,
    /// Whether forces were fitted, which have no instruments.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub forces: bool,
    /// Whether the estimated intercepts were simulated too.
    pub intercepts: bool,
    /// Length of the windows \[s\]; null: whole runs.
    pub window_s: Option<f64>,
    /// Number of windows that were simulated.
    pub windows: u64,
    /// Their samples.
    pub samples: u64,
    /// Number of folds.
    pub folds: u64,
    /// Standard deviations of the measured states over the windows.
    pub std_u: f64,
    /// Of sway speed.
    pub std_v: f64,
    /// Of yaw rate.
    pub std_r: f64,
    /// The estimator with the least median norm of RMSE/std over the recordings; null where they cannot tell it from another,
    /// or none could be simulated over all.
    pub recommended: Option<Estimator>,
    /// That of least median norm, and those that the recordings cannot tell from it.
    pub candidates: Vec<Estimator>,
    /// The other estimators against that of least median norm, recording by recording.
    pub differences: Vec<PairedDifference>,
    /// That, and what went wrong, in words.
    pub statements: Vec<String>,
    /// One entry per estimator.
    pub estimators: Vec<EstimatorScore>,
}

impl LeftOutScores {
    /// The result with instruments from `nominal` over windows of `window_s` seconds.
    pub fn new(pool: &Pool, nominal: NominalSource, window_s: Option<f64>, found: &CrossValidation) -> Self {
        let Pool { removal, strength, .. } = *pool;
        Self { mean_removal: removal, nominal, prior: strength, ..Self::of(window_s, found) }
    }

    /// The result of a ship with forces, fitted with priors of `prior_weight`.
    pub fn of_forces(prior_weight: f64, window_s: Option<f64>, found: &CrossValidation) -> Self {
        Self { forces: true, intercepts: false, prior: prior_weight, ..Self::of(window_s, found) }
    }

    fn of(window_s: Option<f64>, found: &CrossValidation) -> Self {
        let [std_u, std_v, std_r] = found.std;
        Self {
            mean_removal: MeanRemoval::None,
            nominal: NominalSource::Given,
            prior: 0.0,
            forces: false,
            intercepts: true,
            window_s,
            windows: found.windows,
            samples: found.samples,
            folds: found.folds as u64,
            std_u,
            std_v,
            std_r,
            recommended: found.recommendation.as_ref().and_then(Recommendation::estimator),
            candidates: found.recommendation.as_ref().map_or(Vec::new(), Recommendation::candidates),
            differences: found.recommendation.iter().flat_map(|r| &r.others).map(Into::into).collect(),
            statements: found.statements.clone(),
            estimators: found.scores.clone(),
        }
    }

    /// How far an estimator's errors lie above the least.
    pub fn difference(&self, estimator: Estimator) -> Option<&PairedDifference> {
        self.differences.iter().find(|other| other.estimator == estimator)
    }
}

/// Most statements that are told in a line.
const FEW: usize = 8;

/// `merit.json`: figures of merit of standard maneuvers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeritDocument {
    /// Name of the vessel.
    pub vessel: String,
    /// Its length between perpendiculars.
    pub length_m: f64,
    /// Of what the intervals are: `runs`, or the `parameters` of a model.
    pub intervals: String,
    /// Every figure in words.
    pub statements: Vec<String>,
    /// The maneuvers, in the order of the dictionary.
    pub maneuvers: Vec<ManeuverMerit>,
    /// Where the figures' slopes were computed; absent without `--slopes`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slopes_at: Option<SlopesAt>,
}

/// Where the slopes of figures were computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SlopesAt {
    /// The parameters of the model, in units of the state's increment per unit of the term.
    pub parameters: BTreeMap<String, f64>,
    /// Step of the central differences, as a part of the parameter.
    pub step: f64,
}

impl MeritDocument {
    /// Of the figures of `vessel`, whose runs are draws of its parameters or recorded.
    pub fn new(vessel: &str, length_m: f64, of_parameters: bool, maneuvers: Vec<ManeuverMerit>) -> Self {
        let words = |merit: &ManeuverMerit| {
            let figures = merit.figures.iter().map(|figure| format!("{}: {}", merit.name, figure.words()));
            let without = merit.lacking().zip(merit.reason.as_ref());
            let without =
                without.map(|(lacking, reason)| format!("{}: {lacking}, such as {reason}", merit.name));
            let unsloped = merit.figures.iter().filter_map(|figure| {
                let why = figure.without_slopes.as_ref()?;
                Some(format!("{}: no slopes of {}: {why}", merit.name, figure.what))
            });
            let sailed = merit.sailed.iter().map(|sailed| format!("{}: {sailed}", merit.name));
            let remarks = merit.remarks.iter().map(|remark| format!("{}: {remark}", merit.name));
            sailed.chain(remarks).chain(figures).chain(without).chain(unsloped).collect::<Vec<_>>()
        };
        Self {
            vessel: vessel.to_owned(),
            length_m,
            intervals: if of_parameters { "parameters" } else { "runs" }.to_owned(),
            statements: maneuvers.iter().flat_map(words).collect(),
            maneuvers,
            slopes_at: None,
        }
    }

    /// In a line: every statement where there are few; else how many figures there are, how many of IMO's criteria are
    /// met, and those that are not.
    pub fn in_short(&self) -> String {
        if self.statements.len() <= FEW {
            return self.statements.join("; ");
        }
        let all = || self.maneuvers.iter().flat_map(|m| m.figures.iter().map(move |figure| (m, figure)));
        let judged = all().filter(|(_, figure)| figure.most.is_some()).count();
        let met = all().filter(|(_, figure)| figure.passes == Some(true)).count();
        let missed = all().filter(|(_, figure)| figure.most.is_some() && figure.passes != Some(true));
        let missed = missed.map(|(maneuver, figure)| format!("{}: {}", maneuver.name, figure.words()));
        let without = self.maneuvers.iter();
        let without = without.filter_map(|m| Some(format!("{}: {}", m.name, m.lacking()?)));
        let (figures, maneuvers) = (all().count(), self.maneuvers.len());
        let judged = match judged {
            0 => "no criterion of IMO MSC.137(76) applies".to_owned(),
            _ => format!("{met} of {judged} criteria of IMO MSC.137(76) pass"),
        };
        let head = format!("{figures} figures of {maneuvers} maneuvers; {judged}");
        let remarks = self.maneuvers.iter().flat_map(|m| m.remarks.iter().map(move |remark| (m, remark)));
        let remarks = remarks.map(|(maneuver, remark)| format!("{}: {remark}", maneuver.name));
        std::iter::once(head).chain(missed).chain(without).chain(remarks).collect::<Vec<_>>().join("; ")
    }

    /// With the parameters that its figures' slopes were computed at.
    #[must_use]
    pub fn with_slopes_at(self, slopes_at: Option<SlopesAt>) -> Self {
        Self { slopes_at, ..self }
    }
}

impl Document for MeritDocument {
    const ID: &'static str = "merit";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("1", "runs without diverged step"),
        ("m", "length_m"),
        ("s", "t_s"),
        ("deg", "heading_deg"),
        ("m/s", "surge_m_s"),
        ("deg/s", "yaw_rate_deg_s"),
        ("ship lengths", "ahead abeam"),
        ("the unit beside it", "value corrected std low high most"),
        ("the unit beside it per unit of the parameter", "slopes"),
    ];
}

/// The table of every figure of every run.
pub fn merit_rows() -> Columns<MeritTableRow> {
    Columns::<MeritTableRow>::new("merit-rows", 1)
        .text("design", |r| &r.design, |r, design| r.design = design.to_owned())
        .integer("run", "1", |r| r.run, |r, run| r.run = run)
        .text("maneuver", |r| &r.maneuver, |r, maneuver| r.maneuver = maneuver.to_owned())
        .text("figure", |r| &r.figure, |r, figure| r.figure = figure.to_owned())
        .text("unit", |r| &r.unit, |r, unit| r.unit = unit.to_owned())
        .number("value", "the unit beside it", |r| r.value, |r, value| r.value = value)
        .optional("most", "the unit beside it", |r| r.most, |r, most| r.most = most)
}

/// A row of [`merit_rows`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeritTableRow {
    design: String,
    run: i32,
    maneuver: String,
    figure: String,
    unit: String,
    value: f64,
    most: Option<f64>,
}

impl From<&MeritRow> for MeritTableRow {
    fn from(merit_row: &MeritRow) -> Self {
        Self {
            design: merit_row.design.clone(),
            run: merit_row.run,
            maneuver: merit_row.maneuver.clone(),
            figure: merit_row.figure.name.to_owned(),
            unit: merit_row.figure.unit.clone(),
            value: merit_row.figure.value,
            most: merit_row.figure.most,
        }
    }
}
