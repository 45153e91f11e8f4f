//! The next trial of a ship with logs: the design, and its predicted value.

use files::{Error, Provenance, read_document};
use maud::{Markup, html};
use study::documents::{
    CountedRuns, DesignDocument, DesignScores, EstimateDocument, FreeRunErrors, ModelDocument, Quantiles,
    SearchSummary, ValidationDocument,
};

use crate::loader::{Loader, existing};
use crate::number::{exact, fit, interval, median, or_dash, percent, q90, three, three_or_dash, unit};
use crate::parts::{HtmlTable, Section, beyond, coded, held};
use crate::planned_trial::{PlannedTrial, map};

/// The results for the next trial.
#[derive(Clone, Debug)]
pub struct NextTrial {
    /// `next/model.json`: the model for its design.
    pub model: ModelDocument,
    /// Of `next/estimate.json`: how that model was found.
    pub searched: Option<SearchSummary>,
    /// `next/design.json`.
    pub design: DesignDocument,
    /// Of `next/validation.json`: estimates from simulations of it.
    pub counted: Option<CountedRuns>,
    /// `next/plan.json` and its map: its plan on a chart.
    pub planned: Option<PlannedTrial>,
}

/// The folder of the results.
const FOLDER: &str = "next";

/// Reads what is in the folder `next` of the results; `None` without a design. The model starts a separate study: its
/// files have to belong together, not to the logs' other files.
pub(super) fn load(loader: &mut Loader) -> Result<Option<NextTrial>, Error> {
    let mut known = Provenance { allow_mixed: loader.sources.allow_mixed, ..Provenance::default() };
    let Some(design) = read(loader, &mut known, "design", "the next trial's shares")? else {
        return Ok(None);
    };
    let validation: Option<ValidationDocument> =
        read(loader, &mut known, "validation", "what is estimated from the next trial")?;
    let counted = validation.and_then(|validation| validation.counted);
    // Its own, or the one that the logs' model is.
    let at = |name| existing(loader.sources.results.join(name)).map(|path| (path, name));
    let Some((path, name)) = at("next/model.json").or_else(|| at("model.json")) else { return Ok(None) };
    let model = read_document::<ModelDocument>(&path)?;
    known.written("vessel", &path, model.digest)?;
    loader.note(name, "the model that the next trial is designed with", model.digest);
    let plan = read(loader, &mut known, "plan", "the next trial's trajectory")?;
    let (map, document) = map(loader, &format!("{FOLDER}/map"))?;
    let planned =
        plan.map(|plan| PlannedTrial { name: String::new(), plan, map, document, stale: Vec::new() });
    let mut search = Provenance { allow_mixed: loader.sources.allow_mixed, ..Provenance::default() };
    let estimate: Option<EstimateDocument> =
        read(loader, &mut search, "estimate", "how that model was found")?;
    let searched = estimate.and_then(|estimate| estimate.search);
    Ok(Some(NextTrial { model: model.data, searched, design, counted, planned }))
}

fn read<D: files::Document>(
    loader: &mut Loader,
    known: &mut Provenance,
    name: &str,
    what: &str,
) -> Result<Option<D>, Error> {
    let Some(path) = existing(loader.sources.results.join(FOLDER).join(format!("{name}.json"))) else {
        return Ok(None);
    };
    let read = read_document::<D>(&path)?;
    known.made(name, &path, read.digest, &read.provenance)?;
    loader.note(&format!("{FOLDER}/{name}.json"), what, read.digest);
    Ok(Some(read.data))
}

/// The design of the next trial, the expected accuracy of the parameters, and errors of models; `sailed` shows the
/// plan.
pub(super) fn next_trial(next: &NextTrial, sailed: Option<Markup>) -> Section {
    let body = html! {
        p {
            "Designed with the model that was found in the logs, for estimates by its free simulation ("
            (next.design.estimator.map_or("iv".to_owned(), |estimator| estimator.to_string()))
            "). " (coded(&next.design.statement))
            @if let Some(restricted) = &next.design.restricted { " " (coded(&restricted.statement)) }
        }
        (held(next.design.held_in_words().as_ref()))
        (beyond(&next.design.beyond))
        (shares(next))
        (free_runs(next))
        (parameters(next))
        @if let Some(sailed) = sailed { h3 { "Where it is sailed" } (sailed) }
    };
    Section::new("next", "The next trial", "The next trial", body)
}

/// Seconds of the whole trial.
fn duration_s(next: &NextTrial) -> Option<f64> {
    let samples = next.design.covariance.as_ref()?.samples;
    (samples > 1).then(|| samples as f64 / next.model.sample_rate_hz)
}

fn shares(next: &NextTrial) -> Markup {
    let design = &next.design;
    let mut rows: Vec<(&String, f64)> = design.shares.iter().map(|(name, share)| (name, *share)).collect();
    rows.retain(|(_, share)| *share > 0.0);
    rows.sort_by(|a, b| b.1.total_cmp(&a.1));
    let whole = duration_s(next);
    let table = HtmlTable::of(&rows)
        .name("Maneuver", |(name, _)| name)
        .number("Share", |(_, share)| percent(*share))
        .number("Time [s]", |(_, share)| or_dash(whole.map(|whole| format!("{:.0}", share * whole))));
    html! {
        @if let Some(candidates) = design.candidates {
            p.note { "Chosen of " (candidates) " maneuvers that propeller and rudder can hold." }
        }
        (table)
    }
}

