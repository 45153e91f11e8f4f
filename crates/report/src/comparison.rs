use maud::{Markup, html};

use super::missing::missing;
use super::number::{exact, percent_within, published, three_within};
use super::sample::{INTERVALS, drawn_from};
use super::study::Study;
use study::documents::{DesignScores, Published, PublishedShare, Quantiles, Reference, ValidationDocument};

/// Our shares under the bounds, quantiles and failures per design, beside the published shares.
pub(super) fn comparison(study: &Study) -> Markup {
    html! {
        section #comparison {
            h2 { @if study.reference.is_some() { "Result beside the published one" } @else { "Result" } }
            @match &study.validation {
                Some(validation) => (table(&study.scored(), validation, study.reference.as_ref())),
                None => (missing("The comparison of designs is", "validation.json", "validate")),
            }
            @if let Some(reference) = &study.reference {
                p.note { "Published: " (reference.source) ". Published numbers are shown for comparison and used for nothing else." }
            }
        }
    }
}

fn table(scored: &[&DesignScores], validation: &ValidationDocument, reference: Option<&Reference>) -> Markup {
    let bounds = validation.bounds;
    let of = |design: &str| reference.and_then(|r| r.designs.get(design));
    html! {
        div.scroll { table {
            thead { tr {
                th scope="col" { "" }
                @for d in scored { th.number scope="col" { (d.design) } @if reference.is_some() { th.number.published scope="col" { "published" } } }
            } }
            tbody {
                (share_row(&format!("Runs with parameter error below {}", exact(bounds.parameter_error)), scored, reference.is_some(),
                    |d| percent_within(d.parameter_error_share, d.parameter_error_share_interval), |d| of(d).map(|p| p.parameter_error_share)))
                (share_row(&format!("Runs with simulation error below {}", exact(bounds.simulation_error)), scored, reference.is_some(),
                    |d| percent_within(d.simulation_error_share, d.simulation_error_share_interval), |d| of(d).map(|p: &Published| p.simulation_error_share)))
                (plain_row("Parameter error, median", scored, reference.is_some(), |d| median(&d.parameter_error)))
                (plain_row("Parameter error, 90 % quantile", scored, reference.is_some(), |d| q90(&d.parameter_error)))
                (plain_row("Simulation error, median", scored, reference.is_some(), |d| median(&d.simulation_error)))
                (plain_row("Simulation error, 90 % quantile", scored, reference.is_some(), |d| q90(&d.simulation_error)))
                (plain_row("RMSE in surge, median [m/s]", scored, reference.is_some(), |d| median(&d.rmse_u)))
                (plain_row("RMSE in sway, median [m/s]", scored, reference.is_some(), |d| median(&d.rmse_v)))
                (plain_row("RMSE in yaw rate, median [rad/s]", scored, reference.is_some(), |d| median(&d.rmse_r)))
                (plain_row("Runs", scored, reference.is_some(), |d| d.runs.to_string()))
                (plain_row("Free simulation diverged", scored, reference.is_some(), |d| d.diverged.to_string()))
                (plain_row("Not identifiable", scored, reference.is_some(), |d| d.not_identifiable.to_string()))
            }
        } }
        p.note { "A run without an estimate, or whose free simulation diverged, counts as above every bound and as infinite in the quantiles (a dash). " (drawn_from(validation)) ". " (INTERVALS) }
    }
}

fn share_row(
    label: &str,
    scored: &[&DesignScores],
    with_published: bool,
    ours: impl Fn(&DesignScores) -> String,
    theirs: impl Fn(&str) -> Option<PublishedShare>,
) -> Markup {
    html! { tr.main {
        th scope="row" { (label) }
        @for d in scored {
            td.number { (ours(d)) }
            @if with_published { td.number.published { (printed(theirs(&d.design))) } }
        }
    } }
}

fn plain_row(
    label: &str,
    scored: &[&DesignScores],
    with_published: bool,
    cell: impl Fn(&DesignScores) -> String,
) -> Markup {
    html! { tr {
        th scope="row" { (label) }
        @for d in scored {
            td.number { (cell(d)) }
            @if with_published { td.number.published { "–" } }
        }
    } }
}

fn median(errors: &Quantiles) -> String {
    three_within(errors.median, errors.median_interval)
}

fn q90(errors: &Quantiles) -> String {
    three_within(errors.q90, errors.q90_interval)
}

fn printed(share: Option<PublishedShare>) -> String {
    match share {
        Some(PublishedShare::Value(share)) => published(share),
        Some(PublishedShare::Above { above }) => format!(">\u{a0}{}", published(above)),
        None => "–".to_owned(),
    }
}
