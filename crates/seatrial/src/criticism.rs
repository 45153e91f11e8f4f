//! What is wrong with a fitted ship, as documents say it.

use estimation::fitting::{
    AbsentTerm, Channels, Criticism, Fit, LEVEL, LateInput, Lateness, Problem, TurnedSign, Unfit,
};
use refusal::listed;
use ship::forces::Channel;
use ship::model::{DegreeOfFreedom, Vessel};
use study::documents::{AbsentForce, ForceCriticism, LateActuator, TriedSign};

/// Fewer independent pieces for each number hardly show anything.
const FEW: usize = 2;
/// Forces that a document has.
const SHOWN: usize = 20;

/// The inputs and measured disturbances of `vessel`, in the order of a row.
pub(crate) fn channels(vessel: &Vessel) -> Vec<Channel> {
    let own = &vessel.model.variables[3..];
    let channel = |(i, own): (usize, &ship::model::Variable)| Channel {
        name: own.name.clone(),
        unit: own.unit.clone(),
        range: vessel.actuators.get(i).and_then(|own| own.range),
    };
    own.iter().take(vessel.model.exogenous()).enumerate().map(channel).collect()
}

/// What is wrong with `vessel` after `fit`.
///
/// # Errors
/// A start of a window or a number that nothing determines.
pub(crate) fn criticised(vessel: &Vessel, problem: &Problem, fit: &Fit) -> Result<ForceCriticism, Unfit> {
    let channels = channels(vessel);
    let criticise =
        problem.criticise(fit, Channels { all: &channels, inputs: vessel.model.inputs, listed: None })?;
    let not_tested = criticise.has_wrong_sign().then(|| NOT_TESTED.to_owned());
    Ok(ForceCriticism {
        rejected: criticise.rejects(),
        p_value: criticise.p_value,
        units: criticise.units as u64,
        whole_windows: criticise.whole,
        statements: statements(&criticise, vessel.nominal.len()),
        signs: criticise.signs.iter().map(sign).collect(),
        late: criticise.late.iter().map(late).collect(),
        absent: criticise.terms.iter().take(SHOWN).map(absent).collect(),
        tested: criticise.terms.len() as u64,
        hidden: criticise.hidden,
        not_tested,
    })
}

/// Why there are no tests of lags and forces.
const NOT_TESTED: &str =
    "lags and missing forces are not tested: with a wrong sign they would make up for it";

fn sign(turned_sign: &TurnedSign) -> TriedSign {
    TriedSign {
        turned: turned_sign.turn.to_string(),
        share: turned_sign.share,
        windows_better: turned_sign.better as u64,
        windows: turned_sign.windows as u64,
        p_value: turned_sign.p_value,
        wrong: turned_sign.wrong,
    }
}

fn late(late_input: &LateInput) -> LateActuator {
    LateActuator {
        input: late_input.input.clone(),
        late_s: late_input.late_s,
        standard_error: late_input.standard_error,
        share: late_input.share,
        p_value: late_input.p_value,
        kind: late_input.best.map(|(kind, _, _)| kind_in_words(kind).to_owned()),
        time_s: late_input.best.map(|(_, time, _)| time),
        share_fitted: late_input.best.map(|(_, _, share)| share),
        share_of_other: late_input.other,
    }
}

fn kind_in_words(kind: Lateness) -> &'static str {
    match kind {
        Lateness::DeadTime => "dead time",
        Lateness::Lag => "lag",
    }
}

fn absent(own: &AbsentTerm) -> AbsentForce {
    AbsentForce {
        degree: degree(own).to_owned(),
        term: own.term.clone(),
        value: own.value,
        standard_error: own.standard_error,
        unit: own.unit.clone(),
        prime_value: own.prime.map(|one| own.value / one),
        share: own.share,
        p_value: own.p_value,
        candidate: own.candidate,
    }
}

/// The equation that a force is missing in.
pub(crate) fn degree(absent_term: &AbsentTerm) -> &'static str {
    DegreeOfFreedom::ALL[absent_term.degree].name()
}

