use std::collections::BTreeMap;

use maud::{Markup, display, html};
use study::documents::{
    Accuracy, AccuracyOf, AccuracyPoint, CriterionName, DesignDocument, DesignFigure, DesignFigures,
    PromiseUpdate, Reference, Sequence, SequencePart, UpdatedParameter,
};

use crate::dictionary::{omission, shown, used};
use crate::figures::{AccuracyCurve, SensitivityRow, ShareRow, accuracy, sensitivities, shares};
use crate::number::{exact, or_dash, percent, published, three, three_or_dash};
use crate::parts::{Figures, HtmlTable, Section, coded, entry, missing};
use crate::study::Study;

/// The time of each maneuver, and the efficiency of the unused ones.
pub(super) fn allocation(study: &Study, figures: &mut Figures) -> Section {
    let body = match &study.design {
        Some(design) => designed(study, design, figures),
        None => missing("The optimal shares are", "design.json", "design"),
    };
    Section::new("shares", "Shares", "Optimal shares of the experiment time", body)
}

fn designed(study: &Study, design: &DesignDocument, figures: &mut Figures) -> Markup {
    let reference = study.reference.as_ref();
    let names = shown(design.order.iter().map(String::as_str), Some(design));
    let of = |values: &BTreeMap<String, f64>, name: &str| values.get(name).copied().unwrap_or(f64::NAN);
    let share = |name| ShareRow {
        name,
        share: of(&design.shares, name),
        published: published_share(reference, name),
    };
    let sensitivity = |name| SensitivityRow {
        name,
        sensitivity: of(&design.sensitivities, name),
        used: used(design, name),
    };
    let bars: Vec<ShareRow<'_>> = names.iter().copied().map(share).collect();
    let dots: Vec<SensitivityRow<'_>> = names.iter().copied().map(sensitivity).collect();
    html! {
        div.pair {
            (figures.place("shares", shares(&bars), &share_caption(reference)))
            @if let Some(p) = design.dimension {
                (figures.place("sensitivities", sensitivities(&dots, p as f64), &sensitivity_caption(p)))
            }
        }
        (omission(design.order.len(), names.len()))
        (table(&names, design, reference, study.experiment_s))
        (accuracy_of(design, figures))
        (figure_errors(design))
        (updated(study.update.as_ref()))
        @if let Some(sequence) = &design.sequence {
            p.note { "Order, with seconds: " (order(sequence, study.experiment_s)) ". " (sequence.statement) }
        }
    }
}

/// `spiral-slow 50, accelerate 4, …` in seconds, or in samples where the length of the experiment is not known.
fn order(sequence: &Sequence, experiment_s: Option<f64>) -> String {
    let sample_s = experiment_s.map_or(1.0, |whole| whole / sequence.samples as f64);
    let part = |part: &SequencePart| format!("{} {}", part.maneuver, exact(part.samples as f64 * sample_s));
    sequence.parts.iter().map(part).collect::<Vec<_>>().join(", ")
}

/// The published share of a maneuver. An unlisted one has none, unless the listed ones sum to the whole.
fn published_share(reference: Option<&Reference>, name: &str) -> Option<f64> {
    let shares = &reference?.shares;
    let whole = shares.values().sum::<f64>() > 0.995;
    shares.get(name).copied().or(whole.then_some(0.0))
}

fn share_caption(reference: Option<&Reference>) -> Markup {
    html! {
        b { "Share of the experiment time per maneuver." }
        @if reference.is_some_and(|r| !r.shares.is_empty()) { " Solid: this design; outlined: published." }
        @if let Some(used) = reference.and_then(|r| r.used.as_ref()) { " " (used) }
    }
}

fn sensitivity_caption(p: u64) -> Markup {
    html! {
        b { "Sensitivity g of every maneuver." }
        " A maneuver in use (filled) sits at the line g = p = " (p) "; one to the left of it (open) would \
          return less information per second than the mix does, and gets no time."
    }
}

