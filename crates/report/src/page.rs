use maud::{DOCTYPE, Markup, PreEscaped, Render, display, html};

use crate::allocation::{allocation, certificate};
use crate::compared::compared;
use crate::comparison::{comparison, errors, published_selection};
use crate::delivered::delivered;
use crate::dictionary::{dictionary, excitation};
use crate::estimators::{estimators, parameters};
use crate::headline::{headline, kind};
use crate::interactive::{Panel, scripts, styles};
use crate::measured::{MeasuredStudy, logs};
use crate::merit::merit;
use crate::next_trial::next_trial;
use crate::number::{median, or_dash, percent, q90};
use crate::parts::{Figures, HtmlTable, Section, entry, statements};
use crate::searched::searched;
use crate::selection::selection;
use crate::sequential::sequential;
use crate::study::{Study, optimized_first};
use crate::trajectory::{self, trajectory};
use crate::trust::{cross_validation, trust};

/// The page and its figures.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// One self-contained HTML document.
    pub html: String,
    /// File name (`shares.svg`) and SVG text of every figure, in the order of the page.
    pub figures: Vec<(String, String)>,
}

const STYLE: &str = include_str!("style.css");

/// Renders the page, which names the results that `study` lacks.
pub fn render(study: &Study) -> Rendered {
    let mut figures = Figures::default();
    let mut sections = match (&study.measured, &study.sequential, &study.design) {
        (Some(measured), ..) => of_logs(study, measured, &mut figures),
        (None, Some(rounds), None) => sequential(rounds, &mut figures),
        _ => of_trials(study, &mut figures),
    };
    sections.extend([notation(study), files(study)]);
    let html = document(study, &sections, &figures.panels).into_string();
    Rendered { html, figures: figures.files }
}

/// The sections of a study of simulated trials: the plan on its chart, the ship's figures, the errors, then statistics.
fn of_trials(study: &Study, figures: &mut Figures) -> Vec<Section> {
    let mut sections: Vec<Section> = trajectory(study, figures).into_iter().collect();
    sections.extend(merit(study, figures));
    sections.extend([errors(study, figures), comparison(study), parameters(study, figures)]);
    sections.extend(realizations(study));
    sections.extend(estimators(study));
    sections.extend([allocation(study, figures), certificate(study), dictionary(study, figures)]);
    sections.extend(selection(study.selection.as_ref(), figures));
    sections.extend(published_selection(study, figures));
    sections.push(excitation(study));
    sections
}

/// The sections of a study of measured logs: the ship's figures, her model, the next trial, then how it was found.
fn of_logs(study: &Study, measured: &MeasuredStudy, figures: &mut Figures) -> Vec<Section> {
    let mut sections: Vec<Section> = merit(study, figures).into_iter().collect();
    sections.extend(compared(measured.compared.as_ref(), figures));
    sections.push(delivered(measured));
    if let Some(next) = &measured.next {
        let sailed = next.planned.as_ref().map(|planned| trajectory::planned(study, planned, figures));
        sections.push(next_trial(next, sailed));
    }
    sections.extend(searched(measured.searched.as_ref(), figures));
    let is_searched = measured.searched.is_some();
    sections.extend((measured.left_out.is_some() || !is_searched).then(|| cross_validation(measured)));
    sections.extend((measured.is_judged() || !is_searched).then(|| trust(measured)));
    sections.extend(selection(study.selection.as_ref(), figures));
    sections.extend(published_selection(study, figures));
    if study.design.is_some() {
        sections.extend([allocation(study, figures), certificate(study)]);
    }
    if study.dictionary.is_some() {
        sections.push(dictionary(study, figures));
    }
    sections.push(logs(measured));
    sections
}

/// No request leaves the page: the browser refuses all but what stands in it.
const POLICY: &str =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";

fn document(study: &Study, sections: &[Section], panels: &[Panel]) -> Markup {
    let next = study.measured.as_ref().and_then(|measured| measured.next.as_ref());
    let planned = study.trajectory.is_some() || next.is_some_and(|next| next.planned.is_some());
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (study.name) " – " (kind(study)) }
                style { (PreEscaped(STYLE)) @if planned { (PreEscaped(trajectory::STYLE)) } }
                (styles(panels))
            }
            body {
                main {
                    (headline(study))
                    nav aria-label="Contents" { @for s in sections { a href={ "#" (s.id) } { (s.title) } } }
                    @for s in sections { (s.content) }
                }
                (scripts(panels))
            }
        }
    }
}

