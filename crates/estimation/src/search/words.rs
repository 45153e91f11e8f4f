use super::average::Resampled;
use crate::pooled::FreeRunErrors;
use crate::search::compact::SizeScore;
use crate::search::judged::{Margin, NestedAverage, NestedRecording, NestedScore};
use crate::search::nested::{Candidate, Fitted};
use crate::search::scores::mean_of;
use refusal::listed;

use numerics::statistics::median;

/// A remark if whole runs are scored.
pub(crate) const CHOSEN_ON_WINDOWS: &str =
    "the ridge was chosen over windows of the length that is fitted, though whole runs are scored";

/// The errors of the parameters of the model `found`, in words: from searches over resampled recordings, or none.
pub(crate) fn errors(resampled: Option<&Resampled>, found: &Fitted) -> String {
    let Some(Resampled { searches, failed, parameters }) = resampled else {
        return "held back by a ridge; predictions have bands, parameters have no errors".to_owned();
    };
    let named = found.model.parameter_names().filter_map(|name| Some((name, parameters.get(name)?)));
    let intervals = named.map(|(name, own)| {
        let times = if own.chosen < *searches { format!(", in {}", own.chosen) } else { String::new() };
        format!("`{name}` {:.3e} to {:.3e}{times}", own.low, own.high)
    });
    let none = if *failed > 0 { format!(" ({failed} more found no model)") } else { String::new() };
    let all = intervals.collect::<Vec<_>>().join("; ");
    format!(
        "{searches} searches over recordings drawn again{none}: 95 % of them, and how many chose a term if not all: {all}"
    )
}

/// The choice and its score.
pub(crate) fn statements(
    candidates: &[Candidate],
    chosen: usize,
    score: f64,
    sizes: &[SizeScore],
    found: &Fitted,
    nested: &NestedScore,
) -> Vec<String> {
    let mut out = vec![format!(
        "ridge {:.1e} of {} tried: mean fit {score:.1} % of recordings that were left out",
        candidates[chosen].ridge,
        candidates.len()
    )];
    if !sizes.is_empty() {
        out.push(format!(
            "{} terms, the fewest that follow folds left out within a standard error of the best of {} numbers of terms",
            found.model.parameters(),
            sizes.len()
        ));
    }
    out.extend(at_bounds(found));
    out.extend(left_out(nested));
    let rejected: u64 = candidates.iter().map(|c| c.rejected).sum();
    if rejected > 0 {
        let ridges = candidates.iter().filter(|c| c.rejected > 0).count();
        out.push(format!("rejected: {ridges} ridges, of which fits or models diverge in {rejected} folds"));
    }
    if chosen + 1 == candidates.len() {
        out.push("the smallest ridge that was tried is the best: smaller ones may be better".to_owned());
    }
    out
}

/// How the whole search and the base structure follow recordings that were left out, in words.
pub fn left_out(nested: &NestedScore) -> Vec<String> {
    let mut out = vec![match (&nested.search, &nested.base) {
        (Some(own), Some(base)) => format!(
            "the whole search with recordings left out: fit {}; the base structure: fit {}",
            fits(own),
            fits(base)
        ),
        (Some(own), None) => {
            format!(
                "the whole search with recordings left out: fit {}; the base structure diverges",
                fits(own)
            )
        }
        (None, _) => format!(
            "not validated: without some fold there is no model, or it diverges ({} windows) on what was left out",
            nested.diverged
        ),
    }];
    if let (Some(own), Some(base)) = (&nested.search_overlapping, &nested.base_overlapping) {
        out.push(format!(
            "the same over windows that begin at every quarter of one: fit {}; the base structure: fit {}",
            fits(own),
            fits(base)
        ));
    }
    out.extend(nested.margin.as_ref().map(|margin| against(margin, "the base structure")));
    out.extend(nested.average.iter().flat_map(averaged));
    out.extend(contradicting(nested));
    out
}

