use vessel::Model;

use super::compact::SizeScore;
use super::judged::{Margin, NestedScore};
use super::nested::Candidate;
use super::scores::mean_of;
use crate::pooled::FreeRunErrors;

/// What was chosen and how good it is.
pub(super) fn statements(
    candidates: &[Candidate],
    chosen: usize,
    score: f64,
    sizes: &[SizeScore],
    model: &Model,
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
            model.parameters(),
            sizes.len()
        ));
    }
    out.push(match (&nested.search, &nested.base) {
        (Some(own), Some(base)) => format!(
            "the whole search with recordings left out: fit {}; the base structure: fit {}",
            fits(own),
            fits(base)
        ),
        (Some(own), None) => {
            format!("the whole search with recordings left out: fit {}; the base structure diverges", fits(own))
        }
        (None, _) => format!(
            "not validated: without some fold there is no model, or it diverges ({} windows) on what was left out",
            nested.diverged
        ),
    });
    if let (Some(own), Some(base)) = (&nested.search_overlapping, &nested.base_overlapping) {
        out.push(format!(
            "the same over windows that begin at every quarter of one: fit {}; the base structure: fit {}",
            fits(own),
            fits(base)
        ));
    }
    out.extend(nested.margin.as_ref().map(against));
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

fn against(margin: &Margin) -> String {
    let Margin { pairs, median, interval } = margin;
    let told = match interval {
        [Some(low), _] if *low > 0.0 => "better than",
        [_, Some(high)] if *high < 0.0 => "worse than",
        _ => "not told apart from",
    };
    let number = |x: &Option<f64>| x.map_or("∞".to_owned(), |x| format!("{x:+.3}"));
    let ([low, high], median) = (interval.each_ref().map(number), number(median));
    format!(
        "{told} the base structure: its norm of RMSE/std lies {median} above (95 %: {low} to {high}; {pairs} recordings)"
    )
}

fn fits(errors: &FreeRunErrors) -> String {
    let one = |(name, fit): (&str, Option<f64>)| match fit {
        Some(fit) => format!("{name} {fit:.1} %"),
        None => format!("{name} –"),
    };
    let each = ["u", "v", "r"].into_iter().zip(errors.fits()).map(one).collect::<Vec<_>>().join(", ");
    mean_of(errors).map_or(each.clone(), |mean| format!("{each}, mean {mean:.1} %"))
}
