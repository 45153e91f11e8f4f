//! What is wrong with a fitted ship, and what she knows of derivatives, as documents say it.

use std::collections::BTreeMap;

use estimation::criticism::{Criticism, Suspect, number};
use estimation::fitting::{Channels, Estimates, Fit, Prior, Problem, Unfit};
use numerics::statistics::student_half_width;
use numerics::{dot, quadratic};
use refusal::{Invalid, foreign};
use ship::forces::{Channel, Forces, LateralSum, Parameter};
use ship::model::{DegreeOfFreedom, Vessel};
use study::documents::{CaptiveValue, FittedParameter, Reference, SailedSum, SailedSums};

/// Terms that a document has.
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

/// What is wrong with `vessel` after `fit`, with the likeliest terms alone.
pub(crate) fn criticised(vessel: &Vessel, problem: &Problem, fit: &Fit) -> Result<Criticism, Unfit> {
    let channels = channels(vessel);
    let mut criticism = problem.criticise(fit, Channels { all: &channels, inputs: vessel.model.inputs })?;
    let mut terms = 0;
    criticism.absent.retain(|absent| {
        terms += usize::from(absent.kind == Suspect::Term);
        absent.kind != Suspect::Term || terms <= SHOWN
    });
    Ok(criticism)
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
            let captive = sum.captive.map_or(String::new(), |c| format!(" (captive {})", number(c.value)));
            let [value, error] = [sum.value, sum.standard_error].map(number);
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
