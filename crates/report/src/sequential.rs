use crate::figures::{AccuracyCurve, accuracy};
use maud::{Markup, html};

use super::headline::capital;
use super::number::{exact, percent, three, three_or_dash};
use super::placed::{Figures, Section};
use study::documents::SequentialDocument;
use trial::rounds::{Arm, ArmPoint, ArmSummary, RoundGain, Stopping};
use vessel::Source;

/// Trials designed in rounds beside trials designed once: at equal time, and when they stop.
pub(super) fn sequential(found: &SequentialDocument, figures: &mut Figures) -> Vec<Section> {
    let (stops, compares) = match found.statements.split_last() {
        Some((last, others)) => (std::slice::from_ref(last), others),
        None => (&[][..], &[][..]),
    };
    let compared = section(
        "rounds",
        "At equal time",
        html! {
            (about(found))
            (sentences(compares))
            (figure(found, figures))
            (gains(&found.gains))
            (errors(found))
        },
    );
    let stopped = section("stopping", "When to stop", html! { (sentences(stops)) (stopping(found)) });
    vec![compared, stopped]
}

fn section(id: &'static str, title: &'static str, content: Markup) -> Section {
    (id, title, html! { section id=(id) { h2 { (title) } (content) } })
}

fn sentences(statements: &[String]) -> Markup {
    html! { @for said in statements { p { (capital(said)) "." } } }
}

/// What an arm is called.
fn label(arm: Arm) -> &'static str {
    match arm {
        Arm::Sequential => "in rounds",
        Arm::OneShot => "one-shot",
        Arm::Informed => "from the truth",
        Arm::Random => "random",
    }
}

fn about(found: &SequentialDocument) -> Markup {
    let about = if found.crude_about == Source::Nominal { "nominal" } else { "true" };
    html! {
        p {
            (found.realizations) " realizations of " (exact(found.duration_s)) "\u{a0}s in " (found.rounds) " rounds, "
            (found.maneuvers) " candidate maneuvers. Each trial starts from a crude model: the " (about)
            " parameters, each multiplied by exp(" (exact(found.nominal_spread)) "\u{a0}z) with z standard normal. A trial in rounds \
             is one continuous run: after every round the model is estimated again from everything sailed so far (output error), \
             and the next round is designed with it. The one-shot trial is designed with the crude model and laid out \
             for the time that it takes, the one from the truth (which nobody knows) likewise. All meet the same disturbances."
        }
    }
}

fn figure(found: &SequentialDocument, figures: &mut Figures) -> Markup {
    let curves: Vec<AccuracyCurve> = found.arms.iter().map(curve).collect();
    let stop = found.stopping.first().map_or(found.duration_s, |s| s.mean_time_s);
    let figure = accuracy(&curves, (stop, found.accuracy), "median parameter error [1]");
    figures.place("rounds", figure, &html! {
        b { "Median parameter error against time at sea." }
        " The dot is the wanted accuracy, " (exact(found.accuracy)) ", and the mean time after which trials in rounds stop."
    })
}

fn curve(arm: &ArmSummary) -> AccuracyCurve<'static> {
    let points = arm.points.iter().filter_map(|point| Some((point.time_s, point.median?))).collect();
    AccuracyCurve { label: label(arm.name), points }
}

fn head(first: &str, titles: &[&str]) -> Markup {
    html! { thead { tr { th scope="col" { (first) } @for title in titles { th.number scope="col" { (title) } } } } }
}

fn gains(gains: &[RoundGain]) -> Markup {
    html! {
        div.scroll { table.compact {
            (head("Time [s]", &["Error in rounds / one-shot", "95 % interval", "Realizations"]))
            tbody { @for gain in gains { tr {
                th scope="row" { (three(gain.time_s)) }
                td.number { (three_or_dash(gain.ratio)) }
                td.number { (three_or_dash(gain.low)) " to " (three_or_dash(gain.high)) }
                td.number { (gain.pairs) }
            } } }
        } }
        p.note { "Geometric mean over the realizations in which both have an estimate. The first round is the same for both." }
    }
}

fn errors(found: &SequentialDocument) -> Markup {
    let titles = [
        "Time [s]",
        "Median error",
        "90 % quantile",
        "Predicted",
        "Within the accuracy",
        "Not converged",
        "Not identifiable",
        "Diverged",
        "No design",
    ];
    html! {
        div.scroll { table.compact {
            (head("Design", &titles))
            tbody { @for arm in &found.arms {
                @for (i, point) in arm.points.iter().enumerate() { tr.first[i == 0] {
                    th scope="row" { @if i == 0 { (label(arm.name)) } }
                    (point_cells(point))
                } }
            } }
        } }
        p.note {
            "Error: 2-norm over the parameters of (estimate − truth)/truth; a trial without an estimate counts as infinite. \
             Predicted: median of what estimates say of themselves, standard error over parameter."
        }
    }
}

fn point_cells(point: &ArmPoint) -> Markup {
    html! {
        td.number { (three(point.time_s)) }
        td.number { (three_or_dash(point.median)) } td.number { (three_or_dash(point.q90)) }
        td.number { (three_or_dash(point.predicted)) } td.number { (percent(point.within)) }
        td.number { (point.not_converged) } td.number { (point.not_identifiable) }
        td.number { (point.diverged) } td.number { (point.undesigned) }
    }
}

fn stopping(found: &SequentialDocument) -> Markup {
    let titles = [
        "Promised in time",
        "Mean time [s]",
        "Median error at the end",
        "Within the accuracy",
        "Of those promised",
        "RMS error / accuracy",
        "No estimate",
    ];
    let cells = |s: &Stopping| {
        html! {
            th scope="row" { (label(s.arm)) }
            td.number { (s.stopped) } td.number { (three(s.mean_time_s)) }
            td.number { (three_or_dash(s.median_error)) } td.number { (percent(s.within)) }
            td.number { (percent(s.within_stopped.unwrap_or(f64::NAN))) }
            td.number { (three_or_dash(s.rms_over_accuracy)) } td.number { (s.without_estimate) }
        }
    };
    html! {
        div.scroll { table.compact {
            (head("Trial", &titles))
            tbody { @for s in &found.stopping { tr { (cells(s)) } } }
        } }
        p.note {
            "A trial ends with the first round after which an error of " (exact(found.accuracy)) " is promised, or else after \
             the whole time: in rounds the estimate promises it, by its standard errors over the parameters known by then; a \
             one-shot trial is sized before it sails, by the standard errors that the crude model expects. The last three \
             columns are of trials that were promised it; a root mean square error at most the accuracy keeps the promise."
        }
    }
}
