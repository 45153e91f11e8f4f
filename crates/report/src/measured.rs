use files::Error;
use maud::{Markup, display, html};
use refusal::listed;
use study::documents::{
    COLLINEAR, Compared, DegreeTrust, DeliveredKind, EstimateDocument, EstimatorScore, FreeRunErrors,
    IngestDocument, LeftOutScores, ModelDocument, RecordingSummary, SearchSummary, SelectionScores, Traced,
    Trust, WarningSummary,
};

use crate::SelectionStudy;
use crate::loader::Loader;
use crate::next_trial::NextTrial;
use crate::number::{fit, or_dash, percent_within, three, three_or_dash, windows_of};
use crate::parts::{HtmlTable, Section, card, grouped, missing};

/// The results from measured logs.
#[derive(Clone, Debug, Default)]
pub struct MeasuredStudy {
    /// `ingest.json`.
    pub ingest: Option<IngestDocument>,
    /// Of `estimate.json`: how far the estimate can be trusted.
    pub trust: Option<Trust>,
    /// Of `estimate.json`: estimators over recordings left out.
    pub left_out: Option<LeftOutScores>,
    /// `model.json`.
    pub model: Option<ModelDocument>,
    /// The model on recordings of `validation.json`, and over time.
    pub compared: Option<(Compared, Vec<Traced>)>,
    /// Of `estimate.json`: how the structure was searched for.
    pub searched: Option<SearchSummary>,
    /// The next trial.
    pub next: Option<NextTrial>,
}

/// Reads `ingest.json`, `model.json` and the next trial, with the models on `recordings`; takes out of `estimate` what is said of one model of
/// recordings. `None` without a comparison and such a model.
pub(super) fn load(
    loader: &mut Loader,
    estimate: Option<&mut EstimateDocument>,
    recordings: Option<Compared>,
) -> Result<Option<MeasuredStudy>, Error> {
    let taken = estimate.filter(|estimate| estimate.structure.is_some());
    let is_modelled = taken.is_some();
    let (trust, left_out, searched) = taken.map_or((None, None, None), |estimate| {
        (estimate.trust.take(), estimate.left_out.take(), estimate.search.take())
    });
    let compared = super::compared::load(loader, recordings)?;
    if !is_modelled && compared.is_none() {
        return Ok(None);
    }
    let ingest = loader.document("ingest.json", "what was read from the logs, and its quality")?;
    let model = loader.document("model.json", "the model that the estimate delivers")?;
    let next = super::next_trial::load(loader)?;
    Ok(Some(MeasuredStudy { ingest, trust, left_out, model, compared, searched, next }))
}

/// Adds fits and errors of free simulations.
pub(super) fn free_runs<R: Copy>(
    table: HtmlTable<R>,
    errors: impl Fn(R) -> Option<FreeRunErrors>,
) -> HtmlTable<R> {
    let error = |of: fn(FreeRunErrors) -> f64| {
        let errors = &errors;
        move |row| three_or_dash(errors(row).map(of))
    };
    table
        .number("Fit u", |row| fit(errors(row).and_then(|e| e.fit_u)))
        .number("Fit v", |row| fit(errors(row).and_then(|e| e.fit_v)))
        .number("Fit r", |row| fit(errors(row).and_then(|e| e.fit_r)))
        .number("RMSE u [m/s]", error(|e| e.rmse_u))
        .number("RMSE v [m/s]", error(|e| e.rmse_v))
        .number("RMSE r [rad/s]", error(|e| e.rmse_r))
}

impl SelectionStudy {
    /// 90 % of the realizations of design number `design` have a smaller error norm; some may have no model.
    fn q90(&self, design: usize) -> String {
        let norm = self.summary.designs.get(design).and_then(|d| d.overlapping.error_norm.q90);
        norm.map_or("infinite".to_owned(), |norm| format!("{norm:.2}"))
    }
}