/// Statistics of many realizations in memory, by design and estimator, unless they are those of the validation.
fn realizations(study: &Study) -> Option<Section> {
    let counts = study.counted.as_ref()?;
    let counted: u64 = counts.tally.counted.iter().map(|counted| counted.runs).sum();
    if counts.scores.len() < 2 && study.scored().iter().map(|design| design.runs).sum::<u64>() == counted {
        return None;
    }
    let rows = counts.scores.iter().flat_map(|by| {
        optimized_first(&by.designs, |d| &d.design).into_iter().map(|scores| (by.estimator, scores))
    });
    let share = |share: f64, interval: Option<[f64; 2]>| {
        let half = |[low, high]: [f64; 2]| 50.0 * (high - low);
        or_dash(interval.map(|ends| format!("{:.2} ± {:.2} %", 100.0 * share, half(ends))))
    };
    let table = HtmlTable::of(rows)
        .compact()
        .name("Design", |(_, d)| d.design.as_str())
        .text("Estimator", |(estimator, _)| display(estimator))
        .number("Runs", |(_, d)| d.runs)
        .number("Parameter error below its bound", |(_, d)| {
            share(d.parameter_error_share, d.parameter_error_share_interval)
        })
        .number("Median", |(_, d)| median(&d.parameter_error))
        .number("90 %", |(_, d)| q90(&d.parameter_error))
        .number("Simulation error below its bound", |(_, d)| {
            share(d.simulation_error_share, d.simulation_error_share_interval)
        })
        .number("Diverged", |(_, d)| d.diverged)
        .number("Not identifiable", |(_, d)| d.not_identifiable);
    let body = html! {
        (table)
        (statements(&counts.statements))
        p.note {
            "Estimated and scored as soon as they are simulated (" code { "monte-carlo" } "), seed " (counts.seed)
            ". After ±: half of the 95 % interval (Wilson's). Quantiles are read from histograms, to "
            (percent(counts.quantile_error)) "."
        }
    };
    Some(Section::new("realizations", "Realizations", "Many realizations", body))
}

/// The notation.
fn notation(study: &Study) -> Section {
    let body = if study.measured.is_some() { notes_of_logs() } else { notes_of_trials() };
    let states = entry(
        "u, v, r",
        "Surge and sway speed [m/s] and yaw rate [rad/s]; axes x forward, y starboard, z down.",
    );
    Section::new("notation", "Notation", "Notation", html! { dl.names { (body) (states) } })
}

fn notes_of_trials() -> Markup {
    html! {
        (entry("Share", html! { var { "w" sub { "q" } } " = " var { "N" sub { "q" } } "/" var { "N" } ": part of the experiment's samples that maneuver " var { "q" } " gets." }))
        (entry("Sensitivity", html! { var { "g" sub { "q" } } " = Σ" sub { "d" } " tr(" var { "M" sub { "d" } } "(" var { "w" } ")⁻¹ " var { "M" sub { "d,q" } } "), summed over the degrees of freedom. At the optimum no maneuver exceeds " var { "p" } ", the total dimension." }))
        (entry("Gap", html! { "max" sub { "q" } " " var { "g" sub { "q" } } " − " var { "p" } ", after Kiefer and Wolfowitz; relative gap: divided by " var { "p" } "." }))
        (entry("Efficiency", html! { "|det Γ(" var { "w" } ")/det Γ(" var { "w" } "*)|" sup { "1/n" } " with n parameters: the fraction of the experiment time that the optimal shares would need for the same information." }))
        (entry("Parameter error", "2-norm over the parameters of (estimate − truth)/truth, one value per run."))
        (entry("Simulation error", "2-norm of the root mean square errors in surge [m/s], sway [m/s] and yaw rate [rad/s] of the freely simulated model against the true one."))
        (entry("Run, realization", "One experiment, simulated with its own disturbances and estimated on its own."))
    }
}

fn notes_of_logs() -> Markup {
    html! {
        (entry("Fit", "100 (1 − RMSE/std) in percent, of a free simulation that starts at a measured state: 100 is perfect, 0 as good as the mean of the data."))
        (entry("Error norm", "2-norm over surge, sway and yaw rate of RMSE/std; √3 is as bad as the mean of the data."))
        (entry("Recording, sub-experiment", "What was logged in one go, and what it was cut into. Recordings are left out whole."))
        (entry("Condition index", "Square root of the condition number of the normal matrix with the intercept, columns scaled, means left in; from 30 on collinear (Belsley, Kuh and Welsch)."))
        (entry("Standard error", "Sandwich covariance with autocorrelation (Newey and West); of output-error by how much the estimate changes where a sub-experiment is left out (jackknife)."))
        (entry("Partial R²", "How much of a term its instruments tell beyond what they tell of the others (Shea): 1 least squares, near 0 lost."))
        (entry("Whiteness", "Ljung and Box's test: probability of a larger statistic if the residuals were white."))
    }
}

/// The sources of the numbers.
fn files(study: &Study) -> Section {
    let body = match study.files.as_slice() {
        [] => html! { p.missing { "No file was read." } },
        files => HtmlTable::of(files)
            .compact()
            .name("File", |(name, ..)| name)
            .with(html! { th scope="col" { "What it is" } }, |(_, what, _)| html! { td.wrap { (what) } })
            .with(html! { th scope="col" { "Digest" } }, |(.., digest)| html! { td.digest { (digest) } })
            .render(),
    };
    Section::new("files", "Files", "Files", body)
}
