use maud::{Markup, html};
use report_figures::{AccuracyCurve, FigureError, accuracy};

use super::figures::Figures;
use super::number::{percent, three, three_or_dash};
use crate::documents::{ArmSummary, SequentialDocument};

/// What the arms of the figure are called.
const LABELS: [(&str, &str); 4] = [
    ("sequential", "designed in rounds"),
    ("one-shot", "designed once"),
    ("informed", "designed from the truth"),
    ("random", "random"),
];

/// Trials designed in rounds beside trials designed once.
pub(super) fn sequential(found: &SequentialDocument, figures: &mut Figures) -> Result<Markup, FigureError> {
    let curves: Vec<AccuracyCurve> = found.arms.iter().map(curve).collect();
    let stop = found.stopping.mean_time_s.unwrap_or(found.duration_s);
    let figure = accuracy(&curves, (stop, found.accuracy), "median parameter error [1]");
    Ok(html! {
        section #sequential {
            h2 { "Designed in rounds" }
            p {
                (found.realizations) " realizations of " (three(found.duration_s)) " s in " (found.rounds) " rounds. Every \
                 realization begins with a model of its own, whose parameters are off by a factor of e to the "
                (three(found.nominal_spread)) " times a standard normal number."
            }
            @for statement in &found.statements { p { (statement) "." } }
            (figures.place("sequential", figure, &html! {
                b { "Median parameter error against sea time." }
                " The dot is the wanted accuracy, " (three(found.accuracy)) ", and the mean time at which trials designed in \
                 rounds predict that they have reached it."
            })?)
            (table(found))
        }
    })
}

fn curve(arm: &ArmSummary) -> AccuracyCurve<'static> {
    let label = LABELS.iter().find(|(name, _)| *name == arm.name).map_or("other", |(_, label)| *label);
    let points = arm.points.iter().filter_map(|point| Some((point.time_s, point.median?))).collect();
    AccuracyCurve { label, points }
}

fn table(found: &SequentialDocument) -> Markup {
    html! {
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Design" }
                @for title in ["Time [s]", "Median error", "90 % quantile", "Predicted", "Within the accuracy", "No estimate", "No design"] {
                    th.number scope="col" { (title) }
                }
            } }
            tbody { @for arm in &found.arms {
                @for (i, point) in arm.points.iter().enumerate() { tr.first[i == 0] {
                    th scope="row" { @if i == 0 { (arm.name) } }
                    td.number { (three(point.time_s)) }
                    td.number { (three_or_dash(point.median)) } td.number { (three_or_dash(point.q90)) }
                    td.number { (three_or_dash(point.predicted)) } td.number { (percent(point.within)) }
                    td.number { (point.failed) } td.number { (point.undesigned) }
                } }
            } }
        } }
        p.note { "Error: 2-norm over the parameters of (estimate − truth)/truth; predicted: of standard error over estimate." }
    }
}
