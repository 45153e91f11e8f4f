use maud::{Markup, html};
use study::documents::{
    AverageSummary, AverageTerm, Candidate, FreeRunErrors, NestedAverage, NestedRecording, SearchSummary,
    SearchTerm, SizeScore,
};

use crate::figures::{ScoredDot, scored};
use crate::measured::free_runs;
use crate::number::{exact, or_dash, three, three_or_dash, three_within, windows_of};
use crate::parts::{Figures, HtmlTable, Section, statements};

/// Terms beyond this many are not listed: those of the base structure first, then those that were chosen most often.
const MOST_TERMS: usize = 40;

/// The search for the structure: candidates, the score on recordings that the search has not seen, terms.
pub(super) fn searched(search: Option<&SearchSummary>, figures: &mut Figures) -> Option<Section> {
    let search = search?;
    let body = html! {
        (about(search))
        (statements(&search.statements))
        (nested(search))
        (ridges(search, figures))
        @if !search.sizes.is_empty() { (sizes(search, figures)) }
        (terms(search))
        @if let Some(average) = &search.average { (averaged(average)) }
        (recordings(search))
    };
    Some(Section::new("search", "Search for a structure", "The search for a structure", body))
}

fn about(found: &SearchSummary) -> Markup {
    let windows = windows_of(found.window_s);
    html! {
        p {
            "Beside the terms of the vessel a library is fitted by the errors of free simulations over windows of "
            (exact(found.fitted_window_s)) " s that begin every " (exact(found.every_s)) " s, held back by a ridge. "
            (found.folds) " folds of whole recordings choose the ridge; the whole search is repeated without each fold and judged \
             by it, over " (windows) ". Fit: 100 (1 − RMSE/std) over all windows together."
        }
    }
}

/// Scores of the whole search, of the base structure and of the average, over both kinds of windows.
fn nested(found: &SearchSummary) -> Markup {
    let nested = &found.nested;
    let average = nested.average.as_ref();
    let scores = |windows: &'static str,
                  [search, base]: [Option<FreeRunErrors>; 2],
                  of: fn(&NestedAverage) -> Option<FreeRunErrors>| {
        let average = average.map(|average| ("average of models", of(average)));
        let single = [("whole search", search), ("base structure", base)].into_iter();
        single.chain(average).map(move |(name, errors)| (name, windows, errors))
    };
    let consecutive = scores("side by side", [nested.search, nested.base], |average| average.errors);
    let overlapping = [nested.search_overlapping, nested.base_overlapping];
    let overlapping = scores("one at every quarter of another", overlapping, |average| average.overlapping);
    let table = HtmlTable::of(consecutive.chain(overlapping))
        .name("On recordings left out", |(name, ..)| name)
        .text("Windows", |(_, windows, _)| windows);
    html! {
        (free_runs(table, |(.., errors)| errors))
        @if let Some(margin) = &nested.margin {
            p.note {
                "The base structure's norm of RMSE/std lies above that of the search by "
                (three_within(margin.median, Some(margin.interval))) ": median over " (margin.pairs)
                " recordings with its 95 % interval; one that contains 0 tells no difference."
            }
        }
        @if let Some(margin) = average.and_then(|average| average.over_search.as_ref()) {
            p.note {
                "That of the whole search, which is a single model, lies above that of the average by "
                (three_within(margin.median, Some(margin.interval))) ". The average is nested too: all its models are found again \
                 without each fold."
            }
        }
    }
}

fn ridges(found: &SearchSummary, figures: &mut Figures) -> Markup {
    let chosen = |c: &Candidate| Some(c.ridge) == found.ridge;
    let dot = |c: &Candidate| {
        let (at, standard_error) = (c.ridge, c.standard_error);
        Some(ScoredDot { at, score: c.score?, standard_error, chosen: chosen(c) })
    };
    let dots: Vec<ScoredDot> = found.candidates.iter().filter_map(dot).collect();
    let figure = scored(&dots, true, ("ridge Λ [1]", "mean fit of u, v, r [%]"));
    let table = HtmlTable::of(&found.candidates)
        .mark("main", chosen)
        .name("Ridge", |c| three(c.ridge))
        .number("Mean fit [%]", |c| three_or_dash(c.score))
        .number("Standard error", |c| three_or_dash(c.standard_error))
        .number("Folds rejected", |c| c.rejected);
    html! {
        h3 { "Score against the ridge" }
        (figures.place("search-ridge", figure, &html! {
            b { "Mean fit over folds left out, with its standard error." }
            " The filled dot is the ridge that was chosen. Standard errors are of one candidate over recordings; between \
             candidates scores differ less, for the recordings are the same."
        }))
        (table)
    }
}

