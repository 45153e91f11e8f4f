use super::SequentialFile;
use super::stopping::{gain, stopping};
use super::table::{Outcome, Row, Shared};
use super::trial::Arm;
use numerics::statistics::{quantile, sorted};
use study::documents::{ArmPoint, ArmSummary, RoundGain, SequentialDocument, Stopping};

/// `rows` in words and figures. `ends`: samples by the end of every round.
pub(super) fn document(
    config: &SequentialFile,
    rows: &[Row],
    ends: &[usize],
    maneuvers: usize,
    rate_hz: f64,
) -> SequentialDocument {
    let accuracy = config.accuracy;
    let arms: Vec<ArmSummary> =
        Arm::ALL.into_iter().map(|arm| summary(rows, arm, ends, accuracy, rate_hz)).collect();
    let gains: Vec<RoundGain> =
        ends.iter().enumerate().map(|(round, end)| gain(rows, round, *end, rate_hz)).collect();
    let stopping = vec![
        stopping(rows, Arm::Sequential, |row| row.predicted_error, accuracy, rate_hz),
        stopping(rows, Arm::OneShot, |row| row.expected_error, accuracy, rate_hz),
    ];
    SequentialDocument {
        realizations: u64::from(config.realizations),
        rounds: u64::from(config.rounds),
        duration_s: config.duration_s,
        crude_about: config.crude_about.name().to_owned(),
        nominal_spread: config.nominal_spread,
        accuracy,
        maneuvers: maneuvers as u64,
        statements: statements(&arms, &gains, &stopping, accuracy, config.realizations),
        arms,
        gains,
        stopping,
    }
}

fn summary(rows: &[Row], arm: Arm, ends: &[usize], accuracy: f64, rate_hz: f64) -> ArmSummary {
    let point = |(round, end): (usize, &usize)| {
        let own: Vec<&Row> =
            rows.iter().filter(|row| row.arm == arm && row.round as usize == round).collect();
        let errors = sorted(own.iter().map(|row| row.parameter_error));
        let count = |wanted: &dyn Fn(&Row) -> bool| own.iter().filter(|row| wanted(row)).count() as u64;
        let within = count(&|row| row.parameter_error.is_some_and(|error| error <= accuracy));
        ArmPoint {
            time_s: *end as f64 / rate_hz,
            median: quantile(&errors, 0.5),
            q90: quantile(&errors, 0.9),
            predicted: quantile(&sorted(own.iter().map(|row| row.predicted_error)), 0.5),
            within: within as f64 / own.len().max(1) as f64,
            not_identifiable: count(&|row| row.outcome == Outcome::NotIdentifiable),
            not_converged: count(&|row| row.outcome == Outcome::NotConverged),
            diverged: count(&|row| row.outcome == Outcome::Diverged),
            undesigned: count(&|row| row.shared == Shared::Even),
        }
    };
    ArmSummary { name: arm.name().to_owned(), points: ends.iter().enumerate().map(point).collect() }
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
        .map(|arm| stopping.iter().find(|s| s.arm == arm.name()).map(|s| ended(s, realizations)));
    if let (Some(rounds), Some(one_shot)) = (rounds, one_shot) {
        out.push(format!(
            "to an error of {accuracy}, trials in rounds that their own estimates stop {rounds}; one-shot trials that the crude \
             model sizes beforehand {one_shot}"
        ));
    }
    out
}

/// What rounds gain at equal time, in words; the first round is the one-shot trial.
fn gained(gains: &[RoundGain]) -> Option<String> {
    let told = |gain: &RoundGain| {
        let RoundGain { time_s, ratio, low, high, .. } = *gain;
        Some(format!("{:.2} after {time_s:.0} s ({:.2} to {:.2})", ratio?, low?, high?))
    };
    let each: Vec<String> = gains.iter().skip(1).filter_map(told).collect();
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

/// How long trials of an arm take and whether what they are promised is kept, in words.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gain_is_told_only_where_its_interval_excludes_none() {
        let gain = |time_s: f64, ratio: f64, half: f64| RoundGain {
            time_s,
            pairs: 40,
            ratio: Some(ratio),
            low: Some(ratio - half),
            high: Some(ratio + half),
        };
        let first = gain(10.0, 1.0, 0.0);
        let said = |last: RoundGain| gained(&[first, last]).unwrap();
        assert!(said(gain(20.0, 0.75, 0.125)).ends_with("makes it 25 % smaller"));
        assert!(said(gain(20.0, 1.25, 0.125)).ends_with("makes it 25 % larger"));
        assert!(said(gain(20.0, 0.75, 0.5)).contains("0.75 after 20 s (0.25 to 1.25)"));
        assert!(
            said(gain(20.0, 0.75, 0.5)).ends_with("40 realizations do not tell this from no gain at all")
        );
        assert_eq!(gained(&[first]), None);
    }
}