impl MeasuredStudy {
    /// The delivered model's estimator in cross-validation, else the one of least error, with its errors.
    pub(super) fn judged(&self) -> Option<(&EstimatorScore, FreeRunErrors)> {
        let left_out = self.left_out.as_ref()?;
        let delivered = self.model.as_ref().map(|model| model.estimator);
        let mut names = delivered.iter().chain(left_out.candidates.first());
        names.find_map(|name| {
            let score = left_out.estimators.iter().find(|e| e.name == *name)?;
            Some((score, score.errors?))
        })
    }

    /// Whether the estimate of all recordings is judged: how far it can be trusted, or what is wrong with forces.
    pub(super) fn is_judged(&self) -> bool {
        let forces = self.model.as_ref().and_then(|model| model.forces.as_ref());
        self.trust.is_some() || forces.is_some_and(|forces| forces.criticism.is_some())
    }

    /// The search whose model is delivered, with its errors where recordings were left out.
    fn delivered_search(&self) -> Option<(&SearchSummary, FreeRunErrors)> {
        let search = self.searched.as_ref().filter(|_| self.left_out.is_none())?;
        Some((search, search.delivered_errors()?))
    }

    /// What the delivered model of a search predicts, and beside it the others.
    fn delivered(&self) -> Option<String> {
        let (search, errors) = self.delivered_search()?;
        let over = windows_of(search.window_s);
        let beside = search.beside.as_ref();
        let kind = beside.map(|beside| beside.delivered);
        let what = match kind {
            Some(DeliveredKind::Average) => "the average of searched terms and of forces",
            Some(DeliveredKind::Forces) => "of forces",
            _ => "found by a search",
        };
        let others = [
            ("the searched terms", search.nested.search, kind == Some(DeliveredKind::Average)),
            ("the forces", beside.and_then(|beside| beside.errors), kind != Some(DeliveredKind::Forces)),
            ("the terms that the search began with", search.nested.base, true),
        ];
        let other = |(name, errors, _): (&str, Option<FreeRunErrors>, bool)| {
            Some(format!("{} by {name}", mean_fit(&errors?)))
        };
        let others: Vec<String> = others.into_iter().filter(|(.., is)| *is).filter_map(other).collect();
        Some(format!(
            "The delivered model, {what}, follows recordings that were left out of all of its making, over {over}, with a fit of {} in \
             surge, {} in sway and {} in yaw rate: {} on average{}.",
            fit(errors.fit_u),
            fit(errors.fit_v),
            fit(errors.fit_r),
            mean_fit(&errors),
            if others.is_empty() { String::new() } else { format!(", and {}", listed(&others)) },
        ))
    }

    /// The answer in a few sentences.
    pub(super) fn answer(&self, selection: Option<&SelectionStudy>) -> String {
        let mut sentences = Vec::new();
        if let (Some((score, errors)), Some(left_out)) = (self.judged(), &self.left_out) {
            let over = windows_of(left_out.window_s);
            sentences.push(format!(
                "Fitted by {} to the other recordings, the model follows those left out, over {over}, with a fit of {} in \
                 surge, {} in sway and {} in yaw rate.",
                score.name,
                fit(errors.fit_u),
                fit(errors.fit_v),
                fit(errors.fit_r)
            ));
        }
        if let Some(delivered) = self.delivered() {
            sentences.push(delivered);
        } else if let Some(errors) = self.searched.as_ref().and_then(SearchSummary::delivered_errors) {
            sentences.push(format!(
                "A structure found by a search follows recordings that were left out of the whole search with a fit of {}, {} and {}.",
                fit(errors.fit_u),
                fit(errors.fit_v),
                fit(errors.fit_r)
            ));
        }
        if let Some(study) = selection {
            sentences.push(format!(
                "Of models from {} sub-experiments, 90 % have an error norm below {} where the design picks them; picked at \
                 random the bound is {}.",
                study.summary.picks,
                study.q90(0),
                study.q90(1)
            ));
        }
        let degrees = || self.trust.iter().flat_map(|trust| &trust.degrees);
        let refused: Vec<String> = degrees().filter_map(|d| d.reason.clone()).collect();
        if !refused.is_empty() {
            sentences.push(format!("Not identifiable: {}.", listed(&refused)));
        }
        let unsure = |d: &&DegreeTrust| d.reason.is_none() && d.condition_index.is_none_or(|c| c > COLLINEAR);
        let collinear: Vec<String> = degrees().filter(unsure).map(|d| d.weakest.clone()).collect();
        if !collinear.is_empty() {
            sentences.push(format!("Use it for similar motion only: {}.", listed(&collinear)));
        }
        sentences.join(" ").replace('`', "")
    }

