use estimation::pooled::lies_above;
use numerics::statistics::paired_median;
use refusal::listed;
use ship::model::DegreeOfFreedom;

use super::bands::Bands;
use super::covered::Outside;
use super::simulated::Simulated;
use super::spread::Spread;
use super::standing::{ComparedModel, Difference, Standing};
use super::validity::Validity;

/// With fewer recordings than this, windows are compared: the interval of a median would have no two ends.
const FEW: usize = 6;

/// The first of `compared` against the others by their error norms: recording by recording, or window by window.
pub(super) fn differences(
    compared: &[ComparedModel],
    models: &[Simulated],
    std: [f64; 3],
) -> Vec<Difference> {
    let by_window = compared.first().is_none_or(|first| first.recordings.len() < FEW);
    let norms = |i: usize| -> Vec<Option<f64>> {
        match by_window {
            true => models[i].sums.iter().flatten().map(|sum| sum.errors(std, std).error_norm).collect(),
            false => compared[i].recordings.iter().map(|own| own.errors.error_norm).collect(),
        }
    };
    let first = norms(0);
    let difference = |i: usize| {
        let pairs = first.iter().zip(norms(i)).map(|(own, other)| [*own, other]);
        let [low, median, high] = paired_median(pairs)?;
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let (name, place, pairs) = (compared[i].name, compared[i].place, first.len() as u64);
        Some(Difference { name, place, pairs, median: finite(median), interval: [low, high].map(finite) })
    };
    (1..compared.len()).filter_map(difference).collect()
}

/// The verdict on the first of `compared`, then remarks.
pub(super) fn verdict(
    compared: &[ComparedModel],
    differences: &[Difference],
    (validity, outside): (Option<&Validity>, &[Outside]),
    (bands, spread): (Option<&Bands>, Option<&Spread>),
) -> Vec<String> {
    let mut out: Vec<String> = compared.first().map(headline).into_iter().collect();
    out.extend(differences.iter().map(against));
    out.extend(validity.and_then(Validity::statement));
    out.extend(outside.iter().map(Outside::statement));
    out.extend(spread.map(Spread::statement));
    out.extend(bands.map(|b| {
        let [u, v, r] = [b.inside_u, b.inside_v, b.inside_r].map(|share| 100.0 * share);
        format!("inside the 95 % bands: u {u:.1} %, v {v:.1} %, r {r:.1} % of the samples")
    }));
    out
}

/// Useless if it diverges or is no better than the mean of the data.
fn headline(model: &ComparedModel) -> String {
    let errors = &model.errors;
    if errors.diverged > 0 {
        return format!("useless: {} of {} windows diverge", errors.diverged, errors.windows);
    }
    let fits: Vec<String> = DegreeOfFreedom::ALL.into_iter().zip(errors.fits()).map(fit).collect();
    let worse = DegreeOfFreedom::ALL.into_iter().zip(errors.fits());
    let worse = worse.filter(|(_, fit)| fit.is_some_and(|fit| fit <= 0.0));
    let worse: Vec<String> = worse.map(|(d, _)| d.name().to_owned()).collect();
    match worse.len() {
        0 => format!("fit {}", fits.join(", ")),
        _ => format!(
            "useless in {}: no better than the mean of the data (fit {})",
            listed(&worse),
            fits.join(", ")
        ),
    }
}

fn fit((d, fit): (DegreeOfFreedom, Option<f64>)) -> String {
    match fit {
        Some(fit) => format!("{} {fit:.1} %", d.state()),
        None => format!("{} does not vary", d.state()),
    }
}

fn against(difference: &Difference) -> String {
    let Difference { name, place, pairs, median, interval } = difference;
    let verdict = match interval {
        [Some(low), _] if *low > 0.0 => "better than",
        [_, Some(high)] if *high < 0.0 => "worse than",
        _ => "not told apart from",
    };
    let than = match name {
        Standing::LeastSquares => "least squares".to_owned(),
        Standing::Other => "the other model".to_owned(),
        Standing::Averaged => format!("model {} of the average alone", place.unwrap_or_default()),
        Standing::Mean | Standing::Model | Standing::Average => "the mean of the data".to_owned(),
    };
    let lies = lies_above(*median, *interval, *pairs, "pairs");
    format!("{verdict} {than}: {lies}")
}
