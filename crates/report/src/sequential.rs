use maud::{Markup, html};
use study::documents::{Arm, ArmSummary, RoundGain, Source, TrialsInRounds};

use crate::figures::{AccuracyCurve, accuracy};
use crate::number::{exact, interval, percent_within, three, three_or_dash, three_within};
use crate::parts::{Figures, HtmlTable, Section, grouped};

/// Trials designed in rounds compared with trials designed once: at equal time, and when they stop.
pub(super) fn sequential(found: &TrialsInRounds, figures: &mut Figures) -> Vec<Section> {
    let (stops, compares) = match found.statements.split_last() {
        Some((last, others)) => (std::slice::from_ref(last), others),
        None => (&[][..], &[][..]),
    };
    let compared = html! {
        (about(found))
        (sentences(compares))
        (figure(found, figures))
        (gains(&found.gains))
        (errors(found))
    };
    let stopped = html! { (sentences(stops)) (stopping(found)) };
    vec![
        Section::new("rounds", "At equal time", "At equal time", compared),
        Section::new("stopping", "When to stop", "When to stop", stopped),
    ]
}

/// Each with a capital first letter.
fn sentences(statements: &[String]) -> Markup {
    let capital = |said: &String| -> String {
        let mut letters = said.chars();
        letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
    };
    html! { @for said in statements { p { (capital(said)) "." } } }
}

/// The label of an arm.
fn label(arm: Arm) -> &'static str {
    match arm {
        Arm::Sequential => "in rounds",
        Arm::OneShot => "one-shot",
        Arm::Informed => "from the truth",
        Arm::Random => "random",
    }
}

fn about(found: &TrialsInRounds) -> Markup {
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

fn figure(found: &TrialsInRounds, figures: &mut Figures) -> Markup {
    let curve = |arm: &ArmSummary| AccuracyCurve {
        label: label(arm.name),
        points: arm.points.iter().filter_map(|point| Some((point.time_s, point.median?))).collect(),
    };
    let curves: Vec<AccuracyCurve> = found.arms.iter().map(curve).collect();
    let stop = found.stopping.first().map_or(found.duration_s, |s| s.mean_time_s);
    let figure = accuracy(&curves, (stop, found.accuracy), "median parameter error [1]");
    figures.place("rounds", figure, &html! {
        b { "Median parameter error against time at sea." }
        " The dot is the wanted accuracy, " (exact(found.accuracy)) ", and the mean time after which trials in rounds stop."
    })
}

fn gains(gains: &[RoundGain]) -> Markup {
    let table = HtmlTable::of(gains)
        .compact()
        .name("Time [s]", |gain| three(gain.time_s))
        .number("Error in rounds / one-shot", |gain| three_or_dash(gain.ratio))
        .number("95 % interval", |gain| interval(gain.low.zip(gain.high).map(|(low, high)| [low, high])))
        .number("Realizations", |gain| gain.pairs);
    html! {
        (table)
        p.note { "Geometric mean over the realizations in which both have an estimate. The first round is the same for both." }
    }
}

fn errors(found: &TrialsInRounds) -> Markup {
    let table = HtmlTable::of(grouped(&found.arms, |arm| &arm.points))
        .compact()
        .mark("first", |(first, ..)| first)
        .name("Design", |(first, arm, _)| if first { label(arm.name) } else { "" })
        .number("Time [s]", |(.., point)| three(point.time_s))
        .number("Median error", |(.., point)| three_within(point.median, point.median_interval))
        .number("90 % quantile", |(.., point)| three_within(point.q90, point.q90_interval))
        .number("Predicted", |(.., point)| three_or_dash(point.predicted))
        .number("Within the accuracy", |(.., point)| percent_within(point.within, point.within_interval))
        .number("Not converged", |(.., point)| point.not_converged)
        .number("Not identifiable", |(.., point)| point.not_identifiable)
        .number("Diverged", |(.., point)| point.diverged)
        .number("No design", |(.., point)| point.undesigned);
    html! {
        (table)
        p.note {
            "Error: 2-norm over the parameters of (estimate − truth)/truth; a trial without an estimate counts as infinite. \
             Predicted: median of what estimates say of themselves, standard error over parameter."
        }
    }
}

fn stopping(found: &TrialsInRounds) -> Markup {
    let table = HtmlTable::of(&found.stopping)
        .compact()
        .name("Trial", |s| label(s.arm))
        .number("Promised in time", |s| s.stopped)
        .number("Mean time [s]", |s| {
            three_within(Some(s.mean_time_s), s.mean_time_interval_s.map(|ends| ends.map(Some)))
        })
        .number("Median error at the end", |s| three_within(s.median_error, s.median_error_interval))
        .number("Within the accuracy", |s| percent_within(s.within, s.within_interval))
        .number("Of those promised", |s| {
            percent_within(s.within_stopped.unwrap_or(f64::NAN), s.within_stopped_interval)
        })
        .number("RMS error / accuracy", |s| {
            three_within(s.rms_over_accuracy, s.rms_over_accuracy_interval.map(|ends| ends.map(Some)))
        })
        .number("No estimate", |s| s.without_estimate);
    html! {
        (table)
        p.note {
            "A trial ends with the first round after which an error of " (exact(found.accuracy)) " is promised, or else after \
             the whole time: in rounds the estimate promises it, by its standard errors over the parameters known by then; a \
             one-shot trial is sized before it sails, by the standard errors that the crude model expects. The last three \
             columns are of trials that were promised it; a root mean square error at most the accuracy keeps the promise."
        }
    }
}
