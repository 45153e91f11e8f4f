use crate::figures::{AccuracyCurve, accuracy};
use maud::{Markup, html};

use super::number::three;
use super::parts::Figures;
use study::documents::{Accuracy, AccuracyOf, AccuracyPoint, DesignDocument};

/// The required length of the experiment, and that of other designs.
pub(super) fn accuracy_of(design: &DesignDocument, figures: &mut Figures) -> Markup {
    let Some(found) = &design.accuracy else { return html! {} };
    let title = match found.of {
        AccuracyOf::Overall => "root of Σ (std error/θ)² [1]",
        AccuracyOf::PerParameter => "largest std error/θ [1]",
        AccuracyOf::Figures => "largest std error of a figure/wanted [1]",
    };
    let figure = accuracy(&curves(found), (found.duration_s, found.wanted), title);
    html! {
        h3 { "How long?" }
        p { (found.statement) }
        (figures.place("accuracy", figure, &html! {
            b { "Predicted standard error against the duration of the experiment." }
            " The dot is the wanted error, " (three(found.wanted)) ", reached after " (three(found.duration_s)) " s."
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