/// Formats a quantile.
type FormatQuantile = fn(&Quantiles) -> String;

/// Takes an RMSE and its fit from the errors of the model itself, or the same RMSE of simulated trials.
type ErrorsOfModel = fn(FreeRunErrors) -> (f64, Option<f64>);
type ErrorsOfTrials = fn(&DesignScores) -> &Quantiles;

/// The effect of parameter errors on free simulations, next to the errors of the model itself.
fn free_runs(next: &NextTrial) -> Markup {
    let Some(counted) = &next.counted else { return html! {} };
    // A row's name, errors on recordings, and scores of simulated trials with the quantile to show.
    let measured = next
        .searched
        .as_ref()
        .and_then(SearchSummary::delivered_errors)
        .map(|errors| ("this model, on recordings left out of the search", Some(errors), None));
    let scores = counted.scores.iter().flat_map(|score| &score.designs);
    let scored = scores.flat_map(|scores| {
        let half = match scores.design.as_str() {
            "optimized" => "estimated anew from this trial, median",
            _ => "from random maneuvers, median",
        };
        let row = |what, value: FormatQuantile| (what, None, Some((scores, value)));
        match scores.not_identifiable == scores.runs {
            true => vec![row("from random maneuvers: no trial tells all parameters", median)],
            false => vec![row(half, median), row("… 90 % quantile", q90)],
        }
    });
    let table = HtmlTable::of(measured.into_iter().chain(scored)).compact().name("Model", |(what, ..)| what);
    let columns: [(&str, ErrorsOfModel, ErrorsOfTrials); 3] = [
        ("RMSE u [m/s]", |e| (e.rmse_u, e.fit_u), |s| &s.rmse_u),
        ("RMSE v [m/s]", |e| (e.rmse_v, e.fit_v), |s| &s.rmse_v),
        ("RMSE r [rad/s]", |e| (e.rmse_r, e.fit_r), |s| &s.rmse_r),
    ];
    let table = columns.into_iter().fold(table, |table, (head, of_model, of_trials)| {
        table.classed("number broken", head, |(_, errors, scores)| {
            let model =
                errors.map(of_model).map(|(rmse, share)| format!("{} (fit {})", three(rmse), fit(share)));
            let trials = scores.map(|(scores, value)| value(of_trials(scores)));
            or_dash(model.or(trials))
        })
    });
    let stds = next.searched.as_ref().map(|search| [search.std_u, search.std_v, search.std_r]);
    html! {
        h3 { "What that means for the fit" }
        (table)
        p.note {
            "Free simulations. Of simulated trials: quantiles over " (counted.realizations)
            " trials in the stated noise, with 95\u{a0}% intervals (– where there are none to simulate), against the model itself over the validation maneuvers: what errors of the parameters \
             alone cost, in still air and with the right structure."
            @if let Some([u, v, r]) = stds {
                " The logged motion has standard deviations of " (three(u)) "\u{a0}m/s, " (three(v)) "\u{a0}m/s and " (three(r))
                "\u{a0}rad/s: a fit is 100\u{a0}(1 − RMSE/std)."
            }
        }
    }
}

/// Every parameter before the trial, and its standard error after it.
fn parameters(next: &NextTrial) -> Markup {
    let predicted = next.design.covariance.as_ref().map(|covariance| &covariance.standard_errors);
    let half_width = next.model.half_width();
    let within = |value: f64, error: Option<f64>| {
        let half = half_width * error?;
        Some([value - half, value + half])
    };
    let terms = next.model.degrees.iter().flat_map(|d| d.parameters.iter().map(move |p| (d, p)));
    let terms = terms.map(|(degree, p)| {
        let ends = p.low.zip(p.high).map(|(low, high)| [low, high]);
        let ends = ends.or_else(|| within(p.value, p.standard_error));
        (&p.name, degree.name.as_str(), &p.unit, p.value, ends)
    });
    let forces = next.model.forces.iter().flat_map(|force| &force.parameters);
    let forces = forces.map(|p| (&p.name, "forces", &p.unit, p.value, within(p.value, p.standard_error)));
    let table = HtmlTable::of(terms.chain(forces))
        .compact()
        .name("Parameter", |(name, ..)| html! { code { (name) } })
        .text("Of", |(_, of, ..)| of)
        .text("Unit", |(_, _, of, ..)| unit(of))
        .number("Value", |(.., value, _)| three(value))
        .number("Interval, logs", |(.., ends)| interval(ends))
        .number("Predicted, this trial", |(name, ..)| {
            three_or_dash(predicted.and_then(|errors| errors.get(name)).copied())
        });
    let duration = duration_s(next).map_or(String::new(), |s| format!(" of {} s", exact(s)));
    let alone = if next.design.prior.is_some() { " and the logs together" } else { " alone" };
    html! {
        h3 { "What the parameters would be known to" }
        (table)
        p.note {
            "Predicted standard errors are those of estimates from this trial" (duration) (alone)
            ", under the noise that its campaign states; – where it holds constant what they stand before. Intervals from \
             the logs hold 95\u{a0}% of the searches over recordings drawn again, or are " (format!("{half_width:.2}")) " standard errors wide on either side; – \
             where parameters have no errors."
        }
    }
}