    /// Key figures.
    pub(super) fn cards(&self, selection: Option<&SelectionStudy>) -> Markup {
        let fits = |errors: FreeRunErrors, by: &str| {
            let all = [("surge", errors.fit_u), ("sway", errors.fit_v), ("yaw rate", errors.fit_r)];
            all.map(|(what, value)| card(&format!("Fit of {what}, left out"), fit(value), by, &[]))
        };
        html! {
            @if let Some((score, errors)) = self.judged() {
                @for card in fits(errors, &score.name.to_string()) { (card) }
            }
            @if let Some((search, errors)) = self.delivered_search() {
                @let name = match search.beside.as_ref().map(|beside| beside.delivered) {
                    Some(DeliveredKind::Average) => "average",
                    Some(DeliveredKind::Forces) => "forces",
                    _ => "search",
                };
                @for card in fits(errors, name) { (card) }
            }
            @if let Some(study) = selection { (selection_card(study)) }
            @if let Some(trust) = &self.trust {
                @let cut = format!("{} sub-experiments, {} samples", trust.parts, trust.samples);
                (card("Data", trust.sources, "recordings", &[cut]))
            }
        }
    }
}

/// Mean fit of the states that vary.
fn mean_fit(errors: &FreeRunErrors) -> String {
    let fits: Vec<f64> = errors.fits().into_iter().flatten().collect();
    fit((!fits.is_empty()).then(|| fits.iter().sum::<f64>() / fits.len() as f64))
}

fn selection_card(found: &SelectionStudy) -> Markup {
    let degenerate = |i: usize| {
        let share = |d: &SelectionScores| percent_within(d.degenerate_share, d.degenerate_share_interval);
        or_dash(found.summary.designs.get(i).map(share))
    };
    let others = [
        format!("{} random", found.q90(1)),
        format!("degenerate: {} against {}", degenerate(0), degenerate(1)),
    ];
    card("Error norm, 90 % quantile", found.q90(0), "optimized", &others)
}

/// The logs: per recording its rows, the consistency of its velocities, and its channels.
pub(super) fn logs(measured: &MeasuredStudy) -> Section {
    let body = match &measured.ingest {
        None => missing("The quality of the logs is", "ingest.json", "ingest"),
        Some(found) => html! {
            p {
                (found.recordings.len()) " recordings became " (found.runs) " runs, " (found.samples) " samples at "
                (three(found.sample_rate_hz)) " Hz"
                @if let Some(point) = &found.reference_point { "; reference point: " (point) }
                "."
            }
            (recordings(found))
            (left_out(found))
            (warnings(found))
            (motion(found))
            h3 { "Channels" }
            @for recording in &found.recordings { (channels(recording)) }
            p.note { "Noise: robust standard deviation of what a parabola through 11 neighbouring samples leaves." }
        },
    };
    Section::new("logs", "Logs", "Logs", body)
}

fn recordings(found: &IngestDocument) -> HtmlTable<&RecordingSummary> {
    HtmlTable::of(&found.recordings)
        .compact()
        .name("Recording", |r| &r.name)
        .number("Length [s]", |r| three(r.duration_s))
        .number("Samples", |r| r.samples)
        .number("Segments", |r| r.segments)
        .number("Too short", |r| r.short_segments)
        .number("Splits at gaps", |r| r.splits)
        .number("Rows", |r| r.rows.read)
        .number("Empty", |r| r.rows.empty)
        .number("Cut", |r| r.rows.cut)
        .number("Without, with repeated, with earlier time", |r| {
            format!("{}, {}, {}", r.rows.without_time, r.rows.repeated, r.rows.backwards)
        })
}