fn table(
    names: &[&str],
    design: &DesignDocument,
    reference: Option<&Reference>,
    experiment_s: Option<f64>,
) -> Markup {
    let mut table = HtmlTable::of(names.iter().copied())
        .mark("unused", |name| !used(design, name))
        .name("Maneuver", |name| name)
        .number("Share", |name| {
            let printed = |share: &f64| if used(design, name) { percent(*share) } else { "0".to_owned() };
            or_dash(design.shares.get(name).map(printed))
        });
    if let Some(length) = experiment_s {
        table = table.number("Time [s]", |name| time_of(design, name, length));
    }
    if let Some(counts) = &design.counts {
        table = table.number("Segments", |name| counts.get(name).copied().unwrap_or(0));
    }
    if reference.is_some_and(|r| !r.shares.is_empty()) {
        table = table.classed("number published", "Published share", |name| {
            or_dash(published_share(reference, name).map(published))
        });
    }
    table = table
        .number("Sensitivity g", |name| three_or_dash(design.sensitivities.get(name).copied()))
        .number("Efficiency alone", |name| {
            let alone = design.efficiency.as_ref().and_then(|all| all.single.get(name));
            or_dash(alone.map(|alone| if *alone <= 1e-9 { "0".to_owned() } else { percent(*alone) }))
        });
    html! { (table) (footnotes(design)) }
}

/// As it is sailed: where maneuvers are arranged, their pieces.
fn time_of(design: &DesignDocument, name: &str, length: f64) -> String {
    if let Some(sequence) = &design.sequence {
        let pieces = sequence.parts.iter().filter(|part| part.maneuver == name);
        let samples: u64 = pieces.map(|part| part.samples).sum();
        return three_or_dash((samples > 0).then_some(length * samples as f64 / sequence.samples as f64));
    }
    let share = design.shares.get(name).filter(|_| used(design, name));
    three_or_dash(share.map(|share| share * length))
}

fn footnotes(design: &DesignDocument) -> Markup {
    html! {
        @if design.efficiency.is_some() { p.note {
            "Efficiency alone: the fraction of the experiment time that the optimal shares would need for the information of \
             that maneuver on its own; 0 where it leaves some direction without excitation."
        } }
        @if let Some(counted) = &design.counted {
            p.note {
                "Segments: the shares approximated by " (counted.segments) " segments of " (counted.segment_samples)
                " samples; their efficiency against the exact shares is " (percent(counted.efficiency)) "."
            }
        }
        @if let Some(log_det) = design.log_det {
            p.note { "log|det| of the information matrix: " (exact((log_det * 1e4).round() / 1e4)) "." }
        }
    }
}

/// The required length of the experiment, and that of other designs.
fn accuracy_of(design: &DesignDocument, figures: &mut Figures) -> Markup {
    let Some(accuracies) = &design.accuracy else { return html! {} };
    let title = match accuracies.of {
        AccuracyOf::Overall => "root of Σ (std error/θ)² [1]",
        AccuracyOf::Figures => "largest std error of a figure/wanted [1]",
    };
    let figure = accuracy(&curves(accuracies), (accuracies.duration_s, accuracies.wanted), title);
    html! {
        h3 { "How long?" }
        p { (accuracies.statement) }
        (figures.place("accuracy", figure, &html! {
            b { "Predicted standard error against the duration of the experiment." }
            " The dot is the wanted error, " (three(accuracies.wanted)) ", reached after " (three(accuracies.duration_s)) " s."
        }))
    }
}

fn curves(found: &Accuracy) -> Vec<AccuracyCurve<'static>> {
    let curve = |label: &'static str, of: fn(&AccuracyPoint) -> Option<f64>| {
        let points = found.curve.iter().filter_map(|p| of(p).map(|error| (p.duration_s, error))).collect();
        AccuracyCurve { label, points }
    };
    let all = [
        curve("this design", |p| Some(p.design)),
        curve("paper's criterion", |p| p.paper),
        curve("random, median", |p| p.random),
        curve("equal shares", |p| p.equal),
    ];
    all.into_iter().filter(|curve| !curve.points.is_empty()).collect()
}

/// The certificate of the design.
pub(super) fn certificate(study: &Study) -> Section {
    let body = match &study.design {
        Some(design) => certified(design),
        None => missing("The certificate is", "design.json", "design"),
    };
    Section::new("certificate", "Certificate", "Certificate", body)
}

fn certified(design: &DesignDocument) -> Markup {
    html! {
        p { (design.statement) }
        @if let Some(promise) = &design.promise { p { (promise.statement) } }
        @if let Some(prior) = &design.prior { p { (prior.statement) } }
        (crate::parts::held(design.held_in_words().as_ref()))
        (crate::parts::beyond(&design.beyond))
        @if let Some(unreached) = &design.unreached { p.caution { b { "Missed by inputs." } " " (coded(&unreached.statement)) } }
        (facts(design))
    }
}

