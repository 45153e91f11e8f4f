use maud::{Markup, display, html};
use study::documents::{
    Absent, ConstrainedParameter, Criticism, DegreeTrust, EstimatorScore, FoundNoise, LeftOutScores,
    SourceErrors, Suspect, Trust, Verdict,
};

use crate::measured::{MeasuredStudy, free_runs};
use crate::number::{
    fit, or_dash, percent, probability, three, three_or_dash, three_within, unit, windows_of,
};
use crate::parts::{HtmlTable, Section, coded, missing, statements};

/// The diagnostics of the pooled estimate.
pub(super) fn trust(measured: &MeasuredStudy) -> Section {
    let forces = measured.model.as_ref().and_then(|model| model.forces.as_ref());
    let criticism = forces.and_then(|forces| forces.criticism.as_ref());
    let body = match (&measured.trust, criticism) {
        (None, Some(found)) => html! { (statements(&found.statements)) (faults(found)) },
        (None, None) => missing("Trust is", "estimate.json", "estimate --fit together"),
        (Some(found), _) => html! {
            (about(found))
            (statements(&found.statements))
            @if let Some(criticism) = &found.criticism { (faults(criticism)) }
            (tests(found))
            @for degree in &found.degrees { (parameters(degree)) }
            @if !found.constrained.is_empty() { (constrained(&found.constrained)) }
            (runs(&found.runs))
        },
    };
    Section::new("trust", "Trust", "Trust in the estimate from all recordings", body)
}

/// The parameters that were fixed, tied or bounded.
fn constrained(all: &[ConstrainedParameter]) -> Markup {
    let how = |p: &ConstrainedParameter| match (&p.tied_to, p.factor) {
        (Some(to), Some(factor)) if factor != 1.0 => format!("{} times {to}", three(factor)),
        (Some(to), _) => format!("equal to {to}"),
        _ => "fixed".to_owned(),
    };
    let table = HtmlTable::of(all)
        .compact()
        .name("Parameter", |p| &p.name)
        .text("Term", |p| &p.term)
        .text("Unit", |p| unit(&p.unit))
        .text("Fixed or tied", how)
        .number("Value", |p| three_or_dash(p.estimate))
        .number("Standard error", |p| three_or_dash(p.standard_error));
    html! { h3 { "Parameters fixed or tied" } (table) }
}

fn about(found: &Trust) -> Markup {
    html! {
        p {
            "Estimator " (found.estimator) ", " (found.parts) " sub-experiments of " (found.sources) " recordings, "
            (found.samples) " samples; nominal model: " (found.nominal) "; mean removed: " (found.mean_removal)
            @if found.prior > 0.0 { "; prior of strength " (three(found.prior)) }
            "; standard errors with " (found.bandwidth) " lags"
            @if found.replicates > 0 { "; bootstrap of " (found.replicates) " resamples" }
            "."
        }
    }
}

fn tests(found: &Trust) -> Markup {
    let table = HtmlTable::of(&found.degrees)
        .compact()
        .name("Degree", |d| &d.name)
        .text("Status", |d| display(d.status))
        .text("By", |d| display(d.estimator))
        .number("Condition", |d| three_or_dash(d.condition))
        .number("Condition index", |d| three_or_dash(d.condition_index))
        .number("Instruments follow", |d| fit(d.instrument_fit))
        .number("Neighbouring residuals", |d| {
            three_or_dash(d.whiteness.as_ref().map(|w| w.first_autocorrelation))
        })
        .number("White, p", |d| or_dash(d.whiteness.as_ref().map(|w| probability(w.p_value))))
        .with(html! { th scope="col" { "Residual and instrument" } }, |d| match &d.instrument_residual {
            Some(c) => html! {
                td.wrap { (three(c.strongest)) " with " (c.instrument) " at lag " (c.lag) ", p " (probability(c.p_value)) }
            },
            None => html! { td { "–" } },
        });
    html! {
        (table)
        p.note {
            "Condition index of the terms and the intercept: near 1 they vary independently of each other, above 10 some of them \
             tend to go together, from 30 on the data cannot tell some apart. Condition: of their correlations alone, without \
             the intercept."
        }
        h3 { "Weakest directions" }
        ul { @for d in &found.degrees { li { (coded(&d.weakest)) } } }
    }
}