fn sizes(found: &SearchSummary, figures: &mut Figures) -> Markup {
    let kept = found.sizes.iter().find(|size| size.excess <= size.standard_error).map(|size| size.terms);
    let dot = |size: &SizeScore| ScoredDot {
        at: size.terms as f64,
        score: size.excess,
        standard_error: Some(size.standard_error),
        chosen: Some(size.terms) == kept,
    };
    let dots: Vec<ScoredDot> = found.sizes.iter().map(dot).collect();
    let figure = scored(&dots, false, ("number of terms [1]", "loss above the least [1]"));
    html! {
        h3 { "Score against the number of terms" }
        (figures.place("search-terms", figure, &html! {
            b { "Loss of folds left out above the least, with its standard error." }
            " The filled dot is the fewest terms within a standard error of the best. Terms were added one by one, each time the \
             one with the least loss."
        }))
    }
}

fn terms(found: &SearchSummary) -> Markup {
    let mut rows: Vec<&SearchTerm> = found.terms.iter().collect();
    rows.sort_by_key(|term| std::cmp::Reverse((term.base, term.chosen_by_resamples, term.chosen_by_folds)));
    let listed = rows.len().min(MOST_TERMS);
    let mut table = HtmlTable::of(rows[..listed].iter().copied())
        .compact()
        .mark("main", |t| t.base)
        .name("Term", |t| t.term.as_str())
        .text("Of", |t| t.degree.as_str())
        .text("Parameter", |t| t.name.as_str())
        .number("Value", |t| three(t.value))
        .number("Chosen without a fold", |t| or_dash(t.chosen_by_folds));
    if let Some(resamples) = found.resamples {
        table = table
            .number("2.5 %", |t| three_or_dash(t.low))
            .number("97.5 %", |t| three_or_dash(t.high))
            .number("Chosen again", move |t| {
                or_dash(t.chosen_by_resamples.map(|n| format!("{n} of {}", resamples.searches)))
            });
    }
    html! {
        h3 { "Terms" }
        (table)
        p.note {
            "Those of the base structure first, then those that were chosen most often. "
            @match found.resamples {
                Some(resamples) => {
                    "2.5 % and 97.5 %: what so many of " (resamples.searches) " searches over recordings drawn again found less and \
                     more, 0 without the term (bootstrap of the whole search). "
                }
                None => {
                    "A ridge holds them back: predictions have bands, parameters have no errors. "
                }
            }
            @if rows.len() > listed { "The first " (listed) " of " (rows.len()) "; all are in `estimate.json`. " }
            @if !found.sizes.is_empty() {
                "Chosen without a fold: in how many of the " (found.folds) " searches without a fold the term was chosen too."
            }
        }
    }
}

fn recordings(found: &SearchSummary) -> Markup {
    let mut table = HtmlTable::of(&found.nested.recordings)
        .compact()
        .name("Recording", |r: &NestedRecording| r.source.as_str())
        .number("Fold", |r| r.fold + 1)
        .number("Error norm", |r| three_or_dash(r.search_norm))
        .number("Of the base structure", |r| three_or_dash(r.base_norm));
    if found.average.is_some() {
        table = table.number("Of the average", |r| three_or_dash(r.average_norm));
    }
    html! {
        h3 { "Recordings when they were left out" }
        (free_runs(table, |r| r.search))
        p.note { "Fits of a recording are against the standard deviations of its own states." }
    }
}

/// Terms beyond this many are not listed.
const MOST_TERMS_OF_MEMBERS: usize = 120;

/// The terms of the models of an average, with how often each was chosen.
fn averaged(found: &AverageSummary) -> Markup {
    let of_library: Vec<&AverageTerm> = found.terms.iter().filter(|term| !term.base).collect();
    let counts: Vec<(u64, usize)> = (1..=found.models)
        .rev()
        .map(|models| (models, of_library.iter().filter(|term| term.chosen == models).count()))
        .collect();
    let agreed = HtmlTable::of(&counts)
        .name("In so many models", |(models, _)| models.to_string())
        .number("Terms of the library", |(_, terms)| terms);
    let listed = &of_library[..of_library.len().min(MOST_TERMS_OF_MEMBERS)];
    let table = HtmlTable::of(listed.iter().copied())
        .compact()
        .name("Term", |t| t.term.as_str())
        .text("Of", |t| t.degree.as_str())
        .text("Parameter", |t| t.name.as_str())
        .number("In models", |t| format!("{} of {}", t.chosen, found.models))
        .number("Least value", |t| three(t.lowest))
        .number("Mean", |t| three(t.mean))
        .number("Largest", |t| three(t.highest));
    html! {
        h3 { "The average" }
        p {
            (found.models) " models of few terms are averaged. The structure of each was found on " (found.recordings_each)
            " recordings drawn at random, of each kind about as large a share (seed " (found.seed) "); then it was fitted to all. \
             Terms that few models have are those that the recordings leave open."
        }
        (agreed)
        (table)
        @if of_library.len() > listed.len() {
            p.note { "The first " (listed.len()) " of " (of_library.len()) "; all are in `estimate.json`." }
        }
    }
}