/// Values that were omitted from all recordings, and recordings that are not used for estimates by default.
fn left_out(found: &IngestDocument) -> Markup {
    let omitted = found.omitted();
    let doubtful = || found.recordings.iter().filter(|recording| !recording.doubtful.is_empty());
    let judged = || {
        let all = found.recordings.iter().map(|one| (&one.name, &one.contradicts, &one.unjudged));
        all.filter(|(_, against, unjudged)| against.is_some() || unjudged.is_some())
    };
    html! {
        @if !omitted.as_slice().is_empty() {
            h3 { "Values left out" }
            ul { @for one in omitted.as_slice() { li { (one.count) " of `" (one.channel) "` (" (display(one.reason)) ")" } } }
        }
        @if doubtful().next().is_some() {
            h3 { "Doubtful recordings" }
            ul { @for recording in doubtful() { li { (recording.name) ": " (recording.doubtful.join("; ")) } } }
        }
        @if judged().next().is_some() {
            h3 { "Recordings beside the others" }
            ul {
                @for (name, against, unjudged) in judged() {
                    @if let Some(why) = against { li { (name) " contradicts them: " (why) } }
                    @if let Some(why) = unjudged { li { (name) " cannot be judged: " (why) } }
                }
            }
        }
    }
}

/// Warnings about channels, with the recordings concerned.
fn warnings(found: &IngestDocument) -> Markup {
    let mut grouped: Vec<(&WarningSummary, Vec<&str>)> = Vec::new();
    for recording in &found.recordings {
        for warning in &recording.warnings {
            let same = |(known, _): &&mut (&WarningSummary, Vec<&str>)| {
                known.kind == warning.kind && known.channel == warning.channel
            };
            match grouped.iter_mut().find(same) {
                Some((_, recordings)) => recordings.push(&recording.name),
                None => grouped.push((warning, vec![&recording.name])),
            }
        }
    }
    html! { @if !grouped.is_empty() {
        h3 { "Warnings" }
        ul { @for (warning, recordings) in &grouped { li {
            (warning.text) " (" (recordings[0])
            @if recordings.len() > 1 { " and " (recordings.len() - 1) " more" }
            ")"
        } } }
    } }
}

fn motion(found: &IngestDocument) -> Markup {
    let states = grouped(&found.recordings, |r| &r.motion);
    if states.is_empty() {
        return html! {};
    }
    let table = HtmlTable::of(states)
        .compact()
        .mark("first", |(first, ..)| first)
        .name("Recording", |(first, r, _)| if first { r.name.as_str() } else { "" })
        .text("State", |(.., m)| display(m.state))
        .number("RMS difference", |(.., m)| three(m.rms))
        .number("Robust deviation", |(.., m)| three(m.robust_std))
        .number("Bias", |(.., m)| three(m.bias))
        .number("Lag [s]", |(.., m)| three_or_dash(m.lag_s));
    html! {
        h3 { "Logged velocities against position and heading" }
        (table)
        p.note { "In m/s; r in rad/s. A positive lag: the logged velocity comes after the motion." }
    }
}

fn channels(recording: &RecordingSummary) -> Markup {
    let table = HtmlTable::of(&recording.channels)
        .compact()
        .name("Channel", |c| &c.name)
        .text("Unit", |c| &c.unit)
        .number("Rate [Hz]", |c| three_or_dash(c.rate_hz))
        .number("Missing", |c| c.missing)
        .number("Gaps", |c| c.gaps)
        .number("Noise", |c| three_or_dash(c.noise))
        .number("Least", |c| three_or_dash(c.min))
        .number("Greatest", |c| three_or_dash(c.max));
    html! { details { summary { (recording.name) } (table) } }
}
