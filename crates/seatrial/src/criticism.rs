//! What is wrong with a fitted ship, as documents say it.

use std::collections::BTreeMap;

use estimation::fitting::{
    AbsentTerm, Channels, Criticism, Estimates, Fit, LEVEL, LateInput, Lateness, Prior, Problem, TurnedSign,
    Unfit,
};
use numerics::distributions::student_half_width;
use numerics::{dot, quadratic};
use refusal::{Invalid, foreign, listed};
use ship::forces::{Channel, Forces, LateralSum, Parameter};
use ship::model::{DegreeOfFreedom, Vessel};
use study::documents::{
    AbsentForce, CaptiveValue, FittedParameter, ForceCriticism, LateActuator, Reference, SailedSum,
    SailedSums, TriedSign,
};

/// Fewer independent pieces for each number hardly show anything.
const FEW: usize = 2;
/// Forces that a document has.
const SHOWN: usize = 20;

/// The inputs and measured disturbances of `vessel`, in the order of a row.
pub(crate) fn channels(vessel: &Vessel) -> Vec<Channel> {
    let variables = &vessel.model.variables[3..];
    let channel = |(i, variable): (usize, &ship::model::Variable)| Channel {
        name: variable.name.clone(),
        unit: variable.unit.clone(),
        range: vessel.actuators.get(i).and_then(|actuator| actuator.range),
    };
    variables.iter().take(vessel.model.exogenous()).enumerate().map(channel).collect()
}

/// What is wrong with `vessel` after `fit`.
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

fn sign(turned: &TurnedSign) -> TriedSign {
    TriedSign {
        turned: turned.turn.to_string(),
        share: turned.share,
        windows_better: turned.better as u64,
        windows: turned.windows as u64,
        p_value: turned.p_value,
        wrong: turned.wrong,
    }
}

fn late(late: &LateInput) -> LateActuator {
    LateActuator {
        input: late.input.clone(),
        late_s: late.late_s,
        standard_error: late.standard_error,
        share: late.share,
        p_value: late.p_value,
        kind: late.best.map(|(kind, _, _)| kind_in_words(kind).to_owned()),
        time_s: late.best.map(|(_, time, _)| time),
        share_fitted: late.best.map(|(_, _, share)| share),
        share_of_other: late.other,
    }
}

fn kind_in_words(kind: Lateness) -> &'static str {
    match kind {
        Lateness::DeadTime => "dead time",
        Lateness::Lag => "lag",
    }
}

fn absent(term: &AbsentTerm) -> AbsentForce {
    AbsentForce {
        degree: degree(term).to_owned(),
        term: term.term.clone(),
        value: term.value,
        standard_error: term.standard_error,
        unit: term.unit.clone(),
        prime_value: term.prime.map(|one| term.value / one),
        share: term.share,
        p_value: term.p_value,
        candidate: term.candidate,
    }
}

/// The equation that a force is missing in.
pub(crate) fn degree(term: &AbsentTerm) -> &'static str {
    DegreeOfFreedom::ALL[term.degree].name()
}

/// The verdict: signs, then lags, then missing forces.
fn statements(criticism: &Criticism, numbers: usize) -> Vec<String> {
    if criticism.has_wrong_sign() {
        let wrong: Vec<&TurnedSign> = criticism.signs.iter().filter(|sign| sign.wrong).collect();
        return wrong.iter().take(1).map(|sign| wrong_sign(sign)).chain([NOT_TESTED.to_owned()]).collect();
    }
    let Some(p) = criticism.p_value else {
        return vec!["nothing could be tested: no force differs from the ship's own".to_owned()];
    };
    if !criticism.rejects() {
        let said = format!("model not rejected (p {p:.2}), which is no proof of it");
        let few = criticism.units < FEW * numbers;
        let few = few.then(|| {
            format!(
                "{} independent pieces for {numbers} numbers would show gross faults alone",
                criticism.units
            )
        });
        return std::iter::once(said).chain(few).collect();
    }
    let late = criticism.late.iter().filter(|input| input.p_value < LEVEL).map(late_in_words);
    let named: Vec<&AbsentTerm> = criticism.terms.iter().filter(|term| term.candidate).collect();
    let missing = named.first().map(|first| missing(first));
    let others: Vec<String> =
        named.iter().skip(1).map(|term| format!("`{}` in {}", term.term, degree(term))).collect();
    let others = (!others.is_empty()).then(|| format!("cannot be told from: {}", listed(&others)));
    let all: Vec<String> = late.chain(missing).chain(others).collect();
    let begin = format!("model rejected ({})", probability(p));
    std::iter::once(begin).chain(all).collect()
}

