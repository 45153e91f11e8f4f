use std::collections::BTreeMap;

use files::{Columns, Document, Units};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use validation::merit::{ManeuverMerit, MeritRow};

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
        let words = |maneuver_merit: &ManeuverMerit| {
            let figures = maneuver_merit
                .figures
                .iter()
                .map(|figure| format!("{}: {}", maneuver_merit.name, figure.words()));
            let without = maneuver_merit.lacking().zip(maneuver_merit.reason.as_ref());
            let without = without
                .map(|(lacking, reason)| format!("{}: {lacking}, such as {reason}", maneuver_merit.name));
            let unsloped = maneuver_merit.figures.iter().filter_map(|figure| {
                let why = figure.without_slopes.as_ref()?;
                Some(format!("{}: no slopes of {}: {why}", maneuver_merit.name, figure.what))
            });
            let sailed =
                maneuver_merit.sailed.iter().map(|sailed| format!("{}: {sailed}", maneuver_merit.name));
            let remarks =
                maneuver_merit.remarks.iter().map(|remark| format!("{}: {remark}", maneuver_merit.name));
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
        let all =
            || self.maneuvers.iter().flat_map(|own| own.figures.iter().map(move |figure| (own, figure)));
        let judged = all().filter(|(_, figure)| figure.most.is_some()).count();
        let met = all().filter(|(_, figure)| figure.passes == Some(true)).count();
        let missed = all().filter(|(_, figure)| figure.most.is_some() && figure.passes != Some(true));
        let missed = missed.map(|(own, figure)| format!("{}: {}", own.name, figure.words()));
        let without = self.maneuvers.iter();
        let without = without.filter_map(|own| Some(format!("{}: {}", own.name, own.lacking()?)));
        let (figures, maneuvers) = (all().count(), self.maneuvers.len());
        let judged = match judged {
            0 => "no criterion of IMO MSC.137(76) applies".to_owned(),
            _ => format!("{met} of {judged} criteria of IMO MSC.137(76) pass"),
        };
        let head = format!("{figures} figures of {maneuvers} maneuvers; {judged}");
        let remarks =
            self.maneuvers.iter().flat_map(|own| own.remarks.iter().map(move |remark| (own, remark)));
        let remarks = remarks.map(|(own, remark)| format!("{}: {remark}", own.name));
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
