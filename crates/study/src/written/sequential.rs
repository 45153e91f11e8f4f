//! Trials in rounds: `[rounds]` of `campaign.toml`, their table and summary.

use std::collections::BTreeMap;

use files::{Columns, Error, TableReader};
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::{Source, Vessel};
use trial::rounds::{Arm, ArmSummary, Knowledge, Outcome, RoundGain, Row, Shared, Stopping, Summary};

use crate::documents::TrialsInRounds;
use crate::tables::scores;

/// Reads the whole table.
///
/// # Errors
/// Missing columns, damaged blocks.
pub fn rows(reader: &TableReader, rate_hz: f64) -> Result<Vec<Row>, Error> {
    let blank = Row {
        arm: Arm::Sequential,
        realization: 0,
        round: 0,
        samples: 0,
        shared: Shared::Designed,
        outcome: Outcome::Identified,
        parameter_error: None,
        predicted_error: None,
        expected_error: None,
    };
    columns(rate_hz).read(reader, &blank)
}

/// The table of an arm of a realization at the end of a round, one per row, of runs at `rate_hz`.
pub fn columns(rate_hz: f64) -> Columns<Row> {
    scores::of::<Row>()
        .choice("arm", |r| r.arm, |r, arm: Arm| r.arm = arm)
        .integer("run", "1", |r| r.realization as i32, |r, number| r.realization = number as u32)
        .integer("round", "1", |r| r.round as i32, |r, round| r.round = round as u32)
        .number(
            "time",
            "s",
            move |r| r.samples as f64 / rate_hz,
            move |r, time| r.samples = (time * rate_hz).round() as usize,
        )
        .choice("shares", |r| r.shared, |r, shared: Shared| r.shared = shared)
        .choice("status", |r| r.outcome, |r, outcome: Outcome| r.outcome = outcome)
        .optional("parameter_error", "1", |r| r.parameter_error, |r, error| r.parameter_error = error)
        .optional("predicted_error", "1", |r| r.predicted_error, |r, error| r.predicted_error = error)
        .optional("expected_error", "1", |r| r.expected_error, |r, error| r.expected_error = error)
}

/// The summary in words and figures; `maneuvers`: their number in the dictionary.
pub fn document(config: &RoundsSpec, summary: Summary, maneuvers: usize) -> TrialsInRounds {
    let Summary { arms, gains, stopping } = summary;
    TrialsInRounds {
        realizations: u64::from(config.realizations),
        rounds: u64::from(config.rounds),
        duration_s: config.duration_s,
        crude_about: config.crude_about,
        nominal_spread: config.nominal_spread,
        accuracy: config.accuracy,
        maneuvers: maneuvers as u64,
        statements: statements(&arms, &gains, &stopping, config.accuracy, config.realizations),
        arms,
        gains,
        stopping,
    }
}

fn statements(
    arms: &[ArmSummary],
    gains: &[RoundGain],
    stopping: &[Stopping],
    accuracy: f64,
    realizations: u32,
) -> Vec<String> {
    let last = |arm: Arm| arms[arm as usize].points.last().and_then(|point| point.median);
    let whole = gains.last().map_or(0.0, |gain| gain.time_s);
    let mut out = Vec::new();
    if let [Some(sequential), Some(one_shot), Some(informed), Some(random)] = Arm::ALL.map(last) {
        out.push(format!(
            "median parameter error after {whole:.0} s: designed in rounds {sequential:.2}, once from the crude model \
             {one_shot:.2}, once from the truth {informed:.2}, at random {random:.2}"
        ));
    }
    out.extend(gained(gains));
    let [rounds, one_shot] = [Arm::Sequential, Arm::OneShot]
        .map(|arm| stopping.iter().find(|s| s.arm == arm).map(|s| ended(s, realizations)));
    if let (Some(rounds), Some(one_shot)) = (rounds, one_shot) {
        out.push(format!(
            "to an error of {accuracy}, trials in rounds that their own estimates stop {rounds}; one-shot trials that the crude \
             model sizes beforehand {one_shot}"
        ));
    }
    out
}