/// Names the terms that no recording distinguishes from others.
pub(crate) fn combined(names: &[String]) -> Option<String> {
    let named: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    (!named.is_empty()).then(|| {
        format!(
            "in no sample anything but a combination of other terms, hence fixed in model.json, so that the next experiment is designed \
             for the others: {}",
            listed(&named)
        )
    })
}

/// Names the parameters at a bound.
fn at_bounds(found: &Fitted) -> Option<String> {
    let bounds = found.model.bounds()?;
    let own = found.model.parameter_names().zip(&found.theta).zip(bounds);
    let held: Vec<String> = own
        .filter(|((_, theta), ends)| ends.contains(theta))
        .map(|((name, _), _)| format!("`{name}`"))
        .collect();
    (!held.is_empty()).then(|| format!("held at a bound: {}", held.join(", ")))
}

/// A model is useless from this norm of RMSE/std on: that of the mean of the data is √3.
const USELESS: f64 = 1.0;
/// A recording contradicts the others if its error exceeds this many times their median.
const CONTRADICTS: f64 = 4.0;

/// Names the recordings that contradict the others: models of the others are useless for them, or diverge, but fit
/// each other.
fn contradicting(nested: &NestedScore) -> Option<String> {
    let norms: Vec<f64> = nested.recordings.iter().filter_map(|own| own.search_norm).collect();
    let usual = median(norms)?;
    let beyond = |own: &&NestedRecording| match own.search_norm {
        Some(norm) => norm > USELESS && norm > CONTRADICTS * usual,
        None => own.search_diverged > 0,
    };
    let named = nested.recordings.iter().filter(beyond).map(|recording| match recording.search_norm {
        Some(norm) => format!("`{}` by an error norm of {norm:.2}", recording.source),
        None => format!("`{}`, where they diverge", recording.source),
    });
    let named: Vec<String> = named.collect();
    (!named.is_empty()).then(|| {
        format!(
            "models of the other recordings, whose median is {usual:.2}, contradict {}: look at its signs, units, load and ship, or \
             leave it out",
            listed(&named)
        )
    })
}

/// The gain of averaging on recordings that were left out.
pub fn averaged(found: &NestedAverage) -> Vec<String> {
    let mut out = vec![match &found.errors {
        Some(own) => format!("the average with recordings left out: fit {}", fits(own)),
        None => format!(
            "the average is not validated: without some fold a model is missing, or diverges ({} windows) on what was left out",
            found.diverged
        ),
    }];
    out.extend(found.overlapping.as_ref().map(|overlapping| {
        format!("the average over windows that begin at every quarter of one: fit {}", fits(overlapping))
    }));
    let pairs = [(&found.over_search, "the single model"), (&found.over_base, "the base structure")];
    let sentence = |(margin, than): (&Option<Margin>, &str)| {
        margin.as_ref().map(|margin| format!("the average is {}", against(margin, than)))
    };
    out.extend(pairs.into_iter().filter_map(sentence));
    out
}

fn against(margin: &Margin, than: &str) -> String {
    let Margin { pairs, median, interval } = margin;
    let verdict = match interval {
        [Some(low), _] if *low > 0.0 => "better than",
        [_, Some(high)] if *high < 0.0 => "worse than",
        // There are too few pairs for a 95 % interval.
        [None, None] => "too few recordings to tell it from",
        _ => "not told apart from",
    };
    format!("{verdict} {than}: {}", crate::pooled::lies_above(*median, *interval, *pairs, "recordings"))
}

/// Fits of u, v, r and their mean, in words.
pub fn fits(errors: &FreeRunErrors) -> String {
    let one = |(name, fit): (&str, Option<f64>)| match fit {
        Some(fit) => format!("{name} {fit:.1} %"),
        None => format!("{name} –"),
    };
    let each = ["u", "v", "r"].into_iter().zip(errors.fits()).map(one).collect::<Vec<_>>().join(", ");
    mean_of(errors).map_or(each.clone(), |mean| format!("{each}, mean {mean:.1} %"))
}