fn wrong_sign(turned: &TurnedSign) -> String {
    format!(
        "a sign is wrong: the recordings fit better with {} (cost {}, {} of {} windows, {}): check columns and places",
        turned.turn,
        change(turned.share.unwrap_or_default()),
        turned.better,
        turned.windows,
        probability(turned.p_value)
    )
}

fn late_in_words(late: &LateInput) -> String {
    let begin = format!("`{}` acts {} s ", late.input, three(late.late_s.abs()));
    let end = match (late.best, late.other) {
        _ if late.late_s < 0.0 => {
            return format!("{begin}earlier than it is logged (cost {}): check clocks", change(late.share));
        }
        (Some((kind, time, share)), other) => {
            let other = other.map_or(String::new(), |other| match kind {
                Lateness::DeadTime => format!(", as a lag {}", change(other)),
                Lateness::Lag => format!(", as a dead time {}", change(other)),
            });
            format!("{} of {} s: cost {}{other}", kind_in_words(kind), three(time), change(share))
        }
        (None, _) => format!("cost {}", change(late.share)),
    };
    format!("{begin}later than the model has it ({end}): check its actuator and clocks")
}

fn missing(term: &AbsentTerm) -> String {
    let prime = term.prime.map_or(String::new(), |one| {
        format!(
            ", {} ± {} in the prime system",
            three(term.value / one),
            three((term.standard_error / one).abs())
        )
    });
    format!(
        "most likely missing: `{}` in {}, {} ± {} {} if added{prime} (cost {})",
        term.term,
        degree(term),
        three(term.value),
        three(term.standard_error),
        term.unit,
        change(term.share)
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
fn three(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let scientific = format!("{x:.2e}");
    let exponent = scientific.split_once('e').and_then(|(_, power)| power.parse::<i32>().ok());
    match exponent {
        Some(exponent @ -4..=5) => format!("{x:.*}", (2 - exponent).max(0) as usize),
        _ => scientific,
    }
}

// What a fit of forces knows of derivatives: intervals, sums along what was sailed, captive values beside them.

/// Values of captive tests, by the names of parameters.
pub(crate) type Captive = BTreeMap<String, f64>;

/// Refuses captive values of numbers that `vessel`, which has forces, does not leave free.
///
/// # Errors
/// The first of them.
pub fn check_captive(reference: &Reference, vessel: &Vessel) -> Result<(), Invalid> {
    let Some(moved) = &vessel.model.forces else { return Ok(()) };
    check(&reference.derivatives, &moved.forces)
}

fn check(captive: &Captive, forces: &Forces) -> Result<(), Invalid> {
    let known = || forces.parameters().iter().map(|parameter| parameter.name.as_str());
    match captive.keys().find(|name| known().all(|other| other != name.as_str())) {
        None => Ok(()),
        Some(name) => {
            let unknown = Invalid::unknown(format!("`derivatives.{}`", foreign(name)), name, known());
            Err(Invalid { found: "a name that no free number of the vessel has".to_owned(), ..unknown })
        }
    }
}

/// The 95 % interval of an estimate, whose error compares so many `pieces` of recordings; none of one piece.
pub(crate) fn interval(value: f64, error: f64, pieces: usize) -> Option<[f64; 2]> {
    let half = student_half_width(pieces as f64 - 1.0) * error;
    half.is_finite().then_some([value - half, value + half])
}

/// The captive value of a parameter beside its interval: in the prime system where it has one, else in SI units.
pub(crate) fn beside(parameter: &FittedParameter, captive: &Captive) -> Option<CaptiveValue> {
    let value = *captive.get(&parameter.name)?;
    let interval =
        if parameter.prime_value.is_some() { parameter.prime_interval } else { parameter.si_interval };
    Some(CaptiveValue { value, within: interval.map(|[low, high]| (low..=high).contains(&value)) })
}

/// v over r L by least squares; none where the ship never turned. Rows of states: u, v \[m/s\], r \[rad/s\].
pub(crate) fn drift<'a>(states: impl Iterator<Item = &'a [f64; 3]>, length_m: f64) -> Option<f64> {
    let (mut product, mut square) = (0.0, 0.0);
    for [_, v, r] in states {
        product += v * r * length_m;
        square += (r * length_m).powi(2);
    }
    Some(product / square).filter(|ratio| ratio.is_finite())
}

/// The sums of terms where v is `drift` r L; none of one piece of recordings, which has no intervals.
pub(crate) fn sailed(
    forces: &Forces,
    (theta, estimates): (&[f64], &Estimates),
    priors: &[Option<Prior>],
    captive: &Captive,
    drift: f64,
) -> Option<SailedSums> {
    let one = |sum: LateralSum| {
        let (value, used) = (sum.of(theta), used(&sum));
        let standard_error = quadratic(&sum.weights, &estimates.covariance).max(0.0).sqrt();
        let variances: Option<Vec<f64>> =
            used.iter().map(|i| Some((sum.weights[*i] * priors[*i]?.deviation).powi(2))).collect();
        let interval = interval(value, standard_error, estimates.pieces)?;
        Some(SailedSum {
            degree: DegreeOfFreedom::ALL[sum.degree].name().to_owned(),
            order: sum.order,
            terms: used.iter().map(|i| forces.parameters()[*i].name.clone()).collect(),
            value,
            standard_error,
            interval,
            prior_deviation: variances.map(|all| all.iter().sum::<f64>().sqrt()),
            captive: captive_sum(&sum, forces.parameters(), captive, interval),
        })
    };
    let sums = forces.lateral_sums(drift).into_iter().map(one).collect::<Option<_>>()?;
    Some(SailedSums { drift, sums })
}

/// The parameters that count in a sum.
fn used(sum: &LateralSum) -> Vec<usize> {
    (0..sum.weights.len()).filter(|i| sum.weights[*i] != 0.0).collect()
}

/// The sum of captive values, where all are given.
fn captive_sum(
    sum: &LateralSum,
    parameters: &[Parameter],
    captive: &Captive,
    [low, high]: [f64; 2],
) -> Option<CaptiveValue> {
    let written = |i: usize| {
        if sum.weights[i] == 0.0 {
            return Some(0.0);
        }
        let parameter = &parameters[i];
        Some(captive.get(&parameter.name)? * parameter.prime.unwrap_or(1.0) / parameter.scale)
    };
    let theta: Vec<f64> = (0..parameters.len()).map(written).collect::<Option<_>>()?;
    let value = sum.known + dot(&sum.weights, &theta);
    Some(CaptiveValue { value, within: Some((low..=high).contains(&value)) })
}

/// What to say of sums and captive values.
pub(crate) fn captive_statements(sailed: Option<&SailedSums>, parameters: &[FittedParameter]) -> Vec<String> {
    let sums = sailed.filter(|sailed| !sailed.sums.is_empty()).map(|sailed| {
        let one = |sum: &SailedSum| {
            let order = ["", "linear", "quadratic", "cubic"][sum.order.min(3) as usize];
            let captive = sum.captive.map_or(String::new(), |c| format!(" (captive {})", three(c.value)));
            let [value, error] = [sum.value, sum.standard_error].map(three);
            format!("{} {order} {value} ± {error}{captive}", sum.degree)
        };
        let all: Vec<String> = sailed.sums.iter().map(one).collect();
        format!("sums along v = {:.2} r L: {}", sailed.drift, all.join(", "))
    });
    let compared: Vec<&FittedParameter> = parameters.iter().filter(|p| p.captive.is_some()).collect();
    let of = |within: bool| {
        let all =
            compared.iter().filter(move |p| p.captive.is_some_and(|value| value.within == Some(within)));
        all.map(|parameter| format!("`{}`", parameter.name)).collect::<Vec<_>>()
    };
    let captive = (!compared.is_empty()).then(|| {
        let (inside, outside) = (of(true), of(false));
        let not = if outside.is_empty() { String::new() } else { format!(", not {}", outside.join(", ")) };
        format!("{} of {} captive values lie within the intervals{not}", inside.len(), compared.len())
    });
    sums.into_iter().chain(captive).collect()
}