fn facts(design: &DesignDocument) -> Markup {
    let proof = match design.status == study::documents::DesignStatus::Optimal {
        true => "proved: the problem is concave and the gap bounds the distance",
        false => "not proved: the problem is not concave, so the gap certifies a stationary point",
    };
    html! {
        dl.facts {
            (entry("Status", display(design.status)))
            (entry("Global optimum", proof))
            @if let (Some(gap), Some(p)) = (design.gap, design.dimension) {
                (entry("Gap max g − p", format!("{} (p = {p})", three(gap))))
            }
            @if let Some(gap) = design.relative_gap { (entry("Relative gap", three(gap))) }
            @if let Some(efficiency) = &design.efficiency {
                (entry("Efficiency of equal shares", percent(efficiency.equal_shares)))
            }
            (entry("Criterion", html! {
                (design.criterion.title()) "-optimality"
                @if let Some(removal) = design.mean_removal { ", instruments' mean removed: " (removal) }
            }))
        }
    }
}

/// What became of the promise of a design; nothing before its trial.
fn updated(update: Option<&PromiseUpdate>) -> Markup {
    let Some(update) = update else { return html! {} };
    html! {
        h3 { "What became of the promise?" }
        p { (update.statement) }
        (promises_table(&update.parameters))
        p.note {
            "Standard errors as promised for a trial of this length, and from the covariance of its estimate. Scales are what errors \
             are relative to, before and after."
        }
        @for said in &update.statements { p.note { (said) } }
    }
}

fn promises_table(parameters: &[UpdatedParameter]) -> HtmlTable<&UpdatedParameter> {
    HtmlTable::of(parameters)
        .compact()
        .name("Parameter", |parameter| parameter.name.as_str())
        .number("Estimate", |parameter| three(parameter.estimate))
        .number("Scale", |parameter| or_dash(parameter.scale.map(three)))
        .number("Promised", |parameter| three(parameter.standard_error.promised))
        .number("Now", |parameter| three(parameter.standard_error.now))
        .number("Promised/now", |parameter| or_dash(parameter.standard_error.ratio.map(three)))
}

/// How well figures of merit will be known; nothing where the design has none.
fn figure_errors(design: &DesignDocument) -> Markup {
    let Some(errors) = &design.figures else { return html! {} };
    let weighted = design.criterion == CriterionName::Figures;
    let length = match errors.samples {
        1 => ", for one sample: that of N samples is √N times smaller".to_owned(),
        samples => format!(" of {samples} samples"),
    };
    html! {
        h3 { "How well will figures of merit be known?" }
        (figures_table(errors, weighted))
        p.note {
            "Standard errors after this experiment" (length) ", and after the D-optimal one of the same maneuvers \
             and time."
            @if weighted { " A figure without a weight may be known worse than there." }
        }
        @for said in &errors.left_out { p.note { (said) } }
    }
}

fn figures_table(found: &DesignFigures, weighted: bool) -> HtmlTable<&DesignFigure> {
    let with_unit = |value: f64, figure: &DesignFigure| {
        let unit = if figure.unit == "1" { String::new() } else { figure.unit.replace("deg", "°") };
        format!("{} {unit}", three(value)).trim_end().to_owned()
    };
    let mut table = HtmlTable::of(&found.figures)
        .mark("unused", |figure| weighted && figure.weight == 0.0)
        .name("Maneuver", |figure| figure.maneuver.as_str())
        .text("Figure", |figure| figure.what.as_str())
        .number("Value", |figure| with_unit(figure.value, figure));
    if weighted {
        table = table.number("Weight", |figure| three(figure.weight));
    }
    if found.figures.iter().any(|figure| figure.wanted.is_some()) {
        table =
            table.number("Wanted", |figure| or_dash(figure.wanted.map(|wanted| with_unit(wanted, figure))));
    }
    table
        .number("Standard error", |figure| with_unit(figure.standard_error, figure))
        .number("D-optimal", |figure| or_dash(figure.d_optimal.map(|error| with_unit(error, figure))))
        .number("Ratio", |figure| or_dash(figure.ratio.map(three)))
}
