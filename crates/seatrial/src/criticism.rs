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
    let own =
        problem.criticise(fit, Channels { all: &channels, inputs: vessel.model.inputs, listed: None })?;
    let not_tested = own.has_wrong_sign().then(|| NOT_TESTED.to_owned());
    Ok(ForceCriticism {
        rejected: own.rejects(),
        p_value: own.p_value,
        units: own.units as u64,
        whole_windows: own.whole,
        statements: statements(&own, vessel.nominal.len()),
        signs: own.signs.iter().map(sign).collect(),
        late: own.late.iter().map(late).collect(),
        absent: own.terms.iter().take(SHOWN).map(absent).collect(),
        tested: own.terms.len() as u64,
        hidden: own.hidden,
        not_tested,
    })
}

/// Why there are no tests of lags and forces.
const NOT_TESTED: &str =
    "lags and missing forces are not tested: with a wrong sign they would make up for it";

fn sign(own: &TurnedSign) -> TriedSign {
    TriedSign {
        turned: own.turn.to_string(),
        share: own.share,
        windows_better: own.better as u64,
        windows: own.windows as u64,
        p_value: own.p_value,
        wrong: own.wrong,
    }
}

fn late(own: &LateInput) -> LateActuator {
    LateActuator {
        input: own.input.clone(),
        late_s: own.late_s,
        standard_error: own.standard_error,
        share: own.share,
        p_value: own.p_value,
        kind: own.best.map(|(kind, _, _)| kind_in_words(kind).to_owned()),
        time_s: own.best.map(|(_, time, _)| time),
        share_fitted: own.best.map(|(_, _, share)| share),
        share_of_other: own.other,
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
pub(crate) fn degree(own: &AbsentTerm) -> &'static str {
    DegreeOfFreedom::ALL[own.degree].name()
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

fn wrong_sign(own: &TurnedSign) -> String {
    format!(
        "a sign is wrong: the recordings fit better with {} (cost {}, {} of {} windows, {}): check columns and places",
        own.turn,
        change(own.share.unwrap_or_default()),
        own.better,
        own.windows,
        probability(own.p_value)
    )
}

fn late_in_words(own: &LateInput) -> String {
    let begin = format!("`{}` acts {} s ", own.input, three(own.late_s.abs()));
    let end = match (own.best, own.other) {
        _ if own.late_s < 0.0 => {
            return format!("{begin}earlier than it is logged (cost {}): check clocks", change(own.share));
        }
        (Some((kind, time, share)), other) => {
            let other = other.map_or(String::new(), |other| match kind {
                Lateness::DeadTime => format!(", as a lag {}", change(other)),
                Lateness::Lag => format!(", as a dead time {}", change(other)),
            });
            format!("{} of {} s: cost {}{other}", kind_in_words(kind), three(time), change(share))
        }
        (None, _) => format!("cost {}", change(own.share)),
    };
    format!("{begin}later than the model has it ({end}): check its actuator and clocks")
}

fn missing(own: &AbsentTerm) -> String {
    let prime = own.prime.map_or(String::new(), |one| {
        format!(
            ", {} ± {} in the prime system",
            three(own.value / one),
            three((own.standard_error / one).abs())
        )
    });
    format!(
        "most likely missing: `{}` in {}, {} ± {} {} if added{prime} (cost {})",
        own.term,
        degree(own),
        three(own.value),
        three(own.standard_error),
        own.unit,
        change(own.share)
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
