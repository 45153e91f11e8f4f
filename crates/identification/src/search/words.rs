use super::compact::SizeScore;
use super::judged::{Margin, NestedAverage, NestedScore};
use super::nested::{Candidate, Fitted};
use super::scores::mean_of;
use crate::pooled::FreeRunErrors;

/// What was chosen and how good it is.
pub(super) fn statements(
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
    out.extend(nested.margin.as_ref().map(|margin| against(margin, "the base structure")));
    out.extend(nested.average.iter().flat_map(averaged));
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

/// Which parameters their bounds hold.
fn at_bounds(found: &Fitted) -> Option<String> {
    let bounds = found.model.bounds()?;
    let own = found.model.parameter_names().zip(&found.theta).zip(bounds);
    let held: Vec<String> = own
        .filter(|((_, theta), ends)| ends.contains(theta))
        .map(|((name, _), _)| format!("`{name}`"))
        .collect();
    (!held.is_empty()).then(|| format!("held at a bound: {}", held.join(", ")))
}

/// What averaging brings on recordings that were left out.
fn averaged(found: &NestedAverage) -> Vec<String> {
    let mut out = vec![match &found.errors {
        Some(own) => format!("the average with recordings left out: fit {}", fits(own)),
        None => format!(
            "the average is not validated: without some fold a model is missing, or diverges ({} windows) on what was left out",
            found.diverged
        ),
    }];
    out.extend(found.overlapping.as_ref().map(|own| {
        format!("the average over windows that begin at every quarter of one: fit {}", fits(own))
    }));
    let pairs = [(&found.over_search, "the single model"), (&found.over_base, "the base structure")];
    let told = |(margin, than): (&Option<Margin>, &str)| {
        margin.as_ref().map(|margin| format!("the average is {}", against(margin, than)))
    };
    out.extend(pairs.into_iter().filter_map(told));
    out
}

fn against(margin: &Margin, than: &str) -> String {
    let Margin { pairs, median, interval } = margin;
    let told = match interval {
        [Some(low), _] if *low > 0.0 => "better than",
        [_, Some(high)] if *high < 0.0 => "worse than",
        _ => "not told apart from",
    };
    format!("{told} {than}: {}", crate::pooled::lies_above(*median, *interval, *pairs, "recordings"))
}

fn fits(errors: &FreeRunErrors) -> String {
    let one = |(name, fit): (&str, Option<f64>)| match fit {
        Some(fit) => format!("{name} {fit:.1} %"),
        None => format!("{name} –"),
    };
    let each = ["u", "v", "r"].into_iter().zip(errors.fits()).map(one).collect::<Vec<_>>().join(", ");
    mean_of(errors).map_or(each.clone(), |mean| format!("{each}, mean {mean:.1} %"))
}