/// The gain of rounds at equal time, in words; the first round is the one-shot trial.
fn gained(gains: &[RoundGain]) -> Option<String> {
    let sentence = |gain: &RoundGain| {
        let RoundGain { time_s, ratio, low, high, .. } = *gain;
        Some(format!("{:.2} after {time_s:.0} s ({:.2} to {:.2})", ratio?, low?, high?))
    };
    let each: Vec<String> = gains.iter().skip(1).filter_map(sentence).collect();
    let last = gains.last().filter(|_| !each.is_empty())?;
    let verdict = match (last.ratio?, last.low?, last.high?) {
        (ratio, _, high) if high < 1.0 => {
            format!("at the end designing in rounds makes it {:.0} % smaller", 100.0 * (1.0 - ratio))
        }
        (ratio, low, _) if low > 1.0 => {
            format!("at the end designing in rounds makes it {:.0} % larger", 100.0 * (ratio - 1.0))
        }
        _ => format!("at the end {} realizations do not tell this from no gain at all", last.pairs),
    };
    let each = each.join(", ");
    Some(format!(
        "at equal time the error in rounds over the one-shot error is {each}, with 95 % intervals: {verdict}"
    ))
}

/// The duration of trials of an arm and whether predictions hold, in words.
fn ended(found: &Stopping, realizations: u32) -> String {
    let Stopping { stopped, mean_time_s, within, .. } = *found;
    let kept = found
        .rms_over_accuracy
        .map_or(String::new(), |rms| format!(" (root mean square error then {rms:.2} times the promise)"));
    format!(
        "take {mean_time_s:.0} s on average, {stopped} of {realizations} are promised it in time{kept} and {:.0} % of all end \
         within it",
        100.0 * within
    )
}

/// Trials that are designed in rounds, from a crude model, beside trials that are designed once.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoundsSpec {
    /// Realizations of every arm.
    #[schemars(range(min = 1, max = 1_000_000_000))]
    pub realizations: u32,
    /// Total sea time \[s\].
    #[schemars(range(min = 1e-12, max = 1e9))]
    pub duration_s: f64,
    /// Number of rounds of equal length.
    #[schemars(range(min = 1, max = 1_000_000_000))]
    pub rounds: u32,
    /// Spread of the crude model before the trial: its parameters are the central ones times e^(this times a standard
    /// normal number), drawn for every realization.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub nominal_spread: f64,
    /// The central parameters of crude models; nominal parameters that are zero stay zero and need a floor.
    #[serde(default)]
    pub crude_about: Source,
    /// The trial may stop when the predicted error falls to this: 2-norm over the parameters of standard error over
    /// parameter.
    #[schemars(range(min = 1e-12, max = 1e9))]
    pub accuracy: f64,
    /// Smallest moduli of parameters by name, in their units: errors of a smaller parameter are relative to this, and
    /// the crude model's uncertainty is at least this.
    #[serde(default)]
    #[schemars(extend("additionalProperties" = {"type": "number", "minimum": 1e-12, "maximum": 1e9}))]
    pub floor: BTreeMap<String, f64>,
}

impl RoundsSpec {
    /// The knowledge of the parameters before a trial; `seed`: of the crude models.
    ///
    /// # Errors
    /// See [`RoundsSpec::floors`]; a vessel without the central parameters of crude models.
    pub fn knowledge(&self, vessel: &Vessel, seed: u64) -> Result<Knowledge, Invalid> {
        let about = vessel.parameters(self.crude_about)?;
        let floor = self.floors(vessel, &about)?;
        Ok(Knowledge { about, spread: self.nominal_spread, floor, seed })
    }

    /// The floor of every parameter of `vessel`, 0 if not stated.
    fn floors(&self, vessel: &Vessel, about: &[f64]) -> Result<Vec<f64>, Invalid> {
        let names = || vessel.model.parameter_names();
        if let Some(unknown) = self.floor.keys().find(|key| names().all(|name| name != key.as_str())) {
            return Err(Invalid::unknown("`rounds.floor`", unknown, names()));
        }
        let floors: Vec<f64> = names().map(|name| self.floor.get(name).copied().unwrap_or(0.0)).collect();
        let zero =
            names().zip(about).zip(&floors).find(|((_, about), floor)| **about == 0.0 && **floor == 0.0);
        match zero {
            None => Ok(floors),
            Some(((name, _), _)) => Err(Invalid::new(
                format!("`rounds.floor.{name}`"),
                format!("none, and `{}` of `{name}` is zero", self.crude_about.name()),
                "the smallest modulus that counts, since errors are relative",
                "state it, or take `crude_about = \"value\"`",
            )),
        }
    }
}