/// The verdict: signs, then lags, then missing forces.
fn statements(own: &Criticism, numbers: usize) -> Vec<String> {
    if own.has_wrong_sign() {
        let wrong: Vec<&TurnedSign> = own.signs.iter().filter(|own| own.wrong).collect();
        return wrong.iter().take(1).map(|own| wrong_sign(own)).chain([NOT_TESTED.to_owned()]).collect();
    }
    let Some(p) = own.p_value else {
        return vec!["nothing could be tested: no force differs from the ship's own".to_owned()];
    };
    if !own.rejects() {
        let said = format!("model not rejected (p {p:.2}), which is no proof of it");
        let few = own.units < FEW * numbers;
        let few = few.then(|| {
            format!("{} independent pieces for {numbers} numbers would show gross faults alone", own.units)
        });
        return std::iter::once(said).chain(few).collect();
    }
    let late = own.late.iter().filter(|own| own.p_value < LEVEL).map(late_in_words);
    let named: Vec<&AbsentTerm> = own.terms.iter().filter(|own| own.candidate).collect();
    let missing = named.first().map(|first| missing(first));
    let others: Vec<String> =
        named.iter().skip(1).map(|own| format!("`{}` in {}", own.term, degree(own))).collect();
    let others = (!others.is_empty()).then(|| format!("cannot be told from: {}", listed(&others)));
    let all: Vec<String> = late.chain(missing).chain(others).collect();
    let begin = format!("model rejected ({})", probability(p));
    std::iter::once(begin).chain(all).collect()
}

fn wrong_sign(turned_sign: &TurnedSign) -> String {
    format!(
        "a sign is wrong: the recordings fit better with {} (cost {}, {} of {} windows, {}): check columns and places",
        turned_sign.turn,
        change(turned_sign.share.unwrap_or_default()),
        turned_sign.better,
        turned_sign.windows,
        probability(turned_sign.p_value)
    )
}

fn late_in_words(late_input: &LateInput) -> String {
    let begin = format!("`{}` acts {} s ", late_input.input, three(late_input.late_s.abs()));
    let end = match (late_input.best, late_input.other) {
        _ if late_input.late_s < 0.0 => {
            return format!(
                "{begin}earlier than it is logged (cost {}): check clocks",
                change(late_input.share)
            );
        }
        (Some((kind, time, share)), other) => {
            let other = other.map_or(String::new(), |other| match kind {
                Lateness::DeadTime => format!(", as a lag {}", change(other)),
                Lateness::Lag => format!(", as a dead time {}", change(other)),
            });
            format!("{} of {} s: cost {}{other}", kind_in_words(kind), three(time), change(share))
        }
        (None, _) => format!("cost {}", change(late_input.share)),
    };
    format!("{begin}later than the model has it ({end}): check its actuator and clocks")
}

fn missing(absent_term: &AbsentTerm) -> String {
    let prime = absent_term.prime.map_or(String::new(), |one| {
        format!(
            ", {} ± {} in the prime system",
            three(absent_term.value / one),
            three((absent_term.standard_error / one).abs())
        )
    });
    format!(
        "most likely missing: `{}` in {}, {} ± {} {} if added{prime} (cost {})",
        absent_term.term,
        degree(absent_term),
        three(absent_term.value),
        three(absent_term.standard_error),
        absent_term.unit,
        change(absent_term.share)
    )
}

/// A share of the cost as its change: −7.9 %.
fn change(share: f64) -> String {
    format!("−{:.1} %", 100.0 * share.min(1.0))
}

fn probability(p: f64) -> String {
    if p < 1e-4 { "p < 0.0001".to_owned() } else { format!("p {p:.4}") }
}

/// Three significant digits.
pub(crate) fn three(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let scientific = format!("{x:.2e}");
    let exponent = scientific.split_once('e').and_then(|(_, own)| own.parse::<i32>().ok());
    match exponent {
        Some(exponent @ -4..=5) => format!("{x:.*}", (2 - exponent).max(0) as usize),
        _ => scientific,
    }
}
