use maud::{Markup, html};

use super::number::{percent_within, three_or_dash, three_within};
use super::parts::{Section, missing};
use super::shown::{omission, shown};
use super::study::{Study, optimized_first};
use super::table::{Table, grouped};
use study::documents::{DesignDocument, EstimateDocument, MomentsDocument};

/// The excitation of every degree of freedom, and the nonstationarity of the maneuvers.
pub(super) fn excitation(study: &Study) -> Section {
    let conditions = match &study.estimate {
        Some(estimate) => conditioning(estimate),
        None => missing("Condition numbers are", "estimate.json", "estimate"),
    };
    let changes = match &study.moments {
        Some(moments) => nonstationarity(moments, study.design.as_ref()),
        None => missing("Nonstationarity is", "moments.json", "moments"),
    };
    let body = html! { div.pair { div { (conditions) } div { (changes) } } };
    Section::new("excitation", "Excitation", "Excitation", body)
}

fn conditioning(estimate: &EstimateDocument) -> Markup {
    let designs = optimized_first(&estimate.designs, |d| &d.design);
    let table = Table::of(grouped(designs, |d| &d.degrees))
        .compact()
        .mark("first", |(first, ..)| first)
        .name("Design", |(first, d, _)| if first { d.design.as_str() } else { "" })
        .text("Degree", |(.., degree)| &degree.name)
        .number("Condition, median", |(.., degree)| {
            three_within(degree.condition_median, degree.condition_median_interval)
        })
        .number("Largest", |(.., degree)| three_or_dash(degree.condition_max))
        .text("Weakest parameter, runs", |(.., degree)| {
            let share = percent_within(degree.weakest_share, degree.weakest_share_interval);
            format!("{}, {share}", degree.weakest_parameter)
        });
    html! {
        h3 { "Condition of the estimation" }
        (table)
        p.note { "Condition number of the column-scaled normal matrix; the weakest parameter dominates its weakest direction." }
    }
}

fn nonstationarity(MomentsDocument(moments): &MomentsDocument, design: Option<&DesignDocument>) -> Markup {
    let names = shown(moments.maneuvers.iter().map(|maneuver| maneuver.name.as_str()), design);
    let maneuvers = moments.maneuvers.iter().filter(|maneuver| names.contains(&maneuver.name.as_str()));
    let named = Table::of(maneuvers).compact().name("Maneuver", |maneuver| &maneuver.name);
    let table = moments.degrees.iter().fold(named, |table, degree| {
        table.number(&degree.name, |maneuver| {
            let own = maneuver.degrees.iter().find(|d| d.name == degree.name);
            three_or_dash(own.map(|d| d.nonstationarity))
        })
    });
    html! {
        h3 { "Nonstationarity of the maneuvers" }
        (table.number("Samples", |maneuver| maneuver.samples))
        (omission(moments.maneuvers.len(), names.len()))
        p.note {
            "Largest change of a moment between the first and the second half: 0 is stationary. Near 1 the moments hold for \
             the maneuver as a whole only, and a share that is run as a part of it gives other information."
        }
    }
}
