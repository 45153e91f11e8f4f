//! What a fit of forces knows of derivatives: intervals, sums along what was sailed, captive values beside them.

use std::collections::BTreeMap;

use estimation::fitting::{Estimates, Prior};
use numerics::distributions::student_half_width;
use numerics::{dot, quadratic};
use refusal::{Invalid, foreign};
use ship::forces::{Forces, LateralSum, Parameter};
use ship::model::{DegreeOfFreedom, Vessel};
use study::documents::{CaptiveValue, FittedParameter, Reference, SailedSum, SailedSums};

use crate::criticism::three;

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
pub(crate) fn statements(sailed: Option<&SailedSums>, parameters: &[FittedParameter]) -> Vec<String> {
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
