use maud::{Markup, html};

use super::missing::missing;
use super::number::{percent_within, three, three_or_dash, three_within};
use super::shown::{omission, shown};
use super::study::{Study, optimized_first};
use study::documents::{DesignDocument, EstimateDocument, MomentsDocument};

/// How well every degree of freedom was excited, and how far the maneuvers are from stationary.
pub(super) fn excitation(study: &Study) -> Markup {
    html! {
        section #excitation {
            h2 { "Excitation" }
            div.pair {
                div { @match &study.estimate {
                    Some(estimate) => (conditioning(estimate)),
                    None => (missing("Condition numbers are", "estimate.json", "estimate")),
                } }
                div { @match &study.moments {
                    Some(moments) => (nonstationarity(moments, study.design.as_ref())),
                    None => (missing("Nonstationarity is", "moments.json", "moments")),
                } }
            }
        }
    }
}

fn conditioning(estimate: &EstimateDocument) -> Markup {
    html! {
        h3 { "Condition of the estimation" }
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Design" } th scope="col" { "Degree" }
                th.number scope="col" { "Condition, median" } th.number scope="col" { "Largest" }
                th scope="col" { "Weakest parameter, runs" }
            } }
            tbody {
                @for design in optimized_first(&estimate.designs, |d| &d.design) {
                    @for (index, degree) in design.degrees.iter().enumerate() {
                        tr.first[index == 0] {
                            th scope="row" { @if index == 0 { (design.design) } }
                            td { (degree.name) }
                            td.number { (three_within(degree.condition_median, degree.condition_median_interval)) }
                            td.number { (three_or_dash(degree.condition_max)) }
                            td { (degree.weakest_parameter) ", " (percent_within(degree.weakest_share, degree.weakest_share_interval)) }
                        }
                    }
                }
            }
        } }
        p.note { "Condition number of the column-scaled normal matrix; the weakest parameter dominates its weakest direction." }
    }
}

fn nonstationarity(moments: &MomentsDocument, design: Option<&DesignDocument>) -> Markup {
    let names = shown(moments.maneuvers.iter().map(|maneuver| maneuver.name.as_str()), design);
    let maneuvers = moments.maneuvers.iter().filter(|maneuver| names.contains(&maneuver.name.as_str()));
    html! {
        h3 { "Nonstationarity of the maneuvers" }
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Maneuver" }
                @for degree in &moments.degrees { th.number scope="col" { (degree.name) } }
                th.number scope="col" { "Samples" }
            } }
            tbody { @for maneuver in maneuvers { tr {
                th scope="row" { (maneuver.name) }
                @for degree in &moments.degrees {
                    td.number { (maneuver.degrees.iter().find(|d| d.name == degree.name).map_or("–".to_owned(), |d| three(d.nonstationarity))) }
                }
                td.number { (maneuver.samples) }
            } } }
        } }
        (omission(moments.maneuvers.len(), names.len()))
        p.note {
            "Largest change of a moment between the first and the second half: 0 is stationary. Near 1 the moments hold for \
             the maneuver as a whole only, and a share that is run as a part of it gives other information."
        }
    }
}
