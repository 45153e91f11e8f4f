use maud::{Markup, html};

use crate::number::{exact, median, parameter_share, q90, simulation_share, three_or_dash};
use crate::parts::missing;
use crate::study::{Study, Trajectory, optimized_first};
use crate::table::Table;
use study::documents::{Bounds, DesignScores, DesignSummary, ParameterSummary};

/// The planned experiment compared with the others: errors of the models that are estimated from it.
pub(super) fn trials(study: &Study, trajectory: &Trajectory) -> Markup {
    html! {
        h3 { "The plan as an experiment" }
        @match &trajectory.validation {
            Some(planned) => {
                (compared(study, trajectory))
                (bounds_note(study.validation.as_ref().map(|v| v.bounds), planned.bounds))
                (table(study, planned.bounds, &planned.designs))
                @if study.validation.is_none() { (missing("The designs to compare with are", "validation.json", "validate")) }
            }
            None => (missing("The errors of models estimated from the planned trial are", "planned/validation.json", "validate")),
        }
        @match &trajectory.estimate {
            Some(planned) => (spreads(study, &planned.designs)),
            None => (missing("The spread of the estimates from the planned trial is", "planned/estimate.json", "estimate")),
        }
    }
}

/// Says what is compared, and what is not.
fn compared(study: &Study, trajectory: &Trajectory) -> Markup {
    let voyage = trajectory.main.as_ref().and_then(|main| main.plan.voyage.as_ref());
    html! {
        p {
            "The planned experiment is the whole trial"
            @if let Some(voyage) = voyage { " of " (exact(voyage.duration_s)) "\u{a0}s, " (exact(voyage.informative_s)) "\u{a0}s of it in maneuvers" }
            ": it also contains the legs between the maneuvers, while the other experiments"
            @if let Some(length) = study.experiment_s { " of " (exact(length)) "\u{a0}s" }
            " consist of maneuvers alone and know no chart, so its row says what the trial tells as a whole and not that its maneuvers are better chosen."
        }
    }
}

fn bounds_note(others: Option<Bounds>, planned: Bounds) -> Markup {
    let same = |b: &Bounds| {
        b.parameter_error == planned.parameter_error && b.simulation_error == planned.simulation_error
    };
    html! {
        @if let Some(others) = others.filter(|b| !same(b)) {
            p.missing {
                "Shares are not comparable: the planned trial is counted against the bounds " (exact(planned.parameter_error)) " and "
                (exact(planned.simulation_error)) ", the others against " (exact(others.parameter_error)) " and "
                (exact(others.simulation_error)) "."
            }
        }
    }
}

fn table(study: &Study, bounds: Bounds, planned: &[DesignScores]) -> Markup {
    html! {
        div.scroll { table {
            thead {
                tr {
                    th scope="col" rowspan="2" { "Design" }
                    th.number scope="col" rowspan="2" { "Runs" }
                    th.number.spanned scope="col" colspan="3" { "Parameter error" }
                    th.number.spanned scope="col" colspan="3" { "Simulation error" }
                    th.number scope="col" rowspan="2" { "Without" br; "a value" }
                }
                tr {
                    th.number scope="col" { "below " (exact(bounds.parameter_error)) }
                    th.number scope="col" { "median" }
                    th.number scope="col" { "90\u{a0}%" }
                    th.number scope="col" { "below " (exact(bounds.simulation_error)) }
                    th.number scope="col" { "median" }
                    th.number scope="col" { "90\u{a0}%" }
                }
            }
            tbody {
                @for scores in study.scored() { (row(scores, false)) }
                @for scores in planned { (row(scores, true)) }
            }
        } }
        p.note { "Quantiles over the runs. Without a value: not identifiable, or the free simulation diverged; such a run counts as above every bound." }
    }
}

fn row(scores: &DesignScores, planned: bool) -> Markup {
    html! {
        tr.main[planned] {
            th scope="row" { (scores.design) }
            td.number { (scores.runs) }
            td.number { (parameter_share(scores)) }
            td.number { (median(&scores.parameter_error)) }
            td.number { (q90(&scores.parameter_error)) }
            td.number { (simulation_share(scores)) }
            td.number { (median(&scores.simulation_error)) }
            td.number { (q90(&scores.simulation_error)) }
            td.number { (scores.not_identifiable + scores.diverged) }
        }
    }
}

/// Spread of every estimate over its true value, per design.
fn spreads(study: &Study, planned: &[DesignSummary]) -> Markup {
    let others = study.estimate.iter().flat_map(|e| optimized_first(&e.designs, |d| &d.design));
    let designs: Vec<&DesignSummary> = others.chain(planned).collect();
    let known = |p: &&ParameterSummary| p.relative_spread.is_some();
    let parameters: Vec<&ParameterSummary> =
        planned.first().into_iter().flat_map(|d| &d.parameters).filter(known).collect();
    if parameters.is_empty() {
        return html! {};
    }
    let named = Table::of(parameters).class("compact few").name("Relative spread", |p| &p.name);
    let table = designs.iter().fold(named, |table, design| {
        table.number(&design.design, |p| {
            let own = design.parameters.iter().find(|own| own.name == p.name);
            three_or_dash(own.and_then(|own| own.relative_spread))
        })
    });
    html! {
        (table)
        p.note { "Relative spread: standard deviation of the estimate over the identified runs, divided by the modulus of the true value." }
    }
}
