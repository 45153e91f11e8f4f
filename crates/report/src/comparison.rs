use maud::{Markup, html};

use super::missing::missing;
use super::number::{exact, percent, published, three_or_dash};
use super::study::Study;
use study::documents::{Bounds, DesignScores, Published, PublishedShare, Reference};

/// Our shares under the bounds, quantiles and failures per design, beside the published shares.
pub(super) fn comparison(study: &Study) -> Markup {
    html! {
        section #comparison {
            h2 { @if study.reference.is_some() { "Result beside the published one" } @else { "Result" } }
            @match &study.validation {
                Some(validation) => (table(&study.scored(), validation.bounds, study.reference.as_ref())),
                None => (missing("The comparison of designs is", "validation.json", "validate")),
            }
            @if let Some(reference) = &study.reference {
                p.note { "Published: " (reference.source) ". Published numbers are shown for comparison and used for nothing else." }
            }
        }
    }
}

fn table(scored: &[&DesignScores], bounds: Bounds, reference: Option<&Reference>) -> Markup {
    let of = |design: &str| reference.and_then(|r| r.designs.get(design));
    html! {
        div.scroll { table {
            thead { tr {
                th scope="col" { "" }
                @for d in scored { th.number scope="col" { (d.design) } @if reference.is_some() { th.number.published scope="col" { "published" } } }
            } }
            tbody {
                (share_row(&format!("Runs with parameter error below {}", exact(bounds.parameter_error)), scored, reference.is_some(),
                    |d| d.parameter_error_share, |d| of(d).map(|p| p.parameter_error_share)))
                (share_row(&format!("Runs with simulation error below {}", exact(bounds.simulation_error)), scored, reference.is_some(),
                    |d| d.simulation_error_share, |d| of(d).map(|p: &Published| p.simulation_error_share)))
                (plain_row("Parameter error, median", scored, reference.is_some(), |d| three_or_dash(d.parameter_error.median)))
                (plain_row("Parameter error, 90 % quantile", scored, reference.is_some(), |d| three_or_dash(d.parameter_error.q90)))
                (plain_row("Simulation error, median", scored, reference.is_some(), |d| three_or_dash(d.simulation_error.median)))
                (plain_row("Simulation error, 90 % quantile", scored, reference.is_some(), |d| three_or_dash(d.simulation_error.q90)))
                (plain_row("RMSE in surge, median [m/s]", scored, reference.is_some(), |d| three_or_dash(d.rmse_u.median)))
                (plain_row("RMSE in sway, median [m/s]", scored, reference.is_some(), |d| three_or_dash(d.rmse_v.median)))
                (plain_row("RMSE in yaw rate, median [rad/s]", scored, reference.is_some(), |d| three_or_dash(d.rmse_r.median)))
                (plain_row("Runs", scored, reference.is_some(), |d| d.runs.to_string()))
                (plain_row("Free simulation diverged", scored, reference.is_some(), |d| d.diverged.to_string()))
                (plain_row("Not identifiable", scored, reference.is_some(), |d| d.not_identifiable.to_string()))
            }
        } }
        p.note { "A run without an estimate, or whose free simulation diverged, counts as above every bound and as infinite in the quantiles (a dash)." }
    }
}

fn share_row(
    label: &str,
    scored: &[&DesignScores],
    with_published: bool,
    ours: impl Fn(&DesignScores) -> f64,
    theirs: impl Fn(&str) -> Option<PublishedShare>,
) -> Markup {
    html! { tr.main {
        th scope="row" { (label) }
        @for d in scored {
            td.number { (percent(ours(d))) }
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

fn printed(share: Option<PublishedShare>) -> String {
    match share {
        Some(PublishedShare::Value(share)) => published(share),
        Some(PublishedShare::Above { above }) => format!(">\u{a0}{}", published(above)),
        None => "–".to_owned(),
    }
}
