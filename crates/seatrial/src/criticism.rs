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
fn three(x: f64) -> String {
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
    let known = || forces.parameters().iter().map(|own| own.name.as_str());
    match captive.keys().find(|name| known().all(|own| own != name.as_str())) {
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
pub(crate) fn beside(fitted_parameter: &FittedParameter, captive: &Captive) -> Option<CaptiveValue> {
    let value = *captive.get(&fitted_parameter.name)?;
    let interval = if fitted_parameter.prime_value.is_some() {
        fitted_parameter.prime_interval
    } else {
        fitted_parameter.si_interval
    };
    Some(CaptiveValue { value, within: interval.map(|[low, high]| (low..=high).contains(&value)) })
}

/// v over r L by least squares; none where the ship never turned. Rows of states: u, v \[m/s\], r \[rad/s\].
pub(crate) fn drift<'a>(states: impl Iterator<Item = &'a [f64; 3]>, length_m: f64) -> Option<f64> {
    let (mut product, mut square) = (0.0, 0.0);
    for [_, v, r] in states {
        product += v * r * length_m;
        square += (r * length_m).powi(2);
    }
    Some(product / square).filter(|own| own.is_finite())
}

/// The sums of terms where v is `drift` r L; none of one piece of recordings, which has no intervals.
pub(crate) fn sailed(
    forces: &Forces,
    (theta, estimates): (&[f64], &Estimates),
    priors: &[Option<Prior>],
    captive: &Captive,
    drift: f64,
) -> Option<SailedSums> {
    let one = |lateral_sum: LateralSum| {
        let (value, used) = (lateral_sum.of(theta), used(&lateral_sum));
        let standard_error = quadratic(&lateral_sum.weights, &estimates.covariance).max(0.0).sqrt();
        let variances: Option<Vec<f64>> =
            used.iter().map(|i| Some((lateral_sum.weights[*i] * priors[*i]?.deviation).powi(2))).collect();
        let interval = interval(value, standard_error, estimates.pieces)?;
        Some(SailedSum {
            degree: DegreeOfFreedom::ALL[lateral_sum.degree].name().to_owned(),
            order: lateral_sum.order,
            terms: used.iter().map(|i| forces.parameters()[*i].name.clone()).collect(),
            value,
            standard_error,
            interval,
            prior_deviation: variances.map(|all| all.iter().sum::<f64>().sqrt()),
            captive: captive_sum(&lateral_sum, forces.parameters(), captive, interval),
        })
    };
    let sums = forces.lateral_sums(drift).into_iter().map(one).collect::<Option<_>>()?;
    Some(SailedSums { drift, sums })
}

/// The parameters that count in a sum.
fn used(own: &LateralSum) -> Vec<usize> {
    (0..own.weights.len()).filter(|i| own.weights[*i] != 0.0).collect()
}

/// The sum of captive values, where all are given.
fn captive_sum(
    lateral_sum: &LateralSum,
    parameters: &[Parameter],
    captive: &Captive,
    [low, high]: [f64; 2],
) -> Option<CaptiveValue> {
    let written = |i: usize| {
        if lateral_sum.weights[i] == 0.0 {
            return Some(0.0);
        }
        let parameter = &parameters[i];
        Some(captive.get(&parameter.name)? * parameter.prime.unwrap_or(1.0) / parameter.scale)
    };
    let theta: Vec<f64> = (0..parameters.len()).map(written).collect::<Option<_>>()?;
    let value = lateral_sum.known + dot(&lateral_sum.weights, &theta);
    Some(CaptiveValue { value, within: Some((low..=high).contains(&value)) })
}

/// What to say of sums and captive values.
pub(crate) fn captive_statements(sailed: Option<&SailedSums>, parameters: &[FittedParameter]) -> Vec<String> {
    let sums = sailed.filter(|sailed| !sailed.sums.is_empty()).map(|own| {
        let one = |sailed_sum: &SailedSum| {
            let order = ["", "linear", "quadratic", "cubic"][sailed_sum.order.min(3) as usize];
            let captive = sailed_sum
                .captive
                .map_or(String::new(), |captive| format!(" (captive {})", three(captive.value)));
            let [value, error] = [sailed_sum.value, sailed_sum.standard_error].map(three);
            format!("{} {order} {value} ± {error}{captive}", sailed_sum.degree)
        };
        let all: Vec<String> = own.sums.iter().map(one).collect();
        format!("sums along v = {:.2} r L: {}", own.drift, all.join(", "))
    });
    let compared: Vec<&FittedParameter> = parameters.iter().filter(|own| own.captive.is_some()).collect();
    let of = |within: bool| {
        let all =
            compared.iter().filter(move |own| own.captive.is_some_and(|own| own.within == Some(within)));
        all.map(|own| format!("`{}`", own.name)).collect::<Vec<_>>()
    };
    let captive = (!compared.is_empty()).then(|| {
        let (inside, outside) = (of(true), of(false));
        let not = if outside.is_empty() { String::new() } else { format!(", not {}", outside.join(", ")) };
        format!("{} of {} captive values lie within the intervals{not}", inside.len(), compared.len())
    });
    sums.into_iter().chain(captive).collect()
}