fn parameters(degree: &DegreeTrust) -> Markup {
    let mut table = HtmlTable::of(&degree.parameters)
        .compact()
        .name("Parameter", |p| &p.name)
        .text("Term", |p| &p.term)
        .text("Unit", |p| unit(&p.unit))
        .number("Estimate", |p| three_or_dash(p.estimate))
        .number("Standard error", |p| match p.at_bound {
            true => "at its bound".to_owned(),
            false => three_or_dash(p.standard_error),
        });
    if degree.parameters.iter().any(|p| p.bootstrap_std.is_some()) {
        table = table
            .number("Bootstrap", |p| three_or_dash(p.bootstrap_std))
            .number("2.5 %", |p| three_or_dash(p.bootstrap_low))
            .number("97.5 %", |p| three_or_dash(p.bootstrap_high));
    }
    table = table
        .number("Term varies", |p| percent(p.variation))
        .number("Partial R²", |p| three_or_dash(p.instrument_strength));
    html! {
        h3 { "Parameters of " (degree.name) @if degree.reason.is_some() { ": not identifiable" } }
        (table)
        @if let Some(entries) = &degree.correlation { (correlation(degree, entries)) }
    }
}

/// Correlations between the estimates, `entries` as many rows as parameters; none with those at a bound.
fn correlation(degree: &DegreeTrust, entries: &[f64]) -> Markup {
    let parameters = &degree.parameters;
    let rows = parameters.iter().zip(entries.chunks(parameters.len().max(1)));
    let named = HtmlTable::of(rows).compact().name("Correlation", |(p, _)| p.name.as_str());
    let table = parameters.iter().enumerate().fold(named, |table, (i, other)| {
        table.number(&other.name, |(p, row)| {
            let entry = row.get(i).filter(|_| !p.at_bound && !other.at_bound);
            or_dash(entry.map(|x| format!("{x:.2}").replace('-', "−")))
        })
    });
    let held: Vec<&str> = parameters.iter().filter(|p| p.at_bound).map(|p| p.name.as_str()).collect();
    html! {
        (table)
        @if !held.is_empty() { p.note { "A dash: " (held.join(", ")) " at its bound, which correlates with nothing." } }
    }
}

fn runs(runs: &[SourceErrors]) -> Markup {
    let named = HtmlTable::of(runs)
        .compact()
        .name("Recording", |run| &run.source)
        .number("Samples", |run| run.samples);
    html! {
        h3 { "Free simulation over every recording, itself part of the estimate" }
        (free_runs(named, |run| run.errors))
        @if runs.iter().any(|run| run.errors.is_none()) {
            p.note { "A dash: no whole model, or its simulation diverged." }
        }
    }
}

/// Number of candidates that are always shown.
const SHOWN: usize = 5;

/// The candidates: wrong signs, then the likeliest first; those without evidence are folded.
fn faults(found: &Criticism) -> Markup {
    let likely = found.absent.iter().take_while(|a| found.rejected && a.candidate).count();
    let (first, others) = found.absent.split_at(likely.max(SHOWN).min(found.absent.len()));
    let how = match found.units {
        Some(_) => {
            "Each sign is turned by itself, and the ship is fitted again. Then every candidate is added with a number of 0: its score is \
             what the fitted numbers cannot explain of the errors. Cost: by how much the candidate would lower it."
        }
        None => {
            "Score tests of whitened errors of what the model does not have, the likeliest first; values with standard errors as they \
             would be if it were added. Signs of channels: how many times as nominal values say they act."
        }
    };
    html! {
        h3 { "What is wrong with the model" }
        (candidates(found, first))
        @if !others.is_empty() {
            details {
                summary { (others.len()) " more candidates, for which these recordings speak less" }
                (candidates(found, others))
            }
        }
        p.note {
            (how) " p: how often any of all candidates would seem so likely in a right model. Seen from: the least that these recordings \
             would nearly always have shown."
            @if let Some(units) = found.units { " " (units) " windows, or pieces of them, count as independent." }
        }
        @if !found.hidden.is_empty() {
            p.note { "Not to be told from the model's own terms: " (coded(&found.hidden.join(", "))) "." }
        }
        @if found.noise_u.is_some() { (noise(found)) }
    }
}

fn candidates<'a>(found: &Criticism, absent: &'a [Absent]) -> HtmlTable<&'a Absent> {
    let mut table = HtmlTable::of(absent)
        .compact()
        .mark("main", |a| found.rejected && a.candidate)
        .name("Not in the model", |a| match (a.kind, a.share) {
            (Suspect::Term, _) => html! { code { (a.name) } },
            (Suspect::Late, Some(_)) => html! { code { (a.name) } " acts later by" },
            _ => coded(&a.name),
        })
        .text("Degree", |a| a.degree.as_deref().unwrap_or("all"))
        .number("If added", added)
        .text("Unit", |a| unit(&a.unit));
    if found.units.is_some() {
        table = table.number("Cost", |a| a.share.map_or("diverges".to_owned(), |share| percent(-share)));
    }
    table.number("p", |a| probability(a.p_value)).number("Seen from", |a| three_or_dash(a.visible_from))
}

/// `−0.400 ± 0.030`; north and east of a current; a dash of a sign for which the ship was fitted again.
fn added(absent: &Absent) -> String {
    let each = absent.value.iter().zip(&absent.standard_error);
    let each: Vec<String> =
        each.map(|(value, error)| format!("{} ± {}", three(*value), three(*error))).collect();
    or_dash(Some(each.join(", ")).filter(|values| !values.is_empty()))
}

