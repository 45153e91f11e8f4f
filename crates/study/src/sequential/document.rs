use trial::rounds::{Arm, ArmSummary, RoundGain, Stopping, Summary};

use super::SequentialFile;
use crate::documents::SequentialDocument;

/// The summary in words and figures; `maneuvers`: their number in the dictionary.
pub fn document(config: &SequentialFile, summary: Summary, maneuvers: usize) -> SequentialDocument {
    let Summary { arms, gains, stopping } = summary;
    SequentialDocument {
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