/// The noise that the errors were whitened with: its kind, its levels, and by how much others are less likely.
fn noise(found: &Criticism) -> Markup {
    html! {
        p.note {
            "Noise " (if found.stated_noise { "stated" } else { "found" })
            @if let Some(noise) = &found.noise { ", " (noise.kind.words()) }
            ": u " (three_or_dash(found.noise_u)) " m/s, v " (three_or_dash(found.noise_v)) " m/s, r "
            (three_or_dash(found.noise_r)) " rad/s, current " (three_or_dash(found.current_std)) " m/s"
            @if let Some(time) = found.current_time_s { " changing within " (three(time)) " s" }
            @for drift in found.noise.iter().flat_map(|noise| &noise.drifts) {
                ", " (drift.of) " " (drift.state) " " (three(drift.std)) " " (drift.unit) " over " (three(drift.time_s)) " s"
            }
            "."
            @if let Some(noise) = &found.noise {
                " Noise and parameters were found in " (noise.turns) " turns"
                @if !noise.at_rest { ", without coming to rest" }
                "."
                @if !noise.others.is_empty() { " Less likely, in twice the log-likelihood: " (others(noise)) "." }
            }
        }
        @if found.verdict == Verdict::None {
            p.note {
                "No verdict: these errors follow no noise known here. What is missing, and standard errors, do not hold."
            }
        }
    }
}

fn others(noise: &FoundNoise) -> String {
    let each = noise.others.iter().map(|other| format!("{} by {}", other.kind.words(), three(other.below)));
    each.collect::<Vec<_>>().join(", ")
}

/// The estimators compared on recordings that were left out, and the recommended one recording by recording.
pub(super) fn cross_validation(measured: &MeasuredStudy) -> Section {
    let body = match &measured.left_out {
        None => missing("Cross-validation is", "estimate.json", "estimate --folds each"),
        Some(found) => html! {
            (about_folds(found))
            (statements(&found.statements))
            (estimators(found))
            @if let Some((score, _)) = measured.judged() { (sources(score)) }
        },
    };
    Section::new("cross-validation", "Cross-validation", "Cross-validation", body)
}

fn about_folds(found: &LeftOutScores) -> Markup {
    let windows = windows_of(found.window_s);
    html! {
        p {
            "Each of " (found.folds) " folds leaves recordings out, estimates from the others and simulates over those left \
             out: " (found.windows) " " (windows) ", " (found.samples) " samples. "
            @if found.forces {
                "Forces were fitted, with priors of weight " (three(found.prior))
            } @else {
                "Mean of the instruments removed: " (found.mean_removal) "; nominal model: " (found.nominal)
                @if found.prior > 0.0 { "; prior of strength " (three(found.prior)) }
            }
            ". Standard deviations of the states: " (three(found.std_u)) " m/s, " (three(found.std_v)) " m/s, "
            (three(found.std_r)) " rad/s."
        }
    }
}

fn estimators(found: &LeftOutScores) -> Markup {
    let recommended = |e: &EstimatorScore| found.recommended == Some(e.name);
    let named = HtmlTable::of(&found.estimators)
        .mark("main", |e| found.candidates.contains(&e.name))
        .name("Estimator", |e| html! { (e.name) @if recommended(e) { " (recommended)" } });
    let table = free_runs(named, |e| e.errors)
        .number("Error norm", |e| three_or_dash(e.error_norm))
        .number("Above the least", |e| {
            or_dash(found.difference(e.name).map(|d| three_within(d.median, Some(d.interval))))
        })
        .text("By instruments, folds", |e| e.by_instruments.map(|folds| folds.to_string()).join(", "))
        .text("Status", |e| display(e.status));
    html! {
        (table)
        p.note {
            "Above the least: how far the error norm of a recording lies above that by the estimator of least median norm, \
             median over the recordings with its 95 % interval; one that contains 0 tells no difference. "
            "By instruments: folds in which surge, sway and yaw were estimated with simulated instruments."
        }
    }
}

fn sources(score: &EstimatorScore) -> Markup {
    let (simulated, without): (Vec<_>, Vec<_>) = score.sources.iter().partition(|s| s.windows > 0);
    let named =
        HtmlTable::of(simulated).compact().name("Recording", |s| &s.source).number("Windows", |s| s.windows);
    html! {
        h3 { "Recordings left out, " (score.name) }
        (free_runs(named, |s| s.errors))
        p.note {
            "Fits of a recording are against the standard deviations of its own states: a state that hardly varies in it has \
             a low fit whatever the error."
            @if !without.is_empty() { " " (without.len()) " recordings are shorter than a window." }
        }
    }
}
